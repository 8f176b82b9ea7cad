"""The templates of pages; every value put into one is shown as text, never as markup."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from reports.results.words import count, plain


class _WithoutIndentation(PackageLoader):
    """Templates without the indentation of their lines, which is a twentieth of a page."""

    def get_source(
        self, environment: Environment, template: str
    ) -> tuple[str, str, Callable[[], bool] | None]:
        source, path, fresh = super().get_source(environment, template)
        return "\n".join(line.lstrip() for line in source.splitlines()), path, fresh


def template(name: str) -> Template:
    """A template; markup and control characters in its values have no effect."""
    return _environment().get_template(name)


def rendered(name: str, **values: Any) -> str:
    """A page from its template, which may count things with their nouns."""
    return template(name).render(**values, count=count)


@cache
def _environment() -> Environment:
    """One for the process: it keeps the templates that it has compiled."""
    return Environment(
        loader=_WithoutIndentation("reports.page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: plain(value) if type(value) is str else value,
    )
