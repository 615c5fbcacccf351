"""Designs that are drawn at random contradict no answer: a small set of the questions of the benchmark."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest

from benchmarks.bench_advice_oracle import Asked, hunt, is_beyond
from codesign.study import advice
from codesign.study.advice.candidates import arrangements_of
from codesign.views.report.advice_page import advice_table

BOARDS = "pico-2", "cmod-a7-35t", "pynq-z2", "zcu104"

QUESTIONS = (
    Asked("empty", 20, "200kHz", BOARDS),
    Asked("maze", 16, "40kHz", BOARDS),
    Asked("random", 24, "100kHz", BOARDS, {"on": "fabric"}),
    Asked("empty", 60, "1MHz", BOARDS),
)


@pytest.mark.parametrize("asked", QUESTIONS, ids=str)
def test_no_drawn_design_suffices_where_the_answer_says_that_none_does(asked: Asked, tmp_path: Path) -> None:
    question, boards = asked.question(tmp_path), advice.boards_of(asked.boards)
    answer = advice.advise(question, boards)
    outcome = hunt(answer, question, boards, count=40, most_s=2.0)
    assert answer.proof.state == "not proved" or not outcome.finds
    assert not answer.proof.boards or outcome.ran


def test_an_answer_that_overlooks_a_board_is_contradicted(tmp_path: Path) -> None:
    """The net is no sieve: where the answer forgets a board that suffices, drawing finds a design on it."""
    asked = Asked("empty", 16, "1kHz", BOARDS)
    question, boards = asked.question(tmp_path), advice.boards_of(asked.boards)
    answer = advice.advise(question, boards)
    assert answer.recommended == "pico-2"
    wrong = answer.model_copy(update={"recommended": "zcu104"})
    assert hunt(wrong, question, boards, count=200, most_s=4.0).finds


@pytest.mark.parametrize("name", ["pynq-z2", "raspberry-pi-4"])
def test_no_design_of_a_family_is_beyond_the_space_that_the_answer_names(name: str, tmp_path: Path) -> None:
    asked = Asked("empty", 12, "1kHz", (name,))
    question, (board,) = asked.question(tmp_path), advice.boards_of(asked.boards)
    for each in arrangements_of(board, question.problem, question.needs):
        for design in (design for family in islice(each.families(), 40) for design in family.chain):
            assert not is_beyond(each.planner.name, each.style.style, design), (each.style.style, design)


def test_what_an_answer_says_nothing_of_is_named(tmp_path: Path) -> None:
    asked = Asked("empty", 12, "1MHz", BOARDS)
    answer = advice.advise(asked.question(tmp_path), advice.boards_of(asked.boards))
    corners = "grid_search software: paths that cut the corners of obstacles"
    assert corners in answer.proof.beyond
    assert is_beyond("grid_search", "software", {"method": "astar", "corner_cutting": True})
    assert corners in " ".join(advice_table(answer).notes)
