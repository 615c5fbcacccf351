"""The circuit of the state machine reports what the plan and the laws expect, event by event and cycle by cycle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rtl_tools import quickest

from codesign.ground.errors import UnsuitedError
from codesign.ground.models import Task
from codesign.hardware.rtl.verify import verify
from codesign.planners.breadth_first.plan.parameters import (
    Address,
    MemoryPlace,
    MicroArchitecture,
    SearchParameters,
    VgaController,
)
from codesign.planners.breadth_first.rtl import CIRCUITS, EMPTY, KINDS, OVERFLOW, StateMachineCircuit
from codesign.planners.interface import Problem
from codesign.planners.job import Job

MACHINE = StateMachineCircuit()
PARAMETERS = SearchParameters(display=VgaController.NONE)


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "cache"))


def check(job: Job[Problem, SearchParameters]) -> None:
    verified = verify(MACHINE, job, quickest())
    assert verified.first is None, f"{job.parameters}: {verified.first}"


@pytest.mark.parametrize("seed", [3, 7, 12])
def test_random_points_agree(seed: int) -> None:
    for circuit in CIRCUITS:
        verified = verify(circuit, circuit.sample(seed), quickest())
        assert verified.first is None, str(verified.first)


@pytest.mark.slow
def test_many_random_points_agree() -> None:
    for circuit in CIRCUITS:
        for seed in range(100, 300):
            verified = verify(circuit, circuit.sample(seed), quickest())
            assert verified.first is None, f"seed {seed}: {verified.first}"


@pytest.mark.slow
@pytest.mark.parametrize("micro_architecture", MicroArchitecture)
@pytest.mark.parametrize("address", Address)
@pytest.mark.parametrize("shape", [(1, 2), (2, 1), (1, 17), (9, 1), (8, 8), (16, 4), (33, 31)])
def test_maps_at_the_ends_of_addresses(
    shape: tuple[int, int], address: Address, micro_architecture: MicroArchitecture
) -> None:
    parameters = PARAMETERS.model_copy(update={"address": address, "micro_architecture": micro_architecture})
    for begin, end in (((0, 0), (shape[0] - 1, shape[1] - 1)), ((shape[0] - 1, shape[1] - 1), (0, 0))):
        check(Job(Problem(np.ones(shape, np.bool_), (end,), (begin,)), parameters))


def test_samples_cover_every_option() -> None:
    jobs = [MACHINE.sample(seed) for seed in range(60)]
    assert {job.parameters.micro_architecture for job in jobs} == set(MicroArchitecture)
    assert {job.parameters.address for job in jobs} == set(Address)
    assert {job.problem.task for job in jobs} == {Task.PATH, Task.FIELD}
    assert {len(job.problem.goals) for job in jobs} >= {1, 2, 3}
    last = {KINDS[MACHINE.expected(job).events.kind[-1]] for job in jobs}
    assert last == {"path", "empty", "overflow"}
    again = [MACHINE.sample(seed) for seed in range(60)]
    assert [job.problem.digest for job in jobs] == [job.problem.digest for job in again]


def test_a_queue_that_is_too_short_ends_the_search() -> None:
    free = np.ones((6, 6), np.bool_)
    job = Job(Problem(free, ((5, 5),), ((2, 2),)), PARAMETERS.model_copy(update={"queue_words": 3}))
    events = MACHINE.expected(job).events
    # The start pushes four cells: the fourth finds no room.
    assert [KINDS[kind] for kind in events.kind] == ["pop", "push", "push", "push", "overflow"]
    assert int(events.value[-1]) >> 6 == 3
    check(job)


def test_a_search_without_an_answer_ends_with_the_empty_queue() -> None:
    free = np.ones((3, 5), np.bool_)
    free[:, 2] = False
    job = Job(Problem(free, ((0, 4),), ((0, 0),)), PARAMETERS)
    assert MACHINE.expected(job).events.kind[-1] == EMPTY
    assert OVERFLOW not in MACHINE.expected(job).events.kind
    check(job)


def test_another_map_is_noticed(tmp_path: Path) -> None:
    job = MACHINE.sample(12)
    other = replace(job, problem=replace(job.problem, free=~np.zeros_like(job.problem.free)))

    class Wrong(StateMachineCircuit):
        def expected(self, _job: Job[Problem, SearchParameters]) -> object:  # type: ignore[override]
            return super().expected(other)

    verified = verify(Wrong(), job, quickest(), waves=tmp_path / "difference.vcd")
    assert verified.first is not None
    assert (tmp_path / "difference.vcd").exists()


@pytest.mark.parametrize(
    ("changes", "key"),
    [({"memory": MemoryPlace.EXTERNAL}, "search.memory"), ({"memory": MemoryPlace.PROCESS_EXTERNAL}, "search.memory")],
)
def test_parameters_without_a_circuit_are_refused(changes: dict[str, object], key: str) -> None:
    job = Job(Problem(np.ones((4, 4), np.bool_), ((3, 3),), ((0, 0),)), PARAMETERS.model_copy(update=changes))
    for ask in (MACHINE.circuit, MACHINE.expected):
        with pytest.raises(UnsuitedError, match=key):
            ask(job)


def test_a_start_at_a_goal_is_refused() -> None:
    job = Job(Problem(np.ones((4, 4), np.bool_), ((3, 3),), ((3, 3),)), PARAMETERS)
    with pytest.raises(UnsuitedError, match=r"problem\.starts"):
        MACHINE.circuit(job)
    with pytest.raises(UnsuitedError, match="track"):
        MACHINE.circuit(replace(MACHINE.sample(0), inside=frozenset({"search"})))
