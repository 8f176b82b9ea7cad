"""What each of the lecture's rules takes and gives: the types of the record `minirt.rules.Rules`.

Vectors are component-first float64 arrays (3, n). The lecture's own rules also take (3, 1)
where one vector stands for all n; what replaces one of those that decide hits gets (3, n)
throughout.
"""

from __future__ import annotations

from typing import Protocol

from minirt import screen, shading
from minirt.shapes.polygon import PolygonHits
from minirt.shapes.triangle import TriangleHits
from minirt.vectors import Bools, Floats, Ints


class ViewFrameRule(Protocol):
    """S1: the observer's axes, and the plane of the screen."""

    def __call__(self, screen: screen.VirtualScreen, /) -> screen.ViewFrame: ...


class PixelCenterRule(Protocol):
    """S2: the centres (n,) of virtual pixels (i, j), in viewing coordinates."""

    def __call__(
        self, screen: screen.VirtualScreen, i: Floats, j: Floats, /
    ) -> tuple[Floats, Floats]: ...


class ModelFromViewRule(Protocol):
    """S3: P − P0 (3, n) of points of the screen, in modelling coordinates."""

    def __call__(self, frame: screen.ViewFrame, u_s: Floats, v_s: Floats, /) -> Floats: ...


class CloserRule(Protocol):
    """S4: whether hits (n,) come before the best ones so far."""

    def __call__(
        self,
        t: Floats,
        object_: Ints,
        triangle: Ints,
        best_t: Floats,
        best_object: Ints,
        best_triangle: Ints,
        /,
    ) -> Bools: ...


class RayDirectionRule(Protocol):
    """S5: d (3, n) from P − P0."""

    def __call__(self, P_minus_P0: Floats, /) -> Floats: ...


class PointAtRule(Protocol):
    """S5: r(t) = P0 + t·d, (3, n)."""

    def __call__(self, P0: Floats, d: Floats, t: Floats, /) -> Floats: ...


class DepthRule(Protocol):
    """S5: distances (n,) along the view axis, with ν."""

    def __call__(self, t: Floats, nu: float, /) -> Floats: ...


class DistanceRule(Protocol):
    """S5: Euclidean distances (n,), with ‖d‖."""

    def __call__(self, t: Floats, d_length: Floats, /) -> Floats: ...


class IntervalRule(Protocol):
    """S6: whether each t (n,) counts in [t0, t1]."""

    def __call__(self, t: Floats, t0: Floats | float, t1: Floats | float, /) -> Bools: ...


class CombineRule(Protocol):
    """S7: colours (3, n) of local, mirrored and transmitted light."""

    def __call__(
        self, local: Floats, mirrored: Floats, transmitted: Floats, k_r: Floats, k_t: Floats, /
    ) -> Floats: ...


class SphereRule(Protocol):
    """S8: both roots t (n,) on spheres of centres C (3, n) or (3, 1) and radii R."""

    def __call__(self, P0: Floats, d: Floats, C: Floats, R: Floats, /) -> tuple[Floats, Floats]: ...


class SmallestRootRule(Protocol):
    """S8: the t (n,) of the hit, given which roots are in the interval."""

    def __call__(
        self, near: Floats, far: Floats, near_counts: Bools, far_counts: Bools, /
    ) -> Floats: ...


class SphereNormalRule(Protocol):
    """S8: unit normals (3, n) at M on spheres of centres C."""

    def __call__(self, M: Floats, C: Floats, /) -> Floats: ...


class TriangleRule(Protocol):
    """S9: t, β, γ and the case, of triangles with `edge_normal` N."""

    def __call__(
        self, P0: Floats, d: Floats, a: Floats, b: Floats, c: Floats, N: Floats, /
    ) -> TriangleHits: ...


class FaceNormalRule(Protocol):
    """S9, S10: unit normals (3, n) of planes with normals p of any length."""

    def __call__(self, p: Floats, /) -> Floats: ...


class PlaneRule(Protocol):
    """S10: t (n,) where rays meet planes through P1 with normals p."""

    def __call__(self, P0: Floats, d: Floats, P1: Floats, p: Floats, /) -> Floats: ...


class PolygonRule(Protocol):
    """S11: t and the fan's triangle that is met, by S10 and S9."""

    def __call__(
        self,
        P0: Floats,
        d: Floats,
        corners: tuple[Floats, Floats, Floats],
        fan_normals: Floats,
        p: Floats,
        plane: PlaneRule,
        triangle: TriangleRule,
        /,
    ) -> PolygonHits: ...


class ToLightRule(Protocol):
    """S12: the unit direction (3, 1) toward a light that travels along l."""

    def __call__(self, l: Floats, /) -> Floats: ...


class StartRule(Protocol):
    """S12, S14, S16: t0 of secondary rays."""

    def __call__(self, epsilon: float, /) -> float: ...


class TowardViewerRule(Protocol):
    """S13: the normals (3, n) turned to where rays came from."""

    def __call__(self, s: Floats, delta: Floats, /) -> Floats: ...


class IlluminateRule(Protocol):
    """S13: the colour (3, n) of lit points."""

    def __call__(
        self,
        surface: shading.Surfaces,
        light_color: Floats,
        to_light: Floats,
        s: Floats,
        delta: Floats,
        mirror: Floats,
        /,
    ) -> Floats: ...


class ShadowColorRule(Protocol):
    """S13: the colour (3, n) of points in shadow."""

    def __call__(
        self, surface: shading.Surfaces, color: tuple[float, float, float] | None, /
    ) -> Floats: ...


class ReflectRule(Protocol):
    """S14: ρ (3, n)."""

    def __call__(self, delta: Floats, s: Floats, /) -> Floats: ...


class IndicesRule(Protocol):
    """S15: ν and ν_t (n,)."""

    def __call__(self, ior: Floats, leaving: Bools, /) -> tuple[Floats, Floats]: ...


class RefractRule(Protocol):
    """S16: ϱ (3, n); NaN at total internal reflection."""

    def __call__(self, delta: Floats, s: Floats, nu: Floats, nu_t: Floats, /) -> Floats: ...
