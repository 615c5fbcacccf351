"""The terms of the time and the energy of a plan, and the inputs that each rests on: a result is priced anew by them.

A plan is a chain: the map over a link, steps on a component, the answer over a link. Each part of it takes a
``Monomial`` of the figures of platform, part and laws: cycles over a clock, units times the cost of a kernel, words
over the clock of a bus. Their sum is the simulated time but for the rounding to picoseconds: less than 1 ps for each
message, and for each time that an FPGA takes up work. So other values of the figures need no simulation.

An input is named as the platform names it (``arm.costs.wavefront_cell``). A name with a space is no key of a platform:
``part XC7Z020.power.dynamic`` is a figure of a part, ``law wavefront.array.power.activity`` one of a law. ``axi edges``
is how many clock periods the chain waited for edges. That number has bounds, and depends on all that comes before it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from codesign.ground.figures import FIGURES, Figure, ResultFigure
from codesign.inputs.derived import DerivedFigure
from codesign.laws.numbers import Ends, Interval, Monomial
from codesign.system.results.model import ResultModel

When = Literal["always", "busy", "waiting"]
Plan = tuple["Term", ...]
"""The terms of one plan, in the order of the chain."""


@dataclass(frozen=True)
class Term(Monomial):
    """A part of a plan's time, s."""

    where: Annotated[str, Field(description="the component or link")] = ""
    what: Annotated[str, Field(description="the phase, or the message")] = ""
    seconds: Annotated[float, Field(description="at the values of the inputs, s")] = 0.0
    works: Annotated[bool, Field(description="whether the component or link works in it, or waits")] = True


@dataclass(frozen=True)
class Draw(Monomial):
    """A part of what a component or a link draws, W."""

    where: Annotated[str, Field(description="the component or link")] = ""
    when: Annotated[When, Field(description="at all times, only while it works, or only while it does not")] = "always"
    watts: Annotated[float, Field(description="at the values of the inputs, W")] = 0.0
    beside: Annotated[str, Field(description="the component that it works and waits with; by default itself")] = ""

    def during(self, term: Term) -> bool:
        """True if it is drawn in a part of the time."""
        busy = term.works and term.where == (self.beside or self.where)
        return self.when == "always" or busy == (self.when == "busy")


class Terms(ResultModel):
    """Time and energy of a plan as sums of products of inputs."""

    inputs: dict[str, Figure] = Field(description="what the terms rest on, by name")
    times: dict[str, tuple[Plan, ...]] = Field(
        description="the terms of each time by the name of its figure, in the order of the chain. Of several lists, as"
        " of several starts, the greatest sum is the figure"
    )
    draws: tuple[Draw, ...] = Field(description="what is drawn, which with the terms of the time gives the energy")
    open: dict[str, str] = Field(default={}, description="by figure: why it is no sum of terms")

    def plans(self, figure: str) -> tuple[tuple[Monomial, ...], ...]:
        """The sums that a figure is the greatest of; none where it is no sum of terms."""
        if figure in self.open:
            return ()
        if figure == "energy_j":
            plans = self.times.get(ENERGY_OVER, ())
            return tuple(_drawn(plan, self.draws) for plan in plans)
        return self.times.get(figure, ())

    def interval(self, figure: str) -> Interval | None:
        """The least and the greatest value of a figure inside the intervals of all inputs; None without terms.

        Exact where each input moves all terms that it is in the same way, else an interval that holds both.
        """
        return self.intervals((figure,)).get(figure)

    def intervals(self, figures: Iterable[str]) -> dict[str, Interval]:
        """The interval of each figure that has terms. Parts that several figures share are computed once."""
        ends, intervals = Ends(self.inputs), {}
        for figure in figures:
            bounds = list(map(ends.of_sum, self.plans(figure)))
            if bounds:
                least, most = zip(*bounds, strict=True)
                low, high = reduce(np.maximum, least), reduce(np.maximum, most)
                arrays = np.ndim(low) or np.ndim(high)
                intervals[figure] = (low, high) if arrays else (float(low), float(high))
        return intervals


ENERGY_OVER = "plan_time_mean_s"
"""The time over which the energy of a plan is drawn."""


def priced(figure: ResultFigure) -> bool:
    """True if a figure rests on figures with intervals: the times and the energy of a plan, power, what they make."""
    if isinstance(figure, DerivedFigure):
        return any(priced(FIGURES[name]) for name in figure.names)
    return (figure.within in {"time", "task", "energy"} and figure.unit in {"s", "J"}) or figure.name == "power"


def is_edges(name: str) -> bool:
    """True if an input is a number of clock periods waited, which nobody can measure by itself."""
    return name.endswith(" edges")


def _drawn(plan: Plan, draws: Sequence[Draw]) -> tuple[Monomial, ...]:
    """The energy of a plan, with one monomial for each product of inputs."""
    of_plan = tuple((tuple(term.powers.items()), term.divide, term.by, term.where, term.works) for term in plan)
    of_draws = tuple((tuple(draw.powers.items()), draw.where, draw.when, draw.beside) for draw in draws)
    pairs, products = _products(of_plan, of_draws)
    sums: list[Any] = [0.0] * len(products)
    for term, draw, number in pairs:
        sums[number] = sums[number] + plan[term].amount * draws[draw].amount
    return tuple(
        Monomial(amount, dict(powers), divide, by)
        for amount, (powers, divide, by) in zip(sums, products, strict=True)
        if (amount.any() if isinstance(amount, np.ndarray) else amount)
    )


@lru_cache(maxsize=256)
def _products(
    plan: tuple[Any, ...], draws: tuple[Any, ...]
) -> tuple[tuple[tuple[int, int, int], ...], tuple[Any, ...]]:
    """The terms and draws that meet in an energy, with the number of their product, and the different products.

    The points of a study differ in the amounts, and hardly in the inputs that their terms rest on.
    """
    products: dict[Any, Any] = {}
    pairs = []
    for place, (powers, divide, by, where, works) in enumerate(plan):
        term = Term(1.0, dict(powers), divide, by, where, works=works)
        for which, (own, of, when, beside) in enumerate(draws):
            if not Draw(1.0, {}, where=of, when=when, beside=beside).during(term):
                continue
            product = dict(powers)
            for name, power in own:
                product[name] = product.get(name, 0) + power
            kept = {name: power for name, power in product.items() if power}
            key = frozenset(kept.items()), divide, by
            # The last of equal products gives the order of the inputs.
            products[key] = tuple(kept.items()), divide, by
            pairs.append((place, which, list(products).index(key)))
    return tuple(pairs), tuple(products.values())


def mean_of(plans: Sequence[Plan]) -> Plan:
    """The terms of the mean time of several plans: like parts of the chain are one term. Equal plans are one object."""
    counts: dict[int, tuple[Plan, int]] = {}
    for plan in plans:
        counts[id(plan)] = plan, counts.get(id(plan), (plan, 0))[1] + 1
    sums: dict[Any, Term] = {}
    for plan, count in counts.values():
        share = count / len(plans)
        for term in plan:
            key = term.where, term.what, frozenset(term.powers.items()), term.divide, term.by
            old = sums.get(key)
            amount, seconds = (0.0, 0.0) if old is None else (old.amount, old.seconds)
            sums[key] = replace(term, amount=amount + share * term.amount, seconds=seconds + share * term.seconds)
    return tuple(sums.values())


def worst_of(plans: Iterable[Plan]) -> tuple[Plan, ...]:
    """The plans of which one is the slowest at any values of the inputs: those that no other exceeds in every term."""
    kept: list[tuple[dict[Any, float], Plan]] = []
    for plan in plans:
        amounts: dict[Any, float] = {}
        for term in plan:
            key = frozenset(term.powers.items()), term.divide, term.by
            amounts[key] = amounts.get(key, 0.0) + term.amount
        if any(_exceeds(other, amounts) for other, _ in kept):
            continue
        kept = [(other, each) for other, each in kept if not _exceeds(amounts, other)]
        kept.append((amounts, plan))
    return tuple(plan for _, plan in kept)


def _exceeds(more: Mapping[Any, float], less: Mapping[Any, float]) -> bool:
    return all(more.get(key, 0.0) >= amount for key, amount in less.items())
