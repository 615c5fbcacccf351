"""The page of a comparison: what it says, and how it looks in a real browser."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from browser import opened, stands_at_any_width
from page_data import Page
from report_samples import a_result
from shipped_plans import design, result_of

from codesign.ground.errors import Fault, RunError, SpecError
from codesign.ground.figures import FIGURES
from codesign.inputs.constraint import constraint_of
from codesign.views.report import comparison_page
from codesign.views.report.comparison_page import Designs, bar_chart, comparison_html

EVIL = "<script>alert(1)</script>\"'&</style>]]><!--"
FAULT = SpecError([Fault("mine.yaml", 3, 5, "map", f"no path leads from start (1, 2) {EVIL}", "move the start")])
SURE = ("zynq", "wavefront-tiles"), ("virtex4-pci", "wavefront-tiles")


def designs() -> Designs:
    return [
        *((":".join(names), result_of(design(*names))) for names in SURE),
        (f"mine:{EVIL}", FAULT),
        ("too:large", a_result(slices=40_000)),
    ]


def test_a_page_leads_with_the_winners_and_how_sure_they_are() -> None:
    page = Page(comparison_html(designs(), needs=[constraint_of("slices < 30000")]))
    order = ["2 of 4 feasible", "least slices: ", "how sure", "Needs", "Why designs are not feasible", "Each design"]
    text = " ".join(page.text.split())
    places = [text.index(each) for each in order]
    assert places == sorted(places)
    assert "holds: it rests on no assumed figure" in text
    assert "met (proved)" in text
    assert "slices: 40,000 against 33,792" in text
    assert "no path leads from start (1, 2) <script>" in text
    assert "move the start" in text
    assert len(page.scripts) == 1


def test_each_bar_ends_at_its_value_and_each_whisker_at_its_interval() -> None:
    names, results = zip(*((":".join(each), result_of(design(*each))) for each in SURE), strict=True)
    energy = FIGURES["energy_j"]
    chart = bar_chart(names, results, energy, names[0])
    assert chart is not None
    assert chart.whiskers
    assert [bar.kind for bar in chart.bars] == ["best", "plain"]
    by_value = sorted(zip(results, chart.bars, strict=True), key=lambda pair: pair[0].figure(energy) or 0)
    ends = [bar.end or 0 for _, bar in by_value]
    assert ends == sorted(ends)
    for bar in chart.bars:
        assert bar.low is not None
        assert bar.high is not None
        assert bar.end is not None
        assert 0 <= bar.low < bar.end < bar.high <= 100
    assert 2 <= len(chart.ticks) <= 5


def test_a_linear_axis_begins_at_nothing_and_a_chart_of_equals_is_not_drawn() -> None:
    slices = FIGURES["slices"]
    results = [a_result(slices=30_000), a_result(slices=15_000), None]
    chart = bar_chart(["a", "b", "c"], results, slices, "b")
    assert chart is not None
    assert not chart.logarithmic
    assert chart.bars[0].end == pytest.approx(2 * (chart.bars[1].end or 0), rel=1e-4)
    assert chart.bars[2].end is None
    assert chart.bars[2].text == "did not run"
    assert chart.ticks[0] == (0.0, "0")
    wide = bar_chart(["a", "b"], [a_result(slices=30_000), a_result(slices=30)], slices, "b")
    assert wide is not None
    assert wide.logarithmic
    assert [text for _, text in wide.ticks] == ["10", "100", "1,000", "10,000", "100,000"]
    assert bar_chart(["a", "b"], [a_result(), a_result()], slices, None) is None
    assert bar_chart(["a"], [a_result()], slices, None) is None


def test_where_one_design_alone_is_feasible_its_figures_lead() -> None:
    text = " ".join(Page(comparison_html([("a:b", FAULT), ("small:one", a_result())])).text.split())
    assert "1 of 2 feasible" in text
    assert "31,500 slices: small:one" in text
    assert "Which design is best" not in text


def test_a_comparison_without_a_result_is_a_full_page() -> None:
    assert "did not run" in Page(comparison_html([("a:b", FAULT)])).text


def test_a_page_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("kept")
    with pytest.raises(RunError, match=r"page\.html"):
        comparison_page(designs(), tmp_path / "file" / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.slow
def test_a_comparison_stands_at_any_width_in_both_colours_and_on_paper(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    comparison_page(designs(), path, needs=[constraint_of("slices < 30000")])
    stands_at_any_width(browser, path)
    with opened(browser, path, viewport={"width": 400, "height": 900}) as tab:
        widths = tab.eval_on_selector_all(
            ".bar-chart rect", "(all) => all.map((each) => each.getBoundingClientRect().width)"
        )
        assert max(widths) > 200
        tab.keyboard.press("Tab")
        assert tab.evaluate("document.activeElement.getAttribute('role')") == "region"
        tab.focus("summary")
        tab.keyboard.press("Enter")
        assert tab.locator("details[open] table").first.is_visible()
        tab.emulate_media(media="print")
        assert tab.locator(".bar-chart").first.is_visible()
