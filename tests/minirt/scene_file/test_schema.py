"""The published JSON Schema accepts what is valid, and refuses what one key can get wrong."""

from __future__ import annotations

import json
from typing import Any

import jsonschema
import pytest

import minirt
from minirt.scene_file.atlas import atlas_names
from minirt.scene_file.schema import SceneDocument, scene_schema
from tests.helpers.scene_documents import SQUARE, changed

#: The example of the format's documentation.
EXAMPLE: dict[str, Any] = {
    "minirt": 1, "name": "ball-on-quad", "about": "one line: what this scene proves",
    "rules": ["S8", "S11", "S12"],
    "screen": {"P0": [0, 0, 5], "u": [1, 0, 0], "v": [0, 1, 0], "n": [0, 0, 1], "nu": -1.0,
               "l": -1.0, "r": 1.0, "b": -0.75, "t": 0.75, "nx": 256, "ny": 192},
    "light": {"direction": [-1, -2, -1], "color": [1, 1, 1]},
    "background": [0, 0, 0], "shadow_color": None, "epsilon": None, "max_depth": 5,
    "materials": {"red": {"ambient": [0.1, 0, 0], "diffuse": [0.8, 0.1, 0.1],
                          "specular": [0.2, 0.2, 0.2], "shininess": 32, "reflectance": 0.0,
                          "transmittance": 0.0, "ior": None, "alpha": 1.0}},
    "objects": [
        {"type": "sphere", "name": "ball", "material": "red", "center": [0, 0, 0], "radius": 1.0},
        {"type": "triangle", "name": "tri", "material": "red", "vertices": SQUARE[:3]},
        {"type": "polygon", "name": "floor", "material": "red",
         "vertices": [[-4, -1, 4], [4, -1, 4], [4, -1, -4], [-4, -1, -4]]},
        {"type": "mesh", "name": "part", "material": "red", "file": "part.ply",
         "transform": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]},
    ],
}  # fmt: skip


def _validator() -> jsonschema.Draft202012Validator:
    jsonschema.Draft202012Validator.check_schema(scene_schema())
    return jsonschema.Draft202012Validator(scene_schema())


def test_the_schema_is_that_of_the_model() -> None:
    schema = scene_schema()
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert set(schema["properties"]) == set(SceneDocument.model_fields)
    assert json.loads(json.dumps(schema)) == schema


def test_schema_accepts_the_documented_example() -> None:
    _validator().validate(EXAMPLE)
    SceneDocument.model_validate(EXAMPLE)


def test_schema_accepts_every_scene_of_the_atlas() -> None:
    validator, folder = _validator(), minirt.load_scene("atlas:one-sphere").folder
    documents = [json.loads((folder / f"{name}.json").read_text()) for name in atlas_names()]
    assert len(documents) >= 28
    for document in documents:
        validator.validate(document)
    for name in atlas_names():
        validator.validate(minirt.load_scene(f"atlas:{name}").to_dict())


def test_schema_refuses_what_one_key_alone_can_get_wrong() -> None:
    validator = _validator()
    for put, value in (
        (("zoom",), 1), (("minirt",), 2), (("screen", "nx"), 0), (("screen", "P0"), [0, 0]),
        (("objects", 0, "radius"), -1), (("objects", 0, "type"), "cube"), (("light",), {}),
        (("materials", "m", "shininess"), 0), (("rules",), ["S99"]), (("objects",), {}),
    ):  # fmt: skip
        with pytest.raises(jsonschema.ValidationError):
            validator.validate(changed(put, value))
