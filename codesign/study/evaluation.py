"""The evaluation of work: points that compute the same are priced side by side, and all others are simulated."""

from __future__ import annotations

import contextlib
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from codesign.ground.errors import CodesignError
from codesign.ground.memo import Memo
from codesign.study.explored import Explored
from codesign.study.identity import canonical_digest, code_digest, files_read
from codesign.study.partition import Alone, Together, Work
from codesign.study.pricing.computation import Computation, record
from codesign.study.pricing.price import Group, Priced, price, why_alone
from codesign.study.simulator import Simulator, grid_for
from codesign.study.space import DesignPoint, Space
from codesign.study.store import Entry, EntryState
from codesign.system.bind import System
from codesign.system.memory import refusal
from codesign.system.results.result import Result
from codesign.system.scenarios import bind

if TYPE_CHECKING:
    from codesign.maps import OccupancyGrid

EvaluatePoint = Callable[[DesignPoint], Result]
"""Computes one point by itself."""


@dataclass(frozen=True, eq=False)
class Done:
    """The outcome of work.

    - ``work``: it. ``priced``: the outcomes of points that compute the same, in their order; or None. ``block``: the
      same as bytes, where a worker sent them (``Packing``).
    - ``entries``: of points that were simulated by themselves, in their order.
    - ``computations``: the ones computed anew, as JSON by their digest. ``simulated``: how many simulations it
      took. ``ran``: a plan was computed, so that kernels are compiled.
    - ``why_apart``: why nothing came of it, so that its points have to be simulated each by itself
      (``apart``); "" if something came of it.
    - ``interrupt``: what struck meanwhile; ``work`` is then what was done before.
    - ``took_s``: seconds that it took where it was computed; ``simulating_s`` of them were simulations of ``priced``
      points. None where this process loaded or compiled kernels meanwhile.
    """

    work: Work
    priced: Priced | None = None
    block: bytes = b""
    entries: tuple[Entry, ...] = ()
    computations: Mapping[str, str] = field(default_factory=dict)
    simulated: int = 0
    ran: bool = False
    why_apart: str = ""
    interrupt: KeyboardInterrupt | None = None
    took_s: float | None = None
    simulating_s: float | None = None

    @property
    def together(self) -> bool:
        """True if its points were priced side by side."""
        return self.priced is not None or bool(self.block)

    @property
    def apart(self) -> bool:
        """True if its points have to be simulated each by itself."""
        return bool(self.why_apart)


Begun = tuple[Done, Group | None]
"""The outcome of work; and of points that compute the same their group, which is still to be priced."""


def _called(compute: Callable[[], Begun]) -> Begun:
    return compute()


class Evaluator(ABC):
    """Computes work. For ``ProcessExecutor`` it must pickle; each worker then works on a copy of its own.

    ``seconds_a_batch``: how long works are collected where one worker computes them, to be priced side by side.
    """

    seconds_a_batch = 0.0

    warm = False
    """True if a plan was computed here before, so that kernels are loaded."""

    simulating_s = 0.0
    """Seconds of the current work that were simulations."""

    def __init__(self, space: Space) -> None:
        self.space = space

    def __call__(self, work: Work) -> Done:
        """The outcome of one work."""
        ((done,), _) = self.batch((work,), 0.0)
        return done

    def batch(
        self, works: Iterable[Work], seconds: float, guarded: Callable[[Callable[[], Begun]], Begun] = _called
    ) -> tuple[list[Done], float]:
        """The outcomes of the first works, in order, and the seconds that it took.

        Points that compute the same are priced beside those of the other works. No work is begun after ``seconds``, or
        after an interrupt; the first one always is.

        Args:
            works: drawn one by one. guarded: calls what computes a work.
        """
        first = time.perf_counter()
        came: list[Done] = []
        groups: dict[int, Group] = {}
        for work in works:
            begun = time.perf_counter()
            self.simulating_s = 0.0
            try:
                done, group = guarded(partial(self.begin, work))
            except KeyboardInterrupt as struck:
                done, group = Done(Alone(()), interrupt=struck), None
            now = time.perf_counter()
            if self.warm or not done.ran:
                done = replace(done, took_s=now - begun, simulating_s=self.simulating_s)
            self.warm = self.warm or done.ran
            if group is not None:
                groups[len(came)] = group
            came.append(done)
            if done.interrupt is not None or now - first >= seconds:
                break
        for place, done in self._priced(came, groups):
            came[place] = done
        return came, time.perf_counter() - first

    def _priced(self, came: Sequence[Done], groups: Mapping[int, Group]) -> Iterator[tuple[int, Done]]:
        """The outcomes of works, priced, by their places. ``groups``: by place, those that are priced."""
        begun = time.perf_counter()
        outcomes = _prices([*groups.values()])
        a_point = (time.perf_counter() - begun) / max(1, sum(len(came[place].work) for place in groups))
        for place, outcome in zip(groups, outcomes, strict=True):
            done = came[place]
            took_s = None if done.took_s is None else done.took_s + a_point * len(done.work)
            if isinstance(outcome, str):
                yield place, Done(done.work, why_apart=outcome, took_s=took_s, simulating_s=done.simulating_s)
            else:
                yield place, replace(done, priced=outcome, took_s=took_s)

    @abstractmethod
    def begin(self, work: Work) -> Begun:
        """The outcome of work; a point that raises becomes a failed one."""

    def files(self) -> dict[Path, str]:
        """The files that each worker reads, by a digest of what they hold now; not those that ship."""
        return {}


class PointByPoint(Evaluator):
    """Computes each point by itself. ``evaluate`` computes one."""

    def __init__(self, evaluate: EvaluatePoint, space: Space) -> None:
        super().__init__(space)
        self.evaluate = evaluate

    def begin(self, work: Work) -> Begun:
        """The entries of the points, in order."""
        return _one_by_one(work, work.points_of(self.space), self.evaluate), None


class Pricer(Evaluator):
    """Prices points that compute the same, and simulates all others.

    Args:
        explored, grid, memory: see ``Simulator``.
        space: of the points.
        computations: what was computed before, as JSON by its digest.
    """

    seconds_a_batch = 0.1

    def __init__(
        self,
        explored: Explored,
        space: Space,
        grid: OccupancyGrid | None = None,
        memory: int | None = None,
        computations: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(space)
        self.explored, self.grid, self.memory = explored, grid, memory
        self.computations = dict(computations or {})
        self._simulator = Simulator(explored, grid, memory)
        self._memo: Memo | None = None

    def begin(self, work: Work) -> Begun:
        """The outcome of work."""
        if isinstance(work, Together):
            return self._together(work)
        return _one_by_one(work, work.points_of(self.space), self._simulator), None

    def files(self) -> dict[Path, str]:
        """Parts, hosts, calibrations and maps of axes, which are not in the pickle of this."""
        return files_read(self.explored)

    def _together(self, work: Together) -> Begun:
        """Points to be priced side by side; apart where each has to be simulated, or to be refused, by itself."""
        computed: dict[str, str] = {}
        try:
            system = self._bound(work)
            if why := self._why_apart(system):
                return Done(work, why_apart=why), None
            group = Group.of(system, work.specs, lambda: self.computation(system, computed))
        except AssertionError:
            raise  # What two rooms must agree on does not hold: no figure of the study is to be trusted.
        except Exception as fault:
            return Done(work, why_apart=_why(fault)), None
        return Done(work, computations=computed, simulated=len(computed), ran=bool(computed)), group

    def system(self, work: Together) -> System | None:
        """The bound system of points that compute the same; None where each has to be simulated, or refused, by itself.

        Raises:
            CodesignError: the points cannot be bound.
        """
        system = self._bound(work)
        return None if self._why_apart(system) else system

    def _bound(self, work: Together) -> System:
        platform, workload = self.explored.point(work.axes)
        return bind(platform, workload, grid=grid_for(workload, self.explored.workload, self.grid))

    def _why_apart(self, system: System) -> str:
        """The reason why each point has to be simulated, or refused, by itself; "" if they are priced together."""
        return why_alone(system) or " ".join(refusal(system, self.memory) or ())

    def computation(self, system: System, computed: dict[str, str]) -> Computation:
        """The computation of a system, as it was stored or made now; one that was made now is put into ``computed``."""
        if self._memo is None:
            self._memo = Memo()
        digest = computation_digest(system)
        known = self.computations.get(digest)
        if known is not None:
            # What cannot be read is computed again.
            with contextlib.suppress(ValueError, TypeError, KeyError):
                return Computation.read(known)
        begun = time.perf_counter()
        computation = record(system, self._memo)
        self.simulating_s += time.perf_counter() - begun
        computed[digest] = self.computations[digest] = computation.model_dump_json()
        return computation

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_memo": None, "warm": False}


def computation_digest(system: System) -> str:
    """SHA-256 over all that a computation depends on: planner, problem, parameters, places, links and code."""
    platform, placement = system.platform, system.placement
    return canonical_digest(
        [
            code_digest(),
            system.planner.name,
            system.architecture.style,
            system.problem.digest,
            repr(system.workload.problem),
            {name: model.model_dump(mode="json") for name, model in system.parameters.items()},
            dict(placement.places),
            sorted(placement.inside),
            {task: style.style for task, style in placement.styles.items()},
            {name: [spec.type, *spec.between] for name, spec in platform.links.items()},
            {name: sorted(spec.kernels or ()) for name, spec in platform.components.items()},
        ]
    )


def _one_by_one(work: Work, points: Iterable[DesignPoint], evaluate: EvaluatePoint) -> Done:
    entries: list[Entry] = []
    done: list[DesignPoint] = []
    interrupt: KeyboardInterrupt | None = None
    ran = False
    try:
        for point in points:
            entry, planned = _entry_of(evaluate, point)
            entries.append(entry)
            done.append(point)
            ran = ran or planned
    except KeyboardInterrupt as struck:
        work, interrupt = Alone(tuple(done)), struck
    simulated = sum(entry.state is EntryState.DONE for entry in entries)
    return Done(work, entries=tuple(entries[: len(done)]), simulated=simulated, ran=ran, interrupt=interrupt)


def _entry_of(evaluate: EvaluatePoint, point: DesignPoint) -> tuple[Entry, bool]:
    """The entry of a point, and True if a plan was computed."""
    try:
        result = evaluate(point)
        return Entry(point.key, EntryState.DONE, result.model_dump_json()), result.time is not None
    except CodesignError as fault:
        return Entry(point.key, EntryState.FAILED, str(fault)), False
    except AssertionError:
        raise
    except Exception as fault:
        # Not the user's mistake: the place is what a report of it needs.
        return Entry(point.key, EntryState.FAILED, _unexpected(fault)), False


def _prices(groups: Sequence[Group]) -> list[Priced | str]:
    """The outcomes of groups; where they have none, why their points have to be simulated, or refused, one by one."""
    try:
        return [*price(groups)]
    except AssertionError:
        raise
    except Exception as fault:
        return [_why(fault)] if len(groups) == 1 else [each for group in groups for each in _prices([group])]


def _why(fault: Exception) -> str:
    """Why points are not priced. A fault of pricing costs time, and no result: tests of all studies notice it."""
    # Of a fault of the points, each by itself reports what is wrong with it.
    return str(fault) or type(fault).__name__ if isinstance(fault, CodesignError) else _unexpected(fault)


def _unexpected(fault: Exception) -> str:
    return f"{type(fault).__name__}: {fault} ({_place(fault)})"


def _place(fault: Exception) -> str:
    """The innermost line of this package behind ``_entry_of``, or of any other where it never came back here."""
    frames = traceback.extract_tb(fault.__traceback__)
    ours = [frame for frame in frames[1:] if "codesign" in PurePath(frame.filename).parts]
    frame = (ours or frames)[-1]
    return f"{PurePath(frame.filename).name}:{frame.lineno}"
