"""Many machines side by side: what a computation makes them do, with arrays of times in the place of a simulation.

A plan that nothing else contends with is a chain of acts: a message, the work of a component, a message. So no event
decides what comes next, and many machines do it at once. They differ in what their components and links cost: clocks,
rates, widths, costs of kernels. Times are int64 arrays of picoseconds, one entry a machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import RunError
from codesign.ground.figures import Figure
from codesign.ground.numbering import distinct
from codesign.ground.units import PICOSECONDS_PER_SECOND, cycles_by, edge
from codesign.inputs.components import FpgaComponent, MemoryComponent, ProcessorComponent
from codesign.laws import Law
from codesign.study.pricing.computation import BITS, Act, Recorded
from codesign.system.bind import System
from codesign.system.energy import joules
from codesign.system.results.ledger import BEGINS, CYCLES, Ledger, Spent

Column = NDArray[np.float64]


Times = NDArray[np.int64]
"""Picoseconds or cycles, one entry a machine."""

_MOST = 2**62
_EXACT = 2**50
"""Above it, a float is too coarse to find a cycle by a quotient."""


@dataclass(frozen=True, eq=False)
class Clocks:
    """A clock of each of many machines. ``hz``: int64, 1 to 10¹²; edge 0 of each lies at time 0.

    >>> clocks = Clocks(np.array([150_000_000, 10**9]))
    >>> clocks.edge(np.array([3, 3])).tolist(), clocks.at_or_after(np.array([6668, 6668])).tolist()
    ([20000, 3000], [2, 7])
    """

    hz: Times

    @cached_property
    def _period(self) -> tuple[Times, Times]:
        """Whole picoseconds of a period, and what remains of 10¹² after as many cycles as the clock has a second."""
        whole, rest = np.divmod(np.int64(PICOSECONDS_PER_SECOND), self.hz)
        return whole, rest

    def edge(self, cycle: Times) -> Times:
        """The time of an edge, ps: ceil(cycle · 10¹² / hz) = cycle · whole + ceil(cycle · rest / hz).

        Raises:
            RunError: a time is beyond 2^62 ps.
        """
        whole, rest = self._period
        if (cycle.astype(np.float64) * np.maximum(whole, rest)).max(initial=0.0) > _MOST:
            return self._one_by_one(edge, cycle)
        return np.asarray(cycle * whole - (-cycle * rest) // self.hz, np.int64)

    def at_or_after(self, time: Times) -> Times:
        """The first edge at or after a time, ps. A quotient of floats finds it, exact edges correct it."""
        quotient = np.ceil(time * (self.hz / PICOSECONDS_PER_SECOND))
        if quotient.max(initial=0.0) > _EXACT:
            return self._one_by_one(lambda until, hertz: cycles_by(until - 1, hertz) + 1 if until else 0, time)
        cycle = quotient.astype(np.int64)
        cycle = cycle - ((cycle > 0) & (self.edge(np.maximum(cycle - 1, 0)) >= time))
        return np.asarray(cycle + (self.edge(cycle) < time), np.int64)

    def _one_by_one(self, of: Callable[[int, int], int], numbers: Times) -> Times:
        """Compute what is beyond 64 bits on its way in whole numbers of any size."""
        found = [of(number, hertz) for number, hertz in zip(numbers.tolist(), self.hz.tolist(), strict=True)]
        if max(found, default=0) > _MOST:
            raise RunError("a time beyond 2^62 ps", hint="make the problem smaller")
        return np.array(found, np.int64)


@dataclass(frozen=True, eq=False)
class Specs:
    """The components and links of many platforms that are wired alike.

    ``models``: by name, the different models of a component or link. ``which``: by name, the number of the model of
    each machine, intp. ``count``: of machines. ``shape``: a number; where it and ``models`` are the same, machines are
    alike but for prices.
    """

    models: Mapping[str, Sequence[Any]]
    which: Mapping[str, NDArray[np.intp]]
    count: int
    shape: int = 0

    def subset(self, chosen: NDArray[np.intp]) -> Specs:
        """Those of some of the machines."""
        which = {name: numbers[chosen] for name, numbers in self.which.items()}
        return Specs(self.models, which, len(chosen), self.shape)

    def beside(self, others: Iterable[Specs]) -> Specs:
        """These machines and others that are alike but for prices."""
        every = [self, *others]
        which = {name: np.concatenate([each.which[name] for each in every]) for name in self.which}
        return Specs(self.models, which, sum(each.count for each in every), self.shape)

    def spec(self, name: str) -> Any:
        """The model of the first machine."""
        return self.models[name][self.which[name][0]]

    def figure(self, name: str, key: str) -> Figure:
        """A figure of a component or link; see ``of_figures``."""
        return self.of_figures(name, lambda model: model.figure(key))

    def of_figures(self, name: str, of: Callable[[Any], Figure]) -> Figure:
        """A figure of each model as arrays: value, least and greatest, one entry a machine."""
        models = self.models[name]
        if len(models) == 1:
            return of(models[0])
        used, which = self._used[name]
        figures = [of(models[number]) for number in used]
        # Its source is that of the first machine, as that of its other figures is.
        first: Figure = figures[int(which[0])]
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
        """By name, the numbers of the models that any machine has, and the place of each machine's model among them."""
        used = {}
        for name, numbers in self.which.items():
            present, which = distinct(numbers)
            used[name] = present.tolist(), which
        return used

    def column(self, name: str, key: str) -> Times:
        """The whole numbers of a figure of a component or link, one entry a machine."""
        return np.array([int(each.figure(key).value) for each in self.models[name]], np.int64)[self.which[name]]

    def measure(self, name: str, key: str) -> Column:
        """A figure of a component or link, one entry a machine."""
        return np.array([each.figure(key).value for each in self.models[name]], np.float64)[self.which[name]]


class Resource:
    """A component or link: how long it worked. ``busy``: ps. ``acts``, ``amount``: how many acts, and of how much."""

    def __init__(self, specs: Specs, name: str) -> None:
        self.busy: Times = np.zeros(specs.count, np.int64)
        self.acts = self.amount = 0
        self._specs, self._name = specs, name
        self._laws: dict[str, tuple[Law, Clocks]] = {}

    def law(self, unit: str) -> tuple[Law, Clocks]:
        """The law of the acts that are counted in a unit, over arrays, and the clock of its ticks."""
        if unit not in self._laws:
            law = self._specs.spec(self._name).law_of(unit, partial(self._specs.column, self._name))
            hz = np.broadcast_to(np.int64(law.rate()), self._specs.count)
            self._laws[unit] = law, Clocks(hz)
        return self._laws[unit]

    def span(self, now: Times, act: Act) -> tuple[Times, Times]:
        """Begin and end of an act that is requested at ``now``, ps.

        An act of one chain is requested when the one before it has ended, so nothing else is under way.
        """
        law, clocks = self.law(act.unit)
        ticks = np.broadcast_to(np.int64(law.ticks(act.amount)), now.shape)
        if not law.aligned:
            return now, now + clocks.edge(ticks)
        first = clocks.at_or_after(now)
        return clocks.edge(first), clocks.edge(first + ticks)

    def book(self, act: Act, span: Times) -> None:
        """Book an act that took some time, ps."""
        self.busy = self.busy + span
        self.acts += 1
        self.amount += act.amount


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
    """The machines of ``specs``, at time 0, of one bound system but for the costs of their components.

    ``now``: ps. ``by_name``, ``links``: components and links, each with its ``busy``, ps.
    """

    def __init__(self, system: System, specs: Specs) -> None:
        self.system, self.specs = system, specs
        self.now: Times = np.zeros(specs.count, np.int64)
        platform = system.platform
        kinds = (FpgaComponent, ProcessorComponent, MemoryComponent)
        self.by_name = {name: Resource(specs, name) for kind in kinds for name in platform.of(kind)}
        self.links = {name: Resource(specs, name) for name in platform.links}
        self._ticks: dict[str, Any] = {}

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
        """The draw of a processor, memory or link, W: while it works, and while it does not."""
        return self.specs.measure(name, "power.busy"), self.specs.measure(name, "power.idle")

    def cycles(self) -> dict[str, Any]:
        """Clock cycles of the planning component by phase: numbers, or arrays of a processor."""
        if self.system.part is not None:
            return self._ticks
        clocks = Clocks(self.specs.column(self.system.component, "clock"))
        return {phase: clocks.at_or_after(ticks) for phase, ticks in self._ticks.items()}

    def _do(self, act: Act, ledger: Ledger) -> None:
        resource = self._resource(act)
        begin, end = resource.span(self.now, act)
        resource.book(act, end - begin)
        waited: Any = begin - self.now
        ledger.spent[Spent.WAIT, act.where] += waited
        self.now = end
        if act.unit == BITS:
            ledger.count(act.where, act.what, act.amount, 1)
        elif act.unit == CYCLES:
            ledger.count(act.where, "", BEGINS, 1)
            for phase, cycles in act.phases:
                ledger.count(act.where, phase, CYCLES, cycles)
        else:
            ledger.count(act.where, act.what, act.unit, act.amount)
        if act.where == self.system.component:
            law, clocks = resource.law(act.unit)
            for phase, amount in act.phases:
                ticks = law.ticks(amount)
                spent = ticks if law.aligned else clocks.edge(np.broadcast_to(np.int64(ticks), self.specs.count))
                self._ticks[phase] = self._ticks.get(phase, 0) + spent

    def _resource(self, act: Act) -> Resource:
        return (self.links if act.unit == BITS else self.by_name)[act.where]
