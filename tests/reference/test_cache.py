"""What is kept on disk is what would be computed, and nothing stale is ever found."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import minirt
from reference import cache as cache_module
from reference.cache import Cache
from reference.compare.comparison import compare
from reference.compare.stability import exact_answer, stability_of
from reference.registry import REFERENCES
from reference.source import Rendering, Reproducible
from reference.verify.options import Options
from reports.run import RunOptions, run_verify
from tests.helpers.fake_references import Honest, small_scene

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


@dataclass(frozen=True)
class Repeatable(Honest):
    """Renders honestly, says what that depends on, and counts how often it is asked."""

    parts: tuple[str | Path | None, ...] = ("numpy", "no such distribution", None)

    def ingredients(self) -> tuple[str | Path | None, ...]:
        return self.parts

    def render(self, scene: minirt.Scene, scratch: Path) -> Rendering:
        with (scratch / "asked").open("a") as log:
            log.write("x")
        made = super().render(scene, scratch)
        return replace(made, unsupported={"alpha": "has none"}, program="repeatable 1")


def asked(folder: Path) -> int:
    return len((folder / "asked").read_text()) if (folder / "asked").exists() else 0


def test_a_reference_is_asked_once(tmp_path: Path) -> None:
    kept, scene = Cache(tmp_path / "cache"), small_scene()
    first, seconds, old = kept.rendering(Repeatable(), scene, tmp_path)
    assert not old
    assert asked(tmp_path) == 1
    again, as_before, old = kept.rendering(Repeatable(), scene, tmp_path)
    assert old
    assert asked(tmp_path) == 1
    assert as_before == seconds
    assert (again.unsupported, again.program) == (first.unsupported, first.program)
    assert again.frame.keys() == first.frame.keys()
    assert all(again.frame[k].tobytes() == first.frame[k].tobytes() for k in first.frame)


def test_another_ingredient_asks_a_reference_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept, scene, program = Cache(tmp_path / "cache"), small_scene(), tmp_path / "program"
    program.write_text("one")
    dangling = tmp_path / "dangling"
    dangling.symlink_to(tmp_path / "gone")
    for parts in (("numpy",), ("scipy",), (program,), (None,), (dangling,)):
        kept.rendering(Repeatable(parts=parts), scene, tmp_path)
    assert asked(tmp_path) == 5
    program.write_text("another")
    kept.rendering(Repeatable(parts=(program,)), scene, tmp_path)
    kept.rendering(Repeatable("another name", parts=(None,)), scene, tmp_path)
    kept.rendering(Repeatable(parts=(None,)), small_scene(max_depth=1), tmp_path)
    assert asked(tmp_path) == 8
    monkeypatch.setattr(cache_module, "_processor", lambda: "another processor")
    kept.rendering(Repeatable(parts=(None,)), scene, tmp_path)
    assert asked(tmp_path) == 9


def test_what_names_no_ingredients_is_never_kept(tmp_path: Path) -> None:
    kept = Cache(tmp_path / "cache")
    for _ in range(2):
        assert not kept.rendering(Honest(), small_scene(), tmp_path)[2]
    assert not (tmp_path / "cache").exists()


def test_a_spoilt_answer_is_asked_for_again(tmp_path: Path) -> None:
    kept, scene = Cache(tmp_path / "cache"), small_scene()
    expected = kept.rendering(Repeatable(), scene, tmp_path)[0].frame
    (file,) = (tmp_path / "cache").iterdir()
    whole = dict(np.load(file))
    for spoilt in (
        {**whole, "about": np.array("{}")},
        {**whole, "about": np.array("no JSON")},
        {**whole, "colour": whole["depth"]},
        {name: array for name, array in whole.items() if name != "about"},
    ):
        np.savez(file, **spoilt)
        rendering, _, old = kept.rendering(Repeatable(), scene, tmp_path)
        assert not old
        assert rendering.frame["depth"].tobytes() == expected["depth"].tobytes()
    assert kept.rendering(Repeatable(), scene, tmp_path)[2]


def test_every_usual_reference_says_what_it_depends_on() -> None:
    for reference in REFERENCES.values():
        assert isinstance(reference, Reproducible), reference.name
        assert any(reference.ingredients()), reference.name


def test_a_run_says_which_frames_were_kept(tmp_path: Path) -> None:
    kept, scenes = Cache(tmp_path / "cache"), [small_scene()]
    (tmp_path / "asked").touch()
    options = RunOptions(Options(jobs=1, cache=kept))
    first = run_verify(scenes, [Repeatable(), Honest("other")], tmp_path / "a", options)
    again = run_verify(scenes, [Repeatable(), Honest("other")], tmp_path / "b", options)
    assert first.exit_status == again.exit_status == 0
    assert first.remarks == ()
    assert len(again.remarks) == 1
    assert again.remarks[0].startswith("1 of 2 frames of references")
    assert again.remarks[0] in (tmp_path / "b" / "report.html").read_text(encoding="utf-8")
