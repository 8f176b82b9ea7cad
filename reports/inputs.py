"""What commands are given, made into what runs need: scenes, references, a cache, a cluster."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from minirt.scene import Scene
    from reference.cache import Cache
    from reference.jobs.cluster import Cluster
    from reference.source import Reference

#: Seconds of each unit of time.
_UNITS = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0}


def names_in(text: str) -> list[str]:
    """The names in a list that is separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def seconds_in(text: str, option: str) -> float:
    """The seconds of a time such as 90s, 20m, 2h, or a number of seconds; at least one.

    Raises
    ------
    InputError
        It is no such time.
    """
    from minirt.errors import InputError

    found = re.fullmatch(r"(\d{1,6}(?:\.\d+)?)([smh]?)", text.strip())
    seconds = float(found[1]) * _UNITS[found[2]] if found else 0.0
    if seconds < 1:
        raise InputError(
            "not a time", where=option, got=repr(text)[:80],
            expected="at least a second, as 90s, 20m or 2h",
        )  # fmt: skip
    return seconds


def command_words(command: str, option: str) -> tuple[str, ...]:
    """The words of a command, split as a shell would; no shell runs it.

    Raises
    ------
    InputError
        A quotation mark is not closed.
    """
    from minirt.errors import InputError

    try:
        return tuple(shlex.split(command))
    except ValueError as error:
        got = repr(command)[:80]
        raise InputError("not a command", where=option, got=got, expected=str(error)) from None


def scene_names(named: Sequence[str] | None) -> list[str]:
    """The scenes as they were named; without any, those of the atlas."""
    from minirt.scene_file.atlas import atlas_names

    return list(named or [f"atlas:{name}" for name in atlas_names()])


def chosen_scenes(named: Sequence[str] | None) -> list[Scene]:
    """Load the named scenes, or the atlas; all must have different names.

    Frames, records and histories identify a scene by its name.

    Raises
    ------
    InputError or SceneError
        Two scenes have the same name, or one cannot be loaded.
    """
    from minirt import load_scene
    from minirt.errors import InputError
    from reports.results.words import one_line, plain

    scenes = [load_scene(name) for name in scene_names(named)]
    names = [plain(scene.name) for scene in scenes]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        got = one_line(", ".join(twice), 200)
        raise InputError("two scenes have the same name", got=got, expected="a name for each")
    return scenes


def references_of(
    named: Sequence[str], required: Sequence[str]
) -> tuple[tuple[Reference, ...], tuple[str, ...]]:
    """The references to compare with, and the names of those that must answer."""
    from reference.registry import USUAL, choose_references

    must = tuple(each.name for each in choose_references([*named, *required]))
    return choose_references([*(named or USUAL), *must]), must


def usual_cache() -> Cache:
    """Where frames and their stability are kept from run to run."""
    from reference.cache import Cache, usual_folder

    return Cache(usual_folder())


def cache_unless(no_cache: bool) -> Cache | None:
    """The usual cache; None where the user wants none."""
    return None if no_cache else usual_cache()


def cluster_at(address: str | None) -> AbstractContextManager[Cluster | None]:
    """The workers of the Dask scheduler at an address; None without an address.

    Raises
    ------
    InputError
        Dask is not installed, or no scheduler answers there.
    """
    if address is None:
        return nullcontext()
    try:
        from reference.jobs.dask_cluster import DaskCluster
    except ModuleNotFoundError as error:
        from minirt.errors import InputError

        raise InputError(
            "Dask is not installed", where="--cluster", got=f"no module {error.name}",
            expected="pip install 'minirt[cluster]'",
        ) from None  # fmt: skip
    return DaskCluster(address)
