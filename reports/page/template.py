"""The templates of pages: whatever goes into one is text."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from reports.results.words import plain


class _Tight(PackageLoader):
    """Templates without the white space that their lines begin with, a twentieth of a page."""

    def get_source(
        self, environment: Environment, template: str
    ) -> tuple[str, str, Callable[[], bool] | None]:
        source, path, fresh = super().get_source(environment, template)
        return "\n".join(line.lstrip() for line in source.splitlines()), path, fresh


def template(name: str) -> Template:
    """A template whose gaps take any text: markup and control characters do nothing."""
    return _environment().get_template(name)


@cache
def _environment() -> Environment:
    """One a process: what it compiles it keeps."""
    return Environment(
        loader=_Tight("reports.page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: plain(value) if type(value) is str else value,
    )
