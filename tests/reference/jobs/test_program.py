"""Hostile programs end as failures with a message of their own; nothing outside their
working folder changes and nothing of them survives. Honest programs pass."""

from __future__ import annotations

import json
import os
import re
import socket
import stat
import subprocess
import sys
import time
import zipfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import OpenImageIO as oiio
import pytest

import minirt
from converters.frames.io import read_frame, write_frame
from minirt.errors import InputError, ReferenceError
from minirt.frame import Frame
from reference.compare.comparison import compare
from reference.compare.stability import measure
from reference.jobs import sandbox, scratch_folders
from reference.jobs.program import Limits, ProgramEnd, plain_files, run_program, sandbox_missing
from reference.jobs.sandbox import sandboxed
from reference.source import Declared
from tests.helpers.places import ROOT
from tests.helpers.program_runs import JOB, Place, place_of, users
from tests.helpers.tiers import tiered

MIB = 2**20
SIZE = (6, 4)
IMPORTS = "import ctypes, os, signal, socket, subprocess, sys, threading, time\n"


@pytest.fixture(params=tiered(users(), lambda user: user == "me"))
def place(request: pytest.FixtureRequest) -> Iterator[Place]:
    with place_of(request.param) as made:
        yield made


@pytest.fixture(params=users()[-1:])
def ordinary(request: pytest.FixtureRequest) -> Iterator[Place]:
    with place_of(request.param) as made:
        yield made


@pytest.fixture
def mine() -> Iterator[Place]:
    with place_of("me") as made:
        yield made


def test_the_sandbox_is_here() -> None:
    """Required, not optional: without it most of this file would say nothing."""
    assert sandbox_missing() is None


# Honest programs


@pytest.mark.parametrize("boxed", [True, False])
def test_an_honest_program_passes(place: Place, boxed: bool) -> None:
    code = "import os\nopen('out.txt', 'w').write(os.environ['HOME'])\nprint('done')"
    assert place.run(code, sandbox=boxed) == ProgramEnd(0, "", "done\n")
    assert [path.name for path in plain_files(place.workdir)] == ["out.txt", "subject.py"]
    written = place.workdir / "out.txt"
    assert written.read_text(encoding="utf-8") == str(place.workdir)
    assert written.stat().st_uid == place.workdir.stat().st_uid


def test_a_frame_from_the_sandbox_is_read(place: Place) -> None:
    frame = Frame({"hit": np.eye(*SIZE, dtype=bool), "depth": np.ones(SIZE)})
    write_frame(frame, place.folder / "given.npz")
    assert run_copy(place, place.folder / "given.npz", "out.npz").reason == ""
    assert place.workdir / "out.npz" in plain_files(place.workdir)
    assert (read_frame(place.workdir / "out.npz", expect=SIZE)["hit"] == frame["hit"]).all()


def test_processes_threads_and_temporary_files_are_allowed(place: Place) -> None:
    code = """
import concurrent.futures as cf, multiprocessing as mp, os, tempfile
if __name__ == "__main__":
    with tempfile.TemporaryFile() as file, open("/tmp/x", "w") as other:
        file.write(bytes(1000)), other.write("x")
    with mp.Pool(3) as pool, cf.ThreadPoolExecutor(3) as threads:
        print(sum(pool.map(abs, range(9))) + sum(threads.map(abs, range(9))))
    print(sorted(os.listdir("/tmp"))[-1])
"""
    assert place.run(code) == ProgramEnd(0, "", "72\nx\n")
    assert not (place.workdir / "x").exists()


def test_a_program_on_the_search_path_that_closes_its_output(place: Place) -> None:
    assert place.run_command(["sh", "-c", "exec >&- 2>&-; exit 0"]) == ProgramEnd(0, "", "")


def test_what_a_program_prints_is_kept_from_its_end(place: Place) -> None:
    code = "import sys\nfor i in range(9999): print(i)\nsys.stdout.buffer.write(b'\\xff\\n')"
    ended = place.run(code, sandbox=False)
    assert ended.reason == ""
    assert ended.output.endswith("9998\n�\n")
    assert len(ended.output.encode("utf-8", errors="replace")) <= 4002


# How a program ends


@pytest.mark.parametrize("boxed", [True, False])
@pytest.mark.parametrize(
    ("code", "status", "reason"),
    [
        ("sys.exit(3)", 3, "ended with status 3"),
        ("os.kill(os.getpid(), signal.SIGSEGV)", -11, "was ended by SIGSEGV"),
        ("time.sleep(99)", None, "no answer within 0.7 s"),
        (
            "signal.signal(signal.SIGTERM, signal.SIG_IGN)\ntime.sleep(99)",
            None,
            "no answer within 0.7 s",
        ),
        (
            "os.closerange(0, 99)\nos.setsid() if os.fork() == 0 else 0\ntime.sleep(99)",
            None,
            "no answer within 0.7 s",
        ),
    ],
)
def test_a_failure_is_told(
    mine: Place, boxed: bool, code: str, status: int | None, reason: str
) -> None:
    begin = time.monotonic()
    # A program that ends by itself has time to: even a busy machine starts it within this.
    seconds = 60.0 if status is not None else 0.7
    ended = mine.run(IMPORTS + code, sandbox=boxed, wall_seconds=seconds)
    assert (ended.status, ended.reason) == (status, reason)
    assert time.monotonic() - begin < 60


@pytest.mark.parametrize("boxed", [True, False])
def test_a_program_that_is_none(mine: Place, boxed: bool) -> None:
    (mine.workdir / "broken").write_bytes(b"\0\1\2")
    assert mine.run_command(["./missing"], boxed).reason == "there is no program './missing'"
    assert mine.run_command(["no-such-tracer"], boxed).status is None
    ended = mine.run_command(["./broken"], boxed)
    assert ended.reason.startswith("ended with status 12")
    assert "broken" in ended.output
    (mine.workdir / "broken").chmod(0o755)
    assert mine.run_command(["./broken"], boxed).reason.startswith("ended with status 12")


def test_a_device_is_not_read(mine: Place) -> None:
    device = mine.workdir / "out.exr"
    if os.geteuid() == 0:
        os.mknod(device, stat.S_IFCHR | 0o600, os.makedev(1, 3))
        with pytest.raises(InputError, match="a device among the files"):
            plain_files(mine.workdir)
    assert scratch_folders._kind(os.lstat("/dev/null").st_mode) == "device"


def test_a_program_out_of_sight_is_no_program(place: Place) -> None:
    locked = place.folder / "locked"
    locked.mkdir(mode=0o700)
    name = str(locked / "tracer")
    assert place.run_command([name]) == ProgramEnd(None, f"there is no program {name!r}", "")


# Limits, in a sandbox and without

SPEND: dict[str, tuple[str, dict[str, Any], str]] = {
    "busy": ("while True: pass", {"cpu_seconds": 0.5}, "used more than 0.5 s of CPU"),
    "busy in two processes": (
        "os.fork()\nwhile True: pass",
        {"cpu_seconds": 0.5},
        "used more than 0.5 s of CPU",
    ),
    "allocates": (
        "held = []\nwhile True: held.append(b'x' * 2**24)",
        {"memory": 256 * MIB},
        "used more than 256 MiB of memory",
    ),
    "allocates in many processes": (
        "for _ in range(12): os.fork() or (bytearray(b'x' * 2**24), time.sleep(99))\n"
        "time.sleep(99)",
        {"memory": 128 * MIB},
        "used more than 128 MiB of memory",
    ),
    "processes": (
        "for _ in range(45):\n    if os.fork() == 0: time.sleep(99)\ntime.sleep(99)",
        {"processes": 30},
        "ran more than 30 processes and threads",
    ),
    "threads": (
        "for _ in range(45): threading.Thread(target=time.sleep, args=[99]).start()",
        {"processes": 30},
        "ran more than 30 processes and threads",
    ),
    "one file": (
        "file = open('big', 'wb')\nwhile True: file.write(bytes(2**16))",
        {"file_bytes": 2 * MIB},
        "one of its files grew beyond 2 MiB",
    ),
    "many files": (
        "for i in range(2000): open(str(i), 'wb').write(bytes(2**18))",
        {"output_bytes": 8 * MIB},
        "its files grew beyond 8 MiB in all",
    ),
    "nameless files": (
        "held = []\nfor i in range(200):\n    held.append(open('x', 'wb')); os.unlink('x')\n"
        "    held[-1].write(bytes(2**20)); held[-1].flush()\ntime.sleep(99)",
        {"output_bytes": 8 * MIB},
        "its files grew beyond 8 MiB in all",
    ),
    "memory as a file": (
        "for i in range(200):\n    os.write(os.memfd_create('x'), bytes(2**20))\ntime.sleep(99)",
        {"output_bytes": 8 * MIB},
        "its files grew beyond 8 MiB in all",
    ),
    "empty files": (
        "for i in range(9999): open('%x' % i, 'wb')",
        {},
        "its folder holds more than 2,500 files",
    ),
    "deep folders": (
        "while True: os.mkdir('d'); os.chdir('d')",
        {},
        "its folders nest more than 32 deep",
    ),
    "prints": (
        "while True: sys.stdout.write('x' * 2**16)",
        {"output_bytes": 4 * MIB},
        "printed more than 4 MiB",
    ),
}


@pytest.mark.parametrize("boxed", tiered([True, False], lambda boxed: boxed))
@pytest.mark.parametrize("name", SPEND)
def test_what_exceeds_a_limit_is_ended(
    mine: Place, name: str, boxed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scratch_folders, "MOST_ENTRIES", 2500)
    code, limits, reason = SPEND[name]
    ended = mine.run(IMPORTS + code, sandbox=boxed, **limits)
    assert re.fullmatch(reason, ended.reason), ended


@pytest.mark.parametrize(
    "name",
    tiered(
        ["busy", "allocates", "threads", "one file", "prints"], lambda name: name == "allocates"
    ),
)
def test_limits_hold_for_an_ordinary_user(ordinary: Place, name: str) -> None:
    code, limits, reason = SPEND[name]
    assert re.fullmatch(reason, ordinary.run(IMPORTS + code, **limits).reason)


def test_forks_without_end_are_ended(place: Place) -> None:
    """The kernel stops it at some above the limit; at the limit it is seen and ended."""
    code = "while True:\n    try: os.fork()\n    except OSError: pass"
    ended = place.run(IMPORTS + code, processes=20)
    assert ended.reason == "ran more than 20 processes and threads"


def test_the_kernel_holds_the_limit_of_processes(mine: Place) -> None:
    """Without anybody who watches: of 60 children it refuses those beyond the limit."""
    code = """
import os, signal
made = 0
try:
    for made in range(60):
        if os.fork() == 0: signal.pause()
except OSError as error:
    print(made, error.strerror)
"""
    words = [sys.executable, "-S", "-c", code]
    with sandboxed(words, mine.workdir, 20) as (wrapped, environment, _):
        done = subprocess.run(wrapped, env=environment, capture_output=True, text=True, timeout=60)
    made, _, why = done.stdout.partition(" ")
    assert 10 <= int(made) <= 20
    assert why == "Resource temporarily unavailable\n"


def test_many_programs_at_once(mine: Place) -> None:
    """Each has its own working folder, user and limit, which the others do not use up."""
    code = (
        "import os, time\nfor _ in range(7):\n    if os.fork() == 0: time.sleep(1); os._exit(0)\n"
    )
    folders = [mine.workdir / name for name in "abcd"]
    for folder in folders:
        folder.mkdir()

    def run(folder: Path) -> ProgramEnd:
        words = [sys.executable, "-S", "-c", code + "time.sleep(0.5)"]
        return run_program(words, folder, Limits(wall_seconds=30, processes=9), sandbox=True)

    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(run, folders)) == [ProgramEnd(0, "", "")] * 4


@pytest.mark.parametrize("boxed", [True, False])
def test_a_daemon_does_not_survive(place: Place, boxed: bool) -> None:
    code = """
if os.fork() == 0:
    os.setsid()
    if os.fork() == 0:
        os.closerange(0, 99)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while True:
            open("beat", "a").write("x"); time.sleep(0.02)
    os._exit(0)
while not os.path.exists("beat"): time.sleep(0.02)
"""
    assert place.run(IMPORTS + code, sandbox=boxed).reason == ""
    beats = (place.workdir / "beat").stat().st_size
    assert beats > 0
    time.sleep(0.2)
    assert (place.workdir / "beat").stat().st_size == beats


def test_the_end_of_the_parent_ends_the_program(mine: Place) -> None:
    """Whoever runs it is killed: the program and its daemon end, too."""
    code = "if os.fork() == 0: os.setsid()\nopen('on', 'w').close()\ntime.sleep(60)"
    for boxed in (True, False):
        job = json.dumps([[sys.executable, "-c", IMPORTS + code], str(mine.workdir), {}, boxed])
        ours = {**os.environ, "TMPDIR": str(mine.folder)}  # what it cannot clean up, we do
        with subprocess.Popen([sys.executable, "-c", JOB, job], cwd=ROOT, env=ours) as child:
            wait_until(lambda: (mine.workdir / "on").exists())
            assert mine.survivors() != []
            child.kill()
        wait_until(lambda: mine.survivors() == [])
        (mine.workdir / "on").unlink()


def test_a_program_that_kills_its_parent_without_a_sandbox(place: Place) -> None:
    code = "if os.fork() == 0: time.sleep(99)\nos.kill(os.getppid(), 9)\ntime.sleep(99)"
    ended = place.run(IMPORTS + code, sandbox=False)
    assert ended == ProgramEnd(None, "ended the process that watched it", "")


# What a sandbox keeps away


def test_it_kills_nobody(place: Place) -> None:
    code = """
for pid in [os.getppid(), -1, *map(int, filter(str.isdecimal, os.listdir("/proc")))]:
    try: pid != os.getpid() and os.kill(pid, signal.SIGKILL)
    except OSError: pass
print(len(list(filter(str.isdecimal, os.listdir("/proc")))))
sys.exit(7)
"""
    ended = place.run(IMPORTS + code)
    assert ended.reason == "ended with status 7"
    assert int(ended.output) <= 3


def test_it_reads_no_secret(place: Place) -> None:
    code = """
import json, os, sys
def read(path):
    try: return os.listdir(path) if os.path.isdir(path) else open(path).read()
    except OSError as error: return error.strerror
print(json.dumps([read(path) for path in sys.argv[1].split(":")]))
"""
    paths = ["/etc/shadow", str(place.secret), "/etc/ssh", "/run", "/var", "/root", "/home"]
    ended = place.run(code, ":".join(paths))
    assert ended.reason == "", ended
    for path, said in zip(paths, json.loads(ended.output), strict=True):
        shown = {Path(sys.prefix), Path(sys.base_prefix), place.workdir}
        passed = {p.relative_to(path).parts[0] for p in shown if p.is_relative_to(path)}
        assert said == "No such file or directory" or set(said) <= passed, path


def test_it_writes_nowhere_else(place: Place) -> None:
    code = """
import sys
for folder in sys.argv[1].split(":"):
    try: open(folder + "/minirt-planted", "w")
    except OSError as error: print(error.strerror)
"""
    folders = ["/usr", "/etc", "/", "/dev", "/proc/sys/kernel", str(place.secret.parent)]
    folders += [str(place.folder), sys.prefix, str(Path.home())]
    ended = place.run(code, ":".join(folders))
    assert ended.reason == "", ended
    said = ended.output.splitlines()
    assert len(said) >= len(folders) - 1, "a folder of the way to the workdir may be in its /tmp"
    assert set(said) <= {
        "Read-only file system", "Permission denied", "No such file or directory",
    }  # fmt: skip
    assert not any((Path(folder) / "minirt-planted").exists() for folder in folders)


def test_it_has_no_rights_and_no_variables_of_ours(
    place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MINIRT_TEST_TOKEN", "secret")
    code = "import os\nprint(open('/proc/self/status').read(), 'MINIRT_TEST_TOKEN' in os.environ)"
    said = place.run(code).output
    assert re.search(r"NoNewPrivs:\s+1", said)
    assert len(re.findall(r"Cap\w+:\s+0{16}\n", said)) == 5
    assert not re.search(r"Uid:\s+0", said)
    assert said.strip().endswith("False")


def test_it_has_no_network(place: Place) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        code = f"import socket\nsocket.create_connection(('127.0.0.1', {port}), 2).send(b'x')"
        ended = place.run(code)
        assert ended.reason == "ended with status 1"
        assert "Connection refused" in ended.output
        assert place.run(code, sandbox=False).reason == "", "so the port was open"


def test_it_does_not_see_other_working_or_temporary_folders(place: Place) -> None:
    ended = place.run("import os\nprint(os.listdir('/tmp'), os.listdir('..'))")
    assert ended.reason == ""
    assert "neighbour" not in ended.output
    assert ended.output.count("workdir") == 1


def test_a_program_in_a_folder_of_its_own_is_shown_what_is_named(mine: Place) -> None:
    tool = mine.folder / "neighbour" / "tool"
    code = f"print(open({str(mine.secret)!r}).read())"
    (mine.workdir / "subject.py").write_text(code, encoding="utf-8")
    words = [sys.executable, str(mine.workdir / "subject.py")]
    assert run_program(words, mine.workdir, sandbox=True).status == 1
    shown = run_program(words, mine.workdir, sandbox=True, visible=[mine.secret.parent])
    assert (shown.status, shown.output) == (0, "the right answer\n")
    assert not tool.exists()


def test_a_program_beside_our_own_answers_does_not_see_them(
    mine: Place, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path
    home.chmod(0o755)
    (home / "tool").write_text("a program")
    monkeypatch.setenv("XDG_CACHE_HOME", str(home / "cache"))
    (home / "cache" / "minirt").mkdir(parents=True)
    (home / "cache" / "minirt" / "frame.npz").write_text("the answer")
    words = ["ls", str(home), str(home / "cache" / "minirt")]
    shown = run_program(words, mine.workdir, sandbox=True, visible=[home])
    assert "tool" in shown.output
    assert "frame.npz" not in shown.output


def test_files_go_back_to_the_owner_and_lose_what_is_dangerous(place: Place) -> None:
    code = """
import os
os.makedirs("closed/inner"); open("closed/inner/x", "w").close(); open("tool", "w").close()
os.chmod("tool", 0o6755); os.chmod("closed/inner/x", 0); os.chmod("closed", 0)
"""
    ended = place.run(code)
    assert ended.reason in ("", "its folder cannot be looked through: Permission denied")
    assert len(plain_files(place.workdir)) == 3
    owner = place.workdir.stat().st_uid
    for path in place.workdir.rglob("*"):
        here = path.lstat()
        assert here.st_uid == owner
        assert not here.st_mode & (stat.S_ISUID | stat.S_ISGID)
        assert here.st_mode & stat.S_IRUSR


def test_minirt_itself_is_not_in_the_sandbox(
    mine: Place, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where it is installed among this Python's packages, a program could let it render."""
    site = tmp_path
    site.chmod(0o755)
    (site / "numpy").mkdir()
    (site / "minirt").mkdir()
    (site / "minirt" / "render.py").write_text("the algorithm")
    monkeypatch.setattr(sandbox, "_PACKAGES", (site / "minirt", site / "absent"))
    words = ["ls", str(site), str(site / "minirt")]
    shown = run_program(words, mine.workdir, sandbox=True, visible=[site])
    assert shown.status == 0
    assert "numpy" in shown.output
    assert "render.py" not in shown.output


def test_no_sandbox_without_bubblewrap(mine: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(mine.workdir))
    with pytest.raises(ReferenceError, match="apt-get install bubblewrap") as caught:
        run_program([sys.executable, "-c", "open('ran', 'w')"], mine.workdir, sandbox=True)
    assert caught.value.exit_status == 3
    assert list(mine.workdir.iterdir()) == []


def test_no_sandbox_where_bubblewrap_is_denied(
    mine: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    denied = mine.workdir / "bwrap"
    denied.write_text("#!/bin/sh\necho 'No permissions to create a namespace' >&2\nexit 1\n")
    denied.chmod(0o755)
    monkeypatch.setenv("PATH", f"{mine.workdir}:{os.environ['PATH']}")
    reason = sandbox.sandbox_missing()
    assert reason is not None
    assert reason.endswith("No permissions to create a namespace")


# What it leaves in its workdir


def run_copy(place: Place, given: Path, name: str) -> ProgramEnd:
    """A program that writes, as its own, a file that somebody prepared."""
    code = "import shutil, sys\nshutil.copyfile(sys.argv[1], sys.argv[2])"
    return place.run(code, str(given), name)


@pytest.mark.parametrize(
    ("code", "refused"),
    [
        ("os.symlink(sys.argv[1], 'out.exr')", "a symbolic link among the files"),
        ("os.symlink(os.path.dirname(sys.argv[1]), 'out')", "a symbolic link among the files"),
        ("os.mkfifo('out.exr')", "a pipe among the files"),
        ("socket.socket(socket.AF_UNIX).bind('out.exr')", "a socket among the files"),
        ("open('a', 'w'); os.link('a', 'b')", "a second name"),
        ("open('a\\nb', 'w')", "a name that cannot be shown"),
        ("open(b'a\\xff', 'w')", "a name that cannot be shown"),
    ],
)
def test_what_is_no_plain_file_is_refused(mine: Place, code: str, refused: str) -> None:
    ended = mine.run(IMPORTS + code, str(mine.secret))
    assert ended.reason == "", ended
    with pytest.raises(InputError, match=refused) as caught:
        plain_files(mine.workdir)
    assert str(caught.value).isprintable()


def test_a_link_out_is_refused_without_a_sandbox_too(place: Place) -> None:
    code = "import os, sys\nos.symlink(sys.argv[1], 'out.exr')"
    assert place.run(code, str(place.secret), sandbox=False).reason == ""
    with pytest.raises(InputError, match="a symbolic link among the files"):
        plain_files(place.workdir)


def test_a_room_that_is_a_link_or_gone_is_refused(mine: Place) -> None:
    (mine.workdir / "link").symlink_to(mine.folder)
    with pytest.raises(InputError, match="not a folder"):
        plain_files(mine.workdir / "link")
    with pytest.raises(InputError, match="No such file"):
        plain_files(mine.workdir / "gone")


def test_more_than_can_be_counted_is_refused(mine: Place, monkeypatch: pytest.MonkeyPatch) -> None:
    (mine.workdir / "a" / "b").mkdir(parents=True)
    monkeypatch.setattr(scratch_folders, "MOST_ENTRIES", 1)
    with pytest.raises(InputError, match="more than 1 files"):
        plain_files(mine.workdir)
    monkeypatch.setattr(scratch_folders, "MOST_LEVELS", 1)
    with pytest.raises(InputError, match="nest more than 1 deep"):
        plain_files(mine.workdir)


def huge_exr(path: Path) -> None:
    """A true header, with the size in it replaced by 100,000 × 100,000."""
    spec = oiio.ImageSpec(4, 6, 1, "float")
    spec.channelnames = ("Z",)
    out = oiio.ImageOutput.create(str(path))
    assert out is not None
    assert out.open(str(path), spec)
    assert out.write_image(np.ones((6, 4, 1), dtype=np.float32))
    out.close()
    small = np.array([0, 0, 3, 5], dtype="<i4").tobytes()
    large = np.array([0, 0, 99_999, 99_999], dtype="<i4").tobytes()
    data = path.read_bytes()
    assert data.count(small) == 2
    path.write_bytes(data.replace(small, large))


def pickled(path: Path) -> None:
    np.savez(path, depth=np.full(SIZE, {"a": 1}, dtype=object))


def bomb(path: Path) -> None:
    """64 MiB of zeros in 64 KiB: the header promises 6 × 4 numbers."""
    header = {"descr": "<f8", "fortran_order": False, "shape": SIZE}
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive,
        archive.open("depth.npy", "w") as stream,
    ):
        np.lib.format.write_array_header_1_0(stream, header)
        for _ in range(64):
            stream.write(bytes(MIB))


def named(name: str) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        with zipfile.ZipFile(path, "w") as archive, archive.open(name, "w") as stream:
            np.lib.format.write_array(stream, np.ones(SIZE))

    return write


HOSTILE = {
    "huge.exr": (huge_exr, "wrong size|size"),
    "pickled.npz": (pickled, "type"),
    "bomb.npz": (bomb, "length is not the one in its header"),
    "leaves.npz": (named("../../hit.npy"), r"unknown quantity; got '\.\./\.\./hit\.npy'"),
    "script.npz": (named("<script>alert(1)</script>.npy"), "unknown quantity"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_frame_is_refused_with_its_own_message(mine: Place, name: str) -> None:
    write, refused = HOSTILE[name]
    write(mine.folder / name)
    assert run_copy(mine, mine.folder / name, name).reason == ""
    assert mine.workdir / name in plain_files(mine.workdir)
    begin = time.monotonic()
    with pytest.raises(InputError, match=refused):
        read_frame(mine.workdir / name, expect=SIZE)
    assert time.monotonic() - begin < 20


def test_a_folder_of_images_with_a_script_for_a_name(mine: Place) -> None:
    assert mine.run("import os\nos.mkdir('f'); open('f/<script>.png', 'w')").reason == ""
    assert len(plain_files(mine.workdir)) == 2
    with pytest.raises(InputError, match="<script>"):
        read_frame(mine.workdir / "f", expect=SIZE)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_frame_without_numbers_fails_in_the_comparison(mine: Place, value: float) -> None:
    document = minirt.load_scene("atlas:one-sphere").to_dict()
    document["screen"] |= {"nx": 16, "ny": 12}
    scene = minirt.load_scene(document)
    exact = Declared(delta=1e-6, vertex=0, angle=1e-6, color=1e-6, start=None, derivation="given")
    ours, stability = measure(scene, exact)
    wrong = np.where(ours["hit"], value, np.inf)
    write_frame(Frame({"depth": wrong}), mine.folder / "wrong.npz")
    assert run_copy(mine, mine.folder / "wrong.npz", "out.npz").reason == ""
    theirs = read_frame(mine.workdir / "out.npz", expect=(12, 16))
    checks = {c.quantity: c.state for c in compare(scene, ours, stability, theirs, {}).checks}
    assert checks["depth"] == "failed"


# Its own parts


def test_limits_are_for_a_picture_of_a_million_pixels() -> None:
    """Every quantity in float64: 8 bytes × 40 components at the very most."""
    assert Limits().file_bytes >= 8 * 40 * 1e6
    assert replace(Limits(), processes=3).memory == Limits().memory


def wait_until(done: Callable[[], bool], patience: float = 30.0) -> None:
    deadline = time.monotonic() + patience
    while not done():
        assert time.monotonic() < deadline
        time.sleep(0.02)
