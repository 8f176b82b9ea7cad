"""The screen of a scene file, in either form, checked and resolved to the slides' screen."""

from __future__ import annotations

import numpy as np

from minirt.errors import SceneError
from minirt.scene_file.look_at import resolve_look_at
from minirt.scene_file.schema import MAX_PIXELS, SMALLEST, LookAtScreenModel, ScreenModel
from minirt.screen import VirtualScreen
from minirt.vectors import Floats, dot, norm


def resolve_screen(model: ScreenModel | LookAtScreenModel, where: str) -> VirtualScreen:
    """The virtual screen that a scene file describes.

    Parameters
    ----------
    model : ScreenModel or LookAtScreenModel
    where : str
        The file and the JSON path, for errors.

    Raises
    ------
    SceneError
        Too many pixels, a frame that is not orthonormal, ν = 0, no area, or a camera without a
        direction.

    Source: S1, S2.
    """
    if model.nx * model.ny > MAX_PIXELS:
        raise SceneError(
            "the image is over the size limit",
            where=f"{where}.nx",
            got=f"{model.nx} × {model.ny}",
            expected=f"at most {MAX_PIXELS:,} pixels",
        )
    if isinstance(model, LookAtScreenModel):
        return resolve_look_at(model, where)
    _require_orthonormal({name: np.array(getattr(model, name)) for name in "uvn"}, where)
    if abs(model.nu) < SMALLEST:
        raise SceneError(
            "the screen would contain the observer",
            where=f"{where}.nu",
            got=repr(model.nu),
            expected="a number other than 0, of either sign",
        )
    for low, high in ("lr", "bt"):
        if not getattr(model, high) - getattr(model, low) >= SMALLEST:
            raise SceneError(
                "the screen has no area",
                where=f"{where}.{high}",
                got=f"{low} = {getattr(model, low)!r}, {high} = {getattr(model, high)!r}",
                expected=f"{low} < {high}",
            )
    return VirtualScreen(**model.model_dump())


def _require_orthonormal(axes: dict[str, Floats], where: str) -> None:
    """Refuse axes u, v, n that are not of length 1, or not perpendicular, to within 1e-9."""
    for name, axis in axes.items():
        if abs(float(dot(axis, axis)) - 1) > 2e-9:  # the square's error is twice the length's
            raise SceneError(
                "the frame is not orthonormal: not a unit vector",
                where=f"{where}.{name}",
                got=f"length {float(norm(axis))!r}",
                expected="1 to within 1e-9" + _normalised(axis),
            )
    for first, second in ("uv", "un", "vn"):
        product = float(dot(axes[first], axes[second]))
        if abs(product) > 1e-9:
            raise SceneError(
                "the frame is not orthonormal: two axes are not perpendicular",
                where=f"{where}.{second}",
                got=f"{first}·{second} = {product!r}",
                expected="0 to within 1e-9",
            )


def _normalised(axis: Floats) -> str:
    """The unit vector along an axis, as a suggestion; empty for an axis without a direction."""
    length = float(norm(axis))
    return f", as {(axis / length).tolist()}" if length >= SMALLEST else ""
