"""Mitsuba's nested dict as its XML."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

#: The XML tag of each plugin that `converters.mitsuba.scene` uses.
_TAGS = {
    "path": "integrator", "aov": "integrator", "perspective": "sensor", "stratified": "sampler",
    "hdrfilm": "film", "box": "rfilter", "directional": "emitter", "constant": "emitter",
    "sphere": "shape", "ply": "shape", "twosided": "bsdf", "diffuse": "bsdf", "conductor": "bsdf",
    "dielectric": "bsdf", "roughplastic": "bsdf", "blendbsdf": "bsdf",
}  # fmt: skip
_VECTORS = {"center": "point", "direction": "vector"}
_SCALARS = {bool: "boolean", int: "integer", float: "float", str: "string"}


def scene_xml(description: dict[str, Any]) -> str:
    """The XML document of a nested dict; numbers as their shortest round trip.

    A ``filename`` is written without its folder: the file lies beside the document.
    """
    root = ElementTree.Element("scene", version="3.0.0")
    for key, value in description.items():
        if key != "type":
            child = _add(root, key, value)
            if "type" in child.attrib:
                child.set("id", child.attrib.pop("name"))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _add(parent: ElementTree.Element, key: str, value: Any) -> ElementTree.Element:
    if isinstance(value, dict):
        return _add_object(parent, key, value)
    if key == "to_world":
        transform = ElementTree.SubElement(parent, "transform", name=key)
        rows = " ".join(repr(number) for row in value for number in row)
        return ElementTree.SubElement(transform, "matrix", value=rows)
    if isinstance(value, list):
        return ElementTree.SubElement(parent, _VECTORS[key], name=key, value=_numbers(value))
    text = repr(value) if isinstance(value, float) else str(value)
    if isinstance(value, bool):
        text = text.lower()
    elif key == "filename":
        text = Path(value).name
    return ElementTree.SubElement(parent, _SCALARS[type(value)], name=key, value=text)


def _add_object(
    parent: ElementTree.Element, key: str, value: dict[str, Any]
) -> ElementTree.Element:
    kind = value["type"]
    if kind == "ref":
        return ElementTree.SubElement(parent, "ref", name=key, id=value["id"])
    if kind == "rgb":
        return ElementTree.SubElement(parent, "rgb", name=key, value=_numbers(value["value"]))
    child = ElementTree.SubElement(parent, _TAGS[kind], type=kind, name=key)
    for name, part in value.items():
        if name != "type":
            _add(child, name, part)
    return child


def _numbers(values: list[float]) -> str:
    return ", ".join(repr(float(value)) for value in values)
