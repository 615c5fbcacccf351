"""The page of a run as a reader uses it, in a real browser."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from browser import assert_tables_fit, opened, stands_at_any_width
from report_samples import a_result
from runs_over_time import a_drive, a_fleet, a_plan

from codesign.ground.records import Record
from codesign.views.report.page import template_text
from codesign.views.report.result_page import result_page
from codesign.views.trace.moment import moment

pytestmark = pytest.mark.slow

RUNS = {"drive": a_drive, "fleet": a_fleet, "plan": a_plan}


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pages")
    written = {name: folder / f"{name}.html" for name in RUNS}
    for name, path in written.items():
        result_page(a_result(), path, records=RUNS[name]())
    return written


def tick_of(tab: Any) -> float:
    return float(tab.input_value("#time"))


def pixels_of(tab: Any) -> tuple[int, int]:
    """How many colours stand on the map, and how red its first pixel is."""
    # A copy is read: reading often from the canvas that is drawn on makes the browser complain.
    number, first = tab.evaluate(
        """() => {
          const canvas = document.querySelector("#stage"), copy = document.createElement("canvas");
          [copy.width, copy.height] = [canvas.width, canvas.height];
          const context = copy.getContext("2d", { willReadFrequently: true });
          context.drawImage(canvas, 0, 0);
          const { data } = context.getImageData(0, 0, copy.width, copy.height);
          return [new Set(new Uint32Array(data.buffer)).size, data[0]];
        }"""
    )
    return int(number), int(first)


@pytest.mark.parametrize("name", RUNS)
def test_a_run_stands_at_any_width_in_both_colours_and_on_paper(
    browser: Any, pages: dict[str, Path], name: str
) -> None:
    stands_at_any_width(browser, pages[name])
    assert_tables_fit(browser, pages[name])
    for width in (1600, 900, 400):
        with opened(browser, pages[name], viewport={"width": width, "height": 900}, color_scheme="dark") as tab:
            colours, dark = pixels_of(tab)
            assert colours > 5
            box = tab.locator("#stage").bounding_box()
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= width
            assert box["height"] <= 900
            tab.emulate_media(media="print")
            tab.wait_for_selector("html.paper")
            assert tab.locator("#stage").is_visible()
            assert not tab.locator("#play").is_visible()
            colours, light = pixels_of(tab)
            assert colours > 5
            assert light > dark


def test_play_pause_slider_events_and_charts_move_one_time(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["drive"], viewport={"width": 1200, "height": 900}) as tab:
        end = tick_of(tab)
        assert tab.inner_text("#now") == "20 s of 20 s"
        tab.click("#play")
        assert tab.inner_text("#play") == "pause"
        for _ in range(500):
            # A page forbids what Playwright's own waiting would evaluate.
            tab.wait_for_timeout(20)
            if tick_of(tab) > end / 100:
                break
        tab.click("#play")
        here = tick_of(tab)
        assert 0 < here < end
        assert tab.inner_text("#play") == "play"
        button = tab.locator("#events button").nth(2)
        button.click()
        assert tick_of(tab) == float(button.get_attribute("data-at"))
        assert tab.locator("#events [aria-current]").count() == 1
        assert "a plan is under way" in tab.inner_text("#facts")
        tab.locator("#events button").nth(3).click()
        assert "a plan is under way" not in tab.inner_text("#facts")
        assert "robot drives at 400 mm/s" in tab.inner_text("#facts") or "0.4 m/s" in tab.inner_text("#facts")
        tab.locator("#series svg").first.scroll_into_view_if_needed()
        box = tab.locator("#series svg").first.bounding_box()
        tab.mouse.click(box["x"] + box["width"] / 2, box["y"] + 5)
        assert tick_of(tab) == pytest.approx(end / 2, rel=0.02)
        tab.fill("#time", str(end / 4))
        assert tab.inner_text("#now") == "5 s of 20 s"
        assert tab.url.endswith("#t=5")


def test_a_run_is_scrubbed_with_the_keyboard(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["drive"]) as tab:
        end = tick_of(tab)
        tab.focus("#stage")
        tab.keyboard.press("Home")
        assert tick_of(tab) == 0
        tab.keyboard.press("ArrowRight")
        assert tick_of(tab) == pytest.approx(end / 200, abs=1)
        tab.keyboard.press("Shift+ArrowRight")
        assert tick_of(tab) == pytest.approx(end * 0.055, abs=1)
        tab.keyboard.press("n")
        first = tick_of(tab)
        tab.keyboard.press("n")
        assert tick_of(tab) > first
        tab.keyboard.press("p")
        assert tick_of(tab) == first
        tab.keyboard.press("End")
        assert tick_of(tab) == end
        tab.keyboard.press("Space")
        assert tab.inner_text("#play") == "pause"
        tab.keyboard.press("Space")
        assert tab.inner_text("#play") == "play"
        # Everything is reached with the tab key alone.
        reached = set()
        tab.focus("#stage")
        for _ in range(6):
            tab.keyboard.press("Tab")
            reached.add(tab.evaluate("document.activeElement.id || document.activeElement.dataset.at"))
        assert {"play", "time", "pace", "trail"} <= reached


def test_cells_and_robots_of_the_script_are_those_of_the_records(browser: Any, pages: dict[str, Path]) -> None:
    records: list[Record] = a_drive()
    script = "\n".join(template_text(name) for name in ("columns.js", "run/timeline.js"))
    read = """async (ticks) => { %s;
      const head = JSON.parse(document.querySelector("#run-data").textContent);
      const timeline = makeTimeline(head, await readColumns(head.packed));
      return ticks.map((tick) => {
        const { free, believed } = timeline.cellsAt(tick), [robot] = timeline.robotsAt(tick);
        const paths = timeline.pathsAt(tick).length, planning = timeline.planning(0, tick);
        return [[...free], [...believed], robot.row, robot.column, paths, head.tick, planning];
      });
    }"""
    drawn = random.Random(7)
    with opened(browser, pages["drive"]) as tab:
        end = int(tick_of(tab))
        # Forward and backward.
        ticks = [drawn.randrange(end) for _ in range(40)]
        for tick, (free, believed, row, column, paths, size, planning) in zip(
            ticks, tab.evaluate(read % script, ticks), strict=True
        ):
            seen = moment(records, (tick + 1) * size - 1)
            assert seen.free.ravel().tolist() == [bool(cell) for cell in free]
            assert seen.belief is not None
            assert seen.belief.ravel().tolist() == believed
            assert seen.pose is not None
            # Between two poses it is drawn between them.
            assert abs(seen.pose.row - row) < 0.35
            assert abs(seen.pose.column - column) < 0.35
            assert paths == (seen.path is not None)
            last = [event.event for event in seen.events][-1:]
            assert planning == (last == ["plan_requested"])


def test_a_fleet_of_64_can_be_read(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["fleet"], viewport={"width": 1600, "height": 1000}) as tab:
        assert tab.locator("table.robots tbody tr").count() == 64
        assert tab.inner_text("table.robots tbody tr:first-child td:first-child") == "63"
        assert "63 rest at their targets" in tab.inner_text("#facts")
        tab.click("[data-robot='5']")
        assert "robot 5 rests at its target" in tab.inner_text("#facts")
        assert "cells from its target" in tab.inner_text("#facts")
        assert tab.get_attribute("[data-robot='5']", "aria-pressed") == "true"
        assert "robot=5" in tab.url
        tab.focus("#stage")
        tab.keyboard.press("Home")
        assert "64 drive" in tab.inner_text("#facts")
        # Sorted by any column; what has no value comes last.
        heading = tab.locator("table.robots thead button").nth(1)
        heading.click()
        cells = "[...document.querySelectorAll('table.robots tbody tr')].map((row) => row.cells[1].dataset.value)"
        rising = tab.evaluate(cells)
        assert [float(value) for value in rising[:-1]] == sorted(float(value) for value in rising[:-1])
        assert rising[-1] == ""
        heading.click()
        falling = tab.evaluate(cells)
        assert falling[-1] == ""
        assert float(falling[0]) == float(rising[-2])
        assert tab.get_attribute("table.robots thead th:nth-child(2)", "aria-sort") == "descending"
        # A click on the map marks the robot there.
        box = tab.locator("#stage").bounding_box()
        tab.mouse.click(box["x"] + box["width"] * 0.93, box["y"] + box["height"] * 0.5)
        assert "robot=" in tab.url
        plain = tab.evaluate("document.querySelector('#stage').toDataURL()")
        tab.uncheck("#numbers")
        assert tab.evaluate("document.querySelector('#stage').toDataURL()") != plain


def test_a_plan_shows_the_field_of_each_stage(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["plan"]) as tab:
        assert "the field after stage 4" in tab.inner_text("#facts")
        tab.locator("#events button").nth(1).click()
        assert tab.inner_text("#facts").endswith("; the field after stage 1")
        tab.focus("#stage")
        tab.keyboard.press("Home")
        assert tab.inner_text("#facts") == "at 0 s; no stage has ended"


@pytest.mark.parametrize(
    "address", ["#t=nan&robot=-1", "#t=1e99&robot=1.5", "#t=-5", "#robot=__proto__&t=", "#%E0%A4%A"]
)
def test_an_address_that_says_nonsense_does_no_harm(browser: Any, pages: dict[str, Path], address: str) -> None:
    with opened(browser, pages["fleet"], address) as tab:
        assert 0 <= tick_of(tab) <= 1e7
        assert "rest at their targets" in tab.inner_text("#facts") or "drive" in tab.inner_text("#facts")


def test_an_address_opens_the_time_that_it_holds(browser: Any, pages: dict[str, Path]) -> None:
    with opened(browser, pages["fleet"], "#t=4&robot=7") as tab:
        assert tab.inner_text("#now").startswith("4 s of ")
        assert "robot 7 " in tab.inner_text("#facts")


def test_without_scripts_events_and_tables_stand(browser: Any, pages: dict[str, Path]) -> None:
    context = browser.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto(pages["fleet"].as_uri())
    text = tab.inner_text("main")
    assert "needs JavaScript" in text
    assert "robot 1 has arrived" in text
    assert tab.locator("table.robots tbody tr").count() == 64
    context.close()


def test_hostile_names_are_shown_as_they_are(browser: Any, tmp_path: Path) -> None:
    evil = "<img src=x onerror=alert(1)>\"'&</script>"
    path = tmp_path / "page.html"
    result_page(a_result(), path, records=a_drive(name=evil, text=evil))
    with opened(browser, path) as tab:
        assert evil in tab.inner_text("#facts")
        assert evil in tab.inner_text("#events")
        assert tab.locator("img[src=x]").count() == 0
