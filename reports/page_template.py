"""The templates of pages: whatever goes into one is text."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined, Template

from reports.words import plain


def template(name: str) -> Template:
    """A template whose gaps take any text: markup and control characters do nothing."""
    environment = Environment(
        loader=PackageLoader("reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: plain(value) if type(value) is str else value,
    )
    return environment.get_template(name)
