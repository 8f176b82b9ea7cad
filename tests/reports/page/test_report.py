"""The page, read as a browser reads it: what it shows, that nothing leaks in or out."""

from __future__ import annotations

import base64
import io
import re
from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cache
from html.parser import HTMLParser
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from minirt.quantities import QUANTITIES, STAGES
from reports.page.colors import RING
from reports.page.matrix import CAUSAL
from reports.page.report import report_html
from reports.results.findings import findings_of
from reports.results.record import Run
from tests.helpers.fake_references import HOSTILE, CannotSay, Faulty, Honest, Partial, small_scene
from tests.helpers.report_runs import NAMES, empty_run, good_run, run_of, troubled_run

VOID = {"meta", "input", "br", "link", "img"}


@dataclass
class Element:
    tag: str
    attributes: dict[str, str]
    drawn: bool  #: inside an SVG, which has titles of its own
    text: str = ""

    def has(self, name: str) -> bool:
        return name in self.attributes.get("class", "").split()


@dataclass
class Page(HTMLParser):
    """Every element of a page with its text; elements must close in the order they opened."""

    elements: list[Element] = field(default_factory=list)
    open: list[Element] = field(default_factory=list)
    declarations: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_decl(self, decl: str) -> None:
        self.declarations.append(decl)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert len({name for name, _ in attrs}) == len(attrs), attrs
        drawn = any(each.tag == "svg" for each in self.open)
        element = Element(tag, {name: value or "" for name, value in attrs}, drawn)
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop().tag == tag

    def handle_data(self, data: str) -> None:
        for element in self.open:
            element.text += data

    def all(self, tag: str, name: str = "") -> list[Element]:
        return [e for e in self.elements if e.tag == tag and (not name or e.has(name))]


@cache
def text_of(which: str) -> str:
    return report_html({"good": good_run, "troubled": troubled_run, "empty": empty_run}[which]())


@cache
def page_of(which: str) -> Page:
    page = Page()
    page.feed(text_of(which))
    page.close()
    assert [element.tag for element in page.open] == []
    return page


def pictures(which: str) -> dict[str, bytes]:
    found = re.findall(
        r"\.(p\d+)\{background-image:url\(data:image/png;base64,([^)]*)\)\}", text_of(which)
    )
    return {name: base64.b64decode(data, validate=True) for name, data in found}


WHICH = pytest.mark.parametrize("which", ["good", "troubled", "empty"])


@WHICH
def test_page_is_whole_and_asks_for_nothing_from_outside(which: str) -> None:
    page = page_of(which)
    assert page.declarations == ["DOCTYPE html"]
    once = ("html", "head", "title", "body", "main", "h1")
    own = Counter(e.tag for e in page.elements if not e.drawn)
    assert {tag: own[tag] for tag in once} == dict.fromkeys(once, 1)
    links = [v for e in page.elements for k, v in e.attributes.items() if k in ("href", "src")]
    assert all(link.startswith("#") for link in links)
    assert not {e.tag for e in page.elements} & {"link", "iframe", "object", "img", "base", "form"}
    urls = re.findall(r"url\(\s*(.{0,22})", text_of(which))
    assert {url[:22] for url in urls} <= {"data:image/png;base64,"}
    words = re.sub(r"(base64,|text/plain[^>]*>)[A-Za-z0-9+/=]*", "", text_of(which))
    assert not re.search(r"@import|https?:|//[a-z]", words)
    policy = next(e for e in page.all("meta") if "http-equiv" in e.attributes)
    assert policy.attributes["content"].startswith("default-src 'none'")


@WHICH
def test_every_link_has_its_target_and_every_name_is_used_once(which: str) -> None:
    page = page_of(which)
    names = Counter(e.attributes["id"] for e in page.elements if "id" in e.attributes)
    assert set(names.values()) == {1}
    assert {e.attributes["href"][1:] for e in page.all("a")} - {"matrix"} <= set(names)
    described = {
        e.attributes["aria-labelledby"] for e in page.elements if "aria-labelledby" in e.attributes
    }
    assert described <= set(names)


def test_hostile_text_is_shown_and_does_nothing() -> None:
    page, text = page_of("troubled"), text_of("troubled")
    events = [k for e in page.elements for k in e.attributes if k.startswith("on")]
    assert events == []
    assert not set(text) & set("\x00\x1b")
    scripts = page.all("script")
    (script,) = [e for e in scripts if "type" not in e.attributes]
    assert {e.attributes.get("type", "") for e in scripts} == {"", "text/plain", "application/json"}
    assert "onerror" not in script.text
    (data,) = [e for e in scripts if e.attributes.get("type") == "application/json"]
    assert "onerror" in data.text
    assert "<" not in data.text
    shown = HOSTILE.replace("\x1b", "�").replace("\x00", "�")
    assert any(shown in e.text for e in page.all("h3", "title"))
    assert any(f"LLVM ERROR: {shown}" in e.text for e in page.all("pre"))
    assert "{{" in page.all("h3", "title")[0].text + page.all("h3", "title")[1].text


@pytest.mark.parametrize(
    ("which", "look", "begins"),
    [
        ("good", "good", "✓ PASS: 2 scenes agree with honest"),
        ("troubled", "bad", "✗ FAIL: 2 of 2 scenes; first wrong stage: t"),
        ("empty", "bad", "✗ FAIL: no scene was chosen"),
    ],
)
def test_first_comes_the_verdict_then_the_counts(which: str, look: str, begins: str) -> None:
    page = page_of(which)
    assert page.all("h1")[0].text.startswith(begins)
    assert page.all("div", "verdict")[0].has(look)
    chips = [element.text for element in page.all("li")]
    run = {"good": good_run, "troubled": troubled_run, "empty": empty_run}[which]()
    for state, n in run.findings.checks.items():
        assert f"{n} {state}" in chips


def cells(which: str) -> list[Element]:
    kinds = ("passed", "failed", "follows", "silent", "empty", "none")
    return [e for e in page_of(which).all("td") if "title" in e.attributes
            and any(e.has(kind) for kind in kinds)]  # fmt: skip


def test_matrix_has_a_cell_for_everything_each_with_icon_and_word() -> None:
    found = cells("troubled")
    covered = sum(int(cell.attributes.get("colspan", "1")) for cell in found)
    assert covered == 2 * 9 * len(NAMES)
    for cell in found:
        words = cell.text.split()
        assert words[0] in "✓✗↳–!"
        assert len(words) >= 2, cell.text
    reasons = [cell.attributes["title"] for cell in found if cell.has("none")]
    assert any("it is colour-blind" in reason for reason in reasons)


def test_columns_follow_the_causal_order() -> None:
    stages = [STAGES.index(QUANTITIES[name].stage) for name in CAUSAL]
    assert sorted(CAUSAL) == sorted(NAMES)
    assert all(a <= b for a, b in pairwise(stages))
    assert [e.text for e in page_of("good").all("th", "turned")] == list(CAUSAL)


def test_failing_cells_are_listed_first_and_link_to_their_pictures() -> None:
    page = page_of("troubled")
    total = len(troubled_run().findings.failing)
    links = [e.attributes["href"] for e in page.all("a")]
    assert sum(cell.has("failed") or cell.has("follows") for cell in cells("troubled")) == total
    assert links.count("#scene-2-ball-shadow") == 2 * 2
    text = text_of("troubled")
    assert text.index("What fails") < text.index('class="matrix"')


def test_every_compared_quantity_has_three_pictures_that_exist() -> None:
    page = page_of("good")
    known = pictures("good")
    shown = page.all("span", "pic")
    assert len(shown) == 2 * len(NAMES) * 3 + 2
    used = {name for e in shown for name in e.attributes["class"].split() if name != "pic"}
    assert used == set(known)
    for png in known.values():
        assert Image.open(io.BytesIO(png)).size == (48, 36)
    assert all(e.attributes["aria-label"] for e in shown)


def test_one_wrong_pixel_is_outlined_and_enlarged() -> None:
    page = page_of("troubled")
    label = "shadow: 1 wrong pixel, the worst at (10, 30)"
    small = [e for e in page.all("span", "pic") if e.attributes["aria-label"] == label]
    large = [
        e for e in page.all("span", "zoom") if e.attributes["aria-label"] == f"enlarged: {label}"
    ]
    assert len(small) == len(large) == 2
    name = small[0].attributes["class"].split()[1]
    image = np.asarray(Image.open(io.BytesIO(pictures("troubled")[name])).convert("RGB"))
    ring = (image == RING[0]).all(axis=2)
    assert ring.sum() == 24  # the rim of 7 × 7 pixels
    assert np.argwhere(ring).mean(axis=0).tolist() == [30, 10]
    style = large[0].attributes["style"]
    assert "background-size:480px 360px" in style
    assert "background-position:-30px -230px" in style


def test_what_follows_from_an_earlier_stage_is_marked_so() -> None:
    scene = small_scene(materials={"gray": {"ambient": [0, 0, 0]}, "glass": {"ior": 1.5}})
    text = report_html(run_of([scene], [Faulty()]))
    assert "all wrong in an earlier stage already" in text
    assert '<td class="follows"' in text


def test_tolerances_are_shown_with_their_derivation() -> None:
    text = text_of("good")
    assert "256 roundings of 2⁻⁵²" in text
    assert "How a tolerance is derived" in text
    assert "plus 2 times the largest movement" in text


def test_rules_name_the_scenes_that_list_them() -> None:
    page = page_of("good")
    rows = {e.attributes["id"]: e.text for e in page.all("tr") if "id" in e.attributes}
    assert {f"rule-S{k}" for k in range(1, 17)} <= set(rows)
    assert "ball, second" in rows["rule-S12"]
    assert "✓ passed" in rows["rule-S12"]
    assert "shadow 2 of 2" in rows["rule-S12"]
    assert "passed in 2 of 2 scenes" in rows["rule-S12"]
    assert "none in this run" in rows["rule-S1"]
    assert "documented; unit tests" in rows["rule-E3"]


def test_every_rule_that_a_scene_may_list_has_its_row() -> None:
    every = [f"S{k}" for k in range(1, 18)] + [f"E{k}" for k in range(1, 9)]
    scene = small_scene(rules=every)
    page = Page()
    page.feed(report_html(run_of([scene], [Partial()])))
    rows = {e.attributes["id"]: e.text for e in page.all("tr") if "id" in e.attributes}
    assert set(rows) == {f"rule-{rule}" for rule in every}
    assert "✓ passed" in rows["rule-S6"]
    assert "◐ partly checked" in rows["rule-S8"]
    assert "normal: not checked" in rows["rule-S8"]
    assert "– not checked" in rows["rule-S12"]


def test_what_was_not_checked_stands_beside_the_verdict() -> None:
    page = Page()
    page.feed(report_html(run_of([small_scene()], [Partial()])))
    (box,) = page.all("div", "verdict")
    assert "Not checked: ray, object, triangle, depth," in box.text
    page.feed(report_html(run_of([small_scene()], [CannotSay()])))
    assert "Not compared: ball: its pixels are round" in page.all("div", "verdict")[1].text
    assert "Not checked" not in page_of("good").all("div", "verdict")[0].text


def test_a_scene_begins_with_minirts_own_picture() -> None:
    shown = [e for e in page_of("good").all("span", "pic") if "--w" not in e.attributes["style"]]
    assert [e.attributes["aria-label"] for e in shown] == [
        "ball, rendered by minirt", "second, rendered by minirt",
    ]  # fmt: skip
    assert shown[0].attributes["style"] == "width:48px;aspect-ratio:48 / 36"


def test_pictures_can_be_enlarged_with_the_keyboard() -> None:
    page = page_of("good")
    buttons = page.all("button", "larger")
    assert len(buttons) == 2 * len(NAMES)
    assert buttons[0].text == "enlarge ray of honest"
    assert all(b.attributes["aria-pressed"] == "false" for b in buttons)


def test_same_picture_is_stored_once() -> None:
    assert len(pictures("good")) < 2 * len(NAMES) * 3 / 2


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_texts_have_the_contrast_that_wcag_aa_asks_for(theme: str) -> None:
    css = page_of("good").all("style")[0].text
    themes = re.findall(r":root \{(.*?)\}", css, flags=re.DOTALL)
    colors = dict(re.findall(r"--([a-z-]+): (#[0-9a-f]{6})", themes[theme == "dark"]))
    pairs = [
        ("ink", "page"), ("ink", "card"), ("soft", "page"), ("soft", "card"), ("link", "page"),
        ("link", "card"), ("pass", "pass-bg"), ("pass", "card"), ("fail", "fail-bg"),
        ("fail", "card"), ("on-solid", "fail-solid"), ("fail", "follows-bg"),
        ("on-silent", "silent-bg"), ("soft", "pass-bg"), ("soft", "fail-bg"),
    ]  # fmt: skip
    low = {pair: contrast(colors[pair[0]], colors[pair[1]]) for pair in pairs}
    assert min(low.values()) >= 4.5, low


def contrast(one: str, other: str) -> float:
    lights = []
    for color in (one, other):
        code = np.array(list(bytes.fromhex(color[1:]))) / 255
        linear = np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)
        lights.append(float(linear @ [0.2126, 0.7152, 0.0722]))
    return (max(lights) + 0.05) / (min(lights) + 0.05)


def test_failed_scenes_come_before_passed_ones() -> None:
    good, bad = good_run().results, run_of([small_scene("bad")], [Faulty()]).results
    findings = findings_of([*good, *bad])
    run: Run = replace(good_run(), findings=findings, references=("honest", "faulty"))
    page = Page()
    page.feed(report_html(run))
    assert [e.text.split()[1] for e in page.all("h3", "title")] == ["bad", "ball", "second"]
    opened = [e.attributes["id"] for e in page.all("details", "scene") if "open" in e.attributes]
    assert opened == ["scene-3-bad"]


def test_thumbnails_keep_the_page_small() -> None:
    screen = {
        "look_at": {"eye": [0, 1, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 40},
        "nx": 256, "ny": 192,
    }  # fmt: skip
    size = len(report_html(run_of([small_scene(screen=screen)], [Honest()])).encode())
    rest = len(text_of("empty").encode())
    assert size - rest < 10 * 2**20 / 90, "30 scenes × 3 references must stay below 10 MB"
