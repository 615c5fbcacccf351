"""A second question about a map takes what the first one settled, and its answer is that of a first question."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.bench_advice_oracle import Asked
from codesign.study import advice
from codesign.study.advice.candidates import arrangements_of
from codesign.study.advice.certificate import faults_of, read_certificate
from codesign.study.advice.trials import Laboratory

BOARDS = "pico-2", "cmod-a7-35t", "pynq-z2", "zcu104"


def answer(asked: Asked, folder: Path, cache: Path, patch: pytest.MonkeyPatch) -> advice.Advice:
    patch.setenv("CODESIGN_CACHE_DIR", str(cache))
    certificate = folder / "answer.cert"
    found = advice.advise(asked.question(folder), advice.boards_of(BOARDS), certificate=certificate)
    assert not list(faults_of(read_certificate(certificate)))
    return found


@pytest.mark.parametrize(
    ("first", "second"), [("1MHz", "800kHz"), ("1MHz", "400kHz"), ("300kHz", "1MHz"), ("150kHz", "150kHz")]
)
def test_what_an_earlier_question_settled_changes_no_answer(
    first: str, second: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def at(rate: str, cache: str) -> advice.Advice:
        return answer(Asked("rooms", 30, rate, BOARDS), tmp_path, tmp_path / cache, monkeypatch)

    at(first, "kept")
    again, fresh = at(second, "kept"), at(second, "fresh")
    assert again.kept > fresh.kept
    assert again.simulated < fresh.simulated
    for each in (again, fresh):
        assert each.proof.searched.complete
    assert again.recommended == fresh.recommended
    assert (again.proof.state, again.proof.boards) == (fresh.proof.state, fresh.proof.boards)
    assert again.proof.searched.designs == fresh.proof.searched.designs
    assert again.proof.searched.left == 0
    assert [(each.board, each.suffices, each.perhaps) for each in again.boards] == [
        (each.board, each.suffices, each.perhaps) for each in fresh.boards
    ]


def test_a_trial_of_another_share_of_the_part_is_no_trial_of_this_one(tmp_path: Path) -> None:
    asked = Asked("empty", 12, "1kHz", BOARDS[1:2])
    question, boards = asked.question(tmp_path), advice.boards_of(asked.boards)
    (arrangement, *_) = arrangements_of(boards[0], question.problem, question.needs)
    candidate = arrangement.candidate(next(arrangement.families()).chain[0])
    needs = question.needs.model_copy(update={"share": 0.5})
    other = Laboratory(replace(question, needs=needs))
    assert Laboratory(question).key(candidate) != other.key(candidate)
