"""The acts of components and links that a plan causes, recorded: everything that no price moves."""

from __future__ import annotations

from collections.abc import Generator, Hashable, Mapping, Sequence
from functools import cache
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from pydantic import TypeAdapter

from codesign.ground.memo import Memo
from codesign.ground.records import Record
from codesign.planners.interface import Quality, RobotsQuality
from codesign.planners.job import Flow
from codesign.planners.styles import Exchange, Step
from codesign.system.bind import System, planner_steps
from codesign.system.messages import Content, Routes
from codesign.system.outcome import quality_of
from codesign.system.results.ledger import CYCLES, Ledger
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Reason, Result, TaskFigures
from codesign.system.scenarios.plan_once import task_figures
from codesign.system.scenarios.requests import Request, requests_of
from codesign.system.trials import arrival_reason, arrivals_of

BITS = "bits"


class Act(NamedTuple):
    """One thing that a component or link does, from its begin to its end.

    - ``where``: the component or link. ``what``: the message, or the phase of a processor's task.
    - ``unit``: what is counted: ``bits`` of a message, a kernel of a processor, ``cycles`` of an FPGA.
    - ``amount``: of it. ``phases``: of a style's work, the amount of each phase in their order; together ``amount``.
      Messages, and what is done to the map before it is sent, have none.
    """

    where: str
    what: str
    unit: str
    amount: int
    phases: tuple[tuple[str, int], ...] = ()

    @property
    def kind(self) -> Act:
        """An act of any amount, but for messages: their size decides how often a link begins."""
        if self.unit == BITS:
            return self
        return self._replace(amount=self.amount > 0, phases=tuple((phase, some > 0) for phase, some in self.phases))

    def of(self, others: Sequence[Act], repeats: Sequence[int]) -> Act:
        """This and others of its kind as one, with arrays of amounts: each as often as ``repeats`` says."""
        every = [self, *others]
        amounts = np.array([[act.amount, *(some for _, some in act.phases)] for act in every], np.int64)
        if (amounts == amounts[0]).all():
            return self
        amount, *phases = np.repeat(amounts, repeats, axis=0).T
        named = zip((phase for phase, _ in self.phases), phases, strict=True)
        return self._replace(amount=amount, phases=tuple(named))


class Recorded(ResultModel):
    """One request: what is done from the map that is sent to the answer received.

    The numbers are of acts that were done by then. ``before``: of a replan, when the plan of the map before its change
    was there (``answered``); else 0.
    """

    acts: tuple[Act, ...]
    asked: int
    loaded: int
    planned: int
    answered: int
    before: int


class Computation(ResultModel):
    """The computation of a design point.

    - ``requests``: those that differ. ``of_starts``: the number of the request of each start.
    - ``figures``: the fields of a ``Result`` that the planner gives. ``quality``: of the plan.
    - ``task``: what was asked; its times are 0. ``short``: why too few starts arrive, or None.
    """

    requests: tuple[Recorded, ...]
    of_starts: tuple[int, ...]
    figures: dict[str, Any]
    quality: Quality | RobotsQuality | None
    task: TaskFigures
    short: Reason | None

    @property
    def kind(self) -> Hashable:
        """Computations of one kind can be priced side by side (``alike``).

        Which of several requests is the slowest is decided by their amounts, so these are part of it.
        """
        several, moments = len(self.requests) > 1, attrgetter("asked", "loaded", "planned", "answered", "before")
        requests = tuple(
            (*(act if several else act.kind for act in each.acts), *moments(each)) for each in self.requests
        )
        return requests, self.of_starts

    @classmethod
    def read(cls, text: str) -> Computation:
        """The computation that ``model_dump_json`` wrote.

        Raises:
            ValueError: the text is none.
        """
        computation = cls.model_validate_json(text)
        return computation.model_copy(update={"figures": _typed(computation.figures)})


def alike(each: Sequence[tuple[Recorded, ...]], repeats: Sequence[int]) -> tuple[Recorded, ...]:
    """The requests of computations of one kind as one, with arrays of amounts. ``repeats``: machines of each."""
    first, *others = each
    requests = []
    for number, request in enumerate(first):
        beside = [[other[number].acts[place] for other in others] for place in range(len(request.acts))]
        acts = tuple(act.of(its, repeats) for act, its in zip(request.acts, beside, strict=True))
        requests.append(request.model_copy(update={"acts": acts}))
    return tuple(requests)


def _typed(figures: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a result as its model has them."""
    return {name: _adapter(name).validate_python(value) for name, value in figures.items()}


@cache
def _adapter(name: str) -> TypeAdapter[Any]:
    """The validator of a field of a result."""
    annotation: Any = Result.model_fields[name].annotation
    return TypeAdapter(annotation)


_NO_TIMES = dict.fromkeys(
    ("plan_time_mean_s", "plan_time_95_s", "plan_time_worst_s", "map_mean_s", "planning_mean_s", "answer_mean_s"), 0.0
)


def record(system: System, memo: Memo) -> Computation:
    """Compute what a bound system plans, and record what its components and links do.

    ``memo`` shares functional work with other systems.

    Raises:
        RunError: the planner failed.
    """
    requests = requests_of(_Recorder(system), {}, memo)
    distinct: dict[int, Request] = {id(request): request for request in requests.all}
    numbers = {key: number for number, key in enumerate(distinct)}
    first = requests.first.answer
    quality = quality_of(system, first, memo)
    arrivals = arrivals_of(system, first.problem, quality)
    return Computation.model_construct(
        requests=tuple(_recorded(request) for request in distinct.values()),
        of_starts=tuple(numbers[id(request)] for request in requests.all),
        figures=_typed(system.planner.figures(first.plan)),
        quality=quality,
        task=task_figures(system, arrivals, _NO_TIMES),
        short=arrival_reason(arrivals),
    )


def _recorded(request: Request) -> Recorded:
    answer, machine = request.answer, request.machine
    assert isinstance(machine, _Recorder), "it was recorded"
    return Recorded.model_construct(
        acts=tuple(machine.acts),
        asked=answer.asked,
        loaded=answer.loaded,
        planned=answer.planned,
        answered=answer.answered,
        before=0 if request.before is answer else request.before.answered,
    )


class _Recorder:
    """Takes the place of a machine in a chain, and writes down what it would do. ``now``: how many acts so far."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.acts: list[Act] = []
        self._routes = Routes(system.platform)

    def wants(self, _kind: type[Record]) -> bool:
        """No record is wanted."""
        return False

    @property
    def now(self) -> int:
        """The number of acts that were recorded."""
        return len(self.acts)

    def joules(self, boards: Mapping[str, tuple[float, float]]) -> dict[str, float]:
        """None: an energy has a price."""
        del boards
        return {}

    def run(self, process: Generator[Any, Any, None]) -> None:
        """Run a chain to its end: it waits for nothing."""
        for _ in process:
            raise AssertionError("a chain that nothing contends with waits for no event")

    def another(self) -> _Recorder:
        """A recorder of the same system."""
        return _Recorder(self.system)

    def follow_up(self, task: str) -> None:
        """Nothing: a workload with tasks of its own is simulated."""

    def carry(
        self,
        flow: Flow,
        ledger: Ledger | None = None,  # noqa: ARG002 - see ``Machine.carry``
        *,
        bits: int | None = None,
        priority: int = 0,  # noqa: ARG002
        content: Content | None = None,
    ) -> Generator[Any, Any, Any]:
        """Process generator: a message over every link between two tasks."""
        places = self.system.placement.places
        origin, target = places[flow.sender], places[flow.receiver]
        for hop in self._routes.between(origin, target) if origin != target else ():
            if hop.links:
                (link,) = hop.links
                self.acts.append(Act(link, flow.name, BITS, flow.bits if bits is None else bits))
        return content
        yield

    def plan(self, steps: Generator[Step, None, Any], ledger: Ledger | None = None) -> Generator[Any, Any, Any]:
        """Process generator: the steps of the planner's style on its component."""
        del ledger
        return (yield from self._run(self.system.component, steps, self.system.architecture.kernel))

    def perform(
        self,
        task: str,
        steps: Generator[Step, None, Any],
        ledger: Ledger | None = None,  # noqa: ARG002
        *,
        priority: int = 0,  # noqa: ARG002
    ) -> Generator[Any, Any, Any]:
        """Process generator: the steps of a task's own style on its component."""
        placement = self.system.placement
        return (yield from self._run(placement.places[task], steps, placement.styles[task].kernel))

    def charge(
        self,
        task: str,
        kernel: str,
        units: int,
        ledger: Ledger | None = None,  # noqa: ARG002 - see ``Machine.charge``
        *,
        what: str = "",
        priority: int = 0,  # noqa: ARG002
    ) -> Generator[Any, Any, None]:
        """Process generator: units of a kernel on the component of a task, where that is a processor."""
        name = self.system.placement.places[task]
        if units and self.system.platform.components[name].kernels is not None:
            self.acts.append(Act(name, what or task, kernel, units))
        return
        yield

    def _run(self, name: str, steps: Generator[Step, None, Any], kernel: str) -> Generator[Any, Any, Any]:
        steps = planner_steps(self.system.planner, steps)
        if self.system.platform.components[name].chip is not None:
            return (yield from self._on_fpga(name, steps))
        return (yield from self._on_processor(name, steps, kernel))

    def _on_fpga(self, name: str, steps: Generator[Step, None, Any]) -> Generator[Any, Any, Any]:
        while True:
            phases: dict[str, int] = {}
            exchange, output = None, None
            while exchange is None:
                try:
                    step = next(steps)
                except StopIteration as done:
                    output = done.value
                    break
                if isinstance(step, Exchange):
                    exchange = step
                else:
                    phases[step.phase] = phases.get(step.phase, 0) + int(step.cycles.sum())
            self.acts.append(Act(name, "", CYCLES, sum(phases.values()), tuple(phases.items())))
            if exchange is None:
                return output
            yield from self._exchange(exchange)

    def _on_processor(self, name: str, steps: Generator[Step, None, Any], kernel: str) -> Generator[Any, Any, Any]:
        while True:
            try:
                step = next(steps)
            except StopIteration as done:
                return done.value
            if isinstance(step, Exchange):
                yield from self._exchange(step)
                continue
            units, wanted = int(step.cycles.sum()), step.kernel or kernel
            if units:
                self.acts.append(Act(name, step.phase, wanted, units, ((step.phase, units),)))

    def _exchange(self, step: Exchange) -> Generator[Any, Any, None]:
        """A question to another task, that task, and its answer."""
        asker, task = self.system.planner.planning_task, step.to
        yield from self.carry(Flow(asker, task, f"{task} request", step.bits))
        yield from self.perform(task, self.system.placement.styles[task].steps(self.system.job))
        yield from self.carry(Flow(task, asker, f"{task} answer", step.answer_bits))
