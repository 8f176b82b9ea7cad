"""The atlas: the scenes that ship with minirt, by name."""

from __future__ import annotations

import difflib
from importlib import resources
from pathlib import Path

from minirt.errors import SceneError

#: What the source of a scene of the atlas begins with.
ATLAS_PREFIX = "atlas:"


def atlas_names() -> tuple[str, ...]:
    """Names of the scenes that ship with minirt, in alphabetical order.

    Examples
    --------
    >>> atlas_names()[:2]
    ('alpha', 'ball-on-quad')
    """
    files = resources.files("minirt").joinpath("atlas").iterdir()
    return tuple(sorted(f.name[: -len(".json")] for f in files if f.name.endswith(".json")))


def atlas_path(source: str, label: str) -> Path:
    """The file of ``atlas:NAME``.

    Parameters
    ----------
    source : str
        ``atlas:NAME``.
    label : str
        What an error calls the source.

    Raises
    ------
    SceneError
        The atlas has no scene of this name; the message names the closest one.
    """
    name, names = source.removeprefix(ATLAS_PREFIX), atlas_names()
    if name not in names:
        close = "".join(f"atlas:{n}, or " for n in difflib.get_close_matches(name, names, 1))
        raise SceneError(
            "no such scene in the atlas",
            where=label,
            expected=f"{close}one of those that 'minirt scenes' lists",
        )
    return Path(str(resources.files("minirt").joinpath("atlas", f"{name}.json")))
