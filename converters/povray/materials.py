"""Phong's material as POV-Ray's layered texture, whose colour is exactly rule S13's and S7's.

Behind layers that transmit F, a layer of pigment P, transmit τ, emission e, diffuse d and phong p
adds ``F·P·(1−τ)·(e + light·d·max(0, s·L)) + F·light·p·max(0, ρ·L)^n``, in shadow ``F·P·(1−τ)·e``,
and transmits F·τ, or F·P where it has ``filter 1`` (read in the source of 3.7, measured, and
verified by every scene of the atlas). So, from the top, with w = 1 − k_r − k_t:

| layer | pigment | transmits | finish | adds |
|---|---|---|---|---|
| emission | ambient, or the shadow colour | ½ | emission, reflection | w·ambient, k_r·C(ρ) |
| where shadow has a colour | (ambient − shadow)/light | ½ | brilliance 0 | the rest, lit |
| diffuse | diffuse | ½ | diffuse; phong where specular is grey | w·diffuse·max(0, s·L) |
| where specular is coloured | filters specular | | phong | w·specular·max(0, ρ·L)^n |
| last | black | what makes the whole k_t | | k_t·C(ϱ) |

`refraction` scales what arrives from behind the surface, also the ray mirrored at total reflection,
which no layer filters: it is k_r + k_t, as E2 demands, and the layers transmit k_t/(k_r + k_t). A
transparent object casts no shadow itself: a twin that only shadow rays hit does (S12: every object
casts a shadow), see `converters.povray.scene`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from converters.povray.shapes import vector
from minirt.scene import Material

Color = tuple[float, float, float]
#: A share of the strongest channel whose inverse is in float32's range too: a fainter channel is
#: filtered out, and no filter above can restore it.
_FAINTEST = 2.0**-100


@dataclass
class _Layers:
    """A stack of layers from the top, and the share that it transmits so far."""

    through: float = 1.0
    text: list[str] = field(default_factory=list)

    def add(self, color: Color, on: float, finish: str = "") -> None:
        """Add a layer that transmits the share `on`, unfiltered."""
        transmit = f" transmit {on!r}" if on else ""
        self._put(f"rgb {vector(color)}{transmit}", finish)
        self.through *= on

    def filter(self, color: Color) -> None:
        """Add a layer that transmits its colour."""
        self._put(f"rgb {vector(color)} filter 1", "")

    def _put(self, pigment: str, finish: str) -> None:
        finish = f" finish {{ {finish} }}" if finish else ""
        self.text.append(f"texture {{ pigment {{ {pigment} }}{finish} }}")


def unsupported_material(material: Material, light: Color, shadow: Color | None) -> str | None:
    """Why layers cannot express this material's colour exactly; None where they can.

    Parameters
    ----------
    material : Material
    light : tuple of 3 float
        The light's colour.
    shadow : tuple of 3 float or None
        The scene's shadow colour.
    """
    if shadow is not None:
        channels = zip(light, material.ambient, shadow, strict=True)
        if any(lamp == 0 and lit != dark for lamp, lit, dark in channels):
            return "a shadow colour other than the ambient one, in a channel without light"
    least = _FAINTEST * max(material.specular)
    if material.transmittance and any(material.specular) and min(material.specular) <= least:
        return "a highlight that lacks a channel, on a transparent object"
    return None


def material_texture(
    material: Material, light: Color, shadow: Color | None, exposure: float
) -> str:
    """The layered texture of a material, bottom layer first as POV-Ray reads it.

    Parameters
    ----------
    material : Material
        One that `unsupported_material` allows.
    light : tuple of 3 float
        The light's colour.
    shadow : tuple of 3 float or None
        The scene's shadow colour.
    exposure : float
        Factor on emission; the light in the file must have it too.
    """
    k_r, k_t = material.reflectance, material.transmittance
    w = 1 - k_r - k_t
    layers = _Layers()
    dark = material.ambient if shadow is None else shadow
    shine = f"emission {2 * w * exposure!r} reflection {{ {k_r!r} }}"
    layers.add(dark, 0.5, shine + (f" refraction {k_r + k_t!r}" if k_t else ""))
    if shadow is not None:
        channels = zip(material.ambient, shadow, light, strict=True)
        r, g, b = ((lit - dark) / (lamp or 1.0) for lit, dark, lamp in channels)
        constant = 2 * w / layers.through
        layers.add((r, g, b), 0.5, f"diffuse {constant!r}, {constant!r} brilliance 0")
    _add_local(layers, material, w)
    layers.add((0.0, 0.0, 0.0), k_t / (k_r + k_t) / layers.through if k_t else 0.0)
    return "\n  ".join(reversed(layers.text))


def _add_local(layers: _Layers, material: Material, w: float) -> None:
    """S13's diffuse and specular terms, w of them."""
    strongest, F = max(material.specular), layers.through
    diffuse = f"diffuse {2 * w / F!r}"
    if strongest == min(material.specular):
        layers.add(material.diffuse, 0.5, f"{diffuse} {_phong(material, w * strongest / F)}")
        return
    layers.add(material.diffuse, 0.5, diffuse)
    r, g, b = material.specular
    layers.filter((r / strongest, g / strongest, b / strongest))
    layers.add((0.0, 0.0, 0.0), 1.0, _phong(material, w * strongest / layers.through))
    if material.transmittance:
        x, y, z = (strongest / c if c else 1.0 for c in material.specular)
        layers.filter((x, y, z))


def _phong(material: Material, strength: float) -> str:
    return f"phong {strength!r} phong_size {material.shininess}"
