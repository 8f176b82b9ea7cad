"""The report in a real browser: what it draws and says, beside the arrays that it is made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Browser

from converters.frames.io import write_frame
from minirt.frame import Array
from minirt.quantities import QUANTITIES
from reference.compare.comparison import compare
from reference.compare.stability import exact_answer, stability_of
from reference.verify.rendering import render_to_file
from reports.page.colors import BANDS, MASKS, NOTHING, RING, band_of, viridis
from reports.page.pictures import picture_span
from reports.page.report import report_html
from reports.results.findings import findings_of
from reports.results.record import Run
from tests.helpers.browser import Tab, chromium, tab
from tests.helpers.fake_references import (
    HOSTILE,
    NX,
    NY,
    Coarse,
    Faulty,
    Honest,
    OnePixel,
    small_scene,
)
from tests.helpers.report_runs import empty_run, good_run, run_of, troubled_run

#: A name that would do something if it were not text.
WICKED = f"<img src=x onerror=document.title='hacked'> \u202egnp.exe {HOSTILE}"
LONG = "very " * 2000 + "long"


@cache
def mixed_run() -> Run:
    """A scene that three references judge, one with a wicked name, one that passes."""
    failed = run_of([small_scene()], [Faulty(), OnePixel(), Honest(), Coarse()])
    wicked = run_of([small_scene(WICKED, about=LONG)], [OnePixel()])
    passed = run_of([small_scene("second")], [Honest()])
    runs = (failed, wicked, passed)
    return replace(
        failed,
        findings=findings_of([result for run in runs for result in run.results]),
    )


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as opened:
        yield opened


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(report_html(mixed_run()), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def frames(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Array]]:
    """What minirt and the faulty reference rendered, as their .npz files hold it."""
    folder = tmp_path_factory.mktemp("frames")
    scene = small_scene()
    write_frame(exact_answer(scene).frame, folder / "ours.npz")
    (folder / "faulty").mkdir()
    render_to_file(Faulty(), scene, folder / "faulty")
    found = {"ours": folder / "ours.npz", "theirs": folder / "faulty" / "frame.npz"}
    return {
        who: {name: values for name, values in np.load(path).items() if name in QUANTITIES}
        for who, path in found.items()
    }


@pytest.fixture(scope="module")
def ratios() -> dict[str, Array]:
    return ratios_of(Faulty())


def ratios_of(reference: Honest) -> dict[str, Array]:
    """Error over tolerance, computed apart from the page."""
    scene = small_scene()
    exact = exact_answer(scene)
    theirs = reference.render(scene, Path()).frame
    stability = stability_of(exact, reference.declare(scene), set(QUANTITIES))
    return dict(compare(scene, exact.frame, stability, theirs, {}).ratio)


@pytest.fixture
def opened(browser: Browser, report: Path) -> Iterator[Tab]:
    with tab(browser, report) as ready:
        ready.settle()
        yield ready
        assert ready.errors == []
        assert ready.requests
        own = (report.as_uri(), "data:", "blob:")
        assert [url for url in ready.requests if not url.startswith(own)] == []


def test_the_verdict_and_the_counts_are_on_the_first_screen(opened: Tab) -> None:
    page = opened.page
    assert "FAIL: 1 of 1 scene; first wrong stage: t" in page.inner_text("h1")
    for selector in ("h1", ".chips", "#filter", "[data-only=failed]"):
        box = page.locator(selector).first.bounding_box()
        assert box is not None
        assert box["y"] + box["height"] < 900
    assert page.inner_text("#shown") == "3 of 3 scenes shown"


def test_without_a_browser_the_tests_fail_and_say_what_brings_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("PATH", "")
    with pytest.raises(pytest.fail.Exception, match="system-packages PYTHON test"), chromium():
        pass


def test_filter_chips_and_order_choose_what_is_shown(opened: Tab) -> None:
    page = opened.page

    def names() -> list[str]:
        found = page.locator("details.scene:not([hidden]) h3.title").all_inner_texts()
        return [name.split()[1] for name in found]

    assert names() == ["ball", "<img", "second"]
    page.fill("#filter", "SECOND s12")
    assert names() == ["second"]
    assert page.locator("tbody[data-search]:not([hidden])").count() == 1
    page.fill("#filter", "")
    page.click("[data-only=failed]")
    assert names() == ["ball", "<img"]
    assert page.get_attribute("[data-only=failed]", "aria-pressed") == "true"
    page.click("[data-only=failed]")
    page.select_option("#sort", "name")
    assert names() == ["<img", "ball", "second"]
    page.select_option("#sort", "worst")
    assert names()[-1] == "second"


@pytest.mark.full
def test_the_address_holds_the_whole_view_and_survives_a_reload(
    opened: Tab, browser: Browser, report: Path
) -> None:
    page = opened.page
    page.fill("#filter", "s12")
    page.select_option("#sort", "certain")
    page.select_option("#stage-reference", "one-pixel")
    opened.settle()
    page.select_option("#stage-quantity", "depth")
    page.click("[data-mode=difference]")
    page.select_option("#stage-scale", "log")
    page.check("[data-overlay=o]")
    page.click("#clusters button")
    page.click("details.scene:not([open]) > summary")
    opened.settle()

    def seen(shown: Tab) -> dict[str, object]:
        shown.page.wait_for_selector("#sentence")
        values = {
            name: shown.page.input_value(f"#{name}")
            for name in ("filter", "sort", "stage-scene", "stage-reference", "stage-quantity",
                         "stage-scale")
        }  # fmt: skip
        picture, view = shown.picture()
        return {
            **values,
            "mode": shown.page.locator("[data-mode][aria-pressed=true]").inner_text(),
            "objects": shown.page.is_checked("[data-overlay=o]"),
            "pixel": shown.page.inner_text("#inspector h3"),
            "open": shown.page.locator("details.scene[open]").count(),
            "view": view,
            "dots": picture.tobytes(),
        }

    before = seen(opened)
    assert before["filter"] == "s12"
    assert before["stage-reference"] == "one-pixel"
    assert str(before["pixel"]).startswith("Pixel (20, 31)")
    assert before["open"] == 3
    page.reload()
    opened.settle()
    assert seen(opened) == before
    hash_ = page.evaluate("location.hash")
    with tab(browser, report, hash_) as elsewhere:
        elsewhere.settle()
        assert seen(elsewhere) == before


@pytest.mark.full
def test_swap_slider_blink_and_side_by_side_draw_the_values(
    opened: Tab, frames: dict[str, dict[str, Array]]
) -> None:
    expected = {who: colors("shadow", frame["shadow"]) for who, frame in frames.items()}
    assert (expected["ours"] != expected["theirs"]).any(axis=2).sum() > 50
    opened.change(r="faulty", q="shadow", o="", m="side")
    assert same(opened.pixels(NX, NY, 0), expected["ours"])
    assert same(opened.pixels(NX, NY, 1), expected["theirs"])
    opened.change(m="swap")
    assert same(opened.pixels(NX, NY), expected["ours"])
    opened.page.keyboard.down("x")
    assert same(opened.pixels(NX, NY), expected["theirs"])
    opened.page.keyboard.up("x")
    assert same(opened.pixels(NX, NY), expected["ours"])
    opened.change(m="slider")
    opened.page.evaluate("shown.cut = 0.5; draw()")
    shown = opened.pixels(NX, NY)
    assert same(shown[:, : NX // 2 - 1], expected["ours"][:, : NX // 2 - 1])
    assert same(shown[:, NX // 2 + 1 :], expected["theirs"][:, NX // 2 + 1 :])
    opened.change(m="blink")
    seen = set()
    for _ in range(8):
        shown = opened.pixels(NX, NY)
        seen |= {who for who, image in expected.items() if same(shown, image)}
        opened.page.wait_for_timeout(250)
    assert seen == {"ours", "theirs"}


@pytest.mark.full
def test_lengths_are_drawn_on_the_scale_of_both(
    opened: Tab, frames: dict[str, dict[str, Array]]
) -> None:
    opened.change(r="faulty", q="depth", o="", m="side")
    ours, theirs = frames["ours"]["depth"], frames["theirs"]["depth"]
    span = picture_span("depth", ours, theirs)
    share = (ours - span.low[0]) / (span.high[0] - span.low[0])
    levels = np.clip(np.rint(np.nan_to_num(share, posinf=0) * 63), 0, 63).astype(int)
    expected = np.where(np.isfinite(ours)[..., None], viridis(64)[levels], NOTHING)
    assert same(opened.pixels(NX, NY), expected)


def test_the_difference_is_error_over_tolerance_in_bands_and_signed(
    opened: Tab, ratios: dict[str, Array]
) -> None:
    name = "color"
    judged = ~np.isnan(ratios[name])
    assert judged.mean() > 0.5
    assert (ratios[name] > 1).sum() > 50
    opened.change(r="faulty", q=name, o="", m="difference", d="bands")
    expected = BANDS[band_of(np.nan_to_num(ratios[name], nan=0, posinf=np.inf))]
    assert same(opened.pixels(NX, NY)[judged], expected[judged])
    opened.change(r="one-pixel", q="depth", d="linear")
    light = opened.pixels(NX, NY).astype(int)
    column, row = 20, 31
    assert light[row, column, 0] > light[row, column, 2] + 60, "too large: orange"
    others = np.delete(light.reshape(-1, 3), row * NX + column, axis=0)
    assert (np.abs(others - 238) < 30).all()


@pytest.mark.full
def test_uncertain_pixels_are_hatched_and_wrong_ones_outlined(
    opened: Tab, ratios: dict[str, Array]
) -> None:
    opened.change(r="one-pixel", q="shadow", o="w", m="difference")
    rgb, view = opened.picture()
    ring = np.argwhere((rgb == RING[0]).all(axis=2))
    assert len(ring)
    middle = (ring.min(axis=0) + ring.max(axis=0) + 1) / 2
    pane, scale = view["panes"][0], view["scale"]
    assert (middle[1] - pane["left"]) / scale == pytest.approx(10.5, abs=0.1)
    assert (middle[0] - pane["top"]) / scale == pytest.approx(30.5, abs=0.1)
    uncertain = np.isnan(ratios_of(Coarse())["shadow"])
    assert 100 < uncertain.sum() < NX * NY - 100
    opened.change(r="coarse", o="", m="swap")
    plain = opened.pixels(NX, NY).astype(int)
    opened.change(o="u")
    hatched = opened.pixels(NX, NY).astype(int)
    assert np.array_equal((plain != hatched).any(axis=2), uncertain)


@pytest.mark.full
def test_pixels_are_square_and_sharp_at_every_zoom(opened: Tab) -> None:
    opened.change(r="faulty", q="shadow", o="", m="swap")
    palette = {tuple(color) for color in MASKS["shadow"].tolist()}
    for _ in range(3):
        opened.page.keyboard.press("+")
        rgb, view = opened.picture()
        assert float(view["scale"]).is_integer()
        shown = {tuple(color) for color in rgb.reshape(-1, 3)[::7].tolist()} - {(0, 0, 0)}
        assert shown <= palette


def test_the_inspector_has_the_numbers_of_the_files(
    opened: Tab, frames: dict[str, dict[str, Array]], ratios: dict[str, Array]
) -> None:
    opened.change(r="faulty", q="shadow")
    rng, compared = np.random.default_rng(50), 0
    for place in rng.choice(NX * NY, 50, replace=False):
        row, column = divmod(int(place), NX)
        cells = inspected(opened, column, row)
        assert set(cells) == set(QUANTITIES)
        for name, (verdict, ours, theirs, _) in cells.items():
            for who, words in (("ours", ours), ("theirs", theirs)):
                expected = np.atleast_1d(frames[who][name][row, column]).astype(float)
                shown = [number(word) for word in words.split("\n")]
                assert np.array_equal(shown, expected, equal_nan=True), (name, column, row, words)
                compared += 1
            ratio = ratios[name][row, column]
            assert verdict.split()[0] == ("?" if np.isnan(ratio) else "✗" if ratio > 1 else "✓")
    assert compared == 50 * len(QUANTITIES) * 2


def number(word: str) -> float:
    assert "≈" not in word
    return {"none": np.nan, "∞": np.inf, "−∞": -np.inf}.get(word) or float(word)


def inspected(opened: Tab, column: int, row: int) -> dict[str, list[str]]:
    """The inspector's cells at a pixel, by quantity: verdict, ours, theirs, tolerance."""
    opened.page.evaluate(f"change({{p: '{column},{row}'}})")
    opened.page.wait_for_selector(f"#inspector-body[data-shows$=' {column},{row}']")
    cells: dict[str, list[str]] = opened.page.evaluate(
        """() => Object.fromEntries([...document.querySelectorAll(
            "#inspector-body .values:first-of-type tr[data-quantity]")].slice(0, 20).map(
            (row) => [row.dataset.quantity, [...row.querySelectorAll("td")].map(
                (cell) => cell.children.length
                    ? [...cell.children].map((part) => part.textContent).join("\\n")
                    : cell.textContent)]))"""
    )
    return cells


def test_explained_pixels_show_the_algorithms_own_steps_and_everybody(opened: Tab) -> None:
    page = opened.page
    opened.change(r="faulty", q="shadow")
    page.click("#clusters button >> nth=0")
    page.wait_for_selector(".steps")
    assert "Look at rule S12" in page.inner_text("#sentence")
    steps = page.inner_text("#inspector .steps")
    assert "the shadow ray" in steps
    assert "M is in shadow of object" in steps
    assert page.locator("#inspector h4").first.inner_text() == "shadow by every reference"
    everybody = page.locator("#inspector section").first.inner_text()
    assert [name in everybody for name in ("faulty", "one-pixel", "honest")] == [True] * 3
    assert "--pixel" in page.inner_text("#command")
    assert page.is_visible("#space-canvas")
    page.click("#space summary")
    assert "shadow ray" in page.inner_text("#space-table")


@pytest.mark.full
def test_without_a_choice_the_worst_pixel_is_looked_at(opened: Tab) -> None:
    opened.page.wait_for_selector(".steps")
    assert "p" not in opened.state()
    assert "The first wrong stage is shadow" in opened.page.inner_text("#sentence")
    worst = opened.page.inner_text("#worst tbody button >> nth=0")
    assert opened.page.inner_text("#inspector h3").startswith(f"Pixel {worst}")
    opened.page.check("[data-overlay=o]")
    assert opened.state()["o"] == "uwop", "the mark around the pixel stays"


@pytest.mark.full
def test_errors_are_listed_by_size_with_their_share(opened: Tab, ratios: dict[str, Array]) -> None:
    opened.change(r="faulty", q="color")
    rows = opened.page.locator("#histogram tbody tr").all_inner_texts()
    cells = [row.split("\t") for row in rows]
    assert [cell[0] for cell in cells] == [
        "0", "≤ 1/8", "≤ 1/4", "≤ 1/2", "≤ 1", "≤ 2", "≤ 4", "≤ 16", "> 16", "uncertain",
    ]  # fmt: skip
    ratio = ratios["color"]
    assert int(cells[0][2]) == (ratio == 0).sum()
    assert int(cells[8][2]) == (ratio > 16).sum() > 50
    assert int(cells[9][2]) == np.isnan(ratio).sum()
    assert sum(int(cell[2]) for cell in cells) == NX * NY
    assert float(cells[8][1]) > 0.01


@pytest.mark.full
def test_the_view_in_space_turns_and_zooms_by_key(opened: Tab) -> None:
    opened.change(r="faulty", q="shadow")
    opened.page.click("#clusters button >> nth=0")
    opened.page.wait_for_selector("#space:not([hidden])")
    opened.page.focus("#space-canvas")
    pictures = set()
    for key in ("", "ArrowLeft", "ArrowUp", "+", "+"):
        if key:
            opened.page.keyboard.press(key)
        pictures.add(opened.page.evaluate("document.querySelector('#space-canvas').toDataURL()"))
    assert len(pictures) == 5
    opened.page.keyboard.press("0")
    last = opened.page.evaluate("document.querySelector('#space-canvas').toDataURL()")
    assert last in pictures


@pytest.mark.full
def test_a_passing_scene_says_that_its_values_are_not_kept(opened: Tab) -> None:
    page = opened.page
    scene = page.eval_on_selector_all(
        "#stage-scene option", "(all) => all.find((o) => o.textContent.includes('second')).value"
    )
    opened.change(s=scene, r="", q="depth")
    assert inspected(opened, 1, 1) == {}
    text = page.inner_text("#inspector")
    assert "This scene passes" in text
    assert "minirt explain" in text
    page.click("#inspector .pixel >> nth=0")
    page.wait_for_selector(".steps")
    assert page.locator("#inspector tr[data-quantity=depth]").count() == 2


def test_names_and_messages_are_text_whatever_they_hold(opened: Tab) -> None:
    page = opened.page
    options = page.locator("#stage-scene option").all_inner_texts()
    wicked = next(k for k, text in enumerate(options) if "<img" in text)
    page.select_option("#stage-scene", index=wicked)
    opened.settle()
    page.click("#clusters button >> nth=0")
    page.wait_for_selector(".steps")
    assert page.locator("img").count() == 0
    assert "hacked" not in page.title()
    text = page.content()
    assert "\u202e" not in text
    assert "very very" in page.inner_text("details.scene >> nth=1")
    width = page.evaluate("document.documentElement.scrollWidth")
    assert width <= page.evaluate("innerWidth")


@pytest.mark.full
def test_everything_is_reached_and_done_by_keyboard_alone(opened: Tab) -> None:
    page = opened.page
    wanted = {"filter", "sort", "open-all", "stage-scene", "stage-reference", "stage-quantity",
              "stage-canvas", "mode swap", "mode difference"}  # fmt: skip
    reached = set()
    for _ in range(150):
        page.keyboard.press("Tab")
        name = page.evaluate(
            "document.activeElement.id || `mode ${document.activeElement.dataset.mode}`"
        )
        reached.add(name)
        if name == "mode swap":
            page.keyboard.press("Enter")
            assert opened.state()["m"] == "swap"
        if name == "stage-canvas":
            break
    assert wanted - reached == set()
    page.keyboard.press("5")
    assert opened.state()["m"] == "difference"
    page.keyboard.press("ArrowRight")
    first = opened.state()["p"]
    assert "cluster 1 of" in page.inner_text("#stage-status")
    page.keyboard.press("ArrowRight")
    assert opened.state()["p"] != first
    before = [int(x) for x in opened.state()["p"].split(",")]
    page.keyboard.press("Shift+ArrowDown")
    assert [int(x) for x in opened.state()["p"].split(",")] == [before[0], before[1] + 1]
    page.keyboard.press("?")
    assert page.is_visible("#help")
    page.keyboard.press("Escape")
    assert not page.is_visible("#help")
    scene = page.input_value("#stage-scene")
    page.keyboard.press("]")
    opened.settle()
    page.wait_for_function(f"document.querySelector('#stage-scene').value !== '{scene}'")
    page.keyboard.press("[")
    page.wait_for_function(f"document.querySelector('#stage-scene').value === '{scene}'")


@pytest.mark.full
def test_typing_into_the_filter_is_no_command(opened: Tab) -> None:
    opened.page.click("#filter")
    opened.page.keyboard.type("s12")
    assert opened.state()["f"] == "s12"
    assert "m" not in opened.state()


@pytest.mark.parametrize("which", [good_run, troubled_run, empty_run])
def test_no_run_breaks_the_script(
    which: Callable[[], Run], browser: Browser, tmp_path: Path
) -> None:
    path = tmp_path / "report.html"
    path.write_text(report_html(which()), encoding="utf-8")
    with tab(browser, path) as shown:
        for reference in shown.page.locator("#stage-reference option").all_inner_texts():
            shown.page.select_option("#stage-reference", label=reference)
            shown.settle()
            assert shown.page.input_value("#stage-reference") in reference
        assert shown.errors == []


@pytest.mark.full
def test_commands_and_tests_can_be_copied(opened: Tab) -> None:
    opened.change(r="faulty", q="shadow", p="20,20")
    button = opened.page.get_by_role("button", name="copy as a test")
    button.click()
    opened.page.get_by_role("button", name="copied").wait_for()
    opened.page.focus("#filter")
    opened.page.keyboard.press("Control+V")
    assert "def test_ball_faulty_at_20_20()" in opened.page.input_value("#filter")


@pytest.mark.full
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious(browser: Browser, report: Path, scheme: str) -> None:
    with tab(browser, report, "#p=20,20", color_scheme=scheme) as shown:
        shown.settle()
        shown.page.wait_for_selector("#sentence")
        found = Axe().run(shown.page).response
        assert len(found["passes"]) > 20
        bad = [v for v in found["violations"] if v["impact"] in ("serious", "critical")]
        assert [(v["id"], v["nodes"][0]["html"][:200]) for v in bad] == []


@pytest.mark.full
def test_axe_sees_a_planted_fault(browser: Browser, report: Path) -> None:
    with tab(browser, report) as shown:
        shown.page.evaluate(
            """() => {
                one('#help').replaceChildren(document.createElement("select"));
                one('#help').show();
            }"""
        )
        found = Axe().run(shown.page, context="#help").response
        assert "select-name" in {v["id"] for v in found["violations"]}


@pytest.mark.full
def test_reduced_motion_is_respected(browser: Browser, report: Path) -> None:
    with tab(browser, report, "#m=blink&q=shadow", reduced_motion="reduce") as shown:
        shown.settle()
        first = shown.picture()[0]
        for _ in range(4):
            shown.page.wait_for_timeout(400)
            assert np.array_equal(shown.picture()[0], first)
        shown.page.keyboard.down("x")
        assert not np.array_equal(shown.picture()[0], first)


@pytest.mark.full
def test_a_page_of_the_largest_size_is_soon_of_use(
    browser: Browser, report: Path, tmp_path: Path
) -> None:
    more = "".join(
        f'<script type="text/plain" id="more{k}">{"eJxA" * 2**18}</script>\n' for k in range(20)
    )
    path = tmp_path / "large.html"
    path.write_text(report.read_text(encoding="utf-8") + more, encoding="utf-8")
    assert path.stat().st_size > 20 * 2**20
    with tab(browser, path) as shown:
        shown.settle()
        session = shown.page.context.new_cdp_session(shown.page)
        session.send("Performance.enable", {"timeDomain": "threadTicks"})
        shown.page.reload()
        shown.settle()
        found = session.send("Performance.getMetrics")["metrics"]
        (busy,) = [each["value"] for each in found if each["name"] == "TaskDuration"]
        assert 0.05 < busy < 2, "seconds of the processor, however many others use it"


@pytest.mark.full
@pytest.mark.parametrize("width", [390, 1300])
def test_nothing_is_wider_than_the_window(browser: Browser, report: Path, width: int) -> None:
    size = {"width": width, "height": 800}
    with tab(browser, report, "#p=20,20", viewport=size) as shown:
        shown.settle()
        shown.page.wait_for_selector("#sentence")
        assert shown.page.evaluate("document.documentElement.scrollWidth") <= width


def colors(name: str, values: Array) -> Array:
    """The palette's colours of a mask."""
    return np.asarray(MASKS[name][values.astype(int) + 1])


def same(shown: Array, expected: Array) -> bool:
    """Equal colours but for one step of rounding."""
    assert shown.size > 100
    return bool((np.abs(shown.astype(int) - expected.astype(int)) <= 1).all())
