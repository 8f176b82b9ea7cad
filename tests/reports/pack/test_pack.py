"""Packs: the same bytes everywhere, one flipped bit found, nothing replaced without a record."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import minirt
from converters.scene_folder import plain_document
from minirt.errors import InputError, ReferenceError
from minirt.scene import Scene
from reports.cli.main import run
from reports.pack.check import check_scene, differences
from reports.pack.confirm import PackOptions
from reports.pack.make import approve_pack, make_pack
from reports.pack.manifest import CHECKSUM, MANIFEST, files_in, read_manifest, write_manifest
from tests.helpers.fake_references import Honest, InsideOut, Missing, small_scene


def small(name: str = "ball", light: float = -1.0) -> Scene:
    document = small_scene(name).to_dict()
    document["screen"] |= {"nx": 16, "ny": 12}
    document["light"] |= {"direction": [light, -2.0, -1.0]}
    return minirt.load_scene(document)


#: Only exact arithmetic confirms.
ALONE = PackOptions(jobs=1)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("packs") / "pack"
    make_pack(
        [small("ball"), small("another <ball>")], folder, PackOptions([Honest()], ["honest"], 1)
    )
    return folder


@pytest.fixture
def pack(made: Path, tmp_path: Path) -> Path:
    return shutil.copytree(made, tmp_path / "pack")


def said(pack: Path) -> list[str]:
    """What differs, found in this process: a pool for each test would be slow."""
    return [
        f"{entry.name}: {what}"
        for entry in read_manifest(pack).scenes
        for what in check_scene(pack, entry)
    ]


def test_a_pack_holds_each_scene_and_says_who_confirms_it(made: Path) -> None:
    manifest = read_manifest(made)
    assert [entry.name for entry in manifest.scenes] == ["ball", "another <ball>"]
    ball = manifest.scenes[0]
    assert set(ball.files) == {
        "scene.json", "frame.npz", "frame.exr", "sheet.png",
        "uncertain-float64.npz", "uncertain-float32.npz", "uncertain-half.npz",
    }  # fmt: skip
    assert (made / ball.folder / "sheet.png").read_bytes()[1:4] == b"PNG"
    assert ball.quantities["t"].confirmed_by == ["honest", "judge"]
    assert ball.quantities["color"].confirmed_by == ["honest"]
    allowed = [
        ball.quantities["depth"].precisions[p].median for p in ("float64", "float32", "half")
    ]
    assert 0 < float(allowed[0] or 0) < float(allowed[1] or 0) < float(allowed[2] or 0)
    text = (made / MANIFEST).read_text(encoding="ascii")
    assert str(made.parent) not in text
    assert list(differences(made, jobs=1)) == []


DISABLED = {"NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F", "OPENBLAS_CORETYPE": "Nehalem"}


@pytest.mark.full
def test_the_same_pack_has_the_same_bytes_with_and_without_simd(tmp_path: Path) -> None:
    scene = tmp_path / "ball.json"
    scene.write_text(json.dumps(plain_document(small())), encoding="utf-8")
    for name, more in (("one", {}), ("two", DISABLED)):
        words = ["pack", str(scene), "-o", str(tmp_path / name), "--reference", "none"]
        code = "import sys; from reports.cli.main import run; sys.exit(run(sys.argv[1:]))"
        done = subprocess.run(
            [sys.executable, "-W", "ignore", "-c", code, *words], env={**os.environ, **more}
        )
        assert done.returncode == 0
    assert files_in(tmp_path / "one") == files_in(tmp_path / "two")


@pytest.mark.parametrize(
    ("file", "words"),
    [("frame.npz", "frame.npz: other bytes"), ("frame.exr", "frame.exr: other bytes"),
     ("sheet.png", "sheet.png: other bytes"), ("scene.json", "scene.json: other bytes"),
     ("uncertain-half.npz", "uncertain-half.npz: other bytes")],
)  # fmt: skip
def test_one_flipped_bit_of_any_file_is_found(pack: Path, file: str, words: str) -> None:
    path = pack / "ball" / file
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    found = said(pack)
    assert f"ball: {words} than were packed" in found
    assert all(line.startswith("ball: ") for line in found)


def test_a_changed_value_is_named_with_its_pixel(pack: Path) -> None:
    from converters.frames.io import read_frame, write_frame
    from minirt.frame import Frame

    frame = read_frame(pack / "ball" / "frame.npz")
    depth = frame["depth"].copy()
    depth[7, 5] *= 1 + 2.0**-52
    write_frame(Frame({**frame.arrays, "depth": depth}, frame.meta), pack / "ball" / "frame.npz")
    found = said(pack)
    assert run(["pack", "verify", str(pack), "-j", "1"]) == 1
    assert any("depth: 1 of 192 pixels differ, the first at column 5, row 7" in x for x in found)


def test_what_is_missing_or_strange_is_found(pack: Path) -> None:
    (pack / "ball" / "frame.exr").unlink()
    (pack / "ball" / "more.txt").write_text("x", encoding="utf-8")
    (pack / "stray").mkdir()
    found = [f"{each.scene}: {each.what}" for each in differences(pack, jobs=1)]
    assert "ball: frame.exr: missing" in found
    assert "ball: more.txt: not in the manifest" in found
    assert ": stray: not in the manifest" in found


@pytest.mark.parametrize("name", [MANIFEST, CHECKSUM])
def test_one_flipped_bit_of_the_manifest_is_found(
    name: str, pack: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = bytearray((pack / name).read_bytes())
    content[40] ^= 1
    (pack / name).write_bytes(content)
    assert run(["pack", "verify", str(pack)]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert "manifest.json is not the one that manifest.sha256 was written for" in said
    words = ["pack", "approve", str(pack), "--who", "Ada", "--why", "b", "--reference", "none"]
    assert run(words) == 2


def test_a_folder_without_a_manifest_is_no_pack(pack: Path) -> None:
    assert run(["pack", "verify", str(pack / "ball")]) == 2


def test_a_manifest_leads_nowhere_else(pack: Path) -> None:
    manifest = read_manifest(pack)
    away = manifest.scenes[0].model_copy(update={"folder": "../elsewhere"})
    write_manifest(manifest.model_copy(update={"scenes": [away]}), pack)
    with pytest.raises(InputError, match=r"scenes\.0\.folder"):
        read_manifest(pack)


def test_what_a_reference_contradicts_is_not_packed(tmp_path: Path) -> None:
    with pytest.raises(ReferenceError, match="not confirmed, so nothing was packed"):
        make_pack([small()], tmp_path / "pack", PackOptions([InsideOut()], jobs=1))
    with pytest.raises(ReferenceError, match="missing is missing"):
        make_pack([small()], tmp_path / "pack", PackOptions([Honest(), Missing()], ["missing"], 1))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.full
def test_other_frames_are_not_packed_over_but_approved(pack: Path) -> None:
    before = files_in(pack)
    with pytest.raises(InputError, match="other frames; got ball"):
        make_pack([small(light=-1.5), small("another <ball>")], pack, ALONE)
    with pytest.raises(InputError, match="scenes that would be lost; got another <ball>"):
        make_pack([small()], pack, ALONE)
    for who, why in (("", "a reason"), ("Ada", " ")):
        with pytest.raises(InputError, match="an approval says who and why"):
            approve_pack(pack, [small(light=-1.5)], who, why, ALONE)
    assert files_in(pack) == before
    (record,) = approve_pack(pack, [small(light=-1.5)], "Ada", "the light moved", ALONE)
    assert (record.scene, record.who, record.why) == ("ball", "Ada", "the light moved")
    assert record.old["depth"] == record.new["depth"]
    assert record.old["color"] != record.new["color"]
    assert read_manifest(pack).approvals == [record]
    assert said(pack) == []
    kept = {name: h for name, h in before.items() if name.startswith("another")}
    assert kept.items() <= files_in(pack).items()
    assert approve_pack(pack, [small(light=-1.5)], "Ada", "again", ALONE) == ()


def test_only_the_missing_are_added(pack: Path, tmp_path: Path) -> None:
    scene = tmp_path / "third.json"
    scene.write_text(json.dumps(plain_document(small("third"))), encoding="utf-8")
    words = ["pack", "approve", str(pack), str(scene), "--who", "Ada", "--why", "more"]
    words += ["--reference", "none", "-j", "1"]
    assert run([*words, "--only", "failing"]) == 0
    assert len(read_manifest(pack).scenes) == 2
    assert run([*words, "--only", "missing"]) == 0
    assert [entry.name for entry in read_manifest(pack).scenes] == [
        "ball",
        "another <ball>",
        "third",
    ]
    assert [record.old for record in read_manifest(pack).approvals] == [{}]


def test_a_folder_of_something_else_stays(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("x", encoding="utf-8")
    with pytest.raises(InputError, match="holds other files"):
        make_pack([small()], tmp_path, ALONE)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


@pytest.mark.full
def test_a_kill_leaves_the_old_pack_whole(pack: Path) -> None:
    before = files_in(pack)
    words = ["pack", "approve", str(pack), "--who", "A", "--why", "b", "--only", "all"]
    code = "import sys; from reports.cli.main import run; sys.exit(run(sys.argv[1:]))"
    command = [sys.executable, "-c", code, *words, "--reference", "none", "-j", "1"]
    child = subprocess.Popen(command, start_new_session=True)
    end = time.monotonic() + 60
    while time.monotonic() < end and not list(pack.parent.glob(".*/*")):
        time.sleep(0.01)
    os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    assert files_in(pack) == before
    assert said(pack) == []
