"""A sandbox for another author's program, made by Debian's bubblewrap.

Inside there is no network, no other process and of the file system only what programs need:
the system's own folders, this Python, the program and the files that its command names, read
only, and minirt and its answers never; a `/tmp` and a `/dev/shm` of its own; and its room, the only
one of the caller's folders that it can write to. Who starts it as root starts it as another,
unprivileged user, because the limit of processes does not hold for root. Any other user needs the
kernel's user namespaces.
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

#: What a distribution's programs consist of.
_SYSTEM = (
    "/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32", "/opt", "/nix/store",
    "/gnu/store",
)  # fmt: skip
#: What of /etc their libraries read. Not there: shadow, keys, tokens, the names of machines.
_SETTINGS = (
    "alternatives", "fonts", "glvnd", "group", "ImageMagick-*", "java-*", "ld.so.*", "localtime",
    "mono", "nsswitch.conf", "OpenCL", "passwd", "povray", "vulkan",
)  # fmt: skip
_VARIABLES = ("PATH", "LANG", "LC_ALL", "LC_CTYPE", "LC_NUMERIC", "TZ", "OMP_NUM_THREADS")
_NAMESPACES = (
    "--unshare-pid", "--unshare-ipc", "--unshare-uts", "--unshare-net", "--unshare-cgroup-try",
    "--hostname", "sandbox", "--die-with-parent", "--new-session",
)  # fmt: skip
#: systemd's range for users that exist only while a service runs: nobody else has their ids.
_FIRST_UID, _UIDS = 61184, 4336
#: What computes the right answers.
_PACKAGES = tuple(
    Path(__file__).resolve().parents[2] / name
    for name in ("minirt", "converters", "reference", "reports")
)
_turns = itertools.count(os.getpid())


def sandbox_missing() -> str | None:
    """Why there is no sandbox here, with the command that would bring it; None where it works."""
    path = os.environ.get("PATH", os.defpath)
    return _missing(path, os.geteuid())


def sandbox_version() -> str:
    """The name and version of what makes it, as it says them."""
    command = [str(shutil.which("bwrap")), "--version"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


@contextmanager
def sandboxed(
    command: Sequence[str], room: Path, processes: int, visible: Iterable[Path] = ()
) -> Iterator[tuple[list[str], dict[str, str], Path]]:
    """The command that runs `command` in a sandbox, its environment, and its `/tmp`.

    On leaving, the room and all that is in it belong to its owner again and `/tmp` is gone. All
    that was started must have ended by then.

    Parameters
    ----------
    command : sequence of str
        An absolute path to a program, and its arguments.
    room : path
        Resolved.
    processes : int
        Most processes and threads, as the kernel counts them for a user.
    visible : paths, optional
        Files and folders that it may read too.
    """
    owner = room.stat()
    scratch = Path(mkdtemp(prefix="minirt-"))
    uid = _FIRST_UID + next(_turns) % _UIDS if os.geteuid() == 0 else None
    inside = [*_as_user(uid), "prlimit", f"--nproc={processes}", "--", *command]
    try:
        if uid is not None:
            hand_over([room, scratch], uid, uid)
        wanted = [*visible, *_files_in(command)]
        yield [*_bubblewrap(room, scratch, wanted, uid), "--", *inside], _environment(room), scratch
    finally:
        hand_over([room], owner.st_uid, owner.st_gid)
        remove(scratch)


@lru_cache(maxsize=8)
def _missing(path: str, euid: int) -> str | None:
    if shutil.which("bwrap", path=path) is None:
        return "bubblewrap is not installed: apt-get install bubblewrap"
    for program, package in (("prlimit", "util-linux"), ("setpriv", "util-linux")):
        if shutil.which(program, path=path) is None:
            return f"{program} is not installed: apt-get install {package}"
    with TemporaryDirectory(prefix="minirt-") as folder:
        room = Path(folder).resolve()
        with sandboxed([shutil.which("true", path=path) or "/bin/true"], room, 64) as tried:
            done = subprocess.run(tried[0], env=tried[1], capture_output=True, check=False)
    said = " ".join(done.stderr.decode(errors="replace").split())
    rights = (
        "the user namespaces that the kernel or a container denies" if euid else "CAP_SYS_ADMIN"
    )
    return f"bubblewrap does not work here, it needs {rights}: {said}" if done.returncode else None


def _as_user(uid: int | None) -> list[str]:
    """What makes root somebody who may do nothing."""
    if uid is None:
        return []
    identity = [f"--reuid={uid}", f"--regid={uid}", "--clear-groups"]
    return ["setpriv", *identity, "--no-new-privs", "--inh-caps=-all", "--bounding-set=-all"]


def _bubblewrap(room: Path, scratch: Path, wanted: Iterable[Path], uid: int | None) -> list[str]:
    words = [str(shutil.which("bwrap")), *_NAMESPACES]
    words += ["--unshare-user"] if uid is None else []
    words += ["--proc", "/proc", "--dev", "/dev"]
    words += ["--bind", str(scratch), "/tmp", "--bind", str(scratch), "/dev/shm"]  # noqa: S108
    for place in _readable(wanted):
        if not place.is_relative_to(room):
            words += [*_parents(place), *_read_only(place)]
    words += [word for place in _ours(wanted) for word in ("--tmpfs", str(place))]
    words += [*_parents(room), "--bind", str(room), str(room), "--chdir", str(room)]
    return [*words, "--remount-ro", "/dev", "--remount-ro", "/"]


def _ours(wanted: Iterable[Path]) -> Iterator[Path]:
    """What of minirt and its answers could be read: this Python's packages, somebody's home."""
    shown = _readable(wanted)
    for place in (usual_folder().resolve(), *_PACKAGES):
        is_there = os.path.isdir(place)  # noqa: PTH112 - Path's raises what it may not see
        if is_there and any(place.is_relative_to(each) for each in shown):
            yield place


def _readable(wanted: Iterable[Path]) -> list[Path]:
    """What can be read inside, without what lies in a folder that is there already."""
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
    """The folders on the way to a place, which everybody may pass."""
    above = [p for p in reversed(place.parents) if p != Path("/") and str(p) not in _SYSTEM]
    return [word for p in above for word in ("--perms", "0755", "--dir", str(p))]


def _files_in(command: Sequence[str]) -> Iterator[Path]:
    """The files that a command names by their absolute paths."""
    for word in command:
        if word.startswith("/") and len(word) < 4096 and Path(word).is_file():
            yield Path(word)


def _environment(room: Path) -> dict[str, str]:
    kept = {name: os.environ[name] for name in _VARIABLES if name in os.environ}
    own = {"HOME": str(room), "TMPDIR": str(room), "USER": "sandbox", "LOGNAME": "sandbox"}
    return {"PATH": os.defpath, **kept, **own}
