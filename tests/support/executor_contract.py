"""What every executor does, and what its tests share."""

from __future__ import annotations

import contextlib
import multiprocessing
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from explore_fakes import Fake, computed

from codesign.study.evaluation import Done, PointByPoint
from codesign.study.executor import Executor
from codesign.study.partition import Alone, Work
from codesign.study.space import DesignPoint, Space
from codesign.study.store import Entry, EntryState
from codesign.system.results.result import Result


def works_of(axes: dict[str, list[Any]], limit: int = 3) -> list[Work]:
    points = tuple(Space(axes, "").points())
    return [Alone(points[begin : begin + limit]) for begin in range(0, len(points), limit)]


def evaluator(axes: dict[str, list[Any]], log: Path | None = None, at: dict[int, str] | None = None) -> PointByPoint:
    return PointByPoint(Fake(log, at), Space(axes, ""))


def run(
    executor: Executor,
    axes: dict[str, list[Any]],
    log: Path | None = None,
    limit: int = 3,
    at: dict[int, str] | None = None,
) -> dict[str, Entry]:
    entries: dict[str, Entry] = {}
    for done in executor.run(works_of(axes, limit), evaluator(axes, log, at)):
        assert [entry.key for entry in done.entries] == [point.key for point in points_of(done)]
        for entry in done.entries:
            assert entry.key not in entries
            entries[entry.key] = entry
    return entries


def points_of(done: Done) -> tuple[DesignPoint, ...]:
    assert isinstance(done.work, Alone)
    return done.work.points


class Contract:
    """What every executor does."""

    @pytest.fixture
    def executor(self) -> Executor:
        raise NotImplementedError

    def test_every_point_comes_in_once_with_its_result(self, executor: Executor, tmp_path: Path) -> None:
        axes = {"slices": list(range(10, 20))}
        entries = run(executor, axes, tmp_path / "log")
        points = list(Space(axes, "").points())
        assert sorted(computed(tmp_path / "log")) == list(range(10))
        for point in points:
            assert entries[point.key].state is EntryState.DONE
            assert Result.model_validate_json(entries[point.key].text).resources[0].demand == point.axes["slices"]

    def test_an_exception_is_the_failure_of_its_point_alone(self, executor: Executor) -> None:
        axes = {"do": ["nothing", "fail", "refuse", "all the same"]}
        entries = run(executor, axes)
        found = [entries[point.key] for point in Space(axes, "").points()]
        assert [entry.state for entry in found] == [
            EntryState.DONE,
            EntryState.FAILED,
            EntryState.FAILED,
            EntryState.DONE,
        ]
        assert found[1].text.startswith("ZeroDivisionError: no way (explore_fakes.py:")
        assert found[2].text.startswith("relax.block: a block of 9 × 9")
        assert "hint: make it smaller" in found[2].text

    def test_nothing_to_do(self, executor: Executor) -> None:
        assert list(executor.run([], evaluator({}))) == []

    def test_works_are_taken_as_they_are_needed(self, executor: Executor) -> None:
        taken = []
        axes = {"slices": list(range(10, 60))}

        def lazily() -> Iterator[Work]:
            for work in works_of(axes, limit=1):
                taken.append(work)
                yield work

        with contextlib.closing(executor.run(lazily(), evaluator(axes))) as coming:
            next(coming)
        assert len(taken) < 20

    def test_closing_ends_the_work(self, executor: Executor, tmp_path: Path) -> None:
        before = set(multiprocessing.active_children())
        axes = {"do": ["nothing", *(["sleep"] * 20)]}
        works = works_of(axes, limit=1)
        with contextlib.closing(executor.run(works, evaluator(axes, tmp_path / "log"))) as coming:
            next(coming)
        assert set(multiprocessing.active_children()) <= before
        assert len(computed(tmp_path / "log")) <= 1 + 2
