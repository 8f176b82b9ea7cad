"""What the format's validation finds, as one sentence with its JSON path."""

from __future__ import annotations

import difflib
import json
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from minirt.errors import SceneError
from minirt.scene_file.schema import key_names

Path: TypeAlias = list[int | str]


class Fault(NamedTuple):
    """What is wrong, what would be right, and where below the finding's own path."""

    what: str
    expected: str = ""
    below: tuple[str, ...] = ()


def first_fault(error: ValidationError, label: str) -> SceneError:
    """pydantic's first finding as one sentence with the file and the JSON path."""
    findings = error.errors(include_url=False)
    unknown = [f for f in findings if f["type"] == "extra_forbidden"]
    first = (unknown or findings)[0]  # a slip in a key is why another is missing
    path, kind = _path(first), first["type"]
    if kind == "missing" and isinstance(path[-1], int):
        count = sum(1 for f in findings if f["type"] == "missing" and _path(f)[:-1] == path[:-1])
        fault = Fault("too few entries", f"{path[-1] + count}")
        path, got = path[:-1], str(path[-1])
    else:
        fault = _WORDS.get(kind, _other)(first)
        got = "" if kind in ("missing", "union_tag_not_found") else _got(first)
    where = f"{label}: {json_path([*path, *fault.below])}"
    return SceneError(fault.what, where=where, got=got, expected=fault.expected)


def json_path(parts: Path) -> str:
    """A path as people write it: ``objects[2].vertices``; "the document" for the empty one."""
    text = ""
    for part in parts:
        if isinstance(part, str) and part.isidentifier() and part.isascii():
            text += f".{part}"
        else:
            text += f"[{part if isinstance(part, int) else shortened(part)}]"
    return text.lstrip(".") or "the document"


def shortened(value: Any) -> str:
    """A value as JSON, in printable characters, at most 80 of them."""
    text = json.dumps(value, ensure_ascii=True, default=repr)
    return text if len(text) <= 80 else text[:77] + "..."


def _path(finding: ErrorDetails) -> Path:
    """The finding's place in the document, without the names that pydantic adds."""
    parts = [part for part in finding["loc"] if part != "[key]"]
    if parts[:1] == ["screen"]:
        del parts[1:2]  # which form of the screen was tried
    elif parts[:1] == ["objects"]:
        del parts[2:3]  # which type of object was tried
    return parts


def _got(finding: ErrorDetails) -> str:
    context = finding.get("ctx", {})
    if finding["type"] == "union_tag_invalid":
        return shortened(context["tag"])
    if finding["type"] in ("too_short", "too_long"):
        return str(context["actual_length"])
    return shortened(finding["input"])


def _number(finding: ErrorDetails) -> Fault:
    value = finding["input"]
    if isinstance(value, int) and not isinstance(value, bool):
        return Fault("a number is out of range", "within ±1e30")
    return Fault("not a number", "a number")


def _bound(word: str, key: str) -> Callable[[ErrorDetails], Fault]:
    def fault(finding: ErrorDetails) -> Fault:
        return Fault("a number is out of range", f"{word} {finding['ctx'][key]:g}")

    return fault


def _tag(finding: ErrorDetails) -> Fault:
    known = "sphere, triangle, polygon or mesh"
    if finding["type"] == "union_tag_invalid":
        return Fault("unknown type of object", known, ("type",))
    return Fault("a required key is missing", known, ("type",))


def _count(finding: ErrorDetails) -> Fault:
    if finding["type"] == "too_short":
        return Fault("too few entries", f"at least {finding['ctx']['min_length']}")
    return Fault("too many entries", f"at most {finding['ctx']['max_length']}")


def _value(finding: ErrorDetails) -> Fault:
    what, _, expected = finding["msg"].removeprefix("Value error, ").partition("; expected ")
    return Fault(what, expected)


def _other(finding: ErrorDetails) -> Fault:
    message = finding["msg"]
    return Fault("not a usable value", message[0].lower() + message[1:])


def _unknown_key(finding: ErrorDetails) -> Fault:
    """With the key that was probably meant, among those of the object it stands in."""
    *place, key = finding["loc"]
    known = key_names(tuple(place))
    close = difflib.get_close_matches(str(key), known, 1)
    if place == ["screen", "look_at form"] and key in key_names(("screen", "slides form")):
        return Fault("unknown key beside look_at", "either look_at or P0, u, v, n, nu, l, r, b, t")
    if close:
        return Fault("unknown key", f"{close[0]}?")
    return Fault("unknown key", "one of " + ", ".join(known))


def _always(what: str, expected: str) -> Callable[[ErrorDetails], Fault]:
    return lambda _: Fault(what, expected)


_OBJECT = _always("not a JSON object", "an object in braces")
_ARRAY = _always("not an array", "an array in brackets")
_INTEGER = _always("not an integer", "an integer")
_TEXT = _always("not text", "text in quotes")

_WORDS: dict[str, Callable[[ErrorDetails], Fault]] = {
    "missing": lambda f: Fault("a required key is missing"),
    "extra_forbidden": _unknown_key,
    "model_type": _OBJECT,
    "model_attributes_type": _OBJECT,
    "dict_type": _OBJECT,
    "list_type": _ARRAY,
    "tuple_type": _ARRAY,
    "int_type": _INTEGER,
    "int_from_float": _INTEGER,
    "string_type": _TEXT,
    "string_unicode": _always("not Unicode text", "no lone surrogates"),
    "string_too_short": _always("the text is empty", "at least one character"),
    "string_too_long": lambda f: Fault("the text is too long", f"at most {f['ctx']['max_length']}"),
    "string_pattern_mismatch": _always("not a rule of the lecture", "S1 to S17, or E1 to E8"),
    "float_type": _number,
    "finite_number": _always("a number is not finite", "a number within ±1e30"),
    "greater_than_equal": _bound("at least", "ge"),
    "less_than_equal": _bound("at most", "le"),
    "greater_than": _bound("more than", "gt"),
    "less_than": _bound("less than", "lt"),
    "literal_error": lambda f: Fault("not a usable value", str(f["ctx"]["expected"])),
    "union_tag_invalid": _tag,
    "union_tag_not_found": _tag,
    "too_short": _count,
    "too_long": _count,
    "value_error": _value,
}
