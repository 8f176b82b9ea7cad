"""The commands and tests that a report offers to copy do what they say."""

from __future__ import annotations

import ast
import shlex
from dataclasses import replace

import minirt
from reports.page.rerun import ready_test, rerun_command, source_of
from reports.results.findings import findings_of
from reports.results.record import Run
from tests.helpers.fake_references import small_scene
from tests.helpers.report_runs import good_run


def run_by(command: str) -> Run:
    run = good_run()
    return replace(run, provenance=replace(run.provenance, command=command))


def test_a_scene_of_the_atlas_is_named_so_and_one_like_it_is_not() -> None:
    scene = minirt.load_scene("atlas:one-sphere")
    assert source_of(good_run(), scene) == "atlas:one-sphere"
    other = minirt.load_scene({**scene.to_dict(), "about": "another"})
    assert source_of(good_run(), other) == "SCENE.json"


def test_a_scene_from_a_file_is_found_in_the_command_line() -> None:
    run = run_by("minirt gate scenes/ball.json second.json --python tracer:render")
    assert source_of(run, small_scene()) == "scenes/ball.json"
    assert source_of(run, small_scene("unknown")) == "SCENE.json"
    alone = replace(run_by("minirt gate x.json"), findings=findings_of(run.results[:1]))
    assert source_of(alone, small_scene()) == "x.json"


def test_the_command_names_the_implementation_that_was_judged() -> None:
    run = run_by("minirt gate ball.json --cmd './t {scene} {out}' --precision=float32 --out o -j 2")
    words = shlex.split(rerun_command(run, small_scene()))
    assert words == ["minirt", "explain", "ball.json", "--pixel", "COLUMN", "ROW", "--cmd",
                     "./t {scene} {out}", "--precision=float32"]  # fmt: skip
    verified = run_by("minirt verify ball.json --reference embree --timeout 9")
    assert "--timeout" not in rerun_command(verified, small_scene())


def test_the_tests_are_programs() -> None:
    run = run_by("minirt verify ball.json")
    for reference in ("embree", "subject"):
        text = ready_test(run, small_scene('ba"ll'), reference).replace("COLUMN", "1")
        (function,) = [n for n in ast.parse(text).body if isinstance(n, ast.FunctionDef)]
        assert function.name.startswith("test_ba_ll_")
    assert "choose_references(['embree'])" in ready_test(run, small_scene(), "embree")
