"""Whole runs, with child processes, into a folder."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from minirt.errors import InputError
from reference.verify.options import Options
from reports.run import REPORTS, RunOptions, run_verify
from tests.helpers.fake_references import Aborting, Honest, Missing, OnePixel, small_scene


def options(*required: str) -> RunOptions:
    """One process of each kind, and some references that must answer."""
    return RunOptions(Options(jobs=1), required)


def test_a_good_run_leaves_every_report_and_tells_its_progress(tmp_path: Path) -> None:
    told = []

    def progress(done: int, total: int) -> None:
        told.append((done, total))

    scenes = [small_scene("one"), small_scene("two")]
    both = [Honest(), Honest("other")]
    run = run_verify(scenes, both, tmp_path / "new" / "folder", options("honest"), progress)
    assert run.exit_status == 0, run.verdict
    assert told == [(1, 2), (2, 2)]
    assert {path.name for path in run.folder.iterdir()} == set(REPORTS)
    document = json.loads((run.folder / "results.json").read_text(encoding="utf-8"))
    assert document["verdict"]["outcome"] == "passed"
    assert all(scene["seconds"] > 0 for scene in document["scenes"])
    assert all(scene["peak_memory"] > 2**20 for scene in document["scenes"])
    answer = run.results[0].references[0]
    assert set(answer.details.pictures) == {check.quantity for check in answer.checks}
    portraits = [result.thumbnail for result in run.results]
    assert [(p.width, p.height) for p in portraits] == [(48, 36), (48, 36)]
    drawn = [quorum.drawn for quorum in run.results[0].quorum]
    assert [(map_.width, map_.height) for map_ in drawn] == [(48, 36)] * len(answer.checks)
    page = (run.folder / "report.html").read_text(encoding="utf-8")
    assert page.count("how many references confirm each pixel") == 2 * len(answer.checks)


def test_one_wrong_pixel_fails_the_run_even_where_a_reference_crashes(tmp_path: Path) -> None:
    references = [OnePixel(), Aborting(), Missing()]
    run = run_verify([small_scene()], references, tmp_path, options("missing"))
    assert run.exit_status == 1
    assert "aborting crashed on 1 of 1 scene" in run.verdict.troubles
    document = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    output = {a["reference"]: a["output"] for a in document["scenes"][0]["references"]}
    assert "LLVM ERROR: cannot select" in output["aborting"]


def test_no_scene_is_red_and_replaces_the_green_report(tmp_path: Path) -> None:
    (tmp_path / "summary.md").write_text("# PASS", encoding="utf-8")
    (tmp_path / "notes.txt").write_text("mine", encoding="utf-8")
    run = run_verify([], [Honest()], tmp_path)
    assert run.exit_status == 2
    assert "no scene was chosen" in (tmp_path / "summary.md").read_text(encoding="utf-8")
    assert (tmp_path / "notes.txt").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("name", ["file", "file/below", "bad\0name"])
def test_a_folder_that_cannot_be_written_is_said_before_anything_is_rendered(
    name: str, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be written"):
        run_verify([small_scene()], [Aborting()], tmp_path / name)
