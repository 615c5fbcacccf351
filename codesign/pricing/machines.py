"""Many machines side by side: one chain of a plan, with an array of times in the place of a simulation.

A plan that nothing else contends with is a chain: a message, the steps of a component, a message. So no event decides
what comes next, and the same chain (``plan_chain``) runs on many machines at once. They differ in what their components
and links cost: clocks, rates, widths, costs of kernels. Times are int64 arrays of picoseconds, one entry a machine.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.figures import Figure
from codesign.inputs.components import FpgaComponent, MemoryComponent, ProcessorComponent
from codesign.inputs.links import BusLink, IdealLink, SerialLink
from codesign.models import SpecModel
from codesign.planners.styles import Exchange, Step
from codesign.planners.task_graph import Flow
from codesign.pricing.edges import Clocks, Times
from codesign.results.ledger import BEGINS, CYCLES, Ledger, Spent
from codesign.system.bind import System
from codesign.system.build import planner_steps
from codesign.system.messages import Content, Routes

Column = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Specs:
    """The components and links of many platforms that are wired alike.

    ``models``: by name, the different models of a component or link. ``which``: by name, the number of the model of
    each machine, intp. ``count``: of machines.
    """

    models: Mapping[str, tuple[SpecModel, ...]]
    which: Mapping[str, NDArray[np.intp]]
    count: int

    def subset(self, chosen: NDArray[np.intp]) -> Specs:
        """Those of some of the machines."""
        which = {name: numbers[chosen] for name, numbers in self.which.items()}
        return Specs(self.models, which, len(chosen))

    def model(self, name: str) -> Any:
        """The model of the first machine."""
        return self.models[name][self.which[name][0]]

    def figure(self, name: str, of: Callable[[Any], Figure]) -> Figure:
        """A figure of a component or link as arrays: value, least and greatest, one entry a machine."""
        used, which = np.unique(self.which[name], return_inverse=True)
        figures = [of(self.models[name][number]) for number in used]
        first = figures[0]
        if all(figure == first for figure in figures):
            return first
        value, low, high = (
            np.array(values, np.float64)[which]
            for values in zip(*((each.value, *each.interval) for each in figures), strict=True)
        )
        columns: Any = value, low, high
        return Figure(columns[0], first.unit, first.status, first.source, *columns[1:])

    def column(self, name: str, value: Callable[[Any], int]) -> Times:
        """A whole number of a component or link, one entry a machine."""
        return np.array([value(model) for model in self.models[name]], np.int64)[self.which[name]]

    def measure(self, name: str, value: Callable[[Any], float]) -> Column:
        """A number of a component or link, one entry a machine."""
        return np.array([value(model) for model in self.models[name]], np.float64)[self.which[name]]


class _Resource:
    """A component or link: how long it worked. ``busy``: ps."""

    def __init__(self, count: int) -> None:
        self.busy: Times = np.zeros(count, np.int64)


class _Fpga(_Resource):
    """``phases``: clock cycles by phase, the same of all machines."""

    def __init__(self, specs: Specs, name: str) -> None:
        super().__init__(specs.count)
        self.clocks = Clocks(specs.column(name, lambda spec: int(spec.clock.value)))
        self.phases: dict[str, int] = {}


class _Processor(_Resource):
    def __init__(self, specs: Specs, name: str) -> None:
        super().__init__(specs.count)
        self.clocks = Clocks(specs.column(name, lambda spec: int(spec.clock.value)))
        kernels = specs.models[name][0].costs  # type: ignore[attr-defined]
        self.costs = {
            kernel: specs.column(name, lambda spec, kernel=kernel: int(spec.costs[kernel].value))  # type: ignore[misc]
            for kernel in kernels
        }


class _Link(_Resource):
    """An idle line without errors. ``sent``: messages so far; ``bits``: of them. ``waited``: by the last one, ps."""

    def __init__(self, specs: Specs) -> None:
        super().__init__(specs.count)
        self.sent = self.bits = 0
        self.waited: Times = np.zeros(specs.count, np.int64)

    def send(self, now: Times, bits: int) -> Times:
        """The time of the end of a message that is requested at ``now``, ps."""
        begin, end = self._span(now, bits)
        self.busy = self.busy + (end - begin)
        self.waited = begin - now
        self.sent += 1
        self.bits += bits
        return end

    def _span(self, now: Times, bits: int) -> tuple[Times, Times]:
        del bits
        return now, now


class _Bus(_Link):
    def __init__(self, specs: Specs, name: str) -> None:
        super().__init__(specs)
        self._clocks = Clocks(specs.column(name, lambda spec: int(spec.clock.value)))
        self._width = specs.column(name, lambda spec: int(spec.width.value))
        self._setup = specs.column(name, lambda spec: int(spec.setup_cycles.value))
        self._burst = specs.column(name, lambda spec: int(spec.burst_words.value))

    def _span(self, now: Times, bits: int) -> tuple[Times, Times]:
        # ceil(words / burst) · setup + words cycles from the next edge (components.bus).
        words = -(-bits // self._width)
        cycles = -(-words // self._burst) * self._setup + words
        first = self._clocks.at_or_after(now)
        return self._clocks.edge(first), self._clocks.edge(first + cycles)


class _Serial(_Link):
    """Frames that follow each other at once end at multiples of half a bit (components.serial)."""

    def __init__(self, specs: Specs, name: str) -> None:
        super().__init__(specs)
        self._spec = specs.model(name)
        self._baud = specs.column(name, lambda spec: int(spec.baud.value))

    def _span(self, now: Times, bits: int) -> tuple[Times, Times]:
        # A message of one chain is requested when the one before it has ended, so it begins a run of its own.
        half_bits = np.int64(half_bits_of(self._spec, bits))
        # ceil(half_bits · 10¹² / (2 · baud)) is an edge of a clock of 2 · baud.
        return now, now + Clocks(2 * self._baud).edge(np.broadcast_to(half_bits, now.shape))


def half_bits_of(spec: SerialLink, bits: int) -> int:
    """Half bits on the wire of a message, frame by frame (components.serial)."""
    frame = 2 * (spec.start_bits + spec.data_bits + (spec.parity != "none")) + int(2 * spec.stop_bits)
    return -(-bits // spec.data_bits) * frame


class Machines:
    """As many machines as ``specs`` has, at time 0, of one bound system but for what their components cost.

    It has what ``plan_chain`` and ``joules`` ask of a machine. ``now``: ps. ``by_name``, ``links``: components and
    links, each with its ``busy``.
    """

    listening = False

    def __init__(self, system: System, specs: Specs) -> None:
        self.system, self.specs = system, specs
        self.now: Times = np.zeros(specs.count, np.int64)
        platform = system.platform
        self.by_name: dict[str, Any] = {}
        for name, spec in platform.components.items():
            if isinstance(spec, FpgaComponent):
                self.by_name[name] = _Fpga(specs, name)
            elif isinstance(spec, ProcessorComponent):
                self.by_name[name] = _Processor(specs, name)
            elif isinstance(spec, MemoryComponent):
                self.by_name[name] = _Resource(specs.count)
        self.links = {name: _link(specs, name) for name in platform.links}
        self._routes = Routes(platform)
        self._spent: dict[str, Times] = {}

    def run(self, process: Generator[Any, Any, None]) -> None:
        """Run a chain to its end: it waits for nothing."""
        for _ in process:
            raise AssertionError("a chain on machines side by side waits for no event")

    def another(self) -> Machines:
        """The same machines at time 0."""
        return Machines(self.system, self.specs)

    def watts(self, name: str) -> tuple[Column, Column]:
        """What a processor or link draws while it works and while it does not, W."""
        specs = self.specs
        busy = specs.measure(name, lambda spec: spec.power.busy.value)
        return busy, specs.measure(name, lambda spec: spec.power.idle.value)

    def cycles(self) -> dict[str, Any]:
        """Clock cycles of the planning component by phase: numbers, or arrays of a processor."""
        planning = self.by_name[self.system.component]
        if isinstance(planning, _Fpga):
            return dict(planning.phases)
        return {phase: planning.clocks.at_or_after(spent) for phase, spent in self._spent.items()}

    def follow_up(self, task: str) -> None:
        """Nothing: a workload with tasks of its own is simulated."""

    def carry(
        self,
        flow: Flow,
        ledger: Ledger | None = None,
        *,
        bits: int | None = None,
        priority: int = 0,  # noqa: ARG002 - nothing contends
        content: Content | None = None,
    ) -> Generator[Any, Any, Any]:
        """Process generator: a message over every link between two tasks."""
        places = self.system.placement.places
        origin, target = places[flow.sender], places[flow.receiver]
        for hop in self._routes.between(origin, target) if origin != target else ():
            if hop.links:
                (name,) = hop.links
                link, size = self.links[name], flow.bits if bits is None else bits
                self.now = link.send(self.now, size)
                if ledger is not None:
                    ledger.spent[Spent.WAIT, name] += link.waited
                    ledger.count(name, flow.name, size, 1)
        return content
        yield

    def plan(
        self, steps: Generator[Step, None, Any], ledger: Ledger | None = None
    ) -> Generator[Any, Any, Any]:
        """Process generator: the steps of the planner's style on its component."""
        return (yield from self._run(self.system.component, steps, self.system.architecture.kernel, ledger))

    def perform(
        self,
        task: str,
        steps: Generator[Step, None, Any],
        ledger: Ledger | None = None,
        *,
        priority: int = 0,  # noqa: ARG002 - nothing contends
    ) -> Generator[Any, Any, Any]:
        """Process generator: the steps of a task's own style on its component."""
        placement = self.system.placement
        return (yield from self._run(placement.places[task], steps, placement.styles[task].kernel, ledger))

    def _run(
        self, name: str, steps: Generator[Step, None, Any], kernel: str, ledger: Ledger | None
    ) -> Generator[Any, Any, Any]:
        steps = planner_steps(self.system.planner, steps)
        component, ledger = self.by_name[name], Ledger() if ledger is None else ledger
        if isinstance(component, _Fpga):
            return (yield from self._on_fpga(name, component, steps, ledger))
        return (yield from self._on_processor(name, component, steps, kernel, ledger))

    def _on_fpga(
        self, name: str, fpga: _Fpga, steps: Generator[Step, None, Any], ledger: Ledger
    ) -> Generator[Any, Any, Any]:
        while True:
            # From the next edge, the steps follow each other without a gap.
            first, cycles = fpga.clocks.at_or_after(self.now), 0
            begin = fpga.clocks.edge(first)
            ledger.count(name, "", BEGINS, 1)
            ledger.spent[Spent.WAIT, name] += begin - self.now
            exchange, output = None, None
            while exchange is None:
                try:
                    step = next(steps)
                except StopIteration as done:
                    output = done.value
                    break
                if isinstance(step, Exchange):
                    exchange = step
                    break
                amount = int(step.cycles.sum())
                fpga.phases[step.phase] = fpga.phases.get(step.phase, 0) + amount
                ledger.count(name, step.phase, CYCLES, amount)
                cycles += amount
            end = fpga.clocks.edge(first + cycles)
            fpga.busy = fpga.busy + (end - begin)
            self.now = end
            if exchange is None:
                return output
            yield from self._exchange(exchange, ledger)

    def _on_processor(
        self,
        name: str,
        processor: _Processor,
        steps: Generator[Step, None, Any],
        kernel: str,
        ledger: Ledger,
    ) -> Generator[Any, Any, Any]:
        while True:
            try:
                step = next(steps)
            except StopIteration as done:
                return done.value
            if isinstance(step, Exchange):
                yield from self._exchange(step, ledger)
                continue
            units, wanted = int(step.cycles.sum()), step.kernel or kernel
            if step.instead is not None and wanted not in processor.costs:
                units, wanted = step.instead, kernel
            if not units:
                continue
            spent = processor.costs[wanted] * units
            processor.busy = processor.busy + spent
            self.now = self.now + spent
            ledger.count(name, step.phase, wanted, units)
            if name == self.system.component:
                self._spent[step.phase] = self._spent.get(step.phase, np.int64(0)) + spent

    def _exchange(self, step: Exchange, ledger: Ledger) -> Generator[Any, Any, None]:
        """A question to another task, that task, and its answer."""
        asker, task = self.system.planner.planning_task, step.to
        yield from self.carry(Flow(asker, task, f"{task} request", step.bits), ledger)
        yield from self.perform(task, self.system.placement.styles[task].steps(self.system.job), ledger)
        yield from self.carry(Flow(task, asker, f"{task} answer", step.answer_bits), ledger)


def _link(specs: Specs, name: str) -> _Link:
    spec = specs.models[name][0]
    if isinstance(spec, BusLink):
        return _Bus(specs, name)
    if isinstance(spec, SerialLink):
        return _Serial(specs, name)
    assert isinstance(spec, IdealLink), "there are three kinds of links"
    return _Link(specs)
