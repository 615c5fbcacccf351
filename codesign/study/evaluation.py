"""The evaluation of work: points that compute the same are priced side by side, and all others are simulated."""

from __future__ import annotations

import contextlib
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import wraps
from pathlib import Path, PurePath
from typing import TYPE_CHECKING, Any

from codesign.ground.errors import CodesignError
from codesign.ground.memo import Memo
from codesign.inputs.files import data_folder
from codesign.study.explored import Explored
from codesign.study.identity import canonical_digest, code_digest, files_read
from codesign.study.partition import Alone, Together, Work
from codesign.study.pricing.computation import Computation, record
from codesign.study.pricing.price import Priced, price, why_alone
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


def timed(compute: Callable[[Any, Work], Done]) -> Callable[[Any, Work], Done]:
    """Of a method ``__call__`` of an evaluator: what came of work says how long it took."""

    @wraps(compute)
    def timing(self: Evaluator, work: Work) -> Done:
        self.simulating_s = 0.0
        begun = time.perf_counter()
        done = compute(self, work)
        took_s, warm = time.perf_counter() - begun, self.warm
        self.warm = warm or done.ran
        return replace(done, took_s=took_s, simulating_s=self.simulating_s) if warm or not done.ran else done

    return timing


class Evaluator(ABC):
    """Computes work. For ``ProcessExecutor`` it must pickle; each worker then works on a copy of its own."""

    warm = False
    """True if a plan was computed here before, so that kernels are loaded."""

    simulating_s = 0.0
    """Seconds of the current work that were simulations."""

    def __init__(self, space: Space) -> None:
        self.space = space

    @abstractmethod
    def __call__(self, work: Work) -> Done:
        """The outcome of work; a point that raises becomes a failed one."""

    def files(self) -> dict[Path, str]:
        """The files that each worker reads, by a digest of what they hold now; not those that ship."""
        return {}


class PointByPoint(Evaluator):
    """Computes each point by itself. ``evaluate`` computes one."""

    def __init__(self, evaluate: EvaluatePoint, space: Space) -> None:
        super().__init__(space)
        self.evaluate = evaluate

    @timed
    def __call__(self, work: Work) -> Done:
        """The entries of the points, in order."""
        return _one_by_one(work, work.points_of(self.space), self.evaluate)


class Pricer(Evaluator):
    """Prices points that compute the same, and simulates all others.

    Args:
        explored, grid, memory: see ``Simulator``.
        space: of the points.
        computations: what was computed before, as JSON by its digest.
    """

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

    @timed
    def __call__(self, work: Work) -> Done:
        """The outcome of work."""
        if isinstance(work, Together):
            return self._together(work)
        return _one_by_one(work, work.points_of(self.space), self._simulator)

    def files(self) -> dict[Path, str]:
        """Parts, hosts, calibrations and maps of axes, which are not in the pickle of this."""
        shipped = data_folder("platforms")
        read = files_read(self.explored)
        return {file: digest for file, digest in read.items() if shipped not in file.parents}

    def _together(self, work: Together) -> Done:
        """Points priced side by side; apart where each has to be simulated, or to be refused, by itself."""
        computed: dict[str, str] = {}
        try:
            system = self._bound(work)
            if why := self._why_apart(system):
                return Done(work, why_apart=why)
            priced = price(system, work.specs, lambda: self.computation(system, computed))
        except CodesignError as fault:
            # Each point by itself reports what is wrong with it.
            return Done(work, why_apart=str(fault) or type(fault).__name__)
        except AssertionError:
            raise  # What two rooms must agree on does not hold: no figure of the study is to be trusted.
        except Exception as fault:
            # A fault of pricing costs time, and no result. Tests of all shipped studies notice it.
            return Done(work, why_apart=_unexpected(fault))
        return Done(work, priced, computations=computed, simulated=len(computed), ran=bool(computed))

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


def _unexpected(fault: Exception) -> str:
    return f"{type(fault).__name__}: {fault} ({_place(fault)})"


def _place(fault: Exception) -> str:
    """The innermost line of this package behind ``_entry_of``, or of any other where it never came back here."""
    frames = traceback.extract_tb(fault.__traceback__)
    ours = [frame for frame in frames[1:] if "codesign" in PurePath(frame.filename).parts]
    frame = (ours or frames)[-1]
    return f"{PurePath(frame.filename).name}:{frame.lineno}"
