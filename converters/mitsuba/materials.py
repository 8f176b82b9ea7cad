"""Phong's material as Mitsuba's BSDFs: exact for pure diffuse and mirror, else approximate.

| minirt | Mitsuba | |
|---|---|---|
| diffuse alone | two-sided `diffuse` | the same: Lambert's ρ/π meets an irradiance of π·light |
| k_r = 1 | two-sided `conductor`, material none | the same: reflects everything |
| specular, shininess n | `roughplastic`, Beckmann, α = √(2/(n+2)) | as wide; Fresnel's strength |
| k_r, k_t between 0 and 1 | `blendbsdf` by those shares | the same shares |
| ior, k_t > 0 | smooth `dielectric` | the same directions; Fresnel's share is reflected too |
| ambient, α | nothing | radiance without a light; a number that minirt only copies |

α of the lobe: B. Walter et al. 2007 (Microfacet Models for Refraction), n = 2/α² − 2.
"""

from __future__ import annotations

import math
from typing import Any

from minirt.scene import Material

Description = dict[str, Any]


def material_to_dict(material: Material) -> Description:
    """Mitsuba's nearest BSDF, as a plain nested dict."""
    surface = {"type": "twosided", "bsdf": _opaque(material)}
    if material.transmittance == 0:
        return surface
    glass = {"type": "dielectric", "int_ior": material.ior, "ext_ior": 1.0}
    return _blend(material.transmittance, surface, glass)


def is_exact(material: Material) -> bool:
    """Whether Mitsuba's radiance is the slides' own: pure diffuse or pure mirror."""
    if material.reflectance == 1:
        return True
    plain = not any(material.ambient) and not any(material.specular)
    unshared = material.reflectance == 0 and material.transmittance == 0
    return plain and unshared and max(material.diffuse) <= 1


def rgb(color: tuple[float, float, float]) -> Description:
    """A colour of any magnitude."""
    return {"type": "rgb", "value": list(color)}


def _opaque(material: Material) -> Description:
    """The part that is not transmitted: mirror and local colour by their shares."""
    remaining = 1 - material.transmittance
    share = min(material.reflectance / remaining, 1.0) if remaining > 0 else 0.0
    mirror = {"type": "conductor", "material": "none"}
    return _blend(share, _local(material), mirror)


def _local(material: Material) -> Description:
    diffuse = rgb(_reflectance(material.diffuse))
    if not any(material.specular):
        return {"type": "diffuse", "reflectance": diffuse}
    return {
        "type": "roughplastic",
        "distribution": "beckmann",
        "alpha": math.sqrt(2 / (material.shininess + 2)),
        "diffuse_reflectance": diffuse,
        "specular_reflectance": rgb(_reflectance(material.specular)),
    }


def _reflectance(color: tuple[float, float, float]) -> tuple[float, float, float]:
    """Mitsuba takes reflectances up to 1 only."""
    r, g, b = (min(channel, 1.0) for channel in color)
    return r, g, b


def _blend(share: float, first: Description, second: Description) -> Description:
    if share == 0:
        return first
    if share == 1:
        return second
    return {"type": "blendbsdf", "weight": share, "first": first, "second": second}
