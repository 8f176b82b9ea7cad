"""One version of minirt, one of the linter, and a changelog that says what each version changed."""

from __future__ import annotations

import re
from typing import Any

import minirt
from tests.helpers.documents import text_of, yaml_of

CHANGELOG = text_of("CHANGELOG.md")
KINDS = {"Changed", "Added", "Fixed"}


def sections(text: str, level: int) -> dict[str, str]:
    """What stands below each heading of a level, by the heading."""
    parts = re.split(rf"^{'#' * level} (.+)$", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


def hooks() -> dict[str, dict[str, Any]]:
    """Every hook of pre-commit by its id, with the repository that it comes from."""
    repositories = yaml_of(".pre-commit-config.yaml")["repos"]
    return {hook["id"]: hook | {"of": each} for each in repositories for hook in each["hooks"]}


def test_pre_commit_has_the_locked_version_of_the_linter() -> None:
    (locked,) = re.findall(r"^ruff==(\S+)", text_of("requirements.lock"), re.MULTILINE)
    for name in ("ruff-check", "ruff-format"):
        assert hooks()[name]["of"]["rev"] == f"v{locked}"


def test_other_hooks_run_what_is_locked_or_nothing_at_all() -> None:
    others = {name: hook for name, hook in hooks().items() if hook["of"]["repo"] == "local"}
    assert set(others) == {"mypy", "lint-imports", "commit-subject"}
    for name in ("mypy", "lint-imports"):
        assert others[name]["entry"] == f".venv/bin/{name}"
    assert others["commit-subject"]["language"] == "pygrep"


def test_a_subject_may_have_60_characters_and_no_more() -> None:
    """As pre-commit's pygrep with --multiline looks for what must not be there."""
    pattern = re.compile(hooks()["commit-subject"]["entry"], re.MULTILINE | re.DOTALL)
    body = "\n\n" + "why " * 30
    assert not pattern.search("x" * 60 + body)
    assert pattern.search("x" * 61 + body)


def test_the_changelog_has_a_section_for_the_current_version() -> None:
    names = list(sections(CHANGELOG, 2))
    assert names[0] == "Unreleased"
    numbers = [name.split()[0] for name in names[1:]]
    assert minirt.__version__ in numbers
    assert all(re.fullmatch(r"\d+\.\d+\.\d+ \(\d{4}-\d\d-\d\d\)", name) for name in names[1:])


def test_no_section_of_the_changelog_is_empty() -> None:
    for name, text in sections(CHANGELOG, 2).items():
        kinds = sections(text, 3)
        assert kinds, name
        assert set(kinds) <= KINDS, name
        for kind, entries in kinds.items():
            assert re.search(r"^- \S", entries, re.MULTILINE), (name, kind)
