"""Spheres as triangles: closed, turned outward, and as near to the sphere as they say."""

from __future__ import annotations

import numpy as np
import pytest

from converters.tessellate import TRIANGLES, icosphere_within, unit_icosphere
from minirt.vectors import Floats, cross, dot, norm

CENTER = np.array([3.0, -200.0, 0.5])


def corners_of(vertices: Floats, faces: np.ndarray[tuple[int, int], np.dtype[np.int32]]) -> Floats:
    """Corners a, b, c of every face, (3, 3, m): corner, axis, face."""
    return np.stack([vertices[faces[:, k]].T for k in range(3)])


@pytest.mark.parametrize("cuts", [1, 2, 3, 7, 20])
def test_an_icosphere_is_closed_and_faces_outward(cuts: int) -> None:
    sphere = unit_icosphere(cuts)
    assert len(sphere.vertices) == 10 * cuts**2 + 2  # Euler: 20·f² faces, 30·f² edges
    assert len(sphere.faces) == 20 * cuts**2
    np.testing.assert_allclose(norm(sphere.vertices.T), 1, rtol=1e-15)
    edges = np.concatenate(
        [sphere.faces[:, [0, 1]], sphere.faces[:, [1, 2]], sphere.faces[:, [2, 0]]]
    )
    once = {(int(i), int(j)) for i, j in edges}
    assert len(once) == len(edges)  # each edge once in either direction: closed, one winding
    assert once == {(j, i) for i, j in once}
    a, b, c = corners_of(sphere.vertices, sphere.faces)
    assert (dot(a, cross(b - a, c - a)) > 0).all()


@pytest.mark.parametrize("radius", [1e-3, 1.0, 6e6])
@pytest.mark.parametrize("cuts", [1, 4, 13])
def test_triangles_lie_between_the_two_spheres_of_the_bound(cuts: int, radius: float) -> None:
    """And touch both: the bound is balanced and no larger than the error."""
    sphere = unit_icosphere(cuts)
    vertices = sphere.around(CENTER, radius) - CENTER
    rounding = 2.0**-52 * float(norm(CENTER)) / radius
    a, b, c = corners_of(vertices, sphere.faces)
    rng = np.random.default_rng(cuts)
    weights = rng.dirichlet((1, 1, 1), 200)
    inside = [norm(w[0] * a + w[1] * b + w[2] * c) / radius - 1 for w in weights]
    deepest = np.min(np.abs(dot(a, cross(b - a, c - a))) / norm(cross(b - a, c - a))) / radius - 1
    outermost = norm(vertices.T).max() / radius - 1
    assert np.abs(inside).max() <= sphere.error * (1 + 1e-12) + 4 * rounding
    assert outermost == pytest.approx(sphere.error, abs=4 * rounding + 1e-15)
    assert deepest == pytest.approx(-sphere.error, abs=4 * rounding + 1e-15)


def test_vertices_on_the_sphere_itself_would_err_by_twice_the_bound() -> None:
    sphere = unit_icosphere(9)
    a, b, c = corners_of(sphere.vertices, sphere.faces)
    sagitta = 1 - norm((a + b + c) / 3).min()
    assert sagitta == pytest.approx(2 * sphere.error, rel=0.02)


@pytest.mark.parametrize("bound", [0.5, 0.1, 1e-2, 3e-3, 1e-4])
def test_the_coarsest_icosphere_within_a_bound_is_chosen(bound: float) -> None:
    sphere = icosphere_within(bound)
    cuts = round((len(sphere.faces) / 20) ** 0.5)
    assert sphere.error <= bound
    assert cuts == 1 or unit_icosphere(cuts - 1).error > bound
    if bound < 0.01:
        assert len(sphere.faces) == pytest.approx(TRIANGLES / bound, rel=0.1)


@pytest.mark.parametrize("bound", [0.0, 1e-12, 1e-4])
def test_the_most_triangles_are_kept_to_and_the_error_is_true(bound: float) -> None:
    sphere = icosphere_within(bound, most=1000)
    assert len(sphere.faces) == 980
    assert sphere.error > bound
    assert sphere.error == unit_icosphere(7).error
