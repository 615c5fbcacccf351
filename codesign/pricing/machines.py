"""Many machines side by side: what a computation makes them do, with arrays of times in the place of a simulation.

A plan that nothing else contends with is a chain of acts: a message, the work of a component, a message. So no event
decides what comes next, and many machines do it at once. They differ in what their components and links cost: clocks,
rates, widths, costs of kernels. Times are int64 arrays of picoseconds, one entry a machine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from codesign.figures import Figure
from codesign.inputs.components import FpgaComponent, MemoryComponent, ProcessorComponent
from codesign.inputs.links import AnyLink
from codesign.pricing.computation import BITS, Act, Recorded
from codesign.pricing.edges import Clocks, Times
from codesign.results.ledger import BEGINS, CYCLES, Ledger, Spent
from codesign.system.bind import System
from codesign.system.energy import joules

Column = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Specs:
    """The components and links of many platforms that are wired alike.

    ``models``: by name, the different models of a component or link. ``which``: by name, the number of the model of
    each machine, intp. ``count``: of machines.
    """

    models: Mapping[str, Sequence[BaseModel]]
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
        models = self.models[name]
        if len(models) == 1:
            return of(models[0])
        used, which = self._used[name]
        figures = [of(models[number]) for number in used]
        first = figures[0]
        if all(figure == first for figure in figures):
            return first
        value, low, high = (
            np.array(values, np.float64)[which]
            for values in zip(*((each.value, *each.interval) for each in figures), strict=True)
        )
        columns: Any = value, low, high
        return Figure(columns[0], first.unit, first.status, first.source, *columns[1:])

    @cached_property
    def _used(self) -> dict[str, tuple[list[int], NDArray[np.intp]]]:
        """By name, the numbers of the models that any machine has, and the place among them of that of each machine."""
        used = {}
        for name, numbers in self.which.items():
            present, which = np.unique(numbers, return_inverse=True)
            used[name] = present.tolist(), which
        return used

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

    def __init__(self, specs: Specs, name: str) -> None:
        super().__init__(specs.count)
        spec: AnyLink = specs.model(name)
        self._law = spec.law.of(
            spec, lambda key: specs.column(name, lambda each: int(getattr(each, key).value))
        )
        self._ticks = Clocks(np.broadcast_to(np.int64(self._law.rate()), specs.count))
        self.sent = self.bits = 0
        self.waited: Times = np.zeros(specs.count, np.int64)

    def send(self, now: Times, bits: int) -> Times:
        """The time of the end of a message that is requested at ``now``, ps."""
        begin, end = self.span(now, bits)
        self.busy = self.busy + (end - begin)
        self.waited = begin - now
        self.sent += 1
        self.bits += bits
        return end

    def span(self, now: Times, bits: int) -> tuple[Times, Times]:
        """Begin and end of a message that is requested at ``now``, ps.

        A message of one chain is requested when the one before it has ended, so no other is on the line.
        """
        ticks = np.broadcast_to(np.int64(self._law.ticks(bits)), now.shape)
        if not self._law.aligned:
            return now, now + self._ticks.edge(ticks)
        first = self._ticks.at_or_after(now)
        return self._ticks.edge(first), self._ticks.edge(first + ticks)


@dataclass(frozen=True, eq=False)
class Played:
    """A request on many machines.

    - ``times``: when each act had ended, ps; ``times[0]`` is the begin.
    - ``ledger``: of the request. ``first``: of its first plan, which of a replan is that before the change.
    - ``machines``: after it. ``joules``: the parts of the energy from the request on, by name.
    """

    times: tuple[Times, ...]
    ledger: Ledger
    first: Ledger
    machines: Machines
    joules: Mapping[str, Column]


class Machines:
    """As many machines as ``specs`` has, at time 0, of one bound system but for what their components cost.

    ``now``: ps. ``by_name``, ``links``: components and links, each with its ``busy``, ps.
    """

    def __init__(self, system: System, specs: Specs) -> None:
        self.system, self.specs = system, specs
        self.now: Times = np.zeros(specs.count, np.int64)
        platform = system.platform
        self.by_name: dict[str, Any] = {}
        self.by_name |= {name: _Fpga(specs, name) for name in platform.of(FpgaComponent)}
        self.by_name |= {name: _Processor(specs, name) for name in platform.of(ProcessorComponent)}
        self.by_name |= {name: _Resource(specs.count) for name in platform.of(MemoryComponent)}
        self.links = {name: _Link(specs, name) for name in platform.links}
        self._spent: dict[str, Times] = {}

    def play(self, request: Recorded, watts: Mapping[str, tuple[Column, Column]]) -> Played:
        """Do the acts of a request. ``watts``: static and dynamic power of each FPGA."""
        times, ledger = [self.now], Ledger()
        first, before = ledger, None
        for number, act in enumerate(request.acts):
            if request.before and number == request.before:
                before, first, ledger = joules(self, watts), ledger, Ledger()
            self._do(act, ledger)
            times.append(self.now)
        whole = joules(self, watts)
        since = whole if before is None else {part: value - before[part] for part, value in whole.items()}
        return Played(tuple(times), ledger, first, self, since)

    def watts(self, name: str) -> tuple[Column, Column]:
        """What a processor, memory or link draws while it works and while it does not, W."""
        specs = self.specs
        busy = specs.measure(name, lambda spec: spec.power.busy.value)
        return busy, specs.measure(name, lambda spec: spec.power.idle.value)

    def cycles(self) -> dict[str, Any]:
        """Clock cycles of the planning component by phase: numbers, or arrays of a processor."""
        planning = self.by_name[self.system.component]
        if isinstance(planning, _Fpga):
            return dict(planning.phases)
        return {phase: planning.clocks.at_or_after(spent) for phase, spent in self._spent.items()}

    def _do(self, act: Act, ledger: Ledger) -> None:
        if act.unit == BITS:
            link = self.links[act.where]
            self.now = link.send(self.now, act.amount)
            waited: Any = link.waited
            ledger.spent[Spent.WAIT, act.where] += waited
            ledger.count(act.where, act.what, act.amount, 1)
        elif act.unit == CYCLES:
            self._work(self.by_name[act.where], act, ledger)
        else:
            processor = self.by_name[act.where]
            spent = processor.costs[act.unit] * act.amount
            processor.busy = processor.busy + spent
            self.now = self.now + spent
            ledger.count(act.where, act.what, act.unit, act.amount)
            if act.phases and act.where == self.system.component:
                self._spent[act.what] = self._spent.get(act.what, np.int64(0)) + spent

    def _work(self, fpga: _Fpga, act: Act, ledger: Ledger) -> None:
        """Cycles without a gap, from the next edge of the clock."""
        first = fpga.clocks.at_or_after(self.now)
        begin, end = fpga.clocks.edge(first), fpga.clocks.edge(first + act.amount)
        ledger.count(act.where, "", BEGINS, 1)
        waited: Any = begin - self.now
        ledger.spent[Spent.WAIT, act.where] += waited
        for phase, cycles in act.phases:
            fpga.phases[phase] = fpga.phases.get(phase, 0) + cycles
            ledger.count(act.where, phase, CYCLES, cycles)
        fpga.busy = fpga.busy + (end - begin)
        self.now = end
