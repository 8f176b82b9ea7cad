"""What is certain stays right under any error within δ; what is not certain is little."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import minirt
from minirt.culling import squares
from minirt.frame import Frame
from minirt.points import Branch, Points
from minirt.rays import Rays
from minirt.render import blank_frame, fill, trace_pixels
from minirt.rules import SLIDES
from minirt.scene import Facets, Scene
from minirt.vectors import Floats, Index, dot, norm
from minirt.whitted import Whitted
from reference.compare.comparison import compare
from reference.compare.displaced import perpendicular, sideways
from reference.compare.stability import measure
from reference.renderers.embree.source import EmbreeReference
from reference.source import AlongRay, Declared, NormalOffset
from tests.helpers.tiers import tiered

U32 = 2.0**-24


def scene_of(objects: list[dict[str, Any]], folder: Path = Path(), **changes: Any) -> Scene:
    """Objects seen from z = 5 towards the origin, on 64 × 48 pixels."""
    document: dict[str, Any] = {
        "minirt": 1,
        "name": "test",
        "screen": {
            "P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
            "l": -0.5, "r": 0.5, "b": -0.375, "t": 0.375, "nx": 64, "ny": 48,
        },
        "light": {"direction": [-1, -2, -1]},
        "materials": {
            "paint": {"diffuse": [0.8, 0.2, 0.2]},
            "glass": {"ior": 1.5, "transmittance": 0.7, "reflectance": 0.2},
        },
        "objects": objects,
        **changes,
    }  # fmt: skip
    return minirt.load_scene(document, folder=folder)


def declared(scene: Scene, roundings: float = 10.0) -> Declared:
    size = roundings * U32 * scene.extent
    return Declared(size, size / 5, 10 * U32, 10 * U32, NormalOffset(1500 * U32), "")


def random_scene(seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    objects: list[dict[str, Any]] = []
    for k in range(24):
        centre = rng.uniform(-1.5, 1.5, 3)
        material = ("paint", "glass")[k % 2]
        if k % 3:
            radius = rng.uniform(0.05, 0.5)
            objects.append({"type": "sphere", "center": centre.tolist(), "radius": radius})
        else:
            corners = centre + rng.normal(scale=0.6, size=(3, 3))
            objects.append({"type": "triangle", "vertices": corners.tolist()})
        objects[-1]["material"] = material
    return scene_of(objects)


class Sloppy(Whitted):
    """An honest renderer that errs by up to δ: every ray somewhere within δ of the right one."""

    def __init__(self, scene: Scene, error: Declared, seed: int) -> None:
        super().__init__(scene)
        self.error, self.rng = error, np.random.default_rng(seed)

    def _jitter(self, d: Floats) -> Floats:
        angle = self.rng.uniform(0, 2 * np.pi, d.shape[1])
        size = self.error.delta * np.sqrt(self.rng.uniform(0, 1, d.shape[1]))
        first, second = perpendicular(d)
        moved: Floats = size * (np.cos(angle) * first + np.sin(angle) * second)
        return moved

    def rays_of(self, pixels: Index) -> Rays:
        rays = super().rays_of(pixels)
        return replace(rays, P0=rays.origins + self._jitter(rays.d))

    def secondary_rays(self, points: Points, direction: Floats) -> Rays:
        offset = 1500 * U32 * (1 + np.abs(points.M).max(axis=0))
        side = np.copysign(offset, dot(points.normal, direction))
        jitter = self._jitter(np.broadcast_to(direction, points.M.shape))
        return Rays.of(points.M + side * points.normal + jitter, direction)

    def leave(self, points: Points, direction: Floats) -> Branch:
        branch = super().leave(points, direction)
        return replace(branch, length=branch.length + dot(branch.origin - points.M, direction))


def rendered_by(whitted: Whitted) -> Frame:
    frame = blank_frame(whitted.scene)
    for pixels in squares(whitted.scene.screen.nx, whitted.scene.screen.ny):
        fill(frame, pixels, trace_pixels(whitted, pixels, frozenset(frame)))
    return Frame(frame)


def test_the_frame_is_what_render_gives() -> None:
    scene = random_scene(0)
    frame, _ = measure(scene, declared(scene))
    for name, array in minirt.render(scene).items():
        assert array.tobytes() == frame[name].tobytes(), name


@pytest.mark.parametrize("seed", tiered(range(12), lambda seed: seed < 4))
def test_an_honest_renderer_raises_no_false_alarm(seed: int) -> None:
    """Its errors reach δ; those of real renderers seldom do."""
    scene = random_scene(seed)
    error = declared(scene)
    ours, stability = measure(scene, error)
    comparison = compare(scene, ours, stability, rendered_by(Sloppy(scene, error, seed)), {})
    wrong = {check.quantity: check.reason for check in comparison.checks if check.wrong}
    assert not wrong
    compared = {check.quantity: check.compared for check in comparison.checks}
    assert compared["normal"] > 500
    assert compared["refraction_t"] > 100
    assert min(check.certain / check.pixels for check in comparison.checks) > 0.97


def test_a_renderer_that_errs_far_beyond_its_word_is_found() -> None:
    scene = random_scene(1)
    error = declared(scene)
    ours, stability = measure(scene, error)
    careless = rendered_by(Sloppy(scene, declared(scene, 3000.0), 1))
    failed = {c.quantity for c in compare(scene, ours, stability, careless, {}).checks if c.wrong}
    assert {"hit", "object", "t", "normal", "reflection"} <= failed


class Tilted(Whitted):
    """An honest renderer that sees everything up to slope · distance aside, and grain · it off."""

    def __init__(self, scene: Scene, error: Declared, seed: int) -> None:
        self.error, self.rng = error, np.random.default_rng(seed)
        super().__init__(scene, replace(SLIDES, ray_direction=self._tilt, depth_of=self._coarse))

    def _tilt(self, d: Floats) -> Floats:
        angle = self.rng.uniform(0, 2 * np.pi, d.shape[1])
        first, second = perpendicular(d)
        aside = np.cos(angle) * first + np.sin(angle) * second
        tilted: Floats = d + self.error.slope * norm(d) * aside
        return tilted

    def _coarse(self, t: Floats, nu: float) -> Floats:
        factor = 1 + self.error.grain * self.rng.uniform(-1, 1, t.shape)
        coarse: Floats = factor * SLIDES.depth_of(t, nu)
        return coarse


@pytest.mark.parametrize(("times", "alarm"), [(1, False), (30, True)])
@pytest.mark.parametrize("far", [1.0, 100.0])
def test_an_error_that_grows_with_the_distance_is_tolerated_to_its_bound(
    far: float, times: float, alarm: bool
) -> None:
    """The same angles near and far: what is certain does not shrink with the depth of a scene."""
    near = random_scene(3).document["objects"]
    wall = [[-9 * far, -9 * far, -far], [9 * far, -9 * far, -far], [0, 9 * far, -3 * far]]
    scene = scene_of([*near, {"type": "triangle", "material": "paint", "vertices": wall}])
    error = Declared(0.0, 0.0, 0.0, 0.0, None, "", slope=1e-4, grain=1e-5)
    names = ("hit", "object", "t", "depth", "distance")
    ours, stability = measure(scene, error, names)
    careless = replace(error, slope=times * error.slope, grain=times * error.grain)
    theirs = rendered_by(Tilted(scene, careless, 5))
    checks = compare(scene, ours, stability, theirs, {}, names).checks
    assert any(check.wrong for check in checks) is alarm
    assert min(check.certain / check.pixels for check in checks) > 0.97


def test_silhouettes_are_uncertain_and_the_rest_is_not() -> None:
    scene = scene_of([{"type": "sphere", "material": "paint", "center": [0, 0, 0], "radius": 1.0}])
    pixel = 5.0 / 64
    _, stability = measure(scene, Declared(pixel / 4, 0, 0, 0, None, ""), ["hit"])
    uncertain = np.argwhere(~stability.certain["hit"])
    assert 20 < len(uncertain) < 200
    j = 47 - uncertain[:, 0]
    x = (uncertain[:, 1] + 0.5) / 64 - 0.5
    y = (j + 0.5) / 64 - 0.375
    # The silhouette is the cone of half angle asin(1/5): the screen's circle of radius 1/√24.
    assert np.abs(np.hypot(x, y) - 1 / np.sqrt(24)).max() < 0.02


def test_coplanar_objects_are_uncertain_where_they_overlap_and_only_there() -> None:
    quad = [[-0.8, -0.8, 0], [0.3, -0.8, 0], [0.3, 0.8, 0], [-0.8, 0.8, 0]]
    other = [[-x, y, z] for x, y, z in reversed(quad)]
    scene = scene_of([
        {"type": "polygon", "material": "paint", "vertices": quad},
        {"type": "polygon", "material": "paint", "vertices": other},
    ])  # fmt: skip
    ours, stability = measure(scene, declared(scene), ["hit", "object", "depth"])
    x = np.abs(((np.arange(64) + 0.5) / 64 - 0.5) * 5)
    overlap = np.broadcast_to(x < 0.3, (48, 64)) & ours["hit"]
    assert overlap.sum() > 100
    assert not stability.certain["object"][overlap].any()
    single = ours["hit"] & ~overlap
    assert single.sum() > 100
    assert stability.certain["object"][single].all()
    assert stability.certain["hit"].all()


@pytest.mark.parametrize("seed", range(4))
def test_of_many_coplanar_objects_any_may_be_seen(seed: int) -> None:
    """Six quads in one plane: which of them a pixel shows is a matter of rounding."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform((-2.4, -1.8), (0.4, 0.2), (6, 2))
    sides = rng.uniform(1.4, 2.6, (6, 2))
    quads = [
        [[x, y, 0.3 * x], [x + w, y, 0.3 * (x + w)], [x + w, y + h, 0.3 * (x + w)],
         [x, y + h, 0.3 * x]]
        for (x, y), (w, h) in zip(corners.tolist(), sides.tolist(), strict=True)
    ]  # fmt: skip
    scene = scene_of([{"type": "polygon", "material": "paint", "vertices": q} for q in quads])
    ours, stability = measure(scene, declared(scene), ["object"])
    covered = np.zeros((48, 64), dtype=int)
    for k in range(6):
        alone = scene_of([scene.document["objects"][k]])
        covered += minirt.render(alone, quantities=["hit"])["hit"]
    assert (covered > 2).sum() > 100
    assert not stability.certain["object"][covered > 1].any()
    assert stability.certain["object"][covered == 1].mean() > 0.95
    assert ours["object"][covered > 0].min() >= 0


@pytest.mark.parametrize("wall_first", [True, False])
@pytest.mark.parametrize("beside", [-0.9, -0.3, 0.3, 0.9])
def test_beside_the_edge_of_what_overlaps_the_object_is_uncertain(
    beside: float, wall_first: bool
) -> None:
    """A tile on a wall; one pixel looks past the tile's edge, nearer to it than δ."""
    delta = 1e-6
    screen = {"P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
              "l": -0.1, "r": 0.1, "b": -0.1, "t": 0.1, "nx": 1, "ny": 1}  # fmt: skip
    for angle in np.linspace(0.1, 0.1 + 2 * np.pi, 24, endpoint=False):
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        along = np.array([-np.sin(angle), np.cos(angle), 0.0])
        edge = -beside * delta * out
        tile = [edge - along, edge + along, edge + along - 2 * out, edge - along - 2 * out]
        wall = [[-3, -3, 0], [3, -3, 0], [3, 3, 0], [-3, 3, 0]]
        shapes = [wall, np.array(tile).tolist()][:: 1 if wall_first else -1]
        quads = [{"type": "polygon", "material": "paint", "vertices": s} for s in shapes]
        scene = scene_of(quads, screen=screen)
        exact = Declared(delta, 0, 0, 0, None, "")
        _, stability = measure(scene, exact, ["object", "hit"])
        assert not stability.certain["object"].any()
        assert stability.certain["hit"].all()


def test_which_of_two_faces_of_a_mesh_is_met_decides_neither_object_nor_depth(
    tmp_path: Path,
) -> None:
    """A mesh whose square is there twice, once from either side; a hair apart, or not."""
    square = [[-1.5, -1.5], [1.5, -1.5], [1.5, 1.5], [-1.5, 1.5]]
    error = Declared(1e-6, 0, 1e-7, 1e-7, None, "")
    for apart in (0.0, 3e-6):
        vertices = [f"v {x} {y} {z!r}" for z in (0.0, -apart) for x, y in square]
        faces = ["f 1 2 3", "f 1 3 4", "f 7 6 5", "f 8 7 5"]
        (tmp_path / "twice.obj").write_text("\n".join([*vertices, *faces]), encoding="utf-8")
        mesh = {"type": "mesh", "material": "paint", "file": "twice.obj"}
        names = ["object", "depth", "triangle", "normal", "shadow"]
        ours, stability = measure(scene_of([mesh], tmp_path), error, names)
        inside = ours["hit"] & (np.abs(ours["position"][..., :2]).max(axis=2) < 1.4)
        assert inside.sum() > 300
        assert stability.certain["object"][inside].all()
        assert stability.certain["depth"][inside].all()
        assert stability.certain["shadow"][inside].all() == (apart == 0.0)
        assert (stability.tolerance["depth"][inside] > apart).all()
        assert not stability.certain["triangle"][inside].any()
        assert not stability.certain["normal"][inside].any()


@pytest.mark.parametrize("first", [0, 1])
def test_an_overlap_is_uncertain_up_to_the_edge_of_what_overlaps(first: int) -> None:
    """A heptagon on a wall, under an error of a quarter of a pixel: all of its pixels."""
    wall = [[-2.1, -1.7, 0.0], [2.3, -1.7, 0.0], [2.2, 1.8, 0.0], [-2.2, 1.8, 0.0]]
    angles = np.linspace(0.1, 0.1 + 2 * np.pi, 7, endpoint=False).tolist()
    tile = [[1.3 * np.cos(a), 1.3 * np.sin(a), 0.0] for a in angles]
    shapes = [wall, tile] if first == 0 else [tile, wall]
    scene = scene_of([{"type": "polygon", "material": "paint", "vertices": s} for s in shapes])
    _, stability = measure(scene, replace(declared(scene), delta=5 / 64 / 4), ["object"])
    on_tile = scene_of([scene.document["objects"][1 - first]])
    overlap = minirt.render(on_tile, quantities=["hit"])["hit"]
    assert overlap.sum() > 500
    assert not stability.certain["object"][overlap].any()


def test_the_tolerance_of_t_grows_with_the_angle() -> None:
    scene = scene_of([{"type": "sphere", "material": "paint", "center": [0, 0, 0], "radius": 1.0}])
    ours, stability = measure(scene, declared(scene), ["t", "distance"])
    cosine = np.abs((ours["normal"] * ours["ray"]).sum(axis=2))
    judged = ours["hit"] & stability.certain["distance"]
    steep, grazing = judged & (cosine > 0.9), judged & (cosine < 0.2)
    assert steep.sum() > 50
    assert grazing.sum() > 5
    allowed = stability.tolerance["distance"]
    assert allowed[grazing].min() > 2 * allowed[steep].max()


def test_a_late_start_is_part_of_what_may_differ() -> None:
    """A tile floats 1e-3 above the floor: who starts rays 1e-2 away misses its shadow."""
    floor = [[-3, 0, -3], [-3, 0, 3], [3, 0, 3], [3, 0, -3]]
    scene = scene_of(
        [
            {"type": "polygon", "material": "paint", "vertices": floor},
            {"type": "polygon", "material": "paint",
             "vertices": [[x / 6, 1e-3, z / 6] for x, _, z in floor]},
        ],
        light={"direction": [0, -1, 0]},
        screen={"look_at": {"eye": [0, -2, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 50.0},
                "nx": 64, "ny": 48},
    )  # fmt: skip
    near, far = (Declared(1e-7, 0, 0, 0, AlongRay(length), "") for length in (1e-4, 1e-2))
    _, early = measure(scene, near, ["shadow"])
    _, late = measure(scene, far, ["shadow"])
    assert early.certain["shadow"].mean() > 0.99
    assert late.certain["shadow"].mean() < early.certain["shadow"].mean() - 0.01


def test_sideways_directions_are_thirds_of_a_turn() -> None:
    d = np.random.default_rng(3).normal(size=(3, 200))
    d[:, :3] = np.eye(3)
    d[:, 3:5] = [[0.48, 0.5], [0.6, 0.6], [0.64, 0.6]]
    three = [sideways(d, k) for k in range(3)]
    for k, e in enumerate(three):
        assert np.array_equal(sideways(d, k + 3), -e)
        assert np.abs(norm(e) - 1).max() < 4 * 2.0**-52
        assert np.abs(dot(e, d)).max() < 8 * 2.0**-52 * norm(d).max()
        assert np.abs(dot(e, three[(k + 1) % 3]) + 0.5).max() < 8 * 2.0**-52


def pentagon(lift: float) -> Scene:
    """A pentagon that faces the observer, one vertex lifted; the light passes along it."""
    vertices = [[-1, -1, 0], [1, -1, 0], [1.2, 0.3, 0], [0, 1, lift], [-1.2, 0, 0]]
    return scene_of(
        [{"type": "polygon", "material": "paint", "vertices": vertices}],
        light={"direction": [0, -1, 0]},
    )


@pytest.mark.parametrize("lift", [0.0, 4e-10])
def test_what_a_polygon_shades_of_itself_is_certain_only_where_it_is_a_plane(lift: float) -> None:
    scene = pentagon(lift)
    exact = Declared(1e-16, 1e-16, 1e-16, 1e-16, None, "")
    ours, stability = measure(scene, exact, ["shadow", "hit"])
    assert ours["hit"].sum() > 500
    assert stability.certain["hit"][ours["hit"]].mean() > 0.9
    certain = stability.certain["shadow"][ours["hit"]]
    assert certain.mean() > 0.9 if lift == 0 else not certain.any()


def test_any_plane_of_a_polygon_that_is_none_is_allowed() -> None:
    scene = pentagon(4e-10)
    ours, stability = measure(scene, Declared(1e-16, 1e-16, 1e-16, 1e-16, None, ""), ["normal"])
    facets = scene.objects[0]
    assert isinstance(facets, Facets)
    for other in facets.edge_normals.T:
        error = norm(other[:, None] / norm(other[:, None]) - ours["normal"][ours["hit"]].T)
        assert error.max() > 1e-11
        assert (error <= stability.tolerance["normal"][ours["hit"]]).all()


def test_what_is_so_near_that_another_overlooks_it_is_uncertain() -> None:
    """A small tile 1e-6 before the observer, and a wall far behind it."""
    tile = [[-1e-9, -1, 5 - 1e-6], [1e-9, -1, 5 - 1e-6], [1e-9, 1, 5 - 1e-6], [-1e-9, 1, 5 - 1e-6]]
    scene = scene_of(
        [
            {"type": "polygon", "material": "paint",
             "vertices": [[100 * x, y, z] for x, y, z in tile]},
            {"type": "polygon", "material": "paint",
             "vertices": [[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]},
        ]
    )  # fmt: skip
    exact = Declared(1e-13, 1e-13, 1e-13, 1e-13, None, "")
    ours, seeing = measure(scene, exact, ["object"])
    _, short_sighted = measure(scene, replace(exact, near=1e-5), ["object"])
    tile_ = ours["object"] == 0
    assert 0.05 < tile_.mean() < 0.9
    assert seeing.certain["object"].mean() > 0.95
    assert not short_sighted.certain["object"][tile_].any()
    assert short_sighted.certain["object"][~tile_].mean() > 0.95


@pytest.mark.parametrize("ior", [1.0, 1.0005, 0.9995, 1.5])
def test_the_root_of_a_rounded_square_is_tolerated_where_the_refracted_ray_grazes(
    ior: float,
) -> None:
    """As Mitsuba takes it, in float32: fuzzing found pixels at which it was off by 4 tolerances."""
    document = {
        "minirt": 1, "name": "grazed",
        "screen": {"P0": [0, 0, 0], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
                   "l": -0.5, "r": 0.5, "b": -0.06, "t": -0.001, "nx": 32, "ny": 32},
        "light": {"direction": [0, -1, 0]},
        "materials": {"glass": {"ior": ior}},
        "objects": [{"type": "triangle", "name": "floor", "material": "glass",
                     "vertices": [[-90, -0.1, 0], [90, -0.1, 0], [0, -0.1, -200]]}],
    }  # fmt: skip
    scene = minirt.load_scene(document)
    frame, stability = measure(scene, declared(scene))
    certain = stability.certain["refraction"] & (frame["tir"] == 0)
    assert certain.sum() > 200
    ray, normal = (frame[name][certain] for name in ("ray", "normal"))
    cosine = np.abs((ray * normal).sum(axis=1)).astype(np.float32)
    eta, one = np.float32(1 / ior), np.float32(1)
    root = np.sqrt(np.maximum(one - eta * eta * (one - cosine * cosine), np.float32(0)))
    tangent = ray + cosine.astype(float)[:, None] * normal
    theirs = tangent / ior - root.astype(float)[:, None] * normal
    error = np.linalg.norm(theirs - frame["refraction"][certain], axis=1)
    assert (error <= stability.tolerance["refraction"][certain]).all()
    assert error.max() > 1e-8


def test_a_ray_along_a_surface_may_start_on_either_side_of_it() -> None:
    """As fuzzing found on a gem: a zero's sign put Embree's start outside, and ours inside."""
    wall = [[0, -1, 1], [0, 1, 1], [0, 1, 2], [0, -1, 2]]
    document: dict[str, Any] = {
        "minirt": 1, "name": "along",
        "screen": {"look_at": {"eye": [4, 0, 1.5], "target": [0, 0, 1.5], "up": [0, 0, 1],
                               "fov_y": 8}, "nx": 16, "ny": 16},
        "light": {"direction": [0, 0, 1]},
        "materials": {"grey": {}},
        "objects": [
            {"type": "polygon", "material": "grey", "vertices": wall},
            {"type": "polygon", "material": "grey",
             "vertices": [[0, -2, 0.5], [0, 2, 0.5], [-1, 2, 0.5], [-1, -2, 0.5]]},
        ],
    }  # fmt: skip
    scene = minirt.load_scene(document)
    frame, stability = measure(scene, EmbreeReference().declare(scene), ["object", "shadow"])
    assert stability.certain["object"].all()
    assert (frame["object"] == 0).all()
    assert not stability.certain["shadow"].any()
    lone = minirt.load_scene({**document, "objects": document["objects"][:1]})
    assert measure(lone, EmbreeReference().declare(lone), ["shadow"])[1].certain["shadow"].all()
