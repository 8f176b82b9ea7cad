"""A sandbox for another author's program, made by Debian's bubblewrap.

Inside, there is no network and no other process. The program can read the system's own folders,
this Python, itself and the files that its command names, but never minirt and its answers. It can
write to a `/tmp` and a `/dev/shm` of its own and to its working folder, and to no other folder of
the caller. If the caller is root, the program runs as another, unprivileged user, since the limit
of processes does not hold for root. Any other caller needs the kernel's user namespaces.
"""

from __future__ import annotations

import itertools
import os
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp

from reference.cache import usual_folder
from reference.jobs.scratch_folders import hand_over, remove

#: Where a distribution keeps its programs.
_SYSTEM = (
    "/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32", "/opt", "/nix/store",
    "/gnu/store",
)  # fmt: skip
#: What libraries read of /etc. Left out: shadow, keys, tokens, the names of machines.
_SETTINGS = (
    "alternatives", "fonts", "glvnd", "group", "ImageMagick-*", "java-*", "ld.so.*", "localtime",
    "mono", "nsswitch.conf", "OpenCL", "passwd", "povray", "vulkan",
)  # fmt: skip
_VARIABLES = ("PATH", "LANG", "LC_ALL", "LC_CTYPE", "LC_NUMERIC", "TZ", "OMP_NUM_THREADS")
_NAMESPACES = (
    "--unshare-pid", "--unshare-ipc", "--unshare-uts", "--unshare-net", "--unshare-cgroup-try",
    "--hostname", "sandbox", "--die-with-parent", "--new-session",
)  # fmt: skip
#: systemd's range of ids for users that exist only while a service runs: no real user has one.
_FIRST_UID, _UIDS = 61184, 4336
#: The packages that compute the right answers.
_PACKAGES = tuple(
    Path(__file__).resolve().parents[2] / name
    for name in ("minirt", "converters", "reference", "reports")
)
_counter = itertools.count(os.getpid())


def sandbox_missing() -> str | None:
    """Why there is no sandbox here, with the command that installs it; None where it works."""
    path = os.environ.get("PATH", os.defpath)
    return _missing(path, os.geteuid())


def sandbox_version() -> str:
    """The name and version of bubblewrap, as it prints them."""
    command = [str(shutil.which("bwrap")), "--version"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


@contextmanager
def sandboxed(
    command: Sequence[str], workdir: Path, processes: int, visible: Iterable[Path] = ()
) -> Iterator[tuple[list[str], dict[str, str], Path]]:
    """The command that runs `command` in a sandbox, its environment, and its `/tmp`.

    On leaving, the working folder and all in it belong to their owner again, and `/tmp` is removed.
    Everything that was started must have ended by then.

    Parameters
    ----------
    command : sequence of str
        An absolute path to a program, and its arguments.
    workdir : path
        Resolved.
    processes : int
        Largest number of processes and threads, as the kernel counts them for a user.
    visible : paths, optional
        Files and folders that it may read too.
    """
    owner = workdir.stat()
    scratch = Path(mkdtemp(prefix="minirt-"))
    uid = _FIRST_UID + next(_counter) % _UIDS if os.geteuid() == 0 else None
    inside = [*_as_user(uid), "prlimit", f"--nproc={processes}", "--", *command]
    try:
        if uid is not None:
            hand_over([workdir, scratch], uid, uid)
        wanted = [*visible, *_files_in(command)]
        yield (
            [*_bubblewrap(workdir, scratch, wanted, uid), "--", *inside],
            _environment(workdir),
            scratch,
        )
    finally:
        hand_over([workdir], owner.st_uid, owner.st_gid)
        remove(scratch)


@lru_cache(maxsize=8)
def _missing(path: str, euid: int) -> str | None:
    if shutil.which("bwrap", path=path) is None:
        return "bubblewrap is not installed: apt-get install bubblewrap"
    for program, package in (("prlimit", "util-linux"), ("setpriv", "util-linux")):
        if shutil.which(program, path=path) is None:
            return f"{program} is not installed: apt-get install {package}"
    with TemporaryDirectory(prefix="minirt-") as folder:
        workdir = Path(folder).resolve()
        with sandboxed([shutil.which("true", path=path) or "/bin/true"], workdir, 64) as tried:
            done = subprocess.run(tried[0], env=tried[1], capture_output=True, check=False)
    said = " ".join(done.stderr.decode(errors="replace").split())
    rights = (
        "the user namespaces that the kernel or a container denies" if euid else "CAP_SYS_ADMIN"
    )
    return f"bubblewrap does not work here, it needs {rights}: {said}" if done.returncode else None


def _as_user(uid: int | None) -> list[str]:
    """The command that turns root into an unprivileged user."""
    if uid is None:
        return []
    identity = [f"--reuid={uid}", f"--regid={uid}", "--clear-groups"]
    return ["setpriv", *identity, "--no-new-privs", "--inh-caps=-all", "--bounding-set=-all"]


def _bubblewrap(workdir: Path, scratch: Path, wanted: Iterable[Path], uid: int | None) -> list[str]:
    words = [str(shutil.which("bwrap")), *_NAMESPACES]
    words += ["--unshare-user"] if uid is None else []
    words += ["--proc", "/proc", "--dev", "/dev"]
    words += ["--bind", str(scratch), "/tmp", "--bind", str(scratch), "/dev/shm"]  # noqa: S108
    for place in _readable(wanted):
        if not place.is_relative_to(workdir):
            words += [*_parents(place), *_read_only(place)]
    words += [word for place in _ours(wanted) for word in ("--tmpfs", str(place))]
    words += [*_parents(workdir), "--bind", str(workdir), str(workdir), "--chdir", str(workdir)]
    return [*words, "--remount-ro", "/dev", "--remount-ro", "/"]


def _ours(wanted: Iterable[Path]) -> Iterator[Path]:
    """The folders of minirt and of its answers that would be readable, and must be hidden."""
    shown = _readable(wanted)
    for place in (usual_folder().resolve(), *_PACKAGES):
        is_there = os.path.isdir(place)  # noqa: PTH112 - Path's raises what it may not see
        if is_there and any(place.is_relative_to(each) for each in shown):
            yield place


def _readable(wanted: Iterable[Path]) -> list[Path]:
    """What can be read inside; folders within folders of the list are left out."""
    ours = {Path(sys.prefix), Path(sys.base_prefix), Path(sys.base_prefix).resolve()}
    settings = {path for name in _SETTINGS for path in Path("/etc").glob(name)}
    chosen: list[Path] = []
    for place in sorted({*map(Path, _SYSTEM), *settings, *ours, *wanted}):
        covered = any(place.is_relative_to(p) and not p.is_symlink() for p in chosen)
        if place.exists() and place != Path("/") and not covered:
            chosen.append(place)
    return chosen


def _read_only(place: Path) -> list[str]:
    if place.is_symlink() and str(place) in _SYSTEM:
        return ["--symlink", str(place.readlink()), str(place)]
    return ["--ro-bind", str(place), str(place)]


def _parents(place: Path) -> list[str]:
    """Options that make the parent folders of a place, which any user may pass through."""
    above = [p for p in reversed(place.parents) if p != Path("/") and str(p) not in _SYSTEM]
    return [word for p in above for word in ("--perms", "0755", "--dir", str(p))]


def _files_in(command: Sequence[str]) -> Iterator[Path]:
    """The files that a command names by their absolute paths."""
    for word in command:
        if word.startswith("/") and len(word) < 4096 and Path(word).is_file():
            yield Path(word)


def _environment(workdir: Path) -> dict[str, str]:
    kept = {name: os.environ[name] for name in _VARIABLES if name in os.environ}
    own = {"HOME": str(workdir), "TMPDIR": str(workdir), "USER": "sandbox", "LOGNAME": "sandbox"}
    return {"PATH": os.defpath, **kept, **own}
