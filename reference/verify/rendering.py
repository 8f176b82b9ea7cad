"""A reference's frame of a scene, rendered in a child process and handed over in a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from converters.frames.io import write_frame
from minirt.scene import Scene
from reference.cache import Cache, timed_rendering
from reference.compare.check import State, without_answer
from reference.jobs.isolate import Job
from reference.source import NoAnswer, Reference, Unsupported
from reference.verify.results import ReferenceResult


@dataclass(frozen=True)
class RenderedFrame:
    """What a reference's job returns; its frame is in a file.

    Attributes
    ----------
    reference : str
    frame : str
        The path of the file; there is none if nothing was given.
    given : tuple of str
        The quantities in it.
    unsupported : dict of str to str
        Reason by quantity, for each quantity that it cannot give of this scene.
    program : str
        What really ran.
    seconds : float
        Of its own rendering.
    kept : bool
        Whether the frame was kept from an earlier run.
    """

    reference: str
    frame: str
    given: tuple[str, ...]
    unsupported: dict[str, str]
    program: str
    seconds: float
    kept: bool


def render_to_file(
    reference: Reference, scene: Scene, folder: Path, cache: Cache | None = None
) -> RenderedFrame:
    """Render a scene by a reference; the frame is written into the folder. For child processes."""
    if cache is None:
        rendering, seconds, kept = *timed_rendering(reference, scene, folder), False
    else:
        rendering, seconds, kept = cache.rendering(reference, scene, folder)
    path = folder / "frame.npz"
    if rendering.frame:
        write_frame(rendering.frame, path)
    return RenderedFrame(
        reference.name,
        str(path),
        tuple(rendering.frame),
        dict(rendering.unsupported),
        rendering.program,
        seconds,
        kept,
    )


def rendered_frame(
    reference: Reference, job: Job | None, names: tuple[str, ...]
) -> RenderedFrame | ReferenceResult:
    """Wait for a rendering: its frame, or the result that says why there is none.

    Parameters
    ----------
    reference : Reference
    job : Job or None
        That runs `render_to_file`; None for a reference that is missing.
    names : tuple of str
        The quantities that would be compared.
    """
    if job is None:
        return _without_frame(reference, names, "missing", reference.missing() or "")
    outcome = job.outcome()
    if outcome.state == "done":
        rendered: RenderedFrame = outcome.value
        return rendered
    if isinstance(outcome.value, Unsupported):
        return _without_frame(reference, names, "not supported", str(outcome.value))
    if isinstance(outcome.value, NoAnswer):
        error = outcome.value
        return _without_frame(reference, names, error.state, str(error), outcome.output)
    state: State = "timed out" if outcome.state == "timed out" else "crashed"
    return _without_frame(reference, names, state, outcome.reason, outcome.output)


def _without_frame(
    reference: Reference, names: tuple[str, ...], state: State, reason: str, output: str = ""
) -> ReferenceResult:
    checks = without_answer(names, state, reason)
    return ReferenceResult(reference.name, reference.name, checks, output=output)
