"""A camera given by eye, target and field of view, resolved to the slides' screen."""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

from minirt.errors import SceneError
from minirt.scene_file.schema import SMALLEST, LookAtScreenModel
from minirt.screen import VirtualScreen
from minirt.vectors import Floats, cross, norm

_PI = Decimal("3.14159265358979323846264338327950288419716939937510582")


def resolve_look_at(model: LookAtScreenModel, where: str) -> VirtualScreen:
    """The screen at distance 1 in front of the eye: n points from target to eye, ν = −1.

    Parameters
    ----------
    model : LookAtScreenModel
    where : str
        The file and the JSON path of the screen, for errors.

    Raises
    ------
    SceneError
        Eye and target coincide, or `up` is along the line of sight.

    Source: S1.
    """
    camera = model.look_at
    eye, up = np.array(camera.eye), np.array(camera.up)
    backward = eye - np.array(camera.target)
    if not norm(backward) >= SMALLEST:
        raise SceneError(
            "eye and target coincide",
            where=f"{where}.look_at.target",
            got=str(list(camera.target)),
            expected="a point other than the eye",
        )
    n = _unit(backward)
    right = cross(up, n)
    if not norm(right) > 2.0**-40 * norm(up) or not norm(up) > 0:
        raise SceneError(
            "'up' is zero or along the line of sight",
            where=f"{where}.look_at.up",
            got=str(list(camera.up)),
            expected="a direction across the line of sight",
        )
    u = _unit(right)
    v = _unit(cross(n, u))
    top = half_angle_tangent(camera.fov_y)
    side = top * model.nx / model.ny
    u_, v_, n_ = ((float(x), float(y), float(z)) for x, y, z in (u, v, n))
    return VirtualScreen(camera.eye, u_, v_, n_, -1.0, -side, side, -top, top, model.nx, model.ny)


def half_angle_tangent(degrees: float) -> float:
    """tan(degrees/2), correctly rounded but for ties; a C library's tangent differs between CPUs.

    Examples
    --------
    >>> half_angle_tangent(90.0)
    1.0
    """
    with localcontext() as context:
        context.prec = 50
        x = Decimal(degrees) * _PI / 360
        sine, cosine, term, k = Decimal(0), Decimal(1), Decimal(1), 0
        while abs(term) > Decimal("1e-49"):
            k += 1
            term = term * x / k
            if k % 2:
                sine += term if k % 4 == 1 else -term
            else:
                cosine += term if k % 4 == 0 else -term
        return float(sine / cosine)


def _unit(vector: Floats) -> Floats:
    """The unit vector; a second division corrects the rounding of the first one."""
    once = vector / norm(vector)
    return once / norm(once)
