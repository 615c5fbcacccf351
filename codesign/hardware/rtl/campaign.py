"""Many design points are verified: random samples of every circuit, or one point."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from more_itertools import map_reduce

from codesign.ground.errors import CodesignError
from codesign.ground.interrupts import end_children
from codesign.hardware.rtl.bench_runs import Progress, silent
from codesign.hardware.rtl.tools import MissingToolError
from codesign.hardware.rtl.verify import MOST_DEVIATION, Verified, verify
from codesign.planners.circuits import CircuitStyle
from codesign.planners.job import Job


@dataclass(frozen=True, eq=False)
class Asked:
    """A point that is to be verified. ``name``: the point in words, such as ``sample 7``; ``job`` makes it."""

    style: CircuitStyle
    name: str
    job: Callable[[], Job[Any, Any]]


@dataclass(frozen=True)
class Checked:
    """A point that was verified: ``verified``, or the ``failure`` that ended it before it could be compared."""

    planner: str
    style: str
    task: str
    point: str
    verified: Verified | None
    failure: str = ""

    @property
    def equal(self) -> bool:
        """True if the circuit reports what the model expects."""
        return self.verified is not None and self.verified.first is None


@dataclass(frozen=True)
class StyleChecked:
    """All points of one circuit, added up. ``deviation``: the mean, where contention excuses cycles."""

    planner: str
    style: str
    task: str
    points: tuple[Checked, ...]

    @property
    def verified(self) -> list[Verified]:
        """The points that could be compared."""
        return [point.verified for point in self.points if point.verified is not None]

    @property
    def deviation(self) -> float:
        """The mean deviation of the cycles that contention excuses."""
        return sum(each.deviation for each in self.verified) / max(1, len(self.verified))

    @property
    def equal(self) -> bool:
        """True if every point is equal, and the cycles deviate by no more than is excused."""
        return all(point.equal for point in self.points) and self.deviation <= MOST_DEVIATION


def samples(styles: Iterable[CircuitStyle], seeds: Sequence[int]) -> list[Asked]:
    """Random design points of each style, one for each seed."""
    return [Asked(style, f"sample {seed}", _sample(style, seed)) for seed in seeds for style in styles]


def _sample(style: CircuitStyle, seed: int) -> Callable[[], Job[Any, Any]]:
    return lambda: style.sample(seed)


def verify_all(
    asked: Sequence[Asked],
    backend: str = "cxxrtl",
    jobs: int = 1,
    progress: Callable[[Checked], None] | None = None,
    waves: Path | None = None,
    within: Progress = silent,
    cycles: tuple[int, int] | None = None,
) -> tuple[StyleChecked, ...]:
    """Verify points, ``jobs`` at a time, and add them up by style.

    ``progress`` is called after each point, ``within`` with what the simulator of a single point does. ``waves``: the
    file of a waveform around the first difference of the first point that has one, or of ``cycles`` (the first and the
    last one) of that point, or else of the first point.

    Raises:
        MissingToolError: a tool is not installed.
    """
    results: dict[int, Checked] = {}
    for index, checked in _checked(asked, backend, jobs, within if len(asked) == 1 else silent):
        results[index] = checked
        if progress is not None:
            progress(checked)
    in_order = [results[index] for index in range(len(asked))]
    differing = next((i for i, checked in enumerate(in_order) if checked.verified and not checked.equal), None)
    drawn = 0 if differing is None and cycles is not None else differing
    if waves is not None and drawn is not None:
        verify(asked[drawn].style, asked[drawn].job(), backend, waves, cycles=cycles)
    groups = map_reduce(in_order, lambda checked: (checked.planner, checked.style, checked.task))
    return tuple(StyleChecked(planner, style, task, tuple(points)) for (planner, style, task), points in groups.items())


def _checked(asked: Sequence[Asked], backend: str, jobs: int, within: Progress) -> Iterator[tuple[int, Checked]]:
    """Each point by its index, as it is done. The work is done by tools, so threads suffice."""
    if jobs == 1:
        for index, each in enumerate(asked):
            yield index, _check(each, backend, within)
        return
    pool = ThreadPoolExecutor(jobs)
    try:
        futures: dict[Future[Checked], int] = {
            pool.submit(_check, each, backend, within): index for index, each in enumerate(asked)
        }
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        end_children()


def _check(asked: Asked, backend: str, within: Progress) -> Checked:
    style = asked.style
    names = (style.planner, style.style, style.task, asked.name)
    try:
        return Checked(*names, verify(style, asked.job(), backend, None, within))
    except MissingToolError:
        raise
    except CodesignError as fault:
        return Checked(*names, None, str(fault))
    # The code of a plug-in: it may raise anything, and the other points are still verified.
    except Exception as fault:
        return Checked(*names, None, f"{type(fault).__name__}: {fault}")
