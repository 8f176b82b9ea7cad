"""What the inspector shows is what minirt has: steps, rays in space, the pixels that are chosen."""

from __future__ import annotations

import json

import numpy as np
import pytest

import minirt
from minirt.explain.pixel import explain
from reports.explain.space import lines_of, surroundings
from reports.page.inspector import arrays, details
from reports.page.inspector.details import Details, typical_pixels
from tests.helpers.fake_references import Faulty, Honest, OnePixel, small_scene
from tests.helpers.report_runs import result_of


@pytest.fixture(scope="module")
def found() -> dict[str, Details]:
    result = result_of(small_scene(), [Honest(), Faulty(), OnePixel()])
    return {answer.reference: answer.details for answer in result.references}


def test_what_passes_leaves_no_arrays_and_what_fails_leaves_all(
    found: dict[str, Details],
) -> None:
    assert (found["honest"].arrays, found["honest"].first_stage) == ({}, None)
    assert (found["honest"].clusters, found["honest"].worst) == ((), ())
    for name in ("faulty", "one-pixel"):
        assert len(found[name].arrays) == 20
        assert found[name].first_stage is not None
    first = next(iter(found["faulty"].arrays))
    assert first == "shadow", "what fails first is packed first"


def test_of_a_vast_image_no_arrays_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(arrays, "MOST_PIXELS", 100)
    (answer,) = result_of(small_scene(), [Faulty()]).references
    assert answer.details.arrays == {}
    assert answer.details.clusters != ()
    assert len(answer.details.explanations) > 5


def test_when_time_is_up_no_more_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(details, "TIME_LIMIT", 0.0)
    (answer,) = result_of(small_scene(), [Faulty()]).references
    assert len(answer.details.explanations) == 1
    assert len(answer.details.rows) > 5


def test_everybody_explains_the_pixels_where_anybody_fails(
    found: dict[str, Details],
) -> None:
    pixels = set(found["honest"].rows)
    assert {(10, 30), (20, 31)} <= pixels, "one-pixel's wrong ones"
    assert all(set(each.rows) == set(each.explanations) == pixels for each in found.values())
    wrong = {row.quantity for row in found["one-pixel"].rows[10, 30] if row.wrong}
    assert wrong == {"shadow"}
    assert not any(row.wrong for rows in found["honest"].rows.values() for row in rows)


def test_clusters_and_worst_pixels_are_those_of_the_fault(found: dict[str, Details]) -> None:
    one = found["one-pixel"]
    assert one.cluster_count == 2
    assert [(c.stage, c.size, c.column, c.row) for c in one.clusters] == [
        ("t", 1, 20, 31), ("shadow", 1, 10, 30),
    ]  # fmt: skip
    assert [(w.column, w.row, w.quantity) for w in one.worst] == [
        (20, 31, "depth"), (10, 30, "shadow"),
    ]  # fmt: skip


def test_the_page_holds_the_explanation_itself(found: dict[str, Details]) -> None:
    scene = small_scene()
    for (column, row), text in found["faulty"].explanations.items():
        told = json.loads(text)
        assert told["steps"] == explain(scene, column, row).to_dict()["steps"]


def test_typical_pixels_lie_on_what_covers_most() -> None:
    frame = minirt.render(small_scene())
    pixels = typical_pixels(frame)
    seen = [int(frame["object"][row, column]) for column, row in pixels]
    assert sorted(seen) == [0, 1]
    empty = minirt.render(minirt.load_scene({**small_scene().to_dict(), "objects": []}))
    assert len(typical_pixels(empty)) == 1


def test_rays_in_space_end_where_the_frame_says() -> None:
    scene = small_scene()
    frame = minirt.render(scene)
    column, row = 21, 25
    lines = {line.kind: line for line in lines_of(scene, explain(scene, column, row))}
    assert set(lines) == {"ray", "normal", "shadow", "reflected", "refracted"}
    position = frame["position"][row, column]

    def end(kind: str) -> np.ndarray:
        line = lines[kind]
        assert line.length is not None
        return np.array(line.start) + line.length * np.array(line.direction)

    assert lines["ray"].start == scene.screen.P0
    assert np.allclose(end("ray"), position, atol=1e-12)
    for kind in ("normal", "shadow", "reflected", "refracted"):
        assert np.array_equal(lines[kind].start, position)
        assert np.linalg.norm(lines[kind].direction) == pytest.approx(1)
    assert lines["shadow"].meets == "object 0 'ball'"
    assert np.linalg.norm(end("shadow")) == pytest.approx(1), "the ball's surface"
    assert lines["reflected"].length == frame["reflection_t"][row, column]
    assert end("reflected")[1] == pytest.approx(-1), "the floor"


def test_a_ray_that_meets_nothing_is_alone() -> None:
    scene = small_scene()
    (line,) = lines_of(scene, explain(scene, 0, 0))
    assert (line.kind, line.length, line.meets) == ("ray", None, "nothing")


def test_the_screen_and_the_objects_are_where_they_are() -> None:
    scene = minirt.load_scene("atlas:closed-mesh")
    drawn = surroundings(scene)
    screen, P0 = scene.screen, np.array(scene.screen.P0)
    corners = np.array(drawn["screen"])
    assert np.allclose((corners - P0) @ np.array(screen.n), screen.nu)
    assert np.allclose(
        (corners - P0) @ np.array(screen.u), [screen.l, screen.r, screen.r, screen.l]
    )
    assert np.allclose(
        (corners - P0) @ np.array(screen.v), [screen.b, screen.b, screen.t, screen.t]
    )
    mesh = next(thing for thing in drawn["objects"] if thing["type"] == "mesh")
    assert 0 < len(mesh["edges"]) <= 400
    assert mesh["left out"] > 0
    assert np.array(mesh["edges"]).max() == len(mesh["vertices"]) - 1
    ball, floor = surroundings(small_scene())["objects"]
    assert (ball["center"], ball["radius"]) == ([0, 0, 0], 1)
    assert floor["edges"] == [[0, 1], [1, 2], [2, 3], [3, 0]]
    assert floor["left out"] == 0
