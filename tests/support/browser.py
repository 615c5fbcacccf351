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
