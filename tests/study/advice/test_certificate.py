"""The certificate of an answer: accepted as it is written, refused where one of its steps does not follow."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from advice_boards import FABRIC, Run, asked, board, priced

from codesign.study.advice.certificate import Certificate


@pytest.fixture
def certificate(hwsw: Run, corridor: Path, tmp_path: Path) -> Path:
    """Of a question whose answer is the dearest of three boards; a fabric is among the cheaper ones."""
    fabric = tmp_path / "fabric.yaml"
    fabric.write_text(FABRIC, encoding="utf-8")
    boards = [
        priced(board(tmp_path, "quick", 0.001), 90),
        priced(board(tmp_path, "slow", 1000), 20),
        priced(fabric, 50),
    ]
    path = tmp_path / "answer.cert"
    code, answer = asked(hwsw, corridor, boards, "1 MHz", "--certify", path)
    assert (code, answer["recommended"]) == (0, "quick")
    assert answer["proof"]["boards"] == 2
    return path


def test_a_certificate_is_accepted_and_counts_every_design(hwsw: Run, certificate: Path) -> None:
    result = hwsw("verify-advice", certificate, "--json")
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    content = json.loads(certificate.read_text(encoding="utf-8"))
    assert document["designs"]["left"] == 0
    assert document["designs"]["tried"] > 0
    assert sum(document["designs"].values()) == sum(each["searched"]["designs"] for each in content["boards"])
    assert hwsw("verify-advice", certificate).stdout.startswith("Accepted: no design of 2 boards that cost less than")


def _first(document: Any, states: set[str]) -> Any:
    return next(each for of in document["boards"] for each in of["settled"] if each["state"] in states)


def _a_board_less(document: Any) -> None:
    del document["boards"][0]


def _a_dearer_board(document: Any) -> None:
    document["boards"][0]["price_usd"] = 100


def _a_slow_winner(document: Any) -> None:
    document["winner"]["time_s"] = 1.0


def _a_fast_design(document: Any) -> None:
    tried = document["boards"][0]["tried"][0]
    tried["time_s"], tried["shortfalls"] = 1e-9, []


def _a_weak_bound(document: Any) -> None:
    each = _first(document, {"bound", "counted", "tried", "unfit"})
    each |= {"state": "bound", "time_s": 1e-9}


def _a_bound_of_no_units(document: Any) -> None:
    each = _first(document, {"bound", "counted", "tried", "unfit"})
    each |= {"state": "bound", "units": {}, "time_s": 1e9}


def _a_slow_cycle(document: Any) -> None:
    each = _first(document, {"bound", "counted", "tried", "unfit"})
    each |= {"state": "bound", "units": {"": 1}, "unit_s": {"": 1e9}, "clock_hz": 1e8, "time_s": 1e9}


def _a_small_demand(document: Any) -> None:
    each = _first(document, {"bound", "counted", "tried", "unfit"})
    each |= {"state": "unfit", "resource": "slices", "demand": 1.0, "budget": 2.0}


def _a_design_left(document: Any) -> None:
    document["boards"][0]["searched"]["complete"] = False


def _a_tile_less(document: Any) -> None:
    for each in document["boards"][1]["settled"]:
        each["ranges"] = {"tile rows": [1, 1], "tile columns": [1, 99]}


def _no_rate(document: Any) -> None:
    document["needs"]["rate_hz"] = 0.0


def _a_vast_map(document: Any) -> None:
    document["rows"] = document["columns"] = 10**12


def _cycles_of_many_digits(document: Any) -> None:
    each = _first(document, {"bound", "counted", "tried", "unfit"})
    each |= {"state": "bound", "time_s": 1.0, "clock_hz": 1e6, "units": {"": 10**400}}


def _a_family_of_none_left(document: Any) -> None:
    each = _first(document, {"bound", "counted", "tried", "unfit"})
    document["boards"][0]["settled"].append(each | {"state": "left", "designs": 0})


def _designs_of_no_family(document: Any) -> None:
    document["boards"][0]["searched"]["counted"] += 7
    for each in list(document["boards"][0]["settled"]):
        if each["state"] == "counted":
            document["boards"][0]["settled"].remove(each)


@pytest.mark.parametrize(
    "change",
    [
        _no_rate,
        _a_vast_map,
        _cycles_of_many_digits,
        _a_family_of_none_left,
        _designs_of_no_family,
        _a_board_less,
        _a_dearer_board,
        _a_slow_winner,
        _a_fast_design,
        _a_weak_bound,
        _a_bound_of_no_units,
        _a_slow_cycle,
        _a_small_demand,
        _a_design_left,
        _a_tile_less,
    ],
)
def test_a_step_that_does_not_follow_is_refused(hwsw: Run, certificate: Path, change: Callable[[Any], None]) -> None:
    document = json.loads(certificate.read_text(encoding="utf-8"))
    change(document)
    certificate.write_text(json.dumps(document), encoding="utf-8")
    result = hwsw("verify-advice", certificate)
    assert (result.exit_code, "the file was changed" in result.output) == (1, True)
    # With a digest of the changed content, the step itself is refused.
    changed = Certificate.model_validate_json(certificate.read_text(encoding="utf-8"))
    document["digest"] = changed.content
    certificate.write_text(json.dumps(document), encoding="utf-8")
    result = hwsw("verify-advice", certificate)
    assert (result.exit_code, "refused: " in result.output) == (3, True), result.output


@pytest.mark.parametrize("text", ["", "{}", "[1", '{"kind": "advice certificate"}', "\x00\xff"])
def test_a_file_that_is_no_certificate(hwsw: Run, tmp_path: Path, text: str) -> None:
    path = tmp_path / "none.cert"
    path.write_text(text, encoding="utf-8")
    result = hwsw("verify-advice", path)
    assert result.exit_code == 1, result.output
    assert "no certificate of an answer about boards" in result.output
    assert "hint: hwsw advise --certify FILE writes one" in result.output


def test_a_file_of_another_kind_is_not_replaced(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    path = tmp_path / "mine.txt"
    path.write_text("a letter", encoding="utf-8")
    words = ("--goal", "0,0", "--rate", "1 Hz", "--boards", board(tmp_path, "quick", 1), "--certify", path)
    result = hwsw("advise", corridor, *words)
    assert (result.exit_code, path.read_text(encoding="utf-8")) == (2, "a letter")


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_certificate_with_a_number_that_is_none(hwsw: Run, certificate: Path, number: float) -> None:
    document = json.loads(certificate.read_text(encoding="utf-8"))
    document["winner"]["time_s"] = number
    certificate.write_text(json.dumps(document), encoding="utf-8")
    result = hwsw("verify-advice", certificate)
    assert (result.exit_code, "no certificate of an answer" in result.output) == (1, True), result.output


def test_a_certificate_that_was_cut_at_any_place(hwsw: Run, certificate: Path) -> None:
    content = certificate.read_bytes()
    for share in (0.0, 0.1, 0.5, 0.9, 0.999):
        certificate.write_bytes(content[: int(len(content) * share)])
        result = hwsw("verify-advice", certificate)
        assert (result.exit_code, "no certificate of an answer" in result.output) == (1, True), result.output


def test_a_file_that_never_ends_is_not_read(hwsw: Run, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, Path("/dev/zero")):
        result = hwsw("verify-advice", path)
        assert (result.exit_code in (1, 2), "hint: " in result.output or "Error: " in result.output) == (True, True)
