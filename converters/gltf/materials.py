"""Phong's material in glTF's terms, metallic-roughness: approximate.

| minirt | glTF |
|---|---|
| diffuse | base colour, turned towards white as k_r makes it a mirror |
| k_r | metallic; roughness falls to 0 with it |
| specular, shininess n | roughness √α, α = √(2/(n+2)); 1 without a specular term |
| ambient | emissive: radiance that needs no light |
| ior, k_t | KHR_materials_ior, KHR_materials_transmission |
| α | the base colour's, which an opaque material ignores, as minirt does |

Source of α: B. Walter et al. 2007, n = 2/α² − 2; roughness is √α in glTF.
"""

from __future__ import annotations

from typing import Any

from minirt.scene import Material

Description = dict[str, Any]


def material_to_gltf(name: str, material: Material) -> Description:
    """The nearest glTF material, its numbers clamped to what the format allows."""
    mirror = material.reflectance
    base = [min(c, 1.0) * (1 - mirror) + mirror for c in material.diffuse]
    rough = (2 / (material.shininess + 2)) ** 0.25 if any(material.specular) else 1.0
    smooth = max(mirror, material.transmittance)
    description: Description = {
        "name": name,
        "doubleSided": True,
        "pbrMetallicRoughness": {
            "baseColorFactor": [*base, material.alpha],
            "metallicFactor": mirror,
            "roughnessFactor": rough * (1 - smooth),
        },
        "emissiveFactor": [min(c, 1.0) for c in material.ambient],
    }
    if material.ior is not None:
        extensions = {"KHR_materials_ior": {"ior": max(material.ior, 1.0)}}
        if material.transmittance:
            passing = {"transmissionFactor": material.transmittance}
            extensions["KHR_materials_transmission"] = passing
        description["extensions"] = extensions
    return description


def used_extensions(materials: list[Description]) -> list[str]:
    """Names of the glTF extensions that some materials use, sorted."""
    return sorted({name for material in materials for name in material.get("extensions", ())})
