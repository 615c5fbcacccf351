"""The argument that every method of planners and styles takes, and the tasks of a workload as a graph.

Within one turn data flow in one direction: the graph is acyclic. The loop of a mission closes through the world,
between turns.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status, label
from codesign.ground.late import late
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.planners.external_memory import ExternalMemoryLaw

if TYPE_CHECKING:
    import networkx
else:
    networkx = late("networkx")


@dataclass(frozen=True)
class Flow:
    """``bits`` from task ``sender`` to task ``receiver``, named ``name``; a message where they are placed apart."""

    sender: str
    receiver: str
    name: str
    bits: int


@dataclass(frozen=True)
class TaskGraph:
    """Tasks, and the flows between them.

    Raises:
        InputError: a flow that leads in a circle, or from or to no task of ``tasks``.
    """

    tasks: tuple[str, ...]
    flows: tuple[Flow, ...]

    def __post_init__(self) -> None:
        for flow in self.flows:
            for task in (flow.sender, flow.receiver):
                if task not in self.tasks:
                    raise InputError(f"{flow.name!r} flows from or to {task!r}, which is no task", "tasks")
        cycle = _cycle(self.tasks, self._edges)
        if cycle:
            what = f"tasks wait for each other in a circle: {' -> '.join((*cycle, cycle[0]))}"
            raise InputError(what, "tasks", "break it where one of them can go on without the other")

    @property
    def networkx(self) -> networkx.MultiDiGraph[str]:
        """The graph with tasks as nodes, and flows as edges that carry ``name`` and ``bits``."""
        graph: networkx.MultiDiGraph[str] = networkx.MultiDiGraph()
        graph.add_nodes_from(self.tasks)
        for flow in self.flows:
            graph.add_edge(flow.sender, flow.receiver, name=flow.name, bits=flow.bits)
        return graph

    @property
    def order(self) -> tuple[str, ...]:
        """The tasks in order: each after the tasks that it waits for, otherwise as listed."""
        return _order(self.tasks, self._edges)

    @property
    def _edges(self) -> tuple[tuple[str, str], ...]:
        return tuple((flow.sender, flow.receiver) for flow in self.flows)

    def between(self, sender: str, receiver: str) -> tuple[Flow, ...]:
        """The flows from one task directly to another."""
        return tuple(flow for flow in self.flows if (flow.sender, flow.receiver) == (sender, receiver))


# Every machine has a graph, and there are few shapes.
@lru_cache(maxsize=256)
def _cycle(tasks: tuple[str, ...], edges: tuple[tuple[str, str], ...]) -> tuple[str, ...]:
    if len(_order(tasks, edges)) == len(tasks):
        return ()
    # Imported for a mistake only: it takes longer than a thousand orders.
    graph: networkx.MultiDiGraph[str] = networkx.MultiDiGraph()
    graph.add_nodes_from(tasks)
    graph.add_edges_from(edges)
    return tuple(edge[0] for edge in networkx.find_cycle(graph))


@lru_cache(maxsize=256)
def _order(tasks: tuple[str, ...], edges: tuple[tuple[str, str], ...]) -> tuple[str, ...]:
    """The tasks in order; the tasks of a circle and those after it are left out."""
    order: list[str] = []
    while ready := [
        task
        for task in tasks
        if task not in order and all(sender in order for sender, receiver in edges if receiver == task)
    ]:
        order.append(ready[0])
    return tuple(order)


# The demand of a design: lines with their laws, bounds, and the levers that would close a gap.

CandidateT = TypeVar("CandidateT")


@dataclass(frozen=True)
class Lever:
    """A change that would close a gap: the parameter to move, and to which value (or in which direction).

    ``changes``: raw parameters of the planning task by which the change is tried, where it changes the plan.
    ``axes``: raw values by axis that make the change, where it leaves the plan as it is and has one value.
    """

    parameter: str
    advice: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    axes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The change in words."""
        return f"{self.parameter}: {self.advice}"


def lever_texts(levers: Iterable[Lever]) -> tuple[str, ...]:
    """Levers in words."""
    return tuple(lever.text for lever in levers)


@dataclass(frozen=True)
class Line:
    """One line of a demand: a piece of the design, its demand, and the law of that demand.

    - ``resource``: the kind of resource; "" for a bound. A bound, such as word depth, is no resource of the part but
      just as hard.
    - ``most``: the largest feasible value of a bound, in the unit of ``figure``. The part limits resources.
    - ``levers``: the changes that would mend a broken bound.
    """

    name: str
    resource: str
    figure: Figure
    most: Figure | None = None
    levers: tuple[Lever, ...] = ()

    @classmethod
    def item(
        cls,
        name: str,
        resource: str,
        amount: int,
        status: Status,
        source: str,
        ends: tuple[float, float] = (math.inf, -math.inf),
    ) -> Line:
        """A demand for ``amount`` units of a resource. ``ends``: the least and the most that a law allows, if any."""
        low, high = min(amount, ends[0]), max(amount, ends[1])
        return cls(name, resource, Figure(amount, "1", status, source, low, high))

    @classmethod
    def bound(
        cls,
        name: str,
        demand: float | Figure,
        limit: float | Figure,
        unit: str,
        status: Status,
        source: str,
        levers: tuple[Lever, ...] = (),
    ) -> Line:
        """A bound: ``demand`` against ``limit``, both in ``unit``. A number of them has the status and the source."""
        figure, most = (
            each if isinstance(each, Figure) else Figure(each, unit, status, source) for each in (demand, limit)
        )
        return cls(name, "", figure, most, levers)

    @property
    def limit(self) -> float | None:
        """The value of ``most``; None for a resource."""
        return None if self.most is None else self.most.value

    @property
    def amount(self) -> int:
        """The number of units of the resource."""
        return int(self.figure.value)


@dataclass(frozen=True)
class Demand:
    """The demand of a design: lines of resources, lines of other bounds, and levers for each resource that is short."""

    items: tuple[Line, ...]
    bounds: tuple[Line, ...] = ()
    levers: dict[str, tuple[Lever, ...]] = field(default_factory=dict)

    def total(self, resource: str) -> int:
        """The sum over the items of one resource."""
        return sum_by_resource(self.items).get(resource, 0)


def sum_by_resource(items: Iterable[Line]) -> dict[str, int]:
    """The demand of ``items`` by resource."""
    sums: dict[str, int] = {}
    for item in items:
        sums[item.resource] = sums.get(item.resource, 0) + item.amount
    return sums


SLICE_PACKING = 1.13
"""Slices over half of the LUT or flip-flops, in a part that is far from full. Assumed."""


def packed(lines: Sequence[Line]) -> Line:
    """The slices of a piece of these LUT and flip-flops, two of each a slice. The least is for full slices."""
    low, high = (max(bounds) for bounds in zip(*(line.figure.interval for line in lines), strict=True))
    slices = -(-round(SLICE_PACKING * max(line.amount for line in lines)) // 2)
    source = f"{SLICE_PACKING} × half of the LUT or flip-flops"
    ends = -(-low // 2), -(-round(SLICE_PACKING * high) // 2)
    return Line.item(lines[0].name, "slices", slices, Status.ASSUMED, source, ends)


def largest(candidates: Sequence[CandidateT], fits: Callable[[CandidateT], bool]) -> CandidateT | None:
    """The last of the candidates that fits, by bisection; None where not even the first does.

    Candidates stand in the order of their demand: behind one that does not fit, none fits.

    >>> largest(range(1, 100), lambda side: side * side <= 50), largest([8, 9], lambda side: side < 8)
    (7, None)
    """
    count = bisect_left(candidates, True, key=lambda each: not fits(each))
    return candidates[count - 1] if count else None


def part_lever(resource: str, need: int) -> Lever:
    """A part with enough of a resource."""
    return Lever("part", f"take one with at least {need:,} {label(resource)}")


def short_resources(items: Iterable[Line], part: Part) -> dict[str, int]:
    """The demand for each resource of ``part`` that ``items`` exceed."""
    return {
        kind: need
        for kind, need in sum_by_resource(items).items()
        if kind in part.resources and need > part.resources[kind].value
    }


ProblemT = TypeVar("ProblemT")
ParametersT = TypeVar("ParametersT")
AnswerT = TypeVar("AnswerT")


@dataclass(frozen=True, eq=False)
class Job(Generic[ProblemT, ParametersT]):
    """One problem to be planned, with everything that a planner or a style may need to know about it.

    What is planned:

    - ``problem``: a ``Problem``, or what the ``problem_model`` of the planner makes.
    - ``parameters``: of the planning task, also for the style of another task.

    Where it is planned:

    - ``part``: the part of the FPGA; None on a processor.
    - ``memory``: bytes of RAM that the processor has for a plan, a figure; None on an FPGA, and where none is declared.
    - ``inside``: the tasks of the planner that the planning component does itself; None for all of them.
    - ``mapped``: the names of all tasks that the workload maps.
    - ``external``: the external memory that the mapping names, only for a style with ``supports_external``.

    One run of it:

    - ``start``: values to continue from: ``Planner.start_of`` of the last plan, or the result of the task
      ``lower_bound``. A planner without either policy ignores it.
    - ``plan``: the plan; None for a task that runs before it.
    - ``position``: where the robot is, (row, column) in cells.
    - ``memo``: holds work that several runs share; None where no other run needs it.
    - ``detail``: whether a listener wants single steps, or a user may interrupt. Without it a step may be as coarse as
      a whole stage. The sum of the cycles is the same.
    """

    problem: ProblemT
    parameters: ParametersT
    part: Part | None = None
    memory: Figure | None = None
    inside: frozenset[str] | None = None
    mapped: frozenset[str] = frozenset()
    external: ExternalMemoryLaw | None = None
    start: Any = None
    plan: Any = None
    position: tuple[float, float] = (0.0, 0.0)
    memo: Memo | None = None
    detail: bool = True

    def does(self, task: str) -> bool:
        """True if the planning component does ``task`` itself.

        >>> Job(None, None).does("decide"), Job(None, None, inside=frozenset({"relax"})).does("decide")
        (True, False)
        """
        return self.inside is None or task in self.inside

    def shared(self, key: tuple[object, ...], compute: Callable[[], AnswerT]) -> AnswerT:
        """The answer that ``memo`` holds under ``key``; computed where there is none."""
        return compute() if self.memo is None else self.memo.get(key, compute)

    @property
    def chip(self) -> Part:
        """The part, for a style that runs on an FPGA only."""
        assert self.part is not None, "a style on an FPGA needs a part"
        return self.part
