"""The base classes of architecture styles: the layout of a planner on a component, and its cost.

A style gives laws: pure functions with their sources. A ``PlugIn`` registers it. A style of a user plugs in the same
way. At the end stand the styles on a processor: the platform declares its clock and power, so no law gives them, and
software takes no resource of a part.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.ground.records import Record, TaskRecord
from codesign.planners.external_memory import Traffic
from codesign.planners.job import Demand, Job, Lever, Line


@dataclass(frozen=True)
class Step:
    """A run of clock cycles with nothing outside to wait for.

    ``cycles``: int64, one entry an indivisible unit of work (a visit, a pass), in order. ``record`` makes
    the record for listeners from (begin ps, end ps, source). It is called only where there is a listener; None: the
    step has no record. ``phase`` names the phase that the cycles count in. ``ram_addresses``: the addresses that each
    block RAM gets in every cycle; all block RAMs of a design are driven alike. ``kernel``: on a processor, the unit of
    the cycles where that is not the kernel of the style. ``makes``: the class of the records that ``record`` makes;
    records that no listener wants are not made.
    """

    phase: str
    cycles: NDArray[np.int64]
    record: Any = None
    ram_addresses: int = 0
    kernel: str = ""
    makes: type[Record] = TaskRecord


@dataclass(frozen=True)
class Exchange(Step):
    """A round trip between two steps: ``bits`` to the task ``to``, which answers with ``answer_bits``.

    The work goes on once the answer has come. An exchange takes no cycle of its own: between two tasks of one component
    it takes no time.
    """

    phase: str = "detect"
    cycles: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    to: str = "detect"
    bits: int = 1
    answer_bits: int = 1


@dataclass(frozen=True)
class MemoryStep(Step):
    """A step with access to an external memory; the cycles of ``traffic`` are among the cycles of the step."""

    traffic: Traffic = field(default_factory=Traffic)


@dataclass(frozen=True)
class Found:
    """Parameters with the values that a search found.

    ``proofs``: by parameter, what shows that no other value is better, as names and numbers or texts. ``notes``: as
    ``Architecture.notes``.
    """

    parameters: Any
    proofs: Mapping[str, Mapping[str, Any]]
    notes: tuple[str, ...] = ()


Designs = tuple[tuple[Mapping[str, Any], ...], ...]
"""Chains of parameters of a planning task, the most promising chain first.

Within a chain each design takes at least the time and the resources of the one before it, and its plan is at least as
good: a higher last precision, for example. So a search ends a chain at the first design that serves, or that is too
slow.
"""


@dataclass(frozen=True, eq=False)
class Family:
    """Designs of a planning task that one lower bound covers (``Architecture.families``).

    - ``chain``: the parameters of some of them, as a workload writes them. Each takes at least the time and the
      resources of the one before it, and its plan is at least as good: a higher last precision, for example. It may be
      empty where ``parts`` has all.
    - ``least``: parameters that stand for the least of the family: where their items do not fit the part, no design of
      it does, and none reaches a faster clock. They need be no design of it, and may break a bound of the demand:
      registers of as few bits as any design has. By default the first of the chain. ``clock_alone``: they stand for the
      clock alone, so a part that is short of their items may hold others.
    - ``units``: no design of the family that brings every start to a goal takes fewer units, for the worst of the
      starts: cycles of the component under "", on a processor units by kernel. A kernel that is not there: no bound.
    - ``ranges``: the designs in words and whole numbers: (least, greatest) by name. ``count``: how many they are.
    - ``sharper``: sharper ``units`` of every design, which take a computation. Its argument is a number of cycles that
      is too many: the bound is of use up to it.
    - ``parts``: the families that hold every design that is not in the chain, each design in one of them. None: the
      chain has all.
    """

    chain: tuple[Mapping[str, Any], ...]
    units: Mapping[str, int] = field(default_factory=dict)
    ranges: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    count: int = 1
    least: Mapping[str, Any] | None = None
    sharper: Callable[[int], Mapping[str, int]] | None = None
    parts: Callable[[], Iterator[Family]] | None = None
    clock_alone: bool = False

    @property
    def lowest(self) -> Mapping[str, Any]:
        """``least``, or the first of the chain."""
        return self.chain[0] if self.least is None else self.least


Sides = tuple[int, int]
"""The least and the greatest side of a class or of a group of classes."""


def side_classes(cells: int) -> list[Sides]:
    """Sides of tiles with equally many tiles along ``cells`` cells, the smallest first.

    >>> side_classes(10)
    [(1, 1), (2, 2), (3, 3), (4, 4), (5, 9), (10, 10)]
    """
    classes, least = [], 1
    while least <= cells:
        count = -(-cells // least)
        most = cells if count == 1 else -(-cells // (count - 1)) - 1
        classes.append((least, most))
        least = most + 1
    return classes


@dataclass(frozen=True)
class Memory:
    """The contents of each block RAM of a design, all driven alike: words of ``width`` bits, by content."""

    width: int
    words: Mapping[str, int]


def beyond_map(key: str, what: str, nodes: tuple[int, int], map_shape: tuple[int, int]) -> tuple[str, ...]:
    """A note where the ``what`` (block, tile) of ``nodes`` from parameter ``key`` is larger than the map; else none.

    Such an array is partial: all its nodes are built, and those beyond the map hold obstacles.
    """
    held = min(nodes[0], map_shape[0]), min(nodes[1], map_shape[1])
    if held == nodes:
        return ()
    return (
        f"{key}: a {what} of {nodes[0]} × {nodes[1]} nodes is larger than the map of {map_shape[0]} × {map_shape[1]}"
        f" cells: it holds {held[0]} × {held[1]} cells, its other nodes hold obstacles",
    )


class _Style(ABC):
    """The base class of the styles of planning tasks and of other tasks.

    - ``planner``: the planner's name. ``style``: the style's name in YAML. ``description``: one line for ``hwsw list``,
      without a full stop.
    - ``component_type``: the type of component it runs on: ``fpga`` or ``processor``.
    - ``kernel``: on a processor, the kernel that the cycles of steps count. The platform declares its cost.

    Every method about a problem takes a ``Job``. A style on an FPGA gives ``demand``, ``clock_limit`` and
    ``power``. A style on a processor leaves all three as they are: the platform declares clock and power.
    """

    planner: str
    style: str
    description: str
    component_type: str
    kernel: str = ""

    def kernels(self, _job: Job[Any, Any], /) -> tuple[str, ...]:
        """Every kernel that steps of the job count. By default the one kernel of the style.

        A platform without a cost for each of them is refused before anything runs.
        """
        return (self.kernel,)

    def demand(self, _job: Job[Any, Any], /) -> Demand:
        """Resources and other bounds, item by item; feasibility is judged elsewhere. By default none.

        A planning task has no demand for a task that the component does not do itself (``Job.does``). On a processor
        only bounds count.
        """
        return Demand(items=())

    def items(self, job: Job[Any, Any], /) -> tuple[Line, ...]:
        """The resources alone: ``demand`` without its bounds and levers, which may take a computation of the plan."""
        return self.demand(job).items

    def clock_limit(self, _job: Job[Any, Any], /) -> Figure:
        """The fastest clock that a design of this size reaches on the part, Hz, with its interval.

        Raises:
            InputError: the style runs on a processor. Its clock has no limit law.
        """
        raise InputError("a processor's clock has no limit law", self.style, "declare it in the platform")

    def power(self, _demand: Demand, _clock: int, _part: Part, /) -> tuple[Figure, Figure]:
        """Static and dynamic power of a demand on a part at a clock in Hz: W, with their intervals.

        Raises:
            InputError: the style runs on a processor. The platform declares its power.
        """
        raise InputError("a processor's power has no law", self.style, "declare it in the platform")


class FleetUpdates(ABC):
    """The closed loop of n robots, update by update, and the cycles that each robot's circuit takes for an update.

    The robots are at rest at their starts. Then scenario ``fleet`` calls, for each update in this order, ``decide``;
    ``hold``, where the decision takes longer than a time step; and ``act``. A value that leaves its word ends the run.

    - ``step_ps``: the time step, ps.
    - ``cycles``: int64 n, the cycles of the latest decision, one entry a robot.
    """

    step_ps: int
    cycles: NDArray[np.int64]

    @property
    def radius(self) -> float:
        """The radius of each robot's body, cells; 0 where it is not known. Traces draw it."""
        return 0.0

    @property
    @abstractmethod
    def over(self) -> bool:
        """True if no update follows."""

    @property
    @abstractmethod
    def departure(self) -> str | None:
        """The value that left its word and ended the run, in a sentence; None where none did."""

    @property
    @abstractmethod
    def done(self) -> int:
        """The number of updates that are done."""

    @property
    @abstractmethod
    def arrived(self) -> NDArray[np.bool_]:
        """Bool n: whether each robot was at its target when the latest decision began."""

    @property
    @abstractmethod
    def positions(self) -> NDArray[np.float64]:
        """The positions of the robots now: float64 n × 2, (row, column) in cells."""

    @property
    def slowest(self) -> int:
        """The robot that the others wait for: of equals the first."""
        return int(np.argmax(self.cycles))

    @abstractmethod
    def decide(self) -> None:
        """Every robot chooses its next velocity, all from the state now. ``cycles`` follows."""

    @abstractmethod
    def hold(self, steps: int) -> None:
        """The robots drive on with their velocities for ``steps`` time steps, 1 or more."""

    @abstractmethod
    def act(self) -> None:
        """The robots take the velocities that they chose: one time step, which ends the update."""

    @abstractmethod
    def touches(self) -> NDArray[np.float64]:
        """The times at which the bodies of each pair first touch in the latest ``hold`` or ``act``, from 0 to 1.

        Float64, infinity where they do not, one entry a pair in the order of ``numpy.triu_indices(n, 1)``.
        """

    @abstractmethod
    def steps(self, robot: int, *, visits: bool) -> Generator[Step, None, None]:
        """One robot's circuit in the update. ``visits``: in its smallest units; the cycles are the same without."""

    def whole(self, robot: int) -> Generator[Step, None, None]:
        """One robot's update as a step of one unit: for a circuit that reports no phases."""
        yield Step("update", self.cycles[robot : robot + 1])

    @abstractmethod
    def plan(self) -> Any:
        """The run up to its last complete update, as ``Planner.plan`` gives it."""

    @abstractmethod
    def arrivals(self, plan: Any) -> list[int | None]:
        """For each robot the updates that were done when it had arrived, or None."""

    @abstractmethod
    def collisions(self, plan: Any) -> int:
        """The number of pairs of robots that touched in the run."""

    @abstractmethod
    def time_steps(self, plan: Any) -> int:
        """The number of time steps that the run took."""


class Architecture(_Style):
    """A style of one planner's planning task on one type of component.

    - ``supports_external``: whether the design can keep its memories in an external memory. Then ``demand``,
      ``clock_limit`` and ``work`` look at ``Job.external``.
    - ``beyond``: the designs that ``families`` leaves out, in words; empty: none. An answer that rests on the families
      names them.
    """

    supports_external: bool = False
    beyond: str = ""

    def settled(self, parameters: Any) -> Any:
        """The parameters that this style runs with, where it cannot run with the given ones.

        All other methods, and the planner, get the answer. So cycles, resources, messages and quality belong to one
        run. The answer for an answer is the same.
        """
        return parameters

    def find(self, _job: Job[Any, Any], /) -> Found | None:
        """The parameters of a job with the values of those that are left to a search (``TaskParameters.to_find``).

        It is called once a design, after all checks and before the run. By default None: the style has no search. The
        answer may depend on the part: an exploration asks for each.

        Raises:
            InputError: the search cannot be made.
        """
        return None

    def notes(self, _job: Job[Any, Any], /) -> tuple[str, ...]:
        """Facts about a design with the given parameters that a reader must know: "key: sentence", no full stop.

        A note is no fault. It names work of the design that its parameters do not suggest.
        """
        return ()

    def designs(self, _job: Job[Any, Any], /) -> Designs:
        """The sets of parameters that are worth a try for the problem of a job on its part, as a workload writes them.

        The parameters of the job are None: the style chooses them. ``Job.inside`` and ``Job.external`` belong to the
        placement in question. A design that fits no part may be among them: it then shows what is short. By default
        none: the samples of the plug-in are tried.
        """
        return ()

    def families(self, job: Job[Any, Any], /) -> Iterator[Family]:
        """Every design for the problem of a job on its part, in families, the most promising one first.

        ``hwsw advise`` searches them: it excludes a family by its bound, or else tries its designs. The job is as of
        ``designs``. By default each chain of ``designs``, without a bound.
        """
        for chain in self.designs(job):
            yield Family(chain, count=len(chain))

    def memory(self, _job: Job[Any, Any], /) -> Memory | None:
        """The contents of the block RAMs. By default None: the style uses none."""
        return None

    @abstractmethod
    def work(self, job: Job[Any, Any]) -> Generator[Step, None, Any]:
        """Steps to be run on a clock; returns the same plan as ``Planner.plan``.

        A task that the component does not do itself takes no steps here. Where the work has to wait for such a task, it
        yields an ``Exchange``.
        """

    def updates(self, _job: Job[Any, Any], /) -> FleetUpdates | None:
        """The updates of a fleet, for scenario ``fleet``. By default None: the style plans for one robot only."""
        return None


class TaskStyle(_Style):
    """One task of a planner that is placed by itself, on one type of component.

    ``task``: the task's name. ``demand`` is for this task alone.
    """

    task: str

    @abstractmethod
    def steps(self, job: Job[Any, Any], /) -> Generator[Step, None, Any]:
        """One execution, for a robot at ``job.position``.

        Returns the result of the task: a path as ``Planner.path_from`` does (decisions and paths), a start for
        ``Architecture.work`` (lower bounds), or None.
        """

    def again(self, job: Job[Any, Any], /) -> Generator[Step, None, Any]:
        """The steps of one more decision from the same plan: a drive takes one decision at every control turn.

        Their return value is not used. By default they are the steps of ``steps``.
        """
        return self.steps(job)


class HostStyle(Architecture):
    """A planner in software. A subclass defines ``work``, in units of ``kernel``, and ``bytes_a_cell``."""

    style: str = "software"
    component_type = "processor"

    def bytes_a_cell(self, _job: Job[Any, Any], /) -> Figure | None:
        """Bytes that a compiled program holds for each cell of the map; None: not known, so none is held to a limit.

        That is not what this simulation takes (``Planner.memory``).
        """
        return None

    def demand(self, job: Job[Any, Any]) -> Demand:
        """No resource of a part; the arrays of the program, where the platform declares the memory of the processor."""
        figure = self.bytes_a_cell(job)
        if figure is None or job.memory is None:
            return Demand(items=())
        side = math.isqrt(int(job.memory.value / figure.value))
        cells, (low, high) = job.problem.free.size, figure.interval
        source = f"{figure.value:g} bytes a cell, {low:g} to {high:g}: {figure.source}"
        arrays = Line.bound(
            name="memory of the processor",
            demand=Figure(cells * figure.value, "bytes", figure.status, source, cells * low, cells * high),
            limit=job.memory,
            unit="bytes",
            status=figure.status,
            source=source,
            levers=(Lever("problem.map", f"at most about {side} × {side} cells; crop or downsample it"),),
        )
        return Demand(items=(), bounds=(arrays,))


def assumed_bytes(value: float, source: str, low: float, high: float) -> Figure:
    """Bytes a cell that nobody measured: ``low`` of a packed layout, ``high`` of a generous one."""
    return Figure(value, "B", Status.ASSUMED, source, low, high)


class HostTask(TaskStyle):
    """One task in software: one step in units of ``kernel``."""

    style: str = "software"
    component_type = "processor"

    @abstractmethod
    def outcome(self, job: Job[Any, Any], /) -> tuple[int, Any]:
        """The units of the kernel that one execution takes, at least 1, and the result of the task."""

    def steps(self, job: Job[Any, Any]) -> Generator[Step, None, Any]:
        """One step, booked under the task's name."""
        units, result = self.outcome(job)
        yield one_step(self.task, units)
        return result


def task_record(task: str, cycles: int) -> Callable[[int, int, str], TaskRecord]:
    """The record of a step that is a task by itself, for ``Step.record``."""
    return lambda begin, end, source: TaskRecord(begin, source, task, end, cycles)


def map_read(phase: str, problem: Any, kernel: str, more: int = 0) -> Step:
    """The reading of a map, which every program pays for: a unit of ``kernel`` for each cell, wherever the goals are.

    ``more``: units that the same pass takes besides.
    """
    return one_step(phase, problem.free.size + more, kernel=kernel)


def one_step(task: str, cycles: int, ram_addresses: int = 0, kernel: str = "") -> Step:
    """A step of one unit, recorded as a ``TaskRecord`` of ``task``; ``kernel`` as of ``Step``."""
    return Step(task, np.array([cycles], np.int64), task_record(task, cycles), ram_addresses, kernel)
