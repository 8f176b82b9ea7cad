"""A crash leaves the old file or folder, whole; so does an error, without a trace."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from converters import atomic
from converters.atomic import atomic_file, atomic_folder
from converters.frames.io import read_frame, write_frame
from minirt.errors import InputError
from minirt.frame import Frame

#: Writes a frame slowly, one row a block, and says so after the first row.
SLOW_WRITER = """
import sys, time
import numpy as np
from converters.frames import images, io, npz
from minirt.frame import Frame
npz._BLOCK_BYTES = images.BLOCK_BYTES = 1
class Slow(np.ndarray):
    def __getitem__(self, key):
        if isinstance(key, slice) and key.start > 0:
            print("writing", flush=True)
            time.sleep(60)
        return super().__getitem__(key)
depth = np.ones((40, 40)).view(Slow)
io.write_frame(Frame({"depth": depth}), sys.argv[1])
"""


@pytest.mark.parametrize("name", ["f.npz", "f.exr", "f.d"])
def test_a_killed_writer_leaves_the_old_frame_whole(name: str, tmp_path: Path) -> None:
    old = Frame({"depth": np.arange(6.0).reshape(2, 3)}, {"scene": "old"})
    write_frame(old, tmp_path / name)
    command = [sys.executable, "-c", SLOW_WRITER, str(tmp_path / name)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "writing\n"
        assert len(list(tmp_path.iterdir())) == 2, "the new one is on its way"
        child.kill()
        assert child.wait(10) == -signal.SIGKILL
    read = read_frame(tmp_path / name)
    np.testing.assert_array_equal(read["depth"], old["depth"])
    assert read.meta == old.meta
    write_frame(old, tmp_path / name)
    assert set(read_frame(tmp_path / name)) == {"depth"}


@pytest.mark.parametrize("exchange", [True, False])
def test_a_folder_replaces_another(
    exchange: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the system's exchange of names, and with two renamings where there is none."""
    if not exchange:
        monkeypatch.setattr(atomic, "_exchange", lambda first, second: False)
    for round_ in ("first", "second"):
        with atomic_folder(tmp_path / "out") as folder:
            (folder / round_).write_text("x")
    assert [p.name for p in (tmp_path / "out").iterdir()] == ["second"]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_the_exchange_is_one_step_here(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    (tmp_path / "a" / "x").touch()
    assert atomic._exchange(tmp_path / "a", tmp_path / "b") == sys.platform.startswith("linux")
    assert (tmp_path / "b" / "x").exists() == sys.platform.startswith("linux")


@pytest.mark.parametrize("kind", [RuntimeError, KeyboardInterrupt])
def test_an_error_leaves_no_temporary_file(kind: type[BaseException], tmp_path: Path) -> None:
    (tmp_path / "old.txt").write_text("old")

    def half(path: Path) -> None:
        path.write_text("half")
        raise kind

    with pytest.raises(kind), atomic_file(tmp_path / "old.txt") as path:
        half(path)
    with pytest.raises(kind), atomic_folder(tmp_path / "new") as folder:
        half(folder / "file")
    assert [p.name for p in tmp_path.iterdir()] == ["old.txt"]
    assert (tmp_path / "old.txt").read_text() == "old"


def test_a_full_disk_is_one_clear_error(tmp_path: Path) -> None:
    """A limit on the size of files stands in for it."""
    code = (
        "import resource, signal, sys, numpy as np\n"
        "from converters.frames.io import write_frame; from minirt.frame import Frame\n"
        "from minirt.errors import InputError\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000))\n"
        "depth = np.random.default_rng(1).random((200, 200))\n"
        "try: write_frame(Frame({'depth': depth}), sys.argv[1])\n"
        "except InputError as error: print(error)"
    )
    for name in ("f.npz", "f.exr", "f.d"):
        command = [sys.executable, "-c", code, str(tmp_path / name)]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        assert run.stdout.startswith(f"{tmp_path / name}: cannot be written; got "), run.stdout
    assert not list(tmp_path.iterdir())


def test_links_are_followed_and_folders_kept(tmp_path: Path) -> None:
    (tmp_path / "real.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to("real.txt")
    with atomic_file(tmp_path / "link.txt") as path:
        path.write_text("new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "real.txt").read_text() == "new"


def test_the_file_has_the_permissions_of_any_new_file(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("")
    with atomic_file(tmp_path / "f.txt") as path:
        path.write_text("")
        assert path.suffix == ".txt"
    assert (tmp_path / "f.txt").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_target_that_cannot_be_replaced_is_refused(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    (tmp_path / "loop").symlink_to("loop")
    for file in ("folder", "no/file", "loop", "x" * 300, "a\0b", "/dev/null"):
        with pytest.raises(InputError), atomic_file(tmp_path / file) as path:
            path.touch()
    for folder in ("file", "no/folder", "loop", "x" * 300, "a\0b"):
        with pytest.raises(InputError), atomic_folder(tmp_path / folder):
            pass
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "folder", "loop"]


def test_a_reader_never_sees_half_a_file(tmp_path: Path) -> None:
    """A child replaces a file as fast as it can; each read gives one whole version."""
    code = (
        "import sys, itertools; from converters.atomic import atomic_file\n"
        "for k in itertools.count():\n"
        "    with atomic_file(sys.argv[1]) as p: p.write_text(str(k % 10) * 100_000)"
    )
    target = tmp_path / "f.txt"
    target.write_text("x" * 100_000)
    seen: set[str] = set()
    with subprocess.Popen([sys.executable, "-c", code, str(target)]) as child:
        end = time.monotonic() + 20
        while len(seen) < 5 and time.monotonic() < end:
            text = target.read_text()
            assert text == text[:1] * 100_000
            seen.add(text[:1])
        child.kill()
    assert len(seen) >= 5
