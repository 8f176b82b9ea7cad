"""A failing pixel as a C++ test that needs nothing but the author's own intersection."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable

import numpy as np

from minirt.frame import Frame
from minirt.quantities import QUANTITIES
from minirt.render import render
from minirt.rules import SLIDES
from minirt.scene import Scene, Sphere
from minirt.vectors import Floats
from minirt.whitted import primary_directions
from reference.fuzz.trial import Trial

#: Relative tolerance of t, for an intersection in double: 2**16 roundings of 2**-53.
_TOLERANCE = 2.0**-37

_TEXT = """\
// %(about)s
//
// One ray of the scene below, and what minirt finds. Define `intersect` by a call of your own code,
// at the end of this file or in one that is linked with it:
//     g++ -std=c++17 TEST.cpp YOURS.cpp && ./a.out
// Exit status 0: right; 1: wrong. Objects are numbered as in `objects`; t = 1 at the screen.
// Numbers are hexadecimal where they are exact in binary. First wrong stage: %(stage)s.
#include <cmath>
#include <cstdio>
#include <limits>
#include <vector>

struct Sphere { int object; double center[3]; double radius; };
struct Triangle { int object; int face; double a[3], b[3], c[3]; };
struct Answer { bool hit; int object; double t; double value[3]; };

const double infinity = std::numeric_limits<double>::infinity();
const double none = std::numeric_limits<double>::quiet_NaN();

const char *const scene = R"minirt(%(scene)s)minirt";
const std::vector<Sphere> spheres = {%(spheres)s};
const std::vector<Triangle> triangles = {%(triangles)s};

// The ray P0 + t*d, t > 0; d is not normalised.
const double P0[3] = {%(P0)s};
const double d[3] = {%(d)s};

// What is expected. `value` is the quantity that fails: %(quantity)s (%(meaning)s).
const Answer expected = {%(hit)s, %(object)s, %(t)s, {%(value)s}};
const int components = %(components)s;
const double tolerance = %(tolerance)s;

// YOUR CODE: the first object that the ray meets, and `%(quantity)s` there.
Answer intersect(const double origin[3], const double direction[3]);

static bool same(double a, double b) {
    if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
    if (std::isinf(a) || std::isinf(b)) return a == b;
    return std::fabs(a - b) <= tolerance * std::fmax(1.0, std::fabs(b));
}

int main() {
    const Answer got = intersect(P0, d);
    int wrong = (got.hit != expected.hit) + (got.object != expected.object);
    wrong += got.hit && !(std::fabs(got.t - expected.t) <= tolerance * std::fabs(expected.t));
    for (int k = 0; k < components; ++k) wrong += !same(got.value[k], expected.value[k]);
    std::printf("hit %%d object %%d t %%.17g; expected hit %%d object %%d t %%.17g\\n", got.hit,
                got.object, got.t, expected.hit, expected.object, expected.t);
    return wrong ? 1 : 0;
}
"""


def cpp_test(scene: Scene, trial: Trial, about: str) -> str:
    """The text of a C++17 program that tests one pixel's ray.

    Parameters
    ----------
    scene : Scene
    trial : Trial
        Names the pixel and the quantity.
    about : str
        One line for its head.
    """
    frame = render(scene)
    screen, pixel = scene.screen, (trial.row, trial.column)
    quantity = QUANTITIES[trial.quantity or "t"]
    index = trial.row * screen.nx + trial.column
    d = primary_directions(scene, SLIDES, np.array([index]))[:, 0]
    value = np.resize(np.append(_value(frame, quantity.name, pixel), [math.nan] * 3), 3)
    return _TEXT % {
        "about": about.replace("\\", "/").replace("??", "? ?"),
        "stage": trial.stage,
        "scene": json.dumps(scene.to_dict(), ensure_ascii=True),
        "spheres": _spheres(scene),
        "triangles": _triangles(scene),
        "P0": _list(screen.P0),
        "d": _list(d),
        "quantity": quantity.name,
        "meaning": quantity.about,
        "hit": "true" if frame["hit"][pixel] else "false",
        "object": int(frame["object"][pixel]),
        "t": literal(float(frame["t"][pixel])),
        "value": _list(value),
        "components": quantity.components,
        "tolerance": literal(_TOLERANCE),
    }


def literal(value: float) -> str:
    """A double as C++ writes it: hexadecimal, or the constant `infinity` or `none`.

    Examples
    --------
    >>> literal(0.5), literal(-math.inf)
    ('0x1.0000000000000p-1', '-infinity')
    """
    if math.isnan(value):
        return "none"
    if math.isinf(value):
        return "infinity" if value > 0 else "-infinity"
    return value.hex()


def _value(frame: Frame, name: str, pixel: tuple[int, int]) -> Floats:
    return np.atleast_1d(frame[name][pixel]).astype(np.float64)


def _list(values: Iterable[float]) -> str:
    return ", ".join(literal(float(x)) for x in values)


def _spheres(scene: Scene) -> str:
    return "".join(
        f"\n    {{{k}, {{{_list(thing.center)}}}, {literal(thing.radius)}}},"
        for k, thing in enumerate(scene.objects)
        if isinstance(thing, Sphere)
    )


def _triangles(scene: Scene) -> str:
    lines = []
    for k, thing in enumerate(scene.objects):
        if not isinstance(thing, Sphere):
            for face, corners in enumerate(thing.vertices[thing.faces]):
                points = ", ".join(f"{{{_list(corner)}}}" for corner in corners)
                lines.append(f"\n    {{{k}, {face}, {points}}},")
    return "".join(lines)
