"""The product's documents, as the tests that compare them with the code read them."""

from __future__ import annotations

import re
from typing import Any

import yaml

from tests.helpers.places import ROOT

#: What a contributor or a user reads.
DOCUMENTS = ("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "docs/glossary.md")


def text_of(name: str) -> str:
    """The text of a file of the product."""
    return (ROOT / name).read_text(encoding="utf-8")


def yaml_of(name: str) -> Any:
    """The content of a YAML file of the product."""
    return yaml.safe_load(text_of(name))


def quoted(text: str) -> list[str]:
    """What stands in backticks, code blocks left out."""
    prose = re.sub(r"^ *```.*?^ *```", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.findall(r"(?<!`)`([^`\n]+)`", prose)


def rows(text: str) -> list[list[str]]:
    """The cells of every row of every table."""
    lines = [line.strip() for line in text.splitlines() if line.lstrip().startswith("|")]
    return [[cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip("|"))] for line in lines]
