"""Every bad scene is one clear error with its file and JSON path."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path
from typing import Any

import pytest

import minirt
from minirt.errors import MinirtError, SceneError
from tests.helpers.scene_documents import (
    BASE,
    GONE,
    LOOK_AT,
    PENTAGRAM,
    SQUARE,
    changed,
    look_at,
)


def _mesh(file: str, **more: Any) -> dict[str, Any]:
    return {"type": "mesh", "material": "m", "file": file, **more}


_RANGE, _NUMBER = "a number is out of range", "not a number"
_CONVEX = "expected a convex planar polygon, in order"
_OBJECT, _ARRAY = "not a JSON object", "not an array"

INVALID: list[tuple[tuple[str | int, ...], Any, str, str]] = [
    # where it is put, what is put there, the JSON path named, what the sentence says
    (("minirt",), 2, "minirt", "not a usable value; got 2; expected 1"),
    (("minirt",), True, "minirt", "not a version of the format; got true; expected 1"),
    (("minirt",), GONE, "minirt", "a required key is missing"),
    (("name",), 3, "name", "not text; got 3; expected text in quotes"),
    (("name",), "", "name", 'the text is empty; got ""; expected at least one character'),
    (("name",), "\ud800", "name", "not Unicode text"),
    (("about",), "x" * 100_001, "about", "the text is too long"),
    (("zoom",), 1, "zoom", "unknown key; got 1; expected one of minirt, name,"),
    (("rules",), ["S8", "S18"], "rules[1]", "not a rule of the lecture; got \"S18\"; expected S1"),
    (("floor",), {"certain": 2, "why": "x"}, "floor.certain", f"{_RANGE}; got 2; expected at"),
    (("screen",), [], "screen", f"{_OBJECT}; got []"),
    (("screen",), None, "screen", f"{_OBJECT}; got null"),
    (("screen",), GONE, "screen", "a required key is missing"),
    (("screen", "zoom"), 3, "screen.zoom", "unknown key; got 3"),
    (("screen", "look_at"), LOOK_AT, "screen.P0", "unknown key beside look_at; got [0, 0, 5]; "
     "expected either look_at or P0, u, v, n"),
    (("screen", "n"), GONE, "screen.n", "a required key is missing"),
    (("screen", "P0"), [0, 0], "screen.P0", "too few entries; got 2; expected 3"),
    (("screen", "P0"), [0, 0, 0, 0], "screen.P0", "too many entries; got 4; expected at most 3"),
    (("screen", "P0"), [0, "0", 0], "screen.P0[1]", f'{_NUMBER}; got "0"; expected a number'),
    (("screen", "P0"), [0, 0, True], "screen.P0[2]", f"{_NUMBER}; got true"),
    (("screen", "P0"), [0, 0, None], "screen.P0[2]", f"{_NUMBER}; got null"),
    (("screen", "P0"), [0, 0, 1e31], "screen.P0[2]", f"{_RANGE}; got 1e+31; expected at most"),
    (("screen", "P0"), [0, 0, 10**400], "screen.P0[2]", "a number is not finite; got Infinity"),
    (("screen", "P0"), [0, 0, 10**390], "screen.P0[2]", f"{_RANGE}; got 1000"),
    (("screen", "P0"), [0, 0, float("nan")], "screen.P0[2]", "a number is not finite; got NaN"),
    (("screen", "P0"), "origin", "screen.P0", f'{_ARRAY}; got "origin"'),
    (("screen", "u"), [3, 4, 0], "screen.u", "the frame is not orthonormal: not a unit vector; "
     "got length 5.0; expected 1 to within 1e-9, as [0.6, 0.8, 0.0]"),
    (("screen", "u"), [0, 0, 0], "screen.u", "the frame is not orthonormal: not a unit vector"),
    (("screen", "u"), [0, 1, 0], "screen.v", "the frame is not orthonormal: two axes are not perp"),
    (("screen", "nu"), 0, "screen.nu", "the screen would contain the observer; got 0.0; expected"),
    (("screen", "l"), 1, "screen.r", "the screen has no area; got l = 1.0, r = 1.0; expected l"),
    (("screen", "b"), 2, "screen.t", "the screen has no area; got b = 2.0, t = 1.0; expected b"),
    (("screen", "nx"), 0, "screen.nx", f"{_RANGE}; got 0; expected at least 1"),
    (("screen", "nx"), 2.5, "screen.nx", "not an integer; got 2.5; expected an integer"),
    (("screen", "nx"), True, "screen.nx", "not an integer; got true"),
    (("screen", "nx"), 10**6, "screen.nx", f"{_RANGE}; got 1000000; expected at most 131072"),
    (("screen",), {**BASE["screen"], "nx": 20_000, "ny": 20_000}, "screen.nx",
     "the image is over the size limit; got 20000 × 20000; expected at most 268,435,456 pixels"),
    (("screen",), look_at(fov_y=180), "screen.look_at.fov_y", f"{_RANGE}; got 180; expected less"),
    (("screen",), look_at(fov_y=0), "screen.look_at.fov_y", f"{_RANGE}; got 0; expected more"),
    (("screen",), look_at(eye=[0, 0.5, 0]), "screen.look_at.target", "eye and target coincide"),
    (("screen",), look_at(up=[3, 1.5, 5]), "screen.look_at.up", "'up' is zero or along"),
    (("screen",), look_at(up=[0, 0, 0]), "screen.look_at.up", "'up' is zero or along"),
    (("screen",), {"look_at": 5, "nx": 1, "ny": 1}, "screen.look_at", f"{_OBJECT}; got 5"),
    (("light",), GONE, "light", "a required key is missing"),
    (("light",), {}, "light.direction", "a required key is missing"),
    (("light", "direction"), [0, 0, 0], "light.direction", "the light's direction is the zero"),
    (("light", "color"), [0, -1, 0], "light.color[1]", f"{_RANGE}; got -1; expected at least 0"),
    (("background",), [1, 2], "background", "too few entries; got 2; expected 3"),
    (("shadow_color",), "black", "shadow_color", f'{_ARRAY}; got "black"'),
    (("epsilon",), 0, "epsilon", f"{_RANGE}; got 0; expected at least 1e-30"),
    (("max_depth",), 17, "max_depth", f"{_RANGE}; got 17; expected at most 16"),
    (("max_depth",), 1.5, "max_depth", "not an integer; got 1.5"),
    (("materials",), [], "materials", f"{_OBJECT}; got []"),
    (("materials",), {"a b": 5}, 'materials["a b"]', f"{_OBJECT}; got 5"),
    (("materials",), {"": {}}, 'materials[""]', "the text is empty"),
    (("materials", "m", "shininess"), 0, "materials.m.shininess", f"{_RANGE}; got 0"),
    (("materials", "m", "shininess"), 1.5, "materials.m.shininess", "not an integer; got 1.5"),
    (("materials", "m", "shinyness"), 1, "materials.m.shinyness",
     "unknown key; got 1; expected shininess?"),
    (("materials", "m", "alpha"), 1.01, "materials.m.alpha", f"{_RANGE}; got 1.01"),
    (("materials", "m", "ior"), 0, "materials.m.ior", f"{_RANGE}; got 0; expected at least 0.001"),
    (("materials", "m", "transmittance"), 0.5, "materials.m",
     "transmittance without an index of refraction"),
    (("materials", "m"), {"reflectance": 0.6, "transmittance": 0.5, "ior": 1.5}, "materials.m",
     "reflectance + transmittance is 1.1; got {"),
    (("objects",), {}, "objects", f"{_ARRAY}; got {{}}"),
    (("objects", 0), 5, "objects[0]", f"{_OBJECT}; got 5"),
    (("objects", 0), {}, "objects[0].type", "a required key is missing; expected sphere"),
    (("objects", 0, "type"), "cube", "objects[0].type", 'unknown type of object; got "cube"'),
    (("objects", 0, "radius"), 0, "objects[0].radius", f"{_RANGE}; got 0; expected at least 1e-30"),
    (("objects", 0, "radius"), -1.5, "objects[0].radius", f"{_RANGE}; got -1.5"),
    (("objects", 0, "radius"), GONE, "objects[0].radius", "a required key is missing"),
    (("objects", 0, "vertices"), SQUARE, "objects[0].vertices", "unknown key; got ["),
    (("objects", 0), {"type": "sphere", "material": "m", "center": [0, 0, 0], "raduis": 1},
     "objects[0].raduis", "unknown key; got 1; expected radius?"),
    (("screen",), {"look_at": {"eye": [0, 0, 0], "fov": 40}, "nx": 1, "ny": 1},
     "screen.look_at.fov", "unknown key; got 40; expected fov_y?"),
    (("objects", 0, "material"), "n", "objects[0].material",
     'unknown material; got "n"; expected one of ["m"]'),
    (("objects", 1, "vertices"), SQUARE[:2], "objects[1].vertices",
     "too few entries; got 2; expected at least 3"),
    (("objects", 1, "vertices", 2), [1, 1, 0.1], "objects[1].vertices",
     f"the polygon is not planar: vertices[1] lies 0.0499 scene units off its plane; "
     f"{_CONVEX}"),
    (("objects", 1, "vertices", 2), [0.1, 0.1, 0], "objects[1].vertices",
     f"the polygon is not convex, or turns more than once: see vertices[2]; {_CONVEX}"),
    (("objects", 1, "vertices"), PENTAGRAM, "objects[1].vertices",
     "the polygon is not convex, or turns more than once"),
    (("objects", 1, "vertices"), [[0, 0, 0], [1, 1, 1], [3, 3, 3]], "objects[1].vertices",
     f"the polygon has no area; {_CONVEX}"),
    (("objects", 2, "vertices"), SQUARE[:2], "objects[2].vertices",
     "too few entries; got 2; expected 3"),
    (("objects", 2, "vertices", 1), [1, 2], "objects[2].vertices[1]",
     "too few entries; got 2; expected 3"),
    (("objects", 0), _mesh(""), "objects[0].file", "the text is empty"),
    (("objects", 0), _mesh("none.ply"), "objects[0].file", "the mesh file cannot be opened"),
    (("objects", 0), _mesh("../none.ply"), "objects[0].file",
     "the mesh file lies outside the scene's folder"),
    (("objects", 0), _mesh("/none.ply"), "objects[0].file",
     "the mesh file lies outside the scene's folder"),
    (("objects", 0), _mesh("a\0b"), "objects[0].file", "not a usable path"),
    (("objects", 0), _mesh("x.ply", transform=[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]),
     "objects[0].transform", "too few entries; got 3; expected 4"),
]  # fmt: skip


def _loaded(path: Path, folder: Path) -> str:
    """The message of the one error."""
    with pytest.raises(SceneError) as caught:
        minirt.load_scene(path, folder)
    assert caught.value.exit_status == 2
    text = str(caught.value)
    assert "\n" not in text
    assert len(text) < len(str(path)) + 400
    assert text.isprintable()
    return text


@pytest.mark.parametrize(
    ("put", "value", "where", "words"),
    INVALID,
    ids=[f"{f[2]}-{k}" for k, f in enumerate(INVALID)],
)
def test_a_bad_scene_is_one_sentence_with_file_and_path(
    put: tuple[str | int, ...], value: Any, where: str, words: str, tmp_path: Path
) -> None:
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(changed(put, value)))
    assert _loaded(path, tmp_path).startswith(f"{path}: {where}: {words}")


_TEXT = json.dumps(BASE)
RAW: dict[str, tuple[bytes, str]] = {
    "empty": (b"", "not JSON; got nothing; expected one JSON object"),
    "blank": (b" \n", "not JSON; got nothing"),
    "prose": (b"hello", "not JSON; got expecting value at line 1, column 1"),
    "cut off": (_TEXT[:-1].encode(), "not JSON; got expecting ',' delimiter at line 1"),
    "two documents": (_TEXT.encode() * 2, "not JSON; got extra data at line 1"),
    "trailing NUL": (_TEXT.encode() + b"\0", "not JSON; got extra data"),
    "array": (b"[]", "the document: not a JSON object; got []"),
    "null": (b"null", "the document: not a JSON object; got null"),
    "NaN": (_TEXT.replace("-1.0", "NaN", 1).encode(), "screen.nu: a number is not finite; got NaN"),
    "Infinity": (_TEXT.replace("-1.0", "-Infinity", 1).encode(), "screen.nu: a number is not"),
    "1e400": (_TEXT.replace("-1.0", "1e400", 1).encode(), "screen.nu: a number is not finite"),
    "5000 digits": (_TEXT.replace("-1.0", "9" * 5000, 1).encode(), "screen.nu: a number is not"),
    "duplicate key": (_TEXT.replace('"nu"', '"nx": 3, "nu"').encode(),
                      "screen.nx: a key occurs twice in one object; expected each key once"),
    "duplicate in an array": (_TEXT.replace('"radius"', '"radius": 2, "radius"').encode(),
                              "objects[0].radius: a key occurs twice in one object"),
    "deep": (b"[" * 100_000, "nested too deeply; expected at most 64 levels of brackets"),
    "deep and closed": (b"[" * 100_000 + b"]" * 100_000, "nested too deeply"),
    "deep inside": (_TEXT.replace('"small"', "[" * 900 + "]" * 900).encode(), "nested too deeply"),
    "latin-1": (_TEXT.replace("small", "größe").encode("latin-1"),
                "the scene is not UTF-8 text; got byte 0xf6 at offset"),
    "utf-16": (_TEXT.encode("utf-16"), "the scene is not UTF-8 text; got byte 0xff at offset 0"),
}  # fmt: skip


@pytest.mark.parametrize("name", RAW)
def test_a_file_that_is_no_scene_is_one_sentence(name: str, tmp_path: Path) -> None:
    path = tmp_path / "raw.json"
    path.write_bytes(RAW[name][0])
    assert _loaded(path, tmp_path).startswith(f"{path}: {RAW[name][1]}")


UNREAD, MISSING = "the scene file cannot be read", "No such file or directory"


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("nowhere.json", "nowhere.json: the scene file cannot be read; got No such file"),
        ("one-sphere", f"one-sphere: {UNREAD}; got {MISSING}; expected atlas:one-sphere"),
        (".", ".: the scene file cannot be read; got Is a directory"),
        ("", '"": the scene file cannot be read'),
        ("a\0b", '"a\\u0000b": the scene file cannot be read'),
        ("x" * 5000, '"xxxx'),
        ("atlas:nope", "atlas:nope: no such scene in the atlas; expected one of those that"),
        ("atlas:one-spher", "atlas:one-spher: no such scene in the atlas; expected atlas:one"),
        ("atlas:../one-sphere", "atlas:../one-sphere: no such scene in the atlas"),
        ("atlas:", "atlas:: no such scene in the atlas"),
    ],
)  # fmt: skip
def test_a_source_that_cannot_be_read_is_one_sentence(
    source: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError) as caught:
        minirt.load_scene(source)
    assert str(caught.value).startswith(words)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({"minirt": {1, 2}}, "scene: the scene is not JSON data"),
        ({1: 2}, 'scene: ["1"]: unknown key; got 2; expected one of minirt'),
        (changed(("screen", "nu"), float("inf")), "scene: screen.nu: a number is not finite"),
    ],
)
def test_a_dict_that_is_no_scene_is_one_sentence(document: Any, words: str) -> None:
    with pytest.raises(SceneError) as caught:
        minirt.load_scene(document)
    assert str(caught.value).startswith(words)


def test_a_dict_that_contains_itself_is_one_sentence() -> None:
    document: dict[str, Any] = {}
    document["minirt"] = document
    with pytest.raises(SceneError, match="the scene is not JSON data; got Circular"):
        minirt.load_scene(document)


def test_every_error_is_a_minirt_error_with_its_parts() -> None:
    with pytest.raises(MinirtError) as caught:
        minirt.load_scene(changed(("objects", 0, "radius"), -1))
    error = caught.value
    assert (error.where, error.what) == ("scene: objects[0].radius", _RANGE)
    assert (error.got, error.expected) == ("-1", "at least 1e-30")


def test_standard_input_is_a_source(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(_TEXT.encode())))
    assert minirt.load_scene("-").sha256 == minirt.load_scene(BASE).sha256
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"\xff")))
    with pytest.raises(SceneError, match="standard input: the scene is not UTF-8"):
        minirt.load_scene("-")


def test_a_byte_order_mark_is_accepted(tmp_path: Path) -> None:
    path = tmp_path / "marked.json"
    path.write_bytes(b"\xef\xbb\xbf" + _TEXT.encode())
    assert minirt.load_scene(path).sha256 == minirt.load_scene(BASE).sha256
