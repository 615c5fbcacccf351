"""The page of a reproduction: its score, its plots, and how it looks in a real browser."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from browser import opened, stands_at_any_width
from page_data import Page
from report_samples import ROWS, a_reproduction

from codesign.ground.errors import RunError
from codesign.planners.reproduction import Reproduction, Row, Use
from codesign.views.report.reproduction_page import (
    against,
    missed_table,
    reproduction_html,
    reproduction_page,
    score_of,
    score_table,
    scores,
    strips,
    unheld_table,
    why_unheld,
)

EVIL = "<script>alert(1)</script>\"'&</style>]]><!--"


def a_row(published: float | str | None, modelled: float | str | None, **changes: Any) -> Row:
    error = None
    if isinstance(published, int | float) and isinstance(modelled, int | float) and published:
        error = (modelled - published) / published
    return replace(ROWS[0], published=published, modelled=modelled, error=error, **changes)


def papers() -> list[Reproduction]:
    rows = [a_row(100, 100 + percent) for percent in (0, 1, -1, 1.01, 5, -5.01, 10, -10, 10.01, -50, 900)]
    rows += [a_row(None, 1), a_row("≤ 3", 2), a_row(0, 0), a_row(7, "more"), a_row(7, None)]
    missed = a_row(2.0, 1.0, table=EVIL, quantity=EVIL, note=EVIL, use=Use.HELD_OUT)
    second = a_reproduction(paper=f"Saudi 2016 {EVIL}", rows=(*rows, missed))
    return [a_reproduction(), second]


def test_every_row_is_counted_once_and_bounds_count_those_before() -> None:
    score = score_of("x", papers()[1].rows)
    assert score.within == (3, 5, 8)
    assert (score.missed, score.unheld, score.compared) == (4, 5, 12)
    assert score.parts == (3, 2, 3, 4, 5)
    assert sum(score.parts) == score.rows == 17
    assert (score.held_out, score.held_out_met) == (1, 0)


def test_all_papers_come_last_and_one_paper_has_no_sum() -> None:
    names = [score.name for score in scores(papers())]
    assert names == ["Girau 2008", "Saudi 2016", "all papers"]
    assert scores(papers())[-1].rows == 21
    assert [score.name for score in scores(papers()[:1])] == ["Girau 2008"]
    assert score_table(scores(papers())).strong == {2}
    assert not score_table(scores(papers()[:1])).strong


def test_missed_rows_come_worst_first_and_the_others_say_why_they_cannot_be_held() -> None:
    errors = [row[5].value for row in missed_table(papers()).rows]
    assert errors == [9.0, -0.5, -0.5, pytest.approx(0.1001)]
    reasons = [row[5].text for row in unheld_table(papers()).rows]
    assert reasons[1:] == [
        "the paper gives no figure",
        "the paper gives words or a bound",
        "the paper gives 0, which no error is relative to",
        "the model gives words or a bound",
        "the model gives no figure",
    ]
    assert why_unheld(ROWS[3]) == "the model gives no figure"


def test_a_mark_on_the_line_is_a_row_that_is_met() -> None:
    plot = against([a_reproduction(rows=(a_row(1, 1), a_row(1000, 1000), a_row(10, 100), a_row(0, 1)))])
    assert plot is not None
    left, top, right, bottom = plot.frame
    assert len(plot.marks) == 3
    places = [((mark.x - left) / (right - left), (bottom - mark.y) / (bottom - top)) for mark in plot.marks]
    assert places[0] == (0.0, 0.0)
    assert places[1] == (1.0, 1.0)
    assert places[2] == pytest.approx((1 / 3, 2 / 3), abs=1e-3)
    assert against([a_reproduction(rows=(a_row("a", "b"),))]) is None


def test_errors_keep_their_order_and_hide_no_other() -> None:
    first, second = strips(papers())
    assert len(first.marks) == 3
    assert [mark.x for mark in second.marks] == sorted(mark.x for mark in second.marks)
    assert len({(mark.x, mark.y) for mark in second.marks}) == len(second.marks)
    assert all(0 < mark.x < 100 and 0 < mark.y < second.height for mark in second.marks)
    assert strips([a_reproduction(rows=(a_row("a", "b"),))]) == ()


def test_a_page_leads_with_its_score() -> None:
    text = " ".join(Page(reproduction_html(papers())).text.split())
    head = ["21 rows of 2 papers; 15 have figures on both sides", "5 within 1 %", "6 cannot be held", "Score"]
    body = ["Published against computed", "Missed rows", "Rows that cannot be held", "Findings", "All rows"]
    places = [text.index(each) for each in (*head, *body)]
    assert places == sorted(places)


def test_a_page_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("kept")
    with pytest.raises(RunError, match=r"page\.html"):
        reproduction_page(papers(), tmp_path / "file" / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.slow
def test_a_reproduction_stands_at_any_width_in_both_colours_and_on_paper(browser: Any, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    reproduction_page(papers(), path)
    stands_at_any_width(browser, path)
    with opened(browser, path, viewport={"width": 400, "height": 900}, color_scheme="dark") as tab:
        box = tab.locator("svg.against").bounding_box()
        assert 300 < box["width"] < 400
        assert tab.locator(".against .mark").count() == 15
        assert tab.locator(".strips .mark").count() == 15
        assert tab.locator("script").count() == 1
        colour = "getComputedStyle(document.querySelector('.hue-0')).fill"
        dark = tab.evaluate(colour)
        tab.emulate_media(media="print")
        assert tab.locator("svg.against").is_visible()
        assert tab.evaluate(colour) != dark
