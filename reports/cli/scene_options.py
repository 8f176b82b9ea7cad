"""What a command is about and what it may use: scenes (the whole atlas), kept frames, a cluster."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from minirt.scene import Scene
    from reference.cache import Cache
    from reference.jobs.cluster import Cluster


def scene_names(named: Sequence[str] | None) -> list[str]:
    """The scenes as they were named; without any those of the atlas."""
    from minirt.scene_file.atlas import atlas_names

    return list(named or [f"atlas:{name}" for name in atlas_names()])


def chosen_scenes(named: Sequence[str] | None) -> list[Scene]:
    """Those scenes, loaded; no two of one name, since frames, records and histories go by it.

    Raises
    ------
    InputError or SceneError
        Two scenes of one name, or one that cannot be loaded.
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


def usual_cache() -> Cache:
    """Where frames and their stability are kept from run to run."""
    from reference.cache import Cache, usual_folder

    return Cache(usual_folder())


def cache_unless(no_cache: bool) -> Cache | None:
    """The usual cache, if nobody forbids it."""
    return None if no_cache else usual_cache()


def cluster_at(address: str | None) -> AbstractContextManager[Cluster | None]:
    """The workers of the Dask scheduler at an address; none without one.

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
