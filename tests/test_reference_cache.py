"""What is kept on disk is what would be computed, and nothing stale is ever found."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from fake_references import Honest, small_scene

import minirt
from reference import cache as cache_module
from reference.cache import Cache
from reference.compare import compare
from reference.stability import exact_answer, stability_of

NAMES = {"hit", "depth", "shadow"}


def files(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_a_second_call_gives_the_same_bits_from_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, scene = Cache(tmp_path / "new"), small_scene()
    declared = Honest().declare(scene)
    first = kept.exact(scene)
    stable = kept.stability(first, declared, NAMES)
    assert len(files(tmp_path / "new")) == 2
    for name in ("exact_answer", "stability_of"):
        monkeypatch.delattr(cache_module, name)
    again = kept.exact(scene)
    assert again.signature.tobytes() == first.signature.tobytes()
    assert list(again.frame) == list(minirt.QUANTITIES)
    for name in again.frame:
        assert again.frame[name].tobytes() == minirt.render(scene)[name].tobytes()
    found = kept.stability(again, replace(declared, derivation="in other words"), NAMES)
    for ours, theirs in ((stable.certain, found.certain), (stable.tolerance, found.tolerance)):
        assert ours.keys() == theirs.keys()
        assert all(ours[name].tobytes() == theirs[name].tobytes() for name in ours)
    comparison = compare(scene, again.frame, found, again.frame, {}, sorted(NAMES))
    assert comparison.passed


def test_whatever_changes_the_answer_changes_the_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, scene = Cache(tmp_path), small_scene()
    declared = Honest().declare(scene)
    exact = kept.exact(scene)
    kept.exact(small_scene(max_depth=1))
    kept.stability(exact, declared, NAMES)
    kept.stability(exact, declared, {"hit"})
    kept.stability(exact, replace(declared, delta=2 * declared.delta), NAMES)
    assert len(files(tmp_path)) == 5
    monkeypatch.setattr(cache_module, "_program", lambda: "another version")
    kept.exact(scene)
    assert len(files(tmp_path)) == 6


def test_a_mesh_of_the_same_name_with_other_vertices_is_another_scene(tmp_path: Path) -> None:
    mesh = {"type": "mesh", "material": "gray", "file": "m.obj"}
    kept, found = Cache(tmp_path / "cache"), []
    for x in (1, 2):
        folder = tmp_path / str(x)
        folder.mkdir()
        (folder / "m.obj").write_text(f"v 0 0 0\nv {x} 0 0\nv 0 1 0\nf 1 2 3\n")
        document = small_scene(objects=[]).to_dict() | {"objects": [mesh]}
        found.append(kept.exact(minirt.load_scene(document, folder)).frame["hit"].sum())
    assert found[0] < found[1]


def test_a_broken_file_is_computed_anew_and_an_unwritable_folder_is_borne(tmp_path: Path) -> None:
    kept, scene = Cache(tmp_path), small_scene()
    expected = exact_answer(scene).frame["depth"].tobytes()
    kept.exact(scene)
    (path,) = tmp_path.iterdir()
    path.write_bytes(path.read_bytes()[:1000])
    assert kept.exact(scene).frame["depth"].tobytes() == expected
    assert path.stat().st_size > 1000
    file = tmp_path / "file"
    file.write_text("not a folder")
    assert Cache(file).exact(scene).frame["depth"].tobytes() == expected


def test_it_stays_within_its_bound_and_keeps_what_was_used_last(tmp_path: Path) -> None:
    scenes = [small_scene(f"scene {k}") for k in range(4)]
    Cache(tmp_path).exact(scenes[0])
    (first,) = tmp_path.iterdir()
    kept = Cache(tmp_path, most_bytes=int(2.5 * first.stat().st_size))
    for scene in scenes[1:]:
        kept.exact(scene)
    assert len(files(tmp_path)) == 2
    assert first.name not in files(tmp_path)
    before = files(tmp_path)
    kept.exact(scenes[-1])
    assert files(tmp_path) == before


def test_stability_is_that_of_the_scene_itself(tmp_path: Path) -> None:
    scene = small_scene()
    exact = exact_answer(scene)
    declared = Honest().declare(scene)
    ours = stability_of(exact, declared, NAMES)
    found = Cache(tmp_path).stability(exact, declared, NAMES)
    assert all((ours.certain[name] == found.certain[name]).all() for name in NAMES)
