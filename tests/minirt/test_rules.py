"""The lecture's rules S1–S12 and S17, one test or more each, with the departures they need.

Optics (S14–S16) and colour (S7, S13) have files of their own.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import trimesh

import minirt
from minirt.errors import InputError
from minirt.rules import Rules
from minirt.screen import model_from_view, pixel_center, view_frame
from minirt.shapes.polygon import fan
from minirt.shapes.triangle import TriangleCase
from minirt.vectors import Floats

ULP = 2.0**-52
_SCREEN = {"P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
           "l": -1.0, "r": 1.0, "b": -0.75, "t": 0.75, "nx": 16, "ny": 12}  # fmt: skip
_BALL: dict[str, Any] = {"type": "sphere", "material": "m", "center": [0, 0, 0], "radius": 1.0}
_SQUARE: dict[str, Any] = {"type": "polygon", "material": "m",
           "vertices": [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]}  # fmt: skip


def _scene(*objects: dict[str, Any], light: Any = (0, 0, -1), **screen: Any) -> minirt.Scene:
    document = {"minirt": 1, "name": "rules", "screen": {**_SCREEN, **screen},
                "light": {"direction": list(light)},
                "materials": {"m": {}, "half": {"alpha": 0.5}},
                "objects": list(objects)}  # fmt: skip
    return minirt.load_scene(document)


def _floats(*values: Any) -> tuple[float, ...]:
    return tuple(map(float, values))


def test_every_rule_S1_to_S16_can_be_replaced() -> None:
    numbers = {Rules.number(name) for name in Rules.__dataclass_fields__}
    assert numbers == {f"S{k}" for k in range(1, 17)}


# -- S1–S3: the screen -----------------------------------------------------------------------------


@pytest.mark.parametrize("u", [[1, 0, 0], [-1, 0, 0]], ids=["right-handed", "left-handed"])
@pytest.mark.parametrize("nu", [-2.0, 2.0])
def test_S1_screen_lies_in_the_plane_n_is_nu(u: list[int], nu: float) -> None:
    scene = _scene(u=u, nu=nu, l=-0.2, r=1.0, b=0.1, t=0.7)
    d = minirt.render(scene, quantities=["ray"])["ray"]
    d = d * (nu / d[..., 2])[..., None]  # stretched to the plane n = ν
    across = u[0] * d[..., 0]
    assert across.min() == pytest.approx(-0.2 + 1.2 / 16 / 2)
    assert across.max() == pytest.approx(1.0 - 1.2 / 16 / 2)
    assert (d[..., 1].min(), d[..., 1].max()) == pytest.approx((0.1 + 0.025, 0.7 - 0.025))


def test_S2_pixel_centres_and_row_0_at_the_bottom() -> None:
    screen = _scene(l=-2.0, r=2.0, b=-3.0, t=3.0, nx=4, ny=3).screen
    u_s, v_s = pixel_center(screen, np.arange(4.0), np.arange(4.0))
    assert u_s.tolist() == [-1.5, -0.5, 0.5, 1.5]
    assert v_s[:3].tolist() == [-2.0, 0.0, 2.0]
    frame = minirt.render(_scene({**_BALL, "center": [0, 1.5, 0]}))
    assert frame["hit"][:6].any()
    assert not frame["hit"][6:].any()


def test_S3_change_of_frame_matrix_has_the_axes_as_columns() -> None:
    turn = np.array([[2, -1, 2], [2, 2, -1], [-1, 2, 2]]) / 3  # orthonormal rows and columns
    u, v, n = turn.T.tolist()
    screen = _scene(u=u, v=v, n=n).screen
    u_s, v_s = np.array([0.3, -0.9]), np.array([0.1, 0.5])
    expected = turn @ np.stack((u_s, v_s, np.full(2, screen.nu)))
    assert model_from_view(view_frame(screen), u_s, v_s) == pytest.approx(expected, abs=4 * ULP)


def test_S4_pixel_takes_the_properties_of_the_first_object() -> None:
    behind = {**_SQUARE, "vertices": [[-9, -9, -4], [9, -9, -4], [9, 9, -4], [-9, 9, -4]]}
    frame = minirt.render(_scene(behind, {**_BALL, "material": "half"}))
    ball = frame["object"] == 1
    assert 10 < ball.sum() < 150
    assert np.array_equal(frame["alpha"], np.where(ball, 0.5, 1.0))
    assert (frame["t"][ball].max(), 9.0) < (frame["t"][~ball].min(), 10.0)


def test_S5_t_is_1_at_the_screen_and_depth_follows_the_axis() -> None:
    wide = [[-9, -9, 4], [9, -9, 4], [9, 9, 4], [-9, 9, 4]]
    frame = minirt.render(_scene({**_SQUARE, "vertices": wide}))
    assert frame["hit"].all()
    # The plane z = 4 is the screen's: (4 − 5)·p / (−1·p), exact.
    assert (frame["t"] == 1).all()
    assert (frame["depth"] == 1).all()
    distance = np.sqrt((frame["position"] - (0, 0, 5)) ** 2 @ np.ones(3))
    assert frame["distance"] == pytest.approx(distance, rel=8 * ULP)


def test_S5_what_lies_behind_the_observer_is_not_met() -> None:
    assert not minirt.render(_scene({**_BALL, "center": [0, 0, 9]}))["hit"].any()
    assert minirt.intersect_sphere([0, 0, 5], [0, 0, -1], [0, 0, 9], 1.0).far < 0


# -- S6: RT ----------------------------------------------------------------------------------------


def test_S6_a_hit_at_the_origin_itself_does_not_count() -> None:
    scene = _scene(_BALL, _SQUARE)
    on_sphere = minirt.RT(_scene(_BALL), [0, 0, 1], [0, 0, -1])
    assert on_sphere.t == 2
    on_square = minirt.RT(scene, [0.25, 0.5, 0], [0, 0, 1])
    assert on_square.object == 0
    assert minirt.RT(_scene(_SQUARE), [0.25, 0.5, 0], [0, 0, 1]).t == np.inf


@pytest.mark.parametrize("thing", [_BALL, _SQUARE, {**_SQUARE, "type": "triangle"}])
def test_S6_both_ends_of_the_interval_count(thing: dict[str, Any]) -> None:
    vertices = thing.get("vertices", [])[: 3 if thing["type"] == "triangle" else None]
    scene = _scene({**thing, "vertices": vertices} if vertices else thing)
    t = float(minirt.RT(scene, [0.25, -0.5, 8], [0, 0, -2]).t)
    assert 3.5 < t <= 4
    below, above = np.nextafter(t, 0), np.nextafter(t, 9)
    ray = (scene, [0.25, -0.5, 8], [0, 0, -2])
    assert minirt.RT(*ray, t, t).t == t
    assert minirt.RT(*ray, 0, t).t == t
    assert minirt.RT(*ray, t, 9).t == t
    assert minirt.RT(*ray, 0, below).t == np.inf
    assert minirt.RT(*ray, above, 4.1).t == np.inf


def test_S6_RT_all_is_sorted_and_begins_with_RT() -> None:
    rng = np.random.default_rng(40)
    balls = [{**_BALL, "center": rng.normal(size=3).tolist()} for _ in range(6)]
    scene = _scene(
        *balls, _SQUARE, {**_SQUARE, "type": "triangle", "vertices": _SQUARE["vertices"][:3]}
    )
    P0, d = rng.normal(size=(2, 3, 200))
    every, first = minirt.RT_all(scene, P0, d), minirt.RT(scene, P0, d)
    assert every.t.shape[0] > 4
    assert (every.t[1:] >= every.t[:-1]).all()
    for name in ("t", "object", "triangle", "beta", "gamma", "position", "normal"):
        layer = getattr(every, name)[..., 0, :]
        assert np.array_equal(layer, getattr(first, name), equal_nan=True), name
    assert np.isfinite(every.t).sum(axis=0).max() == every.t.shape[0]


def test_S6_shapes_of_one_ray_and_of_none() -> None:
    scene = _scene(_BALL)
    one = minirt.RT(scene, [0, 0, 5], [0, 0, -1])
    assert one.t.shape == ()
    assert one.normal.shape == (3,)
    none = minirt.RT(scene, np.zeros((3, 0)), np.zeros((3, 0)))
    assert none.t.shape == (0,)
    assert none.position.shape == (3, 0)
    assert minirt.RT_all(scene, [9, 9, 9], [0, 0, 1]).t.shape == (0,)
    many = minirt.RT(scene, [0, 0, 5], np.array([[0, 1], [0, 0], [-1, 0]]))
    assert many.t.tolist() == [4.0, np.inf]


@pytest.mark.parametrize(
    ("P0", "d", "interval", "words"),
    [
        ([0, 0], [0, 0, 1], (0, 1), "P0: not a vector; got shape (2,); expected components first"),
        ([0, 0, 0], [0, 0, 0], (0, 1), "d: a direction is the zero vector"),
        ([0, 0, 0], [0, 0, 1e-200], (0, 1), "d: a direction is too short"),
        ([0, 0, np.nan], [0, 0, 1], (0, 1), "P0: a number is not finite or out of range"),
        ([0, 0, 0], [0, 0, 1], (-1, 1), "t0, t1: not an interval of a ray"),
        ([0, 0, 0], [0, 0, 1], (2, 1), "t0, t1: not an interval of a ray"),
        ([0, 0, 0], [0, 0, 1], (np.nan, 1), "t0, t1: not an interval of a ray"),
        ("abc", [0, 0, 1], (0, 1), "P0: not numbers"),
        (np.zeros((3, 2)), np.ones((3, 5)), (0, 1), "different numbers of vectors"),
    ],
)  # fmt: skip
def test_S6_bad_arguments_are_one_clear_error(
    P0: Any, d: Any, interval: tuple[float, float], words: str
) -> None:
    with pytest.raises(InputError) as caught:
        minirt.RT(_scene(_BALL), P0, d, *interval)
    assert str(caught.value).startswith(words)


# -- S8: the sphere --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("z", "near", "far", "t"),
    [(5, 4, 6, 4), (0, -1, 1, 1), (0.5, -0.5, 1.5, 1.5), (1, 0, 2, 2), (-1, -2, 0, np.inf),
     (-3, -4, -2, np.inf)],
)  # fmt: skip
def test_S8_smallest_positive_root(z: float, near: float, far: float, t: float) -> None:
    hit = minirt.intersect_sphere([0, 0, z], [0, 0, -1], [0, 0, 0], 1.0)
    assert _floats(hit.near, hit.far, hit.t) == (near, far, t)


def test_S8_normal_points_outward_also_for_an_observer_inside() -> None:
    inside = minirt.RT(_scene(_BALL), [0, 0, 0], [0, 0, -3])
    assert inside.normal.tolist() == [0, 0, -1]
    assert inside.t == 1 / 3


def test_E8_textbook_roots_cancel_where_ours_keep_their_digits() -> None:
    """Radius 1 at distance 1e6, seen through its middle: t = 1e6 − 1 and 1e6 + 1, from one side."""
    C = np.zeros(3)
    hit = minirt.intersect_sphere([0, 0, 1e6], [0, 0, -1], C, 1.0)
    assert _floats(hit.near, hit.far) == (1e6 - 1, 1e6 + 1)
    # Δ = b² − 4ac for a sphere of radius 1e-3 at distance 1e6: c is R² = 1e-6 short of 1e12, which
    # float64 does not see: its ulp there is 1.2e-4.
    P0, R = np.array([1e6, 0.0, 0.9e-3]), 1e-3
    d = np.array([-1.0, 0.0, 0.0])
    b, c = 2 * d @ (P0 - C), (P0 - C) @ (P0 - C) - R * R
    assert b * b - 4 * c <= 0
    h = np.sqrt(1e-6 - 0.81e-6)
    assert minirt.intersect_sphere(P0, d, C, R).near == pytest.approx(1e6 - h, rel=2 * ULP)


def test_S17_exercise_1_a_tangent_direction() -> None:
    """P0 = (1,5,4), sphere (2,2,4), √2. In the plane z = 4, with L = C − P0 = (1,−3), |L|² = 10, a
    tangent makes sin α = √2/√10 with L, so d ∝ 2·(1,−3) ± (3,1): (5,−5) or (−1,−7); take (1,−1,0).
    It touches at t = L·d/d·d = 2, in (3,3,4).
    """
    P0, d, C = [1, 5, 4], [1, -1, 0], [2, 2, 4]
    # √2 in float64, and its square, are above the truth by 1 ulp: the roots part by √(2·ulp)/√2.
    touch = minirt.intersect_sphere(P0, d, C, np.sqrt(2.0))
    assert touch.t == pytest.approx(2.0, abs=np.sqrt(2 * ULP))
    assert touch.far - touch.near <= 2 * np.sqrt(2 * ULP)
    for other in ([-1, -7, 0], d):
        closest = np.linalg.norm(np.cross(np.subtract(C, P0), other)) / np.linalg.norm(other)
        assert closest == pytest.approx(np.sqrt(2), rel=4 * ULP)
    assert np.isinf(minirt.intersect_sphere(P0, d, C, np.sqrt(2) * (1 - 1e-9)).near)
    wider = minirt.intersect_sphere(P0, d, C, np.sqrt(2) * (1 + 1e-9))
    assert wider.near < 2 < wider.far


def test_S17_exercise_2_a_tangent_sphere() -> None:
    """From (3,2,−1) along (1,2,1): at t = 1 the point (4,4,0); (1,−1,1) is perpendicular to the
    ray, so C = (5,3,1) with R = |(1,−1,1)| = √3 touches it there. With R² = 3 just above and below:
    """
    P0, d, C = [3, 2, -1], [1, 2, 1], [5, 3, 1]
    touch = minirt.intersect_sphere(P0, d, C, np.sqrt(3.0) * (1 + 4 * ULP))
    assert (touch.near, touch.far) == pytest.approx((1, 1), abs=np.sqrt(30 * ULP))
    assert np.isinf(minirt.intersect_sphere(P0, d, C, np.sqrt(3.0) * (1 - 4 * ULP)).near)


def test_S17_exercise_3_the_reflection() -> None:
    """ρ = δ − 2(δ·s)s with δ·s = √2/2: (3,2,1) − √2·(0, √2/2, −√2/2) = (3, 1, 2)."""
    rho = minirt.reflect([3, 2, 1], [0, np.sqrt(2) / 2, -np.sqrt(2) / 2])
    assert rho == pytest.approx([3, 1, 2], rel=4 * ULP)


# -- S9: the triangle ------------------------------------------------------------------------------

_A, _B, _C = [0, 0, 0], [1, 0, 0], [0, 1, 0]


@pytest.mark.parametrize(
    ("x", "y", "case"),
    [(0.25, 0.25, "INSIDE"), (0, 0, "INSIDE"), (1, 0, "INSIDE"), (0, 1, "INSIDE"),
     (0.5, 0.5, "INSIDE"), (0.5, 0, "INSIDE"), (-0.1, 0.5, "OUTSIDE"), (0.6, 0.5, "OUTSIDE"),
     (2, 2, "OUTSIDE")],
)  # fmt: skip
def test_S9_tells_inside_from_outside(x: float, y: float, case: str) -> None:
    hit = minirt.intersect_triangle([x, y, 3], [0, 0, -2], _A, _B, _C)
    assert TriangleCase(int(hit.case)).name == case
    assert _floats(hit.t, hit.beta, hit.gamma) == (1.5, x, y)


def test_S9_third_case_parallel_or_degenerate() -> None:
    parallel = minirt.intersect_triangle([0.2, 0.2, 1], [1, 2, 0], _A, _B, _C)
    within = minirt.intersect_triangle([-1, 0.2, 0], [1, 0, 0], _A, _B, _C)
    line = minirt.intersect_triangle([0.5, 0, 3], [0, 0, -1], _A, _B, [2, 0, 0])
    point = minirt.intersect_triangle([0, 0, 3], [0, 0, -1], _A, _A, _A)
    for hit in (parallel, within, line, point):
        assert hit.case == TriangleCase.NONE
        assert hit.t == np.inf
        assert np.isnan([hit.beta, hit.gamma]).all()


def test_S9_degenerate_triangles_are_never_hit() -> None:
    """Collinear to the last bit, and needles that rounding alone keeps from being collinear."""
    rng = np.random.default_rng(41)
    a, b = rng.integers(-9, 10, (2, 3, 300)).astype(float)
    c = a + 2.0 * (b - a)
    P0 = rng.normal(size=(3, 300)) * 20
    d = a + (b - a) * rng.random(300) - P0
    hit = minirt.intersect_triangle(P0, d, a, b, c)
    assert (hit.case == TriangleCase.NONE).all()


def test_S9_weights_and_t_solve_equation_3() -> None:
    rng = np.random.default_rng(42)
    P0, d, a, b, c = rng.normal(size=(5, 3, 500))
    hit = minirt.intersect_triangle(P0, d, a, b, c)
    beta, gamma = hit.beta, hit.gamma
    right = (1 - beta - gamma) * a + beta * b + gamma * c
    slope = np.abs((d * np.cross(b - a, c - a, axis=0)).sum(axis=0))
    fair = slope > 0.1  # else both sides carry the condition's digits, which accuracy tests count
    assert fair.sum() > 300
    assert np.abs(P0 + hit.t * d - right)[:, fair].max() < 1e3 * ULP * np.abs(hit.t[fair]).max()


def test_E3_t_may_lie_beyond_1() -> None:
    """The slide asks for t, β, γ ∈ [0, 1]; t is S6's, here 5."""
    hit = minirt.intersect_triangle([0.25, 0.25, 5], [0, 0, -1], _A, _B, _C)
    assert hit.t == 5
    assert hit.case == TriangleCase.INSIDE


# -- S10, S11: the polygon -------------------------------------------------------------------------


def test_S10_t_of_the_plane() -> None:
    """(P1 − P0)·p / (d·p) for z = 2 from (0.3, 0.4, 6) along (0, 0, −0.5): 8."""
    square = [[-1, -1, 2], [1, -1, 2], [1, 1, 2], [-1, 1, 2]]
    assert minirt.intersect_polygon([0.3, 0.4, 6], [0, 0, -0.5], square).t == 8
    assert minirt.intersect_polygon([0.3, 0.4, 6], [1, 0, 0], square).t == np.inf


def test_E7_p_is_the_normal_of_the_polygons_plane() -> None:
    vertices = np.array([[0, 0, 0], [4, 0, 2], [5, 3, 4], [1, 4, 2.5], [-1, 2, 0.5]])
    polygon = {**_SQUARE, "vertices": vertices.tolist()}
    p = _scene(polygon).objects[0].plane[:, 0]  # type: ignore[union-attr]
    assert np.abs((np.roll(vertices, -1, axis=0) - vertices) @ p).max() == 0
    assert p[2] > 0


def test_S11_fan_of_m_minus_2_triangles_from_the_first_vertex() -> None:
    assert fan(3).tolist() == [[0, 1, 2]]
    assert fan(5).tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4]]
    square = _SQUARE["vertices"]
    first = minirt.intersect_polygon([0.5, -0.75, 1], [0, 0, -1], square)
    second = minirt.intersect_polygon([-0.5, 0.75, 1], [0, 0, -1], square)
    assert _floats(first.triangle, second.triangle) == (0, 1)
    assert minirt.intersect_polygon([1.5, 0, 1], [0, 0, -1], square).triangle == -1


def _regular(m: int) -> Floats:
    """A regular polygon of m corners, rounded to 1/1024, in the plane z = 0."""
    turn = np.arange(m) * (2 * np.pi / m) + 0.1
    corners = np.stack((np.cos(turn), np.sin(turn), np.zeros(m)), axis=1)
    return np.asarray(np.round(corners * 1024) / 1024)


@pytest.mark.parametrize("m", [5, 8, 64])
def test_S11_covers_exactly_the_pixels_inside(m: int) -> None:
    """A pixel is covered where its centre lies left of every edge, in integers; their area is the
    polygon's up to the pixels that its outline meets: less than perimeter × two pixel diagonals.
    """
    P, side = _regular(m), 96
    centers = (np.arange(side) + 0.5) * (2.5 / side) - 1.25
    x, y = np.meshgrid(centers, centers)
    origins = np.stack((x.ravel(), y.ravel(), np.full(side * side, 2.0)))
    down = np.array([0, 0, -1.0]).reshape(3, 1)
    hit = minirt.intersect_polygon(origins, down, P).triangle.reshape(side, side) >= 0
    ahead = np.roll(P, -1, axis=0)
    # Multiples of 1/3072 and 1/1024: products of these are exact in float64.
    exact = [[Fraction(v).limit_denominator(4096) for v in p[:2]] for p in P]
    assert all(
        abs(float(f) - v) < 1e-9
        for p, q in zip(exact, P, strict=True)
        for f, v in zip(p, q[:2], strict=True)
    )
    left = [
        (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) >= 0
        for p, q in zip(P, ahead, strict=True)
    ]
    assert np.array_equal(hit, np.all(left, axis=0))
    area = float((P[:, 0] * ahead[:, 1] - P[:, 1] * ahead[:, 0]).sum()) / 2
    perimeter = float(np.linalg.norm(ahead - P, axis=1).sum())
    pixel = 2.5 / side
    assert abs(hit.sum() * pixel**2 - area) < perimeter * 2 * np.sqrt(2) * pixel
    assert hit.sum() > 2000


@pytest.mark.parametrize("m", [5, 8, 64])
def test_S11_no_ray_slips_through_the_fans_edges(m: int) -> None:
    """Rays through points of the diagonals; their ends are corners of the polygon."""
    rng = np.random.default_rng(43)
    P = _regular(m)
    k = rng.integers(2, m - 1, 2000)
    share = rng.choice([0.0, 0.25, 0.5, 1.0, *rng.random(4)], 2000)
    M = P[0] + share[:, None] * (P[k] - P[0])
    P0 = rng.normal(size=(2000, 3)) + np.array([0, 0, 4])
    inner = (share > 0) & (share < 1)
    hit = minirt.intersect_polygon(P0.T, (M - P0).T, P)
    assert inner.sum() > 800
    assert (hit.triangle[inner] >= 0).all()
    straight = minirt.intersect_polygon(P0.T * [[0], [0], [1]] + M.T, [0, 0, -1], P)
    assert (straight.triangle[share == 0.5] >= 0).all()


@pytest.mark.parametrize("shift", [0.0, 1e5])
def test_S9_no_ray_slips_through_a_closed_mesh(shift: float) -> None:
    """From inside, through every vertex, edge and middle of an icosphere's 1,280 faces."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    vertices = np.asarray(ball.vertices, dtype=np.float64) + shift
    corners = vertices[np.asarray(ball.faces)]
    a, b, c = corners.transpose(1, 2, 0)
    objects = [{"type": "triangle", "material": "m", "vertices": t.tolist()} for t in corners]
    scene = _scene(*objects, P0=[shift, shift, shift + 5])
    rng = np.random.default_rng(44)
    share = rng.random(a.shape[1])
    targets = np.concatenate(
        (vertices.T, (a + b) / 2, (b + c) / 2, a + share * (c - a), (a + b + c) / 3), axis=1
    )
    for origin in ([0, 0, 0], [0.5, 0.25, -0.125], [0.3, -0.2, 0.1]):
        P0 = np.array(origin).reshape(3, 1) + shift
        hits = minirt.RT(scene, P0, targets - P0)
        assert hits.t.shape[0] > 5000
        assert np.isfinite(hits.t).all()


# -- S12: the shadow ray ---------------------------------------------------------------------------

_FLOOR = {"type": "polygon", "material": "m",
          "vertices": [[-4, -1.3, 4], [4, -1.1, 4], [4, -1.1, -4], [-4, -1.3, -4]]}  # fmt: skip


def test_S12_the_ray_goes_against_the_light() -> None:
    """A ball over a floor, light from above: the shadow is under it, at its own x and z."""
    frame = minirt.render(_scene(_BALL, _FLOOR, light=(0, -1, 0), nx=64, ny=48))
    floor = frame["object"] == 1
    x, z = frame["position"][floor][:, 0], frame["position"][floor][:, 2]
    assert np.array_equal(frame["shadow"][floor] == 1, x * x + z * z <= 1)
    assert {0, 1} == set(frame["shadow"][floor].tolist())
    assert (frame["shadow"][~frame["hit"]] == -1).all()


def test_E4_epsilon_is_the_third_argument_so_that_a_surface_does_not_shade_itself() -> None:
    scene = _scene(_FLOOR, light=(-0.3, -1, -0.2))
    lit = minirt.render(scene)
    assert (lit["shadow"][lit["hit"]] == 0).all()
    acne = minirt.render(scene, rules=minirt.SLIDES.replace(start_of_secondary=lambda _: 0.0))
    assert (acne["shadow"] == 1).sum() > 5


def test_E5_M_is_the_surface_point_not_the_virtual_pixel() -> None:
    """A roof between the screen and the light: the pixels' centres lie in its shadow, the far
    floor does not.
    """
    roof = {**_SQUARE, "vertices": [[-3, 2, 6], [3, 2, 6], [3, 2, 3.5], [-3, 2, 3.5]]}
    scene = _scene(_FLOOR, roof, light=(0, -1, 0))
    frame = minirt.render(scene)
    far = frame["position"][..., 2] < 3
    assert far.sum() > 20
    assert (frame["shadow"][far] == 0).all()
    d = frame["ray"] / -frame["ray"][..., 2:]
    pixels = np.array([0.0, 0.0, 5.0]) + d[far]
    above = minirt.RT(scene, pixels.T, [0, 1, 0])
    assert np.isfinite(above.t).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"foo": max}, "no such rule; got foo; expected one of view_frame, pixel_center"),
        ({"plane": 3}, "plane: not a function; got int"),
    ],
)
def test_only_rules_can_be_replaced(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(minirt.InputError) as caught:
        minirt.SLIDES.replace(**changes)
    assert str(caught.value).startswith(words)


def test_rules_show_themselves_by_what_is_replaced() -> None:
    assert repr(minirt.SLIDES) == "SLIDES"
    assert repr(minirt.SLIDES.replace(plane=max)) == "SLIDES with plane replaced"
