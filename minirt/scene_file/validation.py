"""Validation errors of a scene file: pydantic's, each as one sentence with its JSON path."""

from __future__ import annotations

import difflib
import json
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from minirt.errors import SceneError
from minirt.scene_file.schema import key_names

JsonPath: TypeAlias = list[int | str]


class Message(NamedTuple):
    """What is wrong, what would be right, and where below the error's own path."""

    what: str
    expected: str = ""
    below: tuple[str, ...] = ()


def first_error(error: ValidationError, label: str) -> SceneError:
    """The first of pydantic's errors as one sentence with the file and the JSON path.

    Parameters
    ----------
    error : ValidationError
        Raised by `SceneDocument`.
    label : str
        What the sentence calls the file.
    """
    errors = error.errors(include_url=False)
    unknown = [each for each in errors if each["type"] == "extra_forbidden"]
    first = (unknown or errors)[0]  # a misspelt key is why another one is missing
    path, kind = _path(first), first["type"]
    if kind == "missing" and isinstance(path[-1], int):
        missing = (each for each in errors if each["type"] == "missing")
        count = sum(_path(each)[:-1] == path[:-1] for each in missing)
        message = Message("too few entries", f"{path[-1] + count}")
        path, got = path[:-1], str(path[-1])
    else:
        message = _MESSAGES.get(kind, _other)(first)
        got = "" if kind in ("missing", "union_tag_not_found") else _got(first)
    where = f"{label}: {json_path([*path, *message.below])}"
    return SceneError(message.what, where=where, got=got, expected=message.expected)


def json_path(parts: JsonPath) -> str:
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


def _path(details: ErrorDetails) -> JsonPath:
    """The error's place in the document, without the names that pydantic adds."""
    parts = [part for part in details["loc"] if part != "[key]"]
    if parts[:1] == ["screen"]:
        del parts[1:2]  # which form of the screen was tried
    elif parts[:1] == ["objects"]:
        del parts[2:3]  # which type of object was tried
    return parts


def _got(details: ErrorDetails) -> str:
    context = details.get("ctx", {})
    if details["type"] == "union_tag_invalid":
        return shortened(context["tag"])
    if details["type"] in ("too_short", "too_long"):
        return str(context["actual_length"])
    return shortened(details["input"])


def _number(details: ErrorDetails) -> Message:
    value = details["input"]
    if isinstance(value, int) and not isinstance(value, bool):
        return Message("a number is out of range", "within ±1e30")
    return Message("not a number", "a number")


def _bound(word: str, key: str) -> Callable[[ErrorDetails], Message]:
    def message(details: ErrorDetails) -> Message:
        return Message("a number is out of range", f"{word} {details['ctx'][key]:g}")

    return message


def _tag(details: ErrorDetails) -> Message:
    known = "sphere, triangle, polygon or mesh"
    if details["type"] == "union_tag_invalid":
        return Message("unknown type of object", known, ("type",))
    return Message("a required key is missing", known, ("type",))


def _count(details: ErrorDetails) -> Message:
    if details["type"] == "too_short":
        return Message("too few entries", f"at least {details['ctx']['min_length']}")
    return Message("too many entries", f"at most {details['ctx']['max_length']}")


def _too_long(details: ErrorDetails) -> Message:
    return Message("the text is too long", f"at most {details['ctx']['max_length']}")


def _value(details: ErrorDetails) -> Message:
    what, _, expected = details["msg"].removeprefix("Value error, ").partition("; expected ")
    return Message(what, expected)


def _other(details: ErrorDetails) -> Message:
    message = details["msg"]
    return Message("not a usable value", message[0].lower() + message[1:])


def _unknown_key(details: ErrorDetails) -> Message:
    """An unknown key, with the key of the same object that was probably meant."""
    *place, key = details["loc"]
    known = key_names(tuple(place))
    close = difflib.get_close_matches(str(key), known, 1)
    if place == ["screen", "look_at form"] and key in key_names(("screen", "slides form")):
        return Message(
            "unknown key beside look_at", "either look_at or P0, u, v, n, nu, l, r, b, t"
        )
    if close:
        return Message("unknown key", f"{close[0]}?")
    return Message("unknown key", "one of " + ", ".join(known))


def _always(what: str, expected: str) -> Callable[[ErrorDetails], Message]:
    return lambda _: Message(what, expected)


_OBJECT = _always("not a JSON object", "an object in braces")
_ARRAY = _always("not an array", "an array in brackets")
_INTEGER = _always("not an integer", "an integer")
_TEXT = _always("not text", "text in quotes")

_MESSAGES: dict[str, Callable[[ErrorDetails], Message]] = {
    "missing": lambda _: Message("a required key is missing"),
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
    "string_too_long": lambda e: Message(
        "the text is too long", f"at most {e['ctx']['max_length']}"
    ),
    "string_pattern_mismatch": _always("not a rule of the lecture", "S1 to S17, or E1 to E8"),
    "float_type": _number,
    "finite_number": _always("a number is not finite", "a number within ±1e30"),
    "greater_than_equal": _bound("at least", "ge"),
    "less_than_equal": _bound("at most", "le"),
    "greater_than": _bound("more than", "gt"),
    "less_than": _bound("less than", "lt"),
    "literal_error": lambda e: Message("not a usable value", str(e["ctx"]["expected"])),
    "union_tag_invalid": _tag,
    "union_tag_not_found": _tag,
    "too_short": _count,
    "too_long": _count,
    "value_error": _value,
}
