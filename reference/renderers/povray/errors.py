"""How POV-Ray errs: float64 rays, float32 colours and indices, and the steps of its PNG files."""

from __future__ import annotations

import math

import numpy as np

from converters.placement import Placement, reach
from converters.povray.scene import brightest
from minirt.geometry import Geometry
from minirt.scene import Scene
from reference.renderers.povray.passes import WHITE, Grid
from reference.source import AlongRay, Declared

#: Largest relative errors of rounding to float64 and to float32.
U64, U32 = 2.0**-53, 2.0**-24
#: What is nearer to a ray's start is ignored, in POV-Ray's units: MIN_ISECT_DEPTH for reflected
#: and refracted rays, SHADOW_TOLERANCE for shadow rays.
NEAREST, NEAREST_SHADOW = 1e-4, 1e-3
#: A squared half chord of a sphere below this is no hit (EPSILON).
_CHORD = 1e-10
#: Float32 roundings on the way of a colour through one surface: of the constants of at most six
#: layers, their products and sums.
_ROUNDINGS = 32

_DERIVATION = (
    "float64, u = 2⁻⁵³, in POV-Ray's coordinates (1 scene unit is {scale:g} there); R the largest "
    "coordinate, E the scene's extent, r the least radius. Placing a point moves it by √3·u·R; a "
    "facet's plane and edges err by 20 roundings at that size, a camera ray's direction by 16·u; "
    "a sphere's (half chord)² = r² − c² + t² by 10·u·E², which moves its outline by 5·u·E²/r, and "
    "below 1e-10 it is no hit, 5e-11/r. δ = u·(20·√3·R + 16·E + 5·E²/r) + 5e-11/r "
    "= {delta:.3g} scene units. Rays ignore what is nearer than 1e-4, shadow rays 1e-3. Indices of "
    "refraction are float32: 2⁻²² in a quotient turns a refracted ray as a normal tilted by "
    "2⁻²²·tan θ/(1 − 1/n) does, θ the "
    "critical angle. Positions come in steps of {step:.2g}, normals and colours in codes of "
    "1/65535, colours after float32 sums. Each triangle is tested by itself, with roundings of its "
    "own: a ray through an edge may slip between two."
)


def exposure_of(scene: Scene) -> float:
    """The power of two by which a scene's light is multiplied, so that PNG's codes suffice."""
    bound = brightest(scene)
    return 2.0 ** -math.frexp(bound)[1] if bound > 0 else 1.0


def coarse_color(scene: Scene) -> str | None:
    """Why colours in POV-Ray's steps would say little of a scene; None where they say enough.

    A picture is looked at in colours of 0 to 1, in steps of 1/255. Where the brightest colour is so
    far beyond 1 that POV-Ray's 65,535 codes are coarser than that, dark pixels would be judged by
    a tolerance that lets them be anything.
    """
    step = _color_step(scene)
    if step * 255 <= 1:
        return None
    return f"colours up to {brightest(scene):.3g} leave steps of {step:.2g} between POV-Ray's codes"


def declared(scene: Scene, placement: Placement) -> Declared:
    """Bounds on POV-Ray's errors on a scene that stands where `placement` puts it."""
    R, E = reach(scene, placement), placement.length(scene.extent)
    geometry, scale = Geometry.of(scene), placement.scale
    least = placement.length(float(geometry.spheres.radius.min(initial=np.inf)))
    rounding = U64 * (20 * math.sqrt(3) * R + 16 * E + 5 * E * E / least)
    delta = (rounding + _CHORD / 2 / least) / scale
    step = math.sqrt(3) / 2 * Grid.of(scene, placement).step / scale
    seen = NEAREST if scene.epsilon * scale >= NEAREST_SHADOW else NEAREST_SHADOW
    return Declared(
        delta=delta,
        vertex=math.sqrt(3) * U64 * R / scale,
        angle=16 * U64 + _index_angle(scene),
        color=0.0,
        start=AlongRay(seen / scale),
        derivation=_DERIVATION.format(scale=scale, delta=delta, step=step),
        steps=(
            *((name, step) for name in ("t", "depth", "distance", "position")),
            ("normal", math.sqrt(3) * (1 / WHITE + 4 * U32)),
            ("color", _color_step(scene)),
        ),
        watertight=False,
        near=NEAREST / scale,
    )


def _color_step(scene: Scene) -> float:
    """Half a code and the rounding of sums, in the largest colour that there can be; three axes.

    A point's colour is a convex mixture of at most max_depth + 1 generations'.
    """
    rounding = _ROUNDINGS * (scene.max_depth + 1) * U32
    return math.sqrt(3) * (0.5 / WHITE + rounding) / exposure_of(scene)


def _index_angle(scene: Scene) -> float:
    """The tilt of a normal that turns refracted rays as much as the rounding of indices does.

    A relative error e of n in sin φ = n sin θ turns φ by e·tan φ, at most e·tan θ_c. A tilt a of
    the normal turns it by a·|n cos θ/cos φ − 1|, at least a·(1 − 1/n), n > 1.
    """
    used = [scene.material_of(k) for k in range(len(scene.objects))]
    indices = {max(m.ior, 1 / m.ior) for m in used if m.transmittance and m.ior and m.ior != 1}
    turns = [1 / math.sqrt(n * n - 1) / (1 - 1 / n) for n in indices]
    return 2.0**-22 * max(turns, default=0.0)
