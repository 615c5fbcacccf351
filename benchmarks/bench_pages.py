"""The page of an exploration in a browser: its bytes, and the browser's own time to draw it and to change an axis.

``python -m benchmarks pages``; it needs Chromium and the extra ``browser``. The points are those of the shipped study
``million`` at some of its clocks. The browser's own time is the processor time of the page's main thread: parsing,
scripts, style, layout and paint.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import codesign
from codesign.inputs.exploring import exploring
from codesign.study.study import Study
from codesign.views.report import study_page

CLOCKS = [f"{8 + 14 * number} MHz" for number in range(10)]
ROUNDS = 3

Row = dict[str, str]


def explored(clocks: int) -> Study:
    """20 blocks × 10 numbers of iterations × 5 parts × 10 clocks, at so many clocks of the link."""
    axes = {"relax.schedule": [[111]], "link.clock": CLOCKS[:clocks]}
    workload = exploring(codesign.load_workload("million"), axes, {})
    return codesign.explore(codesign.load_platform("virtex4-pci"), workload, workers=1)


def measured(browser: Any, page: Path) -> dict[str, float]:
    """Milliseconds of one fresh page: to draw it, to change an axis, to colour by another figure, to filter."""
    tab = browser.new_page(viewport={"width": 1600, "height": 1000})
    session = tab.context.new_cdp_session(tab)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def busy() -> float:
        metrics = session.send("Performance.getMetrics")["metrics"]
        return float(next(each["value"] for each in metrics if each["name"] == "TaskDuration"))

    def step(act: Any, *arguments: str) -> float:
        begin = busy()
        act(*arguments)
        tab.evaluate("new Promise((done) => requestAnimationFrame(() => setTimeout(done, 50)))")
        return 1000 * (busy() - begin)

    def load() -> None:
        tab.goto(page.as_uri())
        tab.wait_for_selector("html[data-ready]")

    try:
        return {
            "draw": step(load),
            "axis": step(tab.select_option, "#choose-x", "f:energy_j"),
            "colour": step(tab.select_option, "#choose-colour", "f:slices"),
            "filter": step(tab.click, "[aria-label='only best: share reaching goal']"),
            "all": step(tab.check, "#show-all"),
        }
    finally:
        tab.close()


def run() -> Iterator[Row]:
    """The rows of the table."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        yield {"points": "skipped", "why": "no playwright: pip install 'hwsw-codesign[browser]'"}
        return
    path = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if path is None:
        yield {"points": "skipped", "why": "no Chromium on this machine"}
        return
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        for clocks in (1, 2, 10):
            study, page = explored(clocks), Path(folder) / f"{clocks}.html"
            begin = time.process_time()
            study_page(study, page)
            made = time.process_time() - begin
            rounds = [measured(browser, page) for _ in range(ROUNDS)]
            least = {name: min(each[name] for each in rounds) for name in rounds[0]}
            yield {
                "points": f"{len(study.points):,}",
                "MB": f"{page.stat().st_size / 1e6:.2f}",
                "s to write": f"{made:.1f}",
                **{f"ms: {name}": f"{value:.0f}" for name, value in least.items()},
            }
        browser.close()
