"""How pyrender errs: chords instead of arcs, vertices on a subpixel grid, steps of depth."""

from __future__ import annotations

from converters.pyrender import COARSEST, PyrenderScene
from reference.renderers.pyrender.draw import SUBPIXEL_BITS
from reference.source import Declared

#: Largest relative error of rounding to float32, and the step of a depth buffer of 24 bits.
U32 = 2.0**-24
#: Parts of a pixel that a rasteriser rounds vertices to.
SUBPIXELS = 2**SUBPIXEL_BITS

_DERIVATION = (
    "u = 2⁻²⁴, E the scene's extent, n the longer side of the image in pixels. Vertices are "
    "rounded once, in the observer's coordinates, and where a face is clipped, by at most three "
    "planes, its new corners carry two roundings a plane: 7·√3·u·E. On the image vertices are "
    "rounded to 1/256 pixel, √2/512 of one at most, after {roundings:.0f}·u·n pixels of rounding "
    "per axis in the camera's matrix, the viewport and the planes that depth is interpolated in; "
    "a sphere's triangles stray by up to {chord:.4f} pixel from it. A pixel at distance x is "
    "{pixel:.3g}·x wide. So δ = {delta:.3g} + {slope:.3g}·x scene units. A depth buffer's value "
    "D in [0, 1] means a depth z with dz/z ≤ (f/n)·dD for planes at n and f; the matrix, the "
    "interpolation, the step and pyrender's way back from D, all in float32, make "
    "(12·f/n + 3)·u = {grain:.3g} of the depth."
)


def declared(whole: PyrenderScene) -> Declared:
    """Bounds on pyrender's errors on a scene.

    The camera's matrix turns x, z and P02 = (l + r)/(r − l) into (P00·x + P02·z)/z: 6 roundings
    of numbers up to 2 + |P02|, faces being clipped at twice the screen; times n/2. The viewport
    adds 2·u·n, and depth is interpolated from the corner of the image, which is as good as 4
    roundings of a place there.

    Depths: what is clipped at the near plane is rounded at the scale of the whole scene, hence f
    is at least E. Of the factor 12, the matrix takes 4.5 (P22 ≤ 1, P23/z ≤ 2 and the sum of
    them; halved), the interpolation 4, the step 1 and the way back 2; 3·u for its divisions.

    A sphere whose triangles are too coarse, because their number is limited, adds its error to δ.
    """
    scene, camera = whole.scene, whole.camera
    screen, extent = scene.screen, scene.extent
    pixels = max(screen.nx, screen.ny)
    shift = max(
        abs(screen.l + screen.r) / (screen.r - screen.l),
        abs(screen.b + screen.t) / (screen.t - screen.b),
    )
    roundings = 3 * (2 + shift) + 6
    chord, rest = _chords(whole)
    slope = whole.pixel * (chord + 2**0.5 * (0.5 / SUBPIXELS + roundings * U32 * pixels))
    delta = 7 * 3**0.5 * U32 * extent + rest
    grain = (12 * max(camera.zfar, whole.scale * extent) / camera.znear + 3) * U32
    text = _DERIVATION.format(
        roundings=roundings, chord=chord, pixel=whole.pixel, delta=delta, slope=slope, grain=grain
    )
    return Declared(
        delta=delta, vertex=3**0.5 * U32 * extent, angle=0.0, color=0.0, start=None,
        derivation=text, slope=slope, grain=grain,
    )  # fmt: skip


def _chords(whole: PyrenderScene) -> tuple[float, float]:
    """Largest error of spheres in pixels, and in scene units where that would be too many."""
    chord = rest = 0.0
    for error, distance in whole.chord_errors():
        if error <= COARSEST * whole.pixel * distance:
            chord = max(chord, error / (whole.pixel * distance))
        else:
            rest = max(rest, error)
    return chord, rest
