"""The terms of a plan's time and energy, from the work that its chain did and the figures of platform, part and laws.

A time is no sum of products where things meet in time: a display takes cycles of a memory, a link is down at certain
times or delivers late, tasks of the user's own use the same components, or one of several links side by side is chosen.
``Terms.open`` says so, and nothing is priced.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from codesign.ground.figures import Figure, Status
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.components import MemoryComponent
from codesign.laws import Law, Monomial, Sum, as_sum, symbol
from codesign.laws.acts import UNDISTURBED
from codesign.system.bind import System
from codesign.system.build import Machine
from codesign.system.results.ledger import BEGINS, RETRIES, Ledger, Spent, Work
from codesign.system.results.result import Power
from codesign.system.results.terms import Draw, Plan, Term, Terms, When, mean_of, worst_of

WAIT, WAIT_RETRIES = WAITS = "wait", "wait to send again"
"""The name of what a component or a link does while it does not work."""

NO_ROWS = Figure(0, "1", Status.PUBLISHED, "an SRAM has no rows")
_COUNTED = {"ps": (PICOSECONDS_PER_SECOND, "s"), "ppm": (UNDISTURBED, "1")}
"""By unit of a figure, how many of them make one of the unit of its input."""

SAME = 1e-9
"""Two figures of a law that differ by less than this share are one: each went through some roundings."""


class Figures(Protocol):
    """The figures of one system, or of many machines side by side, where each number is an array."""

    def spec(self, name: str) -> Any:
        """The spec of a component or link; of many machines, one that all are like but for their prices."""

    def figure(self, name: str, key: str) -> Figure:
        """A figure of the spec of a component or link, by its key."""


def open_terms(machine: Machine, ledgers: Iterable[Ledger]) -> Terms | None:
    """Terms that only say why the times of these plans are no sum of terms; None where they are."""
    reason = next(filter(None, (_open(machine, ledger) for ledger in ledgers)), "")
    if not reason:
        return None
    return Terms(inputs={}, times={}, draws=(), open=dict.fromkeys((*TIMES, "energy_j"), reason))


def plan_terms(
    system: System,
    figures: Figures,
    first: Ledger,
    requests: Sequence[Ledger],
    boards: Mapping[str, Power],
    *,
    shares: Mapping[str, float],
    ends_only: bool = False,
) -> Terms:
    """The terms of a task's times, and of the energy of a request; of plans that ``open_terms`` has no reason for.

    Args:
        system: that ran.
        figures: of the system, or of many that differ in their prices.
        first: of the chain of the first plan.
        requests: of the chain of each request; those that are alike are one object.
        boards: the power of each FPGA; see ``energy.board_powers``.
        shares: by memory, its share of the busy time of the FPGA that plans; 0 by default.
        ends_only: the terms are made for ``Terms.intervals`` alone: their seconds and watts stay 0.
    """
    distinct = tuple({id(ledger): ledger for ledger in requests}.values())
    pricing = _Pricing(system, figures, shares, ends_only)
    ledgers = {id(ledger): ledger for ledger in (first, *distinct)}
    plans = {key: pricing.plan(ledger) for key, ledger in ledgers.items()}
    times = {
        "first_plan_s": (plans[id(first)],),
        "plan_time_mean_s": (mean_of([plans[id(ledger)] for ledger in requests]),),
        "plan_time_worst_s": worst_of(plans[id(each)] for each in distinct),
    }
    without = {}
    if len(distinct) == 1:
        times["plan_time_95_s"] = times["plan_time_worst_s"]
    else:
        without["plan_time_95_s"] = "which start is the 95th of a hundred depends on the figures"
    draws = tuple(pricing.draws(boards))
    reason = _open_energy(system)
    without |= {"energy_j": reason} if reason else {}
    # Sound by the way it is made: a validation of every point of an exploration would take as long as the rest.
    return Terms.model_construct(inputs=pricing.inputs, times=times, draws=draws, open=without)


TIMES = ("first_plan_s", "plan_time_mean_s", "plan_time_95_s", "plan_time_worst_s")
"""The times of a plan that have terms."""


def _open(machine: Machine, ledger: Ledger) -> str:
    """The reason for which the time of the plan is no sum of terms; "" if it is one."""
    system = machine.system
    if machine.claimed:
        return "a display takes cycles of the memory that the design works in: how many depends on when it works"
    if system.workload.tasks:
        return "tasks of the workload's own use the same components and links"
    memory = _external(system)
    if memory is not None and any(low < high for low, high in (memory.width.interval, _row_words(memory))):
        return "the words of a row or a word of the external memory are not known: they move its accesses by steps"
    used = {work.where for work in ledger.work}
    return next(filter(None, (_open_link(machine, name) for name in machine.links if name in used)), "")


def _open_link(machine: Machine, name: str) -> str:
    """The reason for which the time of the messages of a link is no sum of terms; "" if it is one."""
    links = machine.system.platform.links
    if links[name].outages:
        return f"link {name} is down at certain times"
    if machine.links[name].late:
        return f"messages of link {name} arrive late"
    ends = set(links[name].between)
    if sum(len(ends & set(link.between)) > 1 for link in links.values()) > 1:
        return f"of link {name} and those beside it each message takes the fastest"
    return ""


def _external(system: System) -> MemoryComponent | None:
    """The memory beside the FPGA that the design keeps its data in."""
    return None if system.external is None else system.platform.of(MemoryComponent)[system.external.name]


def _row_words(memory: MemoryComponent) -> tuple[float, float]:
    return (0.0, 0.0) if memory.row_words is None else memory.row_words.interval


def _open_energy(system: System) -> str:
    """The reason for which the energy is no sum of terms though the time is one; "" if it is one."""
    memory = _external(system)
    if memory is None or memory.power is None:
        return ""
    low, high = _access_ratio(memory)
    return "the share of the time in which the external memory works depends on its accesses" if low < high else ""


class _Pricing:
    """Collects the inputs that terms rest on. ``shares``, ``ends_only``: see ``plan_terms``."""

    def __init__(self, system: System, figures: Figures, shares: Mapping[str, float], ends_only: bool) -> None:
        self.system, self.figures, self.shares, self.ends_only = system, figures, shares, ends_only
        self.inputs: dict[str, Figure] = {}
        self.values: dict[str, Any] = {}
        self._waits: Counter[str] = Counter()

    def input(self, name: str, figure: Figure) -> str:
        """The name of an input, after it was put among the inputs."""
        if name not in self.inputs:
            self.inputs[name], self.values[name] = figure, figure.value
        return name

    def edges(self, name: str, waited: Figure) -> str:
        """The name of the clock periods waited at a component or link; each request has its own.

        So the second one's are ``axi 2 edges``. Equal numbers are not made one: whether they are equal depends on
        the prices, and the terms do not.
        """
        self._waits[name] += 1
        number = self._waits[name]
        return self.input(f"{name}{f' {number}' if number > 1 else ''} edges", waited)

    def term(
        self, work: Work, amount: float, powers: dict[str, int], divide: int = 0, by: tuple[str, ...] = ()
    ) -> Term:
        """A term with its seconds; ``Work.unit`` is no matter."""
        seconds = self._at(Monomial(amount, powers, divide, by))
        return Term(amount, powers, divide, by, work.where, work.what, seconds, work.what not in WAITS)

    def _at(self, monomial: Monomial) -> Any:
        """The value of a term or draw at the values of its inputs."""
        return 0.0 if self.ends_only else monomial.at(self.values)

    def plan(self, ledger: Ledger) -> Plan:
        """The terms of a chain."""
        terms: list[Term] = []
        waits: list[str] = []
        for work, amount in ledger.work.items():
            if work.unit in (BEGINS, RETRIES):
                waits += [work.where]
                continue
            terms += self._of_work(work, amount)
            waits += [work.where]
        for where in dict.fromkeys(waits):
            terms += self._waiting(where, ledger)
        return tuple(term for term in terms if np.any(term.amount))

    def _of_work(self, work: Work, amount: int) -> Iterator[Term]:
        """Messages of one size; or cycles, or units of a kernel, each an act of one."""
        size = 1 if work.bits is None else work.bits + self._errors(work.where, "checksum_bits")
        law, accesses = self._law_of(work.where, str(work.unit)), self._accesses(work.where)
        for each in as_sum(law.ticks(size) / law.rate()).monomials:
            yield self.term(work, amount * each.amount, each.powers | accesses, each.divide, each.by)

    def _errors(self, link: str, key: str) -> int:
        """A number of the errors of a link; 0 where it makes none."""
        errors = self.figures.spec(link).errors
        return 0 if errors is None else int(getattr(errors, key))

    def _law_of(self, name: str, unit: str = "") -> Law:
        """The law of a component or link over the names of its inputs."""
        law: Law = self.figures.spec(name).law_of(unit, lambda key: self._symbol(name, key))
        return law

    def _symbol(self, name: str, key: str) -> Sum:
        """The input of a field of a component or link. Laws count in ps and ppm, and inputs in s and shares."""
        figure = self.figures.figure(name, key)
        if figure.unit not in _COUNTED:
            return symbol(self.input(f"{name}.{key}", figure))
        scale, unit = _COUNTED[figure.unit]
        return scale * symbol(self.input(f"{name}.{key}", figure.per(scale, unit)))

    def _of(self, name: str, key: str) -> str:
        """The input of a field of a component or link."""
        return self.input(f"{name}.{key}", self.figures.figure(name, key))

    def _accesses(self, fpga: str) -> dict[str, int]:
        """The factor of cycles that rest on an external memory."""
        memory, external = _external(self.system), self.system.external
        if memory is None or external is None or fpga != self.system.component:
            return {}
        latency, (low, high) = memory.latency_cycles, _access_ratio(memory)
        source = f"bounds of all cycles, by latency_cycles and row_cycles of {external.name}: {latency.source}"
        ratio = Figure(1.0, "1", latency.status, source, low, high)
        name = f"law {self.system.platform.name}.{external.name}.access_cycles"
        return {self.input(name, ratio): 1} if low < high else {}

    def _waiting(self, name: str, ledger: Ledger) -> Iterator[Term]:
        """The waits at a component or link: for messages sent again, and for the edges of its clock."""
        spent = ledger.spent[Spent.WAIT, name]
        if not np.any(spent):
            return
        again = sum(amount for each, amount in ledger.work.items() if each.where == name and each.unit == RETRIES)
        if again:
            timeouts = again * self._errors(name, "timeout")
            spent -= timeouts
            yield self.term(Work(name, WAIT_RETRIES, ""), timeouts / PICOSECONDS_PER_SECOND, {})
        wait = Work(name, WAIT, "")
        if self.figures.spec(name).law.aligned:
            rate = as_sum(self._law_of(name).rate())
            begins = sum(
                amount
                for each, amount in ledger.work.items()
                if each.where == name and (each.unit == BEGINS or each.bits is not None)
            )
            periods = spent / PICOSECONDS_PER_SECOND * rate.at(self.values)
            source = "clock periods waited until the next edge, at most one each time"
            # Where nothing was waited, there is no term; of many machines, one of 0.
            most: Any = np.where(spent, np.maximum(begins, periods), 0) if np.ndim(spent) else max(begins, periods)
            edges = Figure(periods, "1", Status.CALIBRATED, source, 0 * most, most)
            (each,) = (symbol(self.edges(name, edges)) / rate).monomials
            yield self.term(wait, float(each.amount), each.powers)
        else:
            yield self.term(wait, spent / PICOSECONDS_PER_SECOND, {})

    def draws(self, boards: Mapping[str, Power]) -> Iterator[Draw]:
        """The draws of every FPGA, processor, memory and link."""
        platform, memories = self.system.platform, self.system.platform.of(MemoryComponent)
        for name, power in boards.items():
            yield from self._board(name, power)
        for name, component in platform.components.items():
            if component.kernels is not None:
                yield from self._busy_or_waiting(name)
            elif name in memories and memories[name].power is not None:
                yield from self._memory(name)
        for name, link in platform.links.items():
            if link.power is not None:
                yield from self._busy_or_waiting(name)

    def _draw(self, where: str, when: When, amount: float, powers: dict[str, int], beside: str = "") -> Draw:
        watts = self._at(Monomial(amount, powers))
        return Draw(amount, powers, 0, (), where, when, watts, beside)

    def _busy_or_waiting(self, name: str) -> Iterator[Draw]:
        yield self._draw(name, "busy", 1.0, {self._of(name, "power.busy"): 1})
        yield self._draw(name, "waiting", 1.0, {self._of(name, "power.idle"): 1})

    def _memory(self, name: str) -> Iterator[Draw]:
        """A memory works in a share of the FPGA's cycles, and only beside the FPGA that plans."""
        fpga = self.system.component
        share = self.shares.get(name, 0.0)
        idle = self._of(name, "power.idle")
        if not share:
            yield self._draw(name, "always", 1.0, {idle: 1})
            return
        yield self._draw(name, "waiting", 1.0, {idle: 1}, fpga)
        yield self._draw(name, "busy", 1.0 - share, {idle: 1}, fpga)
        yield self._draw(name, "busy", share, {self._of(name, "power.busy"): 1}, fpga)

    def _board(self, name: str, power: Power) -> Iterator[Draw]:
        """Static power at all times, and dynamic power while the design works, which rises with the clock."""
        law, part = self._law(name), self.figures.spec(name).chip
        static = self.ends_only or power.static == part.static_power
        source = f"part {part.name}.power.static" if static else f"law {law}.power.static"
        yield self._draw(name, "always", 1.0, {self.input(source, power.static): 1})
        if not np.any(power.dynamic.value):
            return
        amount, powers = self._dynamic(name, law, power.dynamic)
        clock = self._of(name, "clock")
        yield self._draw(name, "busy", amount / self.values[clock], {**powers, clock: 1})

    def _law(self, name: str) -> str:
        """The planner and the style on an FPGA."""
        system = self.system
        if name == system.component:
            return f"{system.planner.name}.{system.architecture.style}"
        styles = (style for task, style in system.placement.styles.items() if system.placement.places[task] == name)
        style = next(styles, None)
        return name if style is None else f"{style.planner}.{style.style}"

    def _dynamic(self, name: str, law: str, dynamic: Figure) -> tuple[float, dict[str, int]]:
        """Dynamic power as an amount times inputs: the part's power a slice and Hz, where the law quotes it."""
        rate = self.figures.figure(name, "chip.dynamic_power")
        if not is_quoted(rate, dynamic):
            return 1.0, {self.input(f"law {law}.power.dynamic", dynamic): 1}
        low, high = rate.interval
        amount = dynamic.value / rate.value
        powers = {self.input(f"part {self.figures.spec(name).chip.name}.power.dynamic", rate): 1}
        least, most = dynamic.interval[0] / (low * amount), dynamic.interval[1] / (high * amount)
        differs = (least < 1 - SAME) | (most > 1 + SAME)
        if np.any(differs):
            text = f"activity of the design over that of the law, {law}: {dynamic.source}"
            # Of many machines, only some may differ.
            ends: Any = np.where(differs, np.minimum(1.0, least), 1.0), np.where(differs, np.maximum(1.0, most), 1.0)
            lower, upper = ends if np.ndim(amount) else map(float, ends)
            activity = Figure(1.0, "1", dynamic.status, text, lower, upper)
            powers[self.input(f"law {law}.power.activity", activity)] = 1
        return amount, powers


def is_quoted(rate: Figure, dynamic: Figure) -> bool:
    """True if a law quotes the part's power a slice and Hz in a dynamic power."""
    return rate.source in dynamic.source and bool(np.all(rate.interval[0]))


def _access_ratio(memory: MemoryComponent) -> tuple[float, float]:
    """Bounds of the cycles of any accesses, over the cycles at the declared values.

    All cycles are a · latency + b · row + c, or the greater of such a sum and a constant, with a, b and c at least 0,
    and b at most a: no row is opened without an access. So the ratio of two such sums lies among the ratios of its
    parts: the latency, latency and row together, and 1.
    """
    row = memory.row_cycles or NO_ROWS
    latencies, rows = ((memory.latency_cycles.value, *memory.latency_cycles.interval), (row.value, *row.interval))
    latency, *latency_ends = (max(1, value) for value in latencies)
    opened, *row_ends = rows
    together = [(most + more) / (latency + opened) for most, more in zip(latency_ends, row_ends, strict=True)]
    ratios = [1.0, *(end / latency for end in latency_ends), *together]
    return min(ratios), max(ratios)
