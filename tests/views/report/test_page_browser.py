"""The page of a study as a reader uses it, in a real browser."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import assert_tables_fit, opened
from report_samples import a_hopeless_study, a_study

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.units import Dimension, shown_units
from codesign.views.report import study_page
from codesign.views.report.canvas import Picture
from codesign.views.report.page import template_text
from codesign.views.report.wording import figure_cell, part_cell, quantity_text

pytestmark = pytest.mark.slow
STUDY = a_study(96)


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("pages") / "page.html"
    svg = b'<svg xmlns="http://www.w3.org/2000/svg" width="90" height="60"><path d="M0 0h90v60z"/></svg>'
    study_page(STUDY, path, pictures=[Picture("a", "a shape", "svg", svg)])
    return path


def shown(tab: Any) -> str:
    # Drawing happens before the next frame.
    tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return str(tab.inner_text("#shown-count"))


def painted(tab: Any) -> int:
    """How many pixels of the plot have colour in them."""
    return int(
        tab.evaluate(
            """() => {
              const canvas = document.querySelector("#plot canvas");
              const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
              let count = 0;
              for (let k = 0; k < data.length; k += 4) {
                const most = Math.max(data[k], data[k + 1], data[k + 2]);
                if (data[k + 3] > 60 && most - Math.min(data[k], data[k + 1], data[k + 2]) > 40) count += 1;
              }
              return count;
            }"""
        )
    )


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1600, 900, 400])
def test_a_page_is_drawn_at_any_width_and_in_both_colours(browser: Any, page: Path, width: int, scheme: str) -> None:
    with opened(browser, page, viewport={"width": width, "height": 900}, color_scheme=scheme) as tab:
        assert painted(tab) > 100
        # Nothing but tables with a bar of their own is wider than the page.
        assert tab.evaluate("document.documentElement.scrollWidth") <= width
        assert tab.evaluate("document.querySelector('#plot canvas').getBoundingClientRect().right") <= width
        light = tab.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(251, 251, 250)"
        assert light == (scheme == "light")
        filtered = tab.evaluate("getComputedStyle(document.querySelector('figure img')).filter")
        assert (filtered == "none") == (scheme == "light")
        is_card = tab.evaluate("getComputedStyle(document.querySelector('#points tbody td')).display") == "flex"
        assert is_card == (width == 400)
        if is_card:
            before = "getComputedStyle(document.querySelectorAll('#points tbody td')[1], '::before').content"
            assert tab.evaluate(before) == '"block"'


def test_its_tables_fit(browser: Any, page: Path) -> None:
    assert_tables_fit(browser, page)


PLOT_WIDTH = "document.querySelector('#plot canvas').getBoundingClientRect().width"


def test_a_printed_page_keeps_its_figure_and_its_columns(browser: Any, page: Path) -> None:
    with opened(browser, page, viewport={"width": 1600, "height": 900}, color_scheme="dark") as tab:
        on_screen = tab.evaluate(PLOT_WIDTH)
        tab.emulate_media(media="print")
        shown(tab)
        assert painted(tab) > 100
        assert 800 < tab.evaluate(PLOT_WIDTH) <= 900 < on_screen
        assert tab.evaluate("getComputedStyle(document.querySelector('#controls')).display") == "none"
        assert tab.evaluate("getComputedStyle(document.querySelector('.wide')).overflowX") == "visible"
        assert tab.evaluate("getComputedStyle(document.body).color") == "rgb(0, 0, 0)"
        tab.set_viewport_size({"width": 980, "height": 900})
        wide = "Math.max(...[...document.querySelectorAll('table')].map((t) => t.getBoundingClientRect().right))"
        assert tab.evaluate(wide) <= 980
        assert len(tab.pdf(prefer_css_page_size=True)) > 20_000
        tab.set_viewport_size({"width": 1600, "height": 900})
        tab.emulate_media(media="screen")
        shown(tab)
        assert tab.evaluate(PLOT_WIDTH) == on_screen


def test_two_clicks_give_the_cheapest_that_reaches_all(browser: Any, page: Path) -> None:
    share, slices = FIGURES["share_reaching_goal"], FIGURES["slices"]
    designs = [STUDY.designs[index] for index in STUDY.feasible]
    most = max(design.figure(share) or 0 for design in designs)
    best = [design for design in designs if design.figure(share) == most]
    cheapest = min(design.figure(slices) or math.inf for design in best)
    with opened(browser, page) as tab:
        tab.click("[aria-label='only best: share reaching goal']")
        assert shown(tab) == f"{len(best)} of 96 points shown"
        tab.click("[aria-label='go to best: slices']")
        details = tab.inner_text("#details")
        assert figure_cell(slices, cheapest).text in details.split("\n")
        assert figure_cell(share, most).text in details.split("\n")
        assert "share reaching goal" in tab.inner_text("#filtered")


def test_filters_sliders_and_levels_show_what_they_keep(browser: Any, page: Path) -> None:
    iterations = STUDY.axes["relax.iterations"]
    with opened(browser, page) as tab:
        tab.uncheck("#filter-axes fieldset:nth-child(1) label:nth-of-type(1) input")
        kept = [i for i in STUDY.feasible if STUDY.designs[i].axes["relax.block"] != [12, 22]]
        assert shown(tab).startswith(f"{len(kept)} of ")
        tab.click(f"[aria-label='only iterations {iterations[2]}']")
        kept = [i for i in kept if STUDY.designs[i].axes["relax.iterations"] == iterations[2]]
        assert shown(tab).startswith(f"{len(kept)} of ")
        tab.click("#clear-filters")
        assert shown(tab).startswith(f"{len(STUDY.feasible)} of ")
        tab.focus("[aria-label='most slices']")
        tab.keyboard.press("ArrowLeft")
        values = sorted({STUDY.designs[i].figure(FIGURES["slices"]) or 0 for i in STUDY.feasible})
        kept = [i for i in STUDY.feasible if (STUDY.designs[i].figure(FIGURES["slices"]) or 0) < values[-1]]
        assert shown(tab).startswith(f"{len(kept)} of ")


def test_infeasible_points_are_shown_on_demand_with_what_they_lack(browser: Any, page: Path) -> None:
    out = next(i for i in STUDY.distinct if i not in STUDY.feasible)
    with opened(browser, page) as tab:
        before = shown(tab)
        tab.check("#show-all")
        tab.select_option("#choose-x", "f:slices")
        tab.select_option("#choose-y", "f:misses")
        assert shown(tab) != before
        tab.select_option("#choose-rows", "infeasible")
        tab.click(f"[data-place='{out}']")
        details = tab.inner_text("#details")
        reason = STUDY.points[out].reasons[0]
        assert "not feasible" in details
        assert f"slices {reason.demand:,} against {reason.limit:,} (gap {reason.gap:,})" in details
        assert part_cell(reason.gap, reason.limit).text in details


def test_any_axis_or_figure_can_be_placed_coloured_and_shaped_by(browser: Any, page: Path) -> None:
    with opened(browser, page) as tab:
        for select in ("#choose-x", "#choose-y", "#choose-colour", "#choose-shape"):
            for value in tab.eval_on_selector_all(f"{select} option", "(all) => all.map((each) => each.value)"):
                tab.select_option(select, value)
                assert shown(tab)
                assert tab.locator("#plot canvas").count() == 1
            tab.select_option(select, "a:relax.block")
        assert "12×22" in tab.inner_text("#key")


def test_the_plot_is_used_with_the_keyboard(browser: Any, page: Path) -> None:
    with opened(browser, page) as tab:
        tab.focus("#plot")
        tab.keyboard.press("End")
        first = tab.inner_text("#details-title")
        assert f"{first.lower()}:" in tab.inner_text("#said").lower()
        seen = {first}
        for key in ("ArrowRight", "ArrowRight", "ArrowDown", "ArrowUp", "ArrowLeft", "Home"):
            tab.keyboard.press(key)
            seen.add(tab.inner_text("#details-title"))
        assert len(seen) > 2
        tab.keyboard.press("Space")
        assert "chosen=" in tab.url
        tab.keyboard.press("Enter")
        assert tab.evaluate("document.activeElement.id") == "details"
        tab.keyboard.press("Escape")
        assert tab.evaluate("document.activeElement.id") == "plot"
        assert "Choose a point" in tab.inner_text("#details")
        tab.keyboard.press("+")
        shown(tab)
        assert "zoom=" in tab.url
        tab.keyboard.press("0")
        shown(tab)
        assert "zoom=" not in tab.url


def test_the_mouse_opens_marks_and_zooms(browser: Any, page: Path) -> None:
    with opened(browser, page) as tab:
        tab.locator("#plot").scroll_into_view_if_needed()
        box = tab.locator("#plot .u-over").bounding_box()
        tab.mouse.move(box["x"] + 3, box["y"] + 3)
        tab.mouse.down()
        tab.mouse.move(box["x"] + box["width"] - 3, box["y"] + box["height"] - 3, steps=4)
        tab.mouse.up()
        assert shown(tab)
        assert tab.input_value("#choose-rows") == "chosen"
        assert tab.inner_text("#row-count").startswith(f"{len(STUDY.feasible)} points")
        tab.select_option("#choose-drag", "zoom")
        tab.mouse.move(box["x"] + 5, box["y"] + 5)
        tab.mouse.down()
        tab.mouse.move(box["x"] + 200, box["y"] + 200, steps=4)
        tab.mouse.up()
        shown(tab)
        assert "zoom=" in tab.url


def test_the_address_holds_what_is_seen(browser: Any, page: Path) -> None:
    with opened(browser, page) as tab:
        tab.select_option("#choose-x", "f:energy_j")
        tab.select_option("#choose-shape", "a:relax.block")
        tab.click("[aria-label='only best: slices']")
        tab.check("#show-all")
        count = shown(tab)
        tab.click("[aria-label='go to best: energy']")
        address, title = "#" + tab.url.partition("#")[2], tab.inner_text("#details-title")
    with opened(browser, page, address) as other:
        assert other.input_value("#choose-x") == "f:energy_j"
        assert other.input_value("#choose-shape") == "a:relax.block"
        assert other.is_checked("#show-all")
        assert shown(other) == count
        assert other.inner_text("#details-title") == title


@pytest.mark.parametrize(
    "address",
    [
        "#x=f:none&y=%00&view=99&zoom=a..b&f:slices=5..&a:relax.block=9.-1.x&point=1e9&chosen=a.b&rows=q&logx=7",
        "#" + "&".join(f"f:slices={n}..{n}" for n in range(300)),
        "#%E0%A4%A",
        "#view=facets",
        "#x=__proto__&constructor=1&a:relax.block=",
    ],
)
def test_an_address_that_says_nonsense_does_no_harm(browser: Any, page: Path, address: str) -> None:
    with opened(browser, page, address) as tab:
        assert "of 96 points shown" in shown(tab)


def test_nothing_feasible_is_a_full_page(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    study_page(a_hopeless_study(), path)
    with opened(browser, path) as tab:
        assert "Nothing is feasible" in tab.inner_text("main")
        assert shown(tab) == "6 of 6 points shown" or shown(tab) == "0 of 6 points shown"
        tab.select_option("#choose-x", "f:misses")
        assert tab.locator("#points tbody tr").count() == 6


def test_hostile_names_are_shown_as_they_are(browser: Any, tmp_path: Path) -> None:
    evil = "<img src=x onerror=alert(1)>\"'&</script>"
    study = replace(STUDY, axes={f"x.{evil}": STUDY.axes["relax.block"], **dict([*STUDY.axes.items()][1:])})
    path = tmp_path / "page.html"
    study_page(study, path)
    with opened(browser, path) as tab:
        tab.select_option("#choose-colour", f"a:x.{evil}")
        assert shown(tab)
        assert evil in tab.inner_text("#key")
        assert tab.locator("img[src=x]").count() == 0


def figures_and_values() -> list[tuple[ResultFigure, float]]:
    drawn, pairs = random.Random(5), []
    kinds = [ResultFigure("x", "", "", unit=unit) for unit in ("s", "Hz", "W", "J", "1", "cells", "m/s", "bits")]
    kinds += [FIGURES["slices"], FIGURES["share_reaching_goal"], FIGURES["precision"]]
    for figure in kinds:
        values = [0.0, 1.0, 0.5, 2.5, 0.125, 1234.5, 12345.0, 9999.5, 0.00012345, 1e15, 3.3e22, 999.95, 1e-13]
        values += [10 ** drawn.uniform(-14, 16) for _ in range(150)]
        values += [drawn.randrange(1, 10**6) / 2 ** drawn.randrange(0, 12) for _ in range(150)]
        values += [round(drawn.uniform(0, 1), drawn.randrange(1, 7)) for _ in range(100)]
        if figure.unit not in {"Hz", "W", "J"} and figure.counted == "measure":
            values += [-value for value in values[:200]]
        pairs += [(figure, value) for value in values if figure.counted != "share" or value <= 1]
    return pairs


def test_numbers_are_written_as_the_tables_write_them(browser: Any) -> None:
    pairs = figures_and_values()
    expected = [figure_cell(figure, value).text for figure, value in pairs]
    expected += [part_cell(value, 1.0).text for _, value in pairs if value >= 0]
    told = [[value, {"unit": figure.unit, "counted": figure.counted}] for figure, value in pairs]
    told += [[value, {"unit": "1", "counted": "part"}] for _, value in pairs if value >= 0]
    dimensions = {"s": Dimension.TIME, "Hz": Dimension.FREQUENCY, "W": Dimension.POWER, "J": Dimension.ENERGY}
    bases = {"s": "ps", "Hz": "Hz", "W": "W", "J": "J"}
    scales = {
        unit: {"base": bases[unit], "units": [(name, float(size)) for name, size in shown_units(dimension)]}
        for unit, dimension in dimensions.items()
    }
    tab = browser.new_page()
    script = "([told, scales]) => { %s; return told.map(([v, f]) => makeNumbers(scales).text(v, f)); }"
    texts = tab.evaluate(script % template_text("numbers.js"), [told, scales])
    wrong = [(pair, text, own) for pair, text, own in zip(told, expected, texts, strict=True) if text != own]
    assert wrong == []
    assert quantity_text(math.inf, "s") == "inf"


def test_the_line_of_the_plot_is_the_front_of_its_two_figures(browser: Any) -> None:
    from codesign.study.front import non_dominated

    drawn = random.Random(1)
    xs, ys = ([drawn.randrange(12) for _ in range(60)] for _ in range(2))
    tab = browser.new_page()
    script = """([xs, ys, maximiseX, maximiseY]) => { %s;
      const points = makePoints({ points: xs, main: 0, axes: [], frames: [{ figures: [] }] }, null);
      const x = { key: "x", values: xs, maximise: maximiseX }, y = { key: "y", values: ys, maximise: maximiseY };
      return points.staircase([...xs.keys()], x, y, xs.map(() => 1)); }"""
    for maximise in ([False, False], [True, False], [False, True], [True, True]):
        front = np.flatnonzero(non_dominated(np.column_stack([xs, ys]).astype(float), maximise))
        line = tab.evaluate(script % template_text("study/points.js"), [xs, ys, *maximise])
        assert {(xs[i], ys[i]) for i in line} == {(xs[i], ys[i]) for i in front}
        assert [xs[i] for i in line] == sorted(xs[i] for i in line)


@pytest.fixture(scope="module")
def conditions_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    iterations = STUDY.axes["relax.iterations"]
    axes = {name: values for name, values in STUDY.axes.items() if name != "relax.iterations"}
    # The last axis of the points becomes a condition.
    order = np.arange(len(STUDY.outcomes)).reshape(4, len(iterations), 2).transpose(0, 2, 1).reshape(-1)
    study = replace(
        STUDY, axes=axes, conditions={"relax.iterations": iterations}, outcomes=STUDY.outcomes.chosen(order)
    )
    path = tmp_path_factory.mktemp("pages") / "conditions.html"
    study_page(study, path)
    return path


def test_conditions_are_aggregated_shown_by_themselves_or_side_by_side(browser: Any, conditions_page: Path) -> None:
    with opened(browser, conditions_page) as tab:
        assert shown(tab) == "6 of 8 designs shown"
        tab.select_option("#choose-view", "2")
        assert shown(tab).endswith("designs shown")
        assert "view=2" in tab.url
        tab.select_option("#choose-view", "facets")
        assert shown(tab) == "6 of 8 designs shown"
        assert tab.locator("#plot canvas").count() == 12
        tab.focus("#plot")
        tab.keyboard.press("End")
        assert tab.locator("#details tbody tr").count() == 12
        tab.select_option("#choose-view", "0")
        assert shown(tab)
        assert tab.locator("#plot canvas").count() == 1


def test_many_points_are_drawn_in_squares(browser: Any, page: Path, tmp_path: Path) -> None:
    binned = tmp_path / "binned.html"
    html = page.read_text(encoding="utf-8")
    assert "const BINNED = 25000;" in html
    binned.write_text(html.replace("const BINNED = 25000;", "const BINNED = 10;"), encoding="utf-8")
    with opened(browser, binned) as tab:
        assert painted(tab) > 100
        assert "Squares stand for all points in them" in tab.inner_text("#filtered")


def test_without_scripts_the_tables_stand(browser: Any, page: Path) -> None:
    context = browser.new_context(java_script_enabled=False)
    tab = context.new_page()
    tab.goto(page.as_uri())
    assert "need JavaScript" in tab.inner_text("main")
    assert "Best in each objective" in tab.inner_text("main")
    context.close()
