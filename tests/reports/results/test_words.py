from __future__ import annotations

import math

import pytest

from reference.compare.check import Check, WorstPixel
from reports.results.words import (
    figure,
    icon,
    listed,
    number,
    one_line,
    plain,
    share,
    times,
    values,
    worst_in_words,
)
from tests.helpers.fake_references import HOSTILE


@pytest.mark.parametrize(
    ("ratio", "words"),
    [
        (0.0, "0×"), (1e-9, "<0.01×"), (0.42, "0.42×"), (0.994, "0.99×"), (0.9999, "<1×"),
        (1 - 1e-15, "<1×"), (1 + 1e-9, ">1×"), (1.4, "1.4×"), (14.2, "14×"), (3e5, "3e+05×"),
        (math.inf, "∞×"),
    ],
)  # fmt: skip
def test_ratio_in_words_never_hides_on_which_side_of_one_it_lies(ratio: float, words: str) -> None:
    assert times(ratio) == words


@pytest.mark.parametrize(
    ("part", "whole", "words"),
    [
        (5, 5, "100 %"), (99_999, 100_000, "99.99 %"), (1, 3, "33.33 %"), (0, 7, "0.00 %"),
        (0, 0, "none"),
    ],
)  # fmt: skip
def test_share_is_100_only_where_nothing_is_missing(part: int, whole: int, words: str) -> None:
    assert share(part, whole) == words


def test_plain_text_holds_nothing_that_a_terminal_obeys_or_xml_forbids() -> None:
    text = plain(HOSTILE + "\u202eevil\ud800\r\n\tnext")
    assert not set(text) & set("\x00\x1b\u202e\ud800\r")
    assert text.endswith("�evil�\n\tnext")
    assert "\n" not in one_line(text)


def test_long_text_is_cut_on_one_line() -> None:
    assert one_line("ab " * 50, 10) == "ab ab ab …"


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (math.inf, "∞"), (-math.inf, "−∞"), (math.nan, "none"), (0.123456, "0.123"),
        (3.2e-7, "3.2e-07"),
    ],
)  # fmt: skip
def test_numbers_that_are_none_are_said_in_words(value: float, words: str) -> None:
    assert number(value) == words


def test_values_show_enough_digits_to_differ() -> None:
    assert values("object", [2.0]) == "2"
    assert values("t", [1.00000001]) == "1.00000001"
    assert values("normal", [0.0, math.nan, 1.0]) == "(0, none, 1)"


def check(**fields: object) -> Check:
    worst = WorstPixel(3, 4, (1.0,), (1.5,), 0.5, 0.25)
    known = {"quantity": "t", "stage": "t", "state": "passed", "pixels": 10, "certain": 10,
             "compared": 8, "ratio": 2.0, "worst": worst}  # fmt: skip
    return Check(**{**known, **fields})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("cell", "words"),
    [
        (check(ratio=0.4), "✓ 0.40×"),
        (check(quantity="hit", ratio=0.0), "✓ equal"),
        (check(compared=0, worst=None), "✓ none"),
        (check(state="failed", wrong=7, first_wrong=7, ratio=14.0), "✗ 7 px, 14×"),
        (check(state="failed", wrong=7, first_wrong=0, ratio=14.0), "↳ 7 px, 14×"),
        (check(state="failed", wrong=7, first_wrong=1, ratio=math.inf), "✗ 7 px"),
        (check(state="failed", certain=5), "✗ 50.00 % certain"),
        (check(state="failed", ssim=0.9, ssim_floor=0.95), "✗ SSIM 0.900"),
        (check(state="failed", pixels=0, certain=0, compared=0, worst=None), "✗ unusable"),
        (check(state="known", wrong=7, ratio=14.0), "≈ known: 7 px, 14×"),
        (check(state="not supported"), "– not supported"),
        (check(state="not given"), "– not given"),
        (check(state="crashed"), "! crashed"),
        (check(state="timed out"), "! timed out"),
        (check(state="missing"), "! missing"),
    ],
)  # fmt: skip
def test_every_way_to_end_has_its_icon_and_words(cell: Check, words: str) -> None:
    assert f"{icon(cell)} {figure(cell)}" == words


def test_names_are_listed_as_in_a_sentence() -> None:
    assert [listed(["a", "b", "c"][:k]) for k in (1, 2, 3)] == ["a", "a and b", "a, b and c"]


def test_worst_pixel_names_both_values_and_the_tolerance() -> None:
    words = worst_in_words(check())
    assert words == "(3, 4): ours 1, theirs 1.5; error 0.5, tolerance 0.25"
    assert worst_in_words(check(ratio=0.0)) == ""
    assert worst_in_words(check(worst=None)) == ""
