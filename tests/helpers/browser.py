"""Chromium for the reports' tests: one that is not there is a failure, never a skip."""

from __future__ import annotations

import base64
import io
import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from minirt.frame import Array

ARGUMENTS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip


@contextmanager
def chromium() -> Iterator[Browser]:
    """A browser without a window."""
    names = ("chromium", "chromium-browser", "google-chrome")
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        pytest.fail("no Chromium to open the report in: .ci/system-packages PYTHON test brings it")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=found, args=ARGUMENTS)
        yield browser
        browser.close()


@dataclass
class Tab:
    """An open page, what it asked for, and what went wrong in it."""

    page: Page
    requests: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)

    def state(self) -> dict[str, str]:
        """The state of the view that the address holds."""
        state: dict[str, str] = self.page.evaluate(
            "Object.fromEntries(new URLSearchParams(location.hash.slice(1)))"
        )
        return state

    def change(self, **changes: str) -> None:
        """Change the view as its controls do, and wait until it is drawn."""
        self.page.evaluate("(changes) => change(changes)", changes)
        self.settle()

    def settle(self) -> None:
        """Wait until the stage has drawn what was asked for."""
        self.page.wait_for_selector("#stage-canvas[data-view]:not([aria-busy])")
        self.page.evaluate("() => new Promise((done) => requestAnimationFrame(done))")

    def picture(self) -> tuple[Array, dict[str, Any]]:
        """The stage's dots (height, width, 3), and where the image lies on them."""
        url, view = self.page.evaluate(
            """() => {
                const canvas = document.querySelector("#stage-canvas");
                return [canvas.toDataURL(), canvas.dataset.view];
            }"""
        )
        png = base64.b64decode(url.partition(",")[2])
        rgb = np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))
        return rgb, json.loads(view)

    def pixels(self, nx: int, ny: int, pane: int = 0) -> Array:
        """The colours (ny, nx, 3) that one pane shows of the image's pixels, at their middles."""
        rgb, view = self.picture()
        place, scale = view["panes"][pane], view["scale"]
        rows = (place["top"] + (np.arange(ny) + 0.5) * scale).astype(int)
        columns = (place["left"] + (np.arange(nx) + 0.5) * scale).astype(int)
        return rgb[np.ix_(rows, columns)]


@contextmanager
def tab(browser: Browser, path: Path, hash_: str = "", **options: Any) -> Iterator[Tab]:
    """A page of its own, ready."""
    given: dict[str, Any] = {"viewport": {"width": 1300, "height": 900}, **options}
    context = browser.new_context(**given)
    page = context.new_page()
    opened = Tab(page)
    page.on("request", lambda request: opened.requests.append(request.url))
    page.on("pageerror", lambda error: opened.errors.append(str(error)))
    page.on("console", lambda m: opened.errors.append(m.text) if m.type == "error" else None)
    page.goto(path.as_uri() + hash_)
    page.wait_for_selector("html[data-ready]", state="attached")
    yield opened
    context.close()
