"""The page of an answer about boards: it says what the answer says, and looks well in a real browser."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from advice_boards import CELLS, Run, board, priced
from browser import assert_tables_fit, opened, stands_at_any_width
from page_data import Page

from codesign.study import advice
from codesign.study.advice import Advice, Question
from codesign.views.report.advice_page import PathKeeper, advice_html, advice_page, price_chart, speed_chart

EVIL = "<img src=x onerror=alert(1)>\"'&.txt"


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))


def answered(
    folder: Path, rate: str | None = None, name: str = "map.txt", **motion: str
) -> tuple[Advice, Question, Any]:
    """Five boards, the dearer the quicker; one has no price."""
    (folder / name).write_text("." * CELLS + "\n", encoding="utf-8")
    files = [priced(board(folder, f"board{number}", 10.0**number), 1000 // 3**number) for number in range(4)]
    moving = advice.parse_motion(*(motion.get(key) for key in ("speed", "sight", "brake", "sensor", "delay")))
    needs = advice.parse_needs(rate, motion=moving)
    section = advice.problem_section(folder / name, ["0,0"], [f"0,{CELLS - 1}"], needs)
    question, keeper = advice.ask(needs, section, folder / name), PathKeeper()
    boards = advice.boards_of([str(file) for file in (*files, board(folder, "unpriced", 5.0))])
    return advice.advise(question, boards, listeners=[keeper]), question, keeper.paths


def test_a_page_has_the_question_the_verdict_every_board_and_the_command(tmp_path: Path) -> None:
    answer, question, paths = answered(tmp_path, sight="4m", brake="2m/s^2")
    page = Page(advice_html(answer, question, paths, "hwsw advise map.txt"))
    text = " ".join(page.text.split())
    order = [
        answer.question,
        answer.verdict,
        answer.driving,
        "Run the recommended design",
        "How sure it is",
        "All boards",
    ]
    places = [text.index(" ".join(each.split())) for each in order]
    assert places == sorted(places)
    assert answer.command is not None
    assert " ".join(answer.command.split()) in text
    assert "hwsw advise map.txt" in text
    rows = [each for each in page.elements if each[0] == "tr"]
    assert len(rows) >= 1 + len(answer.boards)
    assert all(text.count(each.board) >= 3 for each in answer.boards)
    assert all(dict(each[1]).get("scope") == "col" for each in page.elements if each[0] == "th")
    assert all(each[1]["alt"] for each in page.elements if each[0] == "img")
    assert all(each[1]["aria-label"] for each in page.elements if each[0] == "svg" and each[1].get("role") == "img")
    assert len(paths) == 1
    assert "from 1 of 1 start" in text


def test_the_marks_stand_where_the_figures_of_the_answer_are(tmp_path: Path) -> None:
    answer, _, _ = answered(tmp_path, "300 Hz", sight="4m", brake="2m/s^2")
    chart = price_chart(answer)
    assert chart is not None
    shown = {mark.name: mark for mark in chart.marks}
    assert set(shown) == {each.board for each in answer.boards if each.price_usd}
    (line, words), *_ = chart.levels
    assert words == "asked: 300 Hz"
    for each in answer.boards:
        if each.board not in shown:
            assert f"Not drawn, as a figure is missing: {each.board}." in chart.notes
            continue
        mark, design = shown[each.board], each.design
        assert design is not None
        assert design.rate_hz is not None
        assert mark.ends is not None
        # Higher is quicker: the line of the need parts those that suffice from the others.
        assert (mark.y <= line) == each.suffices == (design.rate_hz >= 300)
        assert mark.ends[1] < mark.y < mark.ends[0] or mark.ends[0] < mark.y < mark.ends[1]
        assert mark.kind == ("best" if each.board == answer.recommended else "plain" if each.suffices else "short")
        assert answer.boards[mark.number - 1] is each
    # Prices are factors of 3 and times factors of 10: the marks stand on a line.
    marks = [shown[f"board{number}"] for number in range(4)]
    steps = [(after.x - before.x, after.y - before.y) for before, after in pairwise(marks)]
    assert all(step == pytest.approx(steps[0], abs=0.6) for step in steps)
    drives = speed_chart(answer)
    assert drives is not None
    assert {mark.name for mark in drives.marks} == set(answer.driven)
    falls = sorted(drives.marks, key=lambda mark: mark.x)
    assert [mark.y for mark in falls] == sorted(mark.y for mark in falls)
    corners = [tuple(map(float, each.split())) for each in drives.curve[1:].split("L")]
    for mark in drives.marks:
        near = min(corners, key=lambda corner: abs(corner[0] - mark.x))
        assert near[1] == pytest.approx(mark.y, abs=3)


def test_nothing_is_asked_of_the_network_and_a_hostile_name_is_text(tmp_path: Path) -> None:
    answer, question, paths = answered(tmp_path, "300 Hz", EVIL)
    html = advice_html(answer, question, paths)
    assert EVIL in Page(html).text
    assert "<img src=x" not in html
    for tag, attributes in Page(html).elements:
        for name in ("src", "href", "data", "action"):
            assert (attributes.get(name) or "data:").startswith("data:"), tag
    assert not re.findall(r"url\(|@import|https?:", html)


def test_where_no_board_suffices_the_page_has_no_command(hwsw: Run, tmp_path: Path) -> None:
    (tmp_path / "map.txt").write_text("." * CELLS + "\n", encoding="utf-8")
    slow, page = board(tmp_path, "slow", 10_000), tmp_path / "page.html"
    words = ("advise", tmp_path / "map.txt", "--goal", "0,0", "--boards", slow, "--rate", "1 kHz", "--html", page)
    result = hwsw(*words)
    assert result.exit_code == 3
    assert f"page: {page}" in result.output
    html = page.read_text(encoding="utf-8")
    text = " ".join(Page(html).text.split())
    assert "No board suffices" in text
    assert "Run the recommended design" not in text
    assert "0 paths" not in html
    # It is made again with the command that stands on it, over the page that is there.
    assert "--rate '1 kHz'" in text
    assert hwsw(*words).exit_code == 3


@pytest.mark.slow
def test_a_page_stands_at_any_width_in_both_colours_and_on_paper(browser: Any, tmp_path: Path) -> None:
    answer, question, paths = answered(tmp_path, speed="3.5m/s", sight="4m", brake="2m/s^2")
    page = tmp_path / "page.html"
    advice_page(answer, question, page, paths=paths)
    stands_at_any_width(browser, page)
    assert_tables_fit(browser, page)
    for width in (1200, 390):
        with opened(browser, page, viewport={"width": width, "height": 900}) as tab:
            inside = """[...document.querySelectorAll(".plot text, .plot circle")].filter((each) => {
              const box = each.getBoundingClientRect(), frame = each.closest("figure").getBoundingClientRect();
              return box.left < frame.left || box.right > frame.right || box.bottom > frame.bottom;
            }).map((each) => each.textContent)"""
            assert tab.evaluate(inside) == []
            # Labels of one axis do not touch.
            touching = """[...document.querySelectorAll(".plot .area")].flatMap((area) => {
              const boxes = [...area.querySelectorAll("text[text-anchor=middle]:not([class])")]
                .map((each) => each.getBoundingClientRect()).sort((one, two) => one.left - two.left);
              return boxes.slice(1).filter((box, k) => boxes[k].right > box.left).map((box) => box.left);
            })"""
            assert tab.evaluate(touching) == []
