"""The bit-serial circuit reports what the plan and the laws expect, event by event and cycle by cycle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from codesign.ground.errors import UnsuitedError
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.verify import verify
from codesign.planners.circuits import Circuit
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.rtl import CIRCUITS
from codesign.planners.interface import Problem
from codesign.planners.job import Job

CIRCUIT, DECISION = CIRCUITS
OPEN = np.ones((7, 13), np.bool_)


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "cache"))


def job(free: Any = OPEN, goals: tuple[tuple[int, int], ...] = ((0, 0),), **changes: Any) -> Job[Any, Any]:
    options = {"block": (7, 13), "iterations": 4, "schedule": (8, 11), **changes}
    return Job(Problem(free, goals, ((3, 5),)), RelaxParameters(**options), position=(3.0, 5.0))


def check(point: Job[Any, Any], circuit: Any = CIRCUIT) -> None:
    if tools.command_of("iverilog") is None:
        pytest.skip("Icarus Verilog is not installed")
    verified = verify(circuit, point, "icarus")
    assert verified.first is None, f"{point.parameters}: {verified.first}"


@pytest.mark.parametrize("seed", [1, 3, 6])
def test_random_points_agree(seed: int) -> None:
    check(CIRCUIT.sample(seed))


@pytest.mark.parametrize("seed", [0, 2])
def test_the_decision_module_by_itself_agrees(seed: int) -> None:
    check(DECISION.sample(seed), DECISION)


@pytest.mark.parametrize("pipeline", [0, 1])
@pytest.mark.parametrize("termination", ["sound", "published"])
def test_four_blocks_agree(pipeline: int, termination: str) -> None:
    check(job(block=(4, 7), pipeline=pipeline, termination=termination))


@pytest.mark.parametrize(
    ("digit_bits", "pipeline", "schedule"),
    [(2, 0, (5, 8)), (2, 1, (11, 15)), (4, 0, (5, 8, 10)), (4, 1, (22,)), (8, 0, (9, 13)), (8, 1, (43, 46))],
)
def test_digits_of_several_bits_agree(digit_bits: int, pipeline: int, schedule: tuple[int, ...]) -> None:
    free = np.ones((3, 8), np.bool_)
    free[1, 2:4] = False
    point = job(free, block=(3, 4), digit_bits=digit_bits, pipeline=pipeline, schedule=schedule)
    check(replace(point, position=(2.0, 5.0)))


def test_rows_of_more_than_64_nodes_are_read_out_in_pieces() -> None:
    check(job(np.ones((2, 70), np.bool_), block=(2, 70), iterations=40))


def test_two_stages_of_the_or_tree_agree() -> None:
    free = np.zeros((18, 18), np.bool_)
    free[9, 9:12] = True
    check(job(free, ((9, 9),), block=(18, 18), schedule=(4,)))


@pytest.mark.slow
@pytest.mark.parametrize("first", range(1000, 1400, 50))
def test_many_random_points_agree(first: int) -> None:
    for seed in range(first, first + 50):
        check(CIRCUIT.sample(seed))


def test_a_pocket_makes_the_run_go_on_to_the_last_stage() -> None:
    free = OPEN.copy()
    free[5, 1:] = free[5:, 1] = False
    free[6, 0] = free[5, 0] = False
    kept, filled = (
        CIRCUIT.expected(job(free, pockets=pockets, schedule=(40, 44))).cycles for pockets in ("kept", "filled")
    )
    assert kept["relax"] > filled["relax"]


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"schedule": (1, 8)}, "relax.schedule"),
        ({"schedule": (5, 8), "pipeline": 1}, "relax.schedule"),
        ({"goals": ((0, 1), (1, 0), (2, 1), (1, 2))}, "problem.goals"),
    ],
)
def test_what_no_circuit_has_is_refused(changes: dict[str, Any], key: str) -> None:
    with pytest.raises(UnsuitedError) as caught:
        CIRCUIT.circuit(job(**changes))
    assert [fault.key for fault in caught.value.faults] == [key]
    assert all(fault.hint for fault in caught.value.faults)


@pytest.mark.parametrize(
    ("file", "before", "after"),
    [
        ("harmonic_decide.v", ".east_step(in_data[PLACE_BITS + 1])", ".east_step(in_data[PLACE_BITS])"),
        ("harmonic_decide.v", ".memory(in_data[PLACE_BITS + 2 +: 3])", ".memory(in_data[PLACE_BITS + 1 +: 3])"),
        ("harmonic_decide.v", "left <= precision + 1'b1", "left <= precision"),
        ("harmonic_decision.v", "rises = second ? b_over : a_over", "rises = second ? a_over : b_over"),
        ("harmonic_decision.v", "b_over_a == total_over", "b_over_a != total_over"),
        ("harmonic_field.v", ".OUTPUT_REGISTER(1)", ".OUTPUT_REGISTER(0)"),
    ],
)
def test_a_fault_in_the_decision_is_found(file: str, before: str, after: str, tmp_path: Path) -> None:
    if tools.command_of("iverilog") is None:
        pytest.skip("Icarus Verilog is not installed")

    class Faulty(type(DECISION)):  # type: ignore[misc]
        def circuit(self, point: Job[Any, Any]) -> Circuit:
            circuit = DECISION.circuit(point)
            (source,) = (each for each in circuit.sources if each.name == file)
            text = source.read_text(encoding="utf-8")
            assert before in text
            (tmp_path / file).write_text(text.replace(before, after), encoding="utf-8")
            others = (each for each in circuit.sources if each != source)
            return replace(circuit, sources=(*others, tmp_path / file))

    assert any(verify(Faulty(), DECISION.sample(seed), "icarus").first is not None for seed in range(12))
