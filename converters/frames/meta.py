"""What a frame says about itself, as the text of one JSON object."""

from __future__ import annotations

import json
from collections.abc import Mapping

from minirt.errors import InputError


def meta_text(meta: Mapping[str, str]) -> str:
    """The JSON text; the same for the same content."""
    return json.dumps(dict(meta), sort_keys=True)


def parse_meta(text: str, where: str) -> dict[str, str]:
    """What `meta_text` wrote; values that are not strings are kept as their JSON text.

    Raises
    ------
    InputError
        Not the JSON text of an object.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError("not JSON", where=where, got=str(error)[:200]) from None
    if not isinstance(document, dict):
        raise InputError("not a JSON object", where=where, got=text[:80])
    return {k: v if isinstance(v, str) else json.dumps(v) for k, v in document.items()}
