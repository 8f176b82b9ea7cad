"""What the documents name is there: paths, links, names in the code, tests, targets of make."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

import pytest

from tests.helpers.documents import DOCUMENTS, quoted, text_of, yaml_of
from tests.helpers.places import ROOT

TOPS = {path.name for path in ROOT.iterdir()} - {".venv", "report", "nights"}
FORMS = ("bug_report", "feature_request", "wrong_verdict")
GLOSSARY = text_of("docs/glossary.md")


@cache
def words_of_the_code() -> frozenset[str]:
    """Every word of every file that is no document."""
    tops = ("minirt", "converters", "reference", "reports", "tests")
    files = [path for top in tops for path in (ROOT / top).rglob("*.py")]
    files += [ROOT / name for name in ("Makefile", "pyproject.toml", ".ci/run")]
    texts = (path.read_text(encoding="utf-8") for path in files)
    return frozenset(word for text in texts for word in re.findall(r"\w+", text))


def paths_in(text: str) -> list[str]:
    """What is meant as a path of the product: `minirt/rules.py`, `tests/house/`, `Makefile`."""
    words = [word for word in quoted(text) if re.fullmatch(r"[\w./-]+", word)]
    return [word for word in words if word.split("/")[0] in TOPS and "NAME" not in word]


def anchors(text: str) -> set[str]:
    """What GitHub makes of the headings of a document, for links to them."""
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_path_that_a_document_names_is_there(document: str) -> None:
    paths = paths_in(text_of(document))
    assert paths
    assert [path for path in paths if not (ROOT / path).exists()] == []


@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_link_within_the_product_has_its_target(document: str) -> None:
    text = text_of(document)
    folder = (ROOT / document).parent
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        file, _, heading = target.partition("#")
        if "://" in file:
            continue
        assert (folder / file).exists(), target
        if heading:
            assert heading in anchors((folder / file).read_text(encoding="utf-8")), target


@pytest.mark.parametrize("document", ["CONTRIBUTING.md", "SECURITY.md", "docs/glossary.md"])
def test_every_name_that_a_document_quotes_stands_in_the_code(document: str) -> None:
    names = [word for word in quoted(text_of(document)) if re.fullmatch(r"[A-Za-z_]\w+", word)]
    assert names
    assert [name for name in names if name not in words_of_the_code()] == []


@pytest.mark.parametrize("document", ["CONTRIBUTING.md", "SECURITY.md", "docs/glossary.md"])
def test_a_name_stands_in_the_file_in_which_a_document_says_it_is(document: str) -> None:
    pairs = re.findall(r"`(\w+)`\s+in\s+`([\w./-]+\.\w+)`", text_of(document))
    assert pairs
    assert [(n, f) for n, f in pairs if not re.search(rf"\b{n}\b", text_of(f))] == []


def test_every_target_of_make_that_a_document_names_is_there() -> None:
    targets = set(re.findall(r"^([a-z-]+):.*## ", text_of("Makefile"), re.MULTILINE))
    named = {t for d in DOCUMENTS for t in re.findall(r"(?:^|`)make ([a-z-]+)", text_of(d), re.M)}
    assert {"setup", "test", "verify"} <= named
    assert named - targets == set()


def test_every_term_of_the_glossary_is_a_word_of_the_code() -> None:
    terms = re.findall(r"\*\*(.+?)\*\*", GLOSSARY)
    assert len(terms) >= 12
    code = {word.lower() for word in words_of_the_code()}
    words = {word for term in terms for word in term.split()}
    missing = {word for word in words if code.isdisjoint({word, f"{word}s", f"{word}ed"})}
    assert missing == set()


@pytest.mark.parametrize("form", FORMS)
def test_an_issue_form_is_one_that_github_shows(form: str) -> None:
    """Its rules: github.com shows a form that breaks one of them to nobody."""
    found: dict[str, Any] = yaml_of(f".github/ISSUE_TEMPLATE/{form}.yml")
    assert found.keys() >= {"name", "description", "body"}
    assert found.keys() <= {"name", "description", "title", "labels", "body"}
    asked = [part for part in found["body"] if part["type"] != "markdown"]
    assert asked
    assert len({part["id"] for part in asked}) == len({*map(str, asked)}) == len(asked)
    for part in asked:
        assert part["type"] in ("input", "textarea", "dropdown", "checkboxes")
        assert part["attributes"]["label"]
        assert part.keys() <= {"type", "id", "attributes", "validations"}
        if part["type"] == "dropdown":
            assert len(set(part["attributes"]["options"])) == len(part["attributes"]["options"])


def test_every_issue_form_is_tested() -> None:
    files = {path.stem for path in (ROOT / ".github" / "ISSUE_TEMPLATE").iterdir()}
    assert files == {*FORMS, "config"}
    assert yaml_of(".github/ISSUE_TEMPLATE/config.yml").keys() == {
        "blank_issues_enabled", "contact_links",
    }  # fmt: skip
