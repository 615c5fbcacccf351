"""Pages in a real browser: Chromium, driven by Playwright, with everything that goes wrong in it written down."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def needs_browser() -> None:
    """Skip where there is no browser to look with."""
    pytest.importorskip("playwright", reason="no page was opened: pip install playwright (extra browser)")
    if CHROMIUM is None:
        pytest.skip("no page was opened: there is no Chromium on this machine")


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def opened(browser: Any, page: Path, address: str = "", **options: Any) -> Iterator[Any]:
    """A page that has been drawn; it fails if the console says anything, or if anything is asked for from outside."""
    context = browser.new_context(**options)
    tab, faults = context.new_page(), []
    tab.on("console", lambda message: faults.append(f"console: {message.text}"))
    tab.on("pageerror", lambda error: faults.append(f"error: {error}"))
    tab.on("request", lambda request: faults.extend([request.url] * (request.url[:4] == "http")))
    try:
        tab.goto(f"{page.as_uri()}{address}")
        tab.wait_for_selector("html[data-ready]")
        yield tab
        assert faults == []
    finally:
        context.close()


def stands_at_any_width(browser: Any, page: Path) -> None:
    """Look at a page at 1600, 900 and 400 px, light and dark, and print it: it is never wider than its window."""
    for width in (1600, 900, 400):
        for scheme in ("light", "dark"):
            with opened(browser, page, viewport={"width": width, "height": 900}, color_scheme=scheme) as tab:
                assert tab.evaluate("document.documentElement.scrollWidth") <= width
                light = tab.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(251, 251, 250)"
                assert light == (scheme == "light")
                tab.emulate_media(media="print")
                assert tab.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
                assert len(tab.pdf(prefer_css_page_size=True)) > 10_000


def assert_tables_fit(browser: Any, page: Path) -> None:
    """At 1600 px no table hides a column, and no row is mostly empty; at 400 px a table of few columns is no card."""
    with opened(browser, page, viewport={"width": 1600, "height": 1000}) as tab:
        hidden = "[...document.querySelectorAll('.wide')].filter((each) => each.scrollWidth > each.clientWidth + 1)"
        assert tab.evaluate(f"{hidden}.map((each) => each.ariaLabel)") == []
        # A row is no higher than the lines of its longest text ask for: 36rem hold 60 letters at least.
        empty = """[...document.querySelectorAll("tbody tr")].filter((row) => {
          const most = Math.max(...[...row.cells].map((cell) => cell.textContent.length));
          return row.getBoundingClientRect().height > 78 && row.getBoundingClientRect().height > 24 * (2 + most / 24);
        }).map((row) => row.innerText)"""
        assert tab.evaluate(empty) == []
    with opened(browser, page, viewport={"width": 400, "height": 900}) as tab:
        few = (
            "[...document.querySelectorAll('table')]"
            ".filter((each) => each.tHead && each.tHead.rows[0].cells.length < 4)"
        )
        assert tab.evaluate(f"{few}.filter((each) => getComputedStyle(each).display !== 'table').length") == 0
        assert tab.evaluate(f"{few}.length") > 0
