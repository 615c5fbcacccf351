"""Designs that are drawn at random contradict no answer: a small set of the questions of the benchmark."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.bench_advice_oracle import Asked, hunt
from codesign.study import advice

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
