"""The verdict about a need, and about a winner, at every value inside the intervals; or the figure that decides."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from codesign.ground.figures import FIGURES, Figure, ResultFigure, named
from codesign.ground.units import counted
from codesign.inputs.constraint import LOWER, STRICT, Constraint
from codesign.inputs.derived import DerivedFigure, derived_ends
from codesign.inputs.expression import evaluate
from codesign.laws import Monomial
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Result
from codesign.system.results.terms import priced
from codesign.system.verdicts.fits import Fit, fit_verdict
from codesign.system.verdicts.sums import Bound, Difference, Input, Inputs, Margin, Sum, greatest_of

# Designs that are compared by one figure: values and intervals as columns, results where they are needed.

Floats = NDArray[np.float64]


class Rivals(Protocol):
    """Designs by their positions."""

    def values(self, figure: ResultFigure) -> Floats:
        """The figure of each; NaN: it is infeasible or has none."""

    def ends(self, figure: ResultFigure) -> tuple[Floats, Floats]:
        """The ends of the interval of the figure of each; NaN: it has none, or the figure is no sum of terms."""

    def assessed(self, why_not: Callable[[Result], str]) -> NDArray[np.bool_]:
        """True if there is no reason against a verdict in what each has in common with others."""

    def at_hand(self, position: int) -> bool:
        """True if the full result of one is at hand, or has to be simulated."""

    def result(self, position: int) -> Result:
        """The full result of one."""

    def shared(self, position: int) -> Result:
        """Its result, or what that has in common with others: all but what rests on times, energy and clock."""


class Listed:
    """Results as rivals."""

    def __init__(self, results: Sequence[Result]) -> None:
        self._results = results

    def values(self, figure: ResultFigure) -> Floats:
        """The figure of each; NaN: it is infeasible or has none."""
        values = (result.figure(figure) if result.feasible else None for result in self._results)
        return np.array([math.nan if value is None else value for value in values], np.float64)

    def ends(self, figure: ResultFigure) -> tuple[Floats, Floats]:
        """The ends of the interval of the figure of each."""
        pairs = [_interval(result, figure) for result in self._results]
        table = np.array(pairs, np.float64).reshape(-1, 2)
        return table[:, 0], table[:, 1]

    def assessed(self, why_not: Callable[[Result], str]) -> NDArray[np.bool_]:
        """True if there is no reason against a verdict about each."""
        return np.array([not why_not(result) for result in self._results], np.bool_)

    def at_hand(self, position: int) -> bool:  # noqa: ARG002
        """All are."""
        return True

    def result(self, position: int) -> Result:
        """One of them."""
        return self._results[position]

    def shared(self, position: int) -> Result:
        """The same."""
        return self._results[position]


def _interval(result: Result, figure: ResultFigure) -> tuple[float, float]:
    """The interval of a figure that is a sum of terms; NaN where it is none."""
    none = math.nan, math.nan
    return none if result.terms is None else result.interval(figure) or none


# The margin of a figure that an expression makes of others, as a function of the inputs of these.


@dataclass(frozen=True)
class Side:
    """A derived figure of one result; or a limit. ``parts``: the sums or the value of each figure that it is made of.

    ``low``, ``high``: the ends of its interval.
    """

    figure: DerivedFigure
    parts: Mapping[str, tuple[Sum, ...] | float]
    low: float
    high: float
    limit: float | None = None

    @classmethod
    def of(cls, held: Result | float, figure: DerivedFigure, inputs: Inputs) -> Side:
        """The side of a result, which has the figure inside all intervals (``ends_of``); or of a limit."""
        if not isinstance(held, Result):
            return cls(figure, {}, held, held, held)
        ends = ends_of(held, figure)
        assert ends is not None, "the caller looks"
        parts: dict[str, tuple[Sum, ...] | float] = {}
        for name in figure.names:
            sums = inputs.sums(held, name) if priced(FIGURES[name]) else ()
            parts[name] = sums or held.figure(FIGURES[name]) or 0.0
        return cls(figure, parts, *ends)

    def at(self, values: Mapping[str, Any]) -> Any:
        """The figure where inputs have these values."""
        if self.limit is not None:
            return self.limit

        def column(name: str) -> Any:
            part = self.parts[name]
            return np.asarray(greatest_of(part, values) if isinstance(part, tuple) else part, np.float64)

        return evaluate(self.figure.node, column) / self.figure.size

    @property
    def sums(self) -> Iterable[Sum]:
        """Every sum that it is made of."""
        return chain.from_iterable(part for part in self.parts.values() if isinstance(part, tuple))


@dataclass(frozen=True)
class DerivedMargin(Difference):
    """The excess of ``theirs`` over ``ours``."""

    ours: Side
    theirs: Side
    inputs: Mapping[str, Input]

    @property
    def reversed(self) -> DerivedMargin:
        """The same with the sides exchanged."""
        return DerivedMargin(self.theirs, self.ours, self.inputs)

    @property
    def names(self) -> Iterable[str]:
        """The inputs of all sums."""
        sums = (*self.ours.sums, *self.theirs.sums)
        return chain.from_iterable(each.inputs for plan in sums for each in plan)

    def at(self, values: Mapping[str, Any] | None = None) -> Any:
        """The margin where inputs have the given values (numbers or arrays), all others their own."""
        full = {name: each.value for name, each in self.inputs.items()} | dict(values or {})
        return self.theirs.at(full) - self.ours.at(full)

    def least(self) -> Bound:
        """The least margin inside all intervals, or a bound of it."""
        return Bound(self.theirs.low - self.ours.high, exact=False)


def ends_of(result: Result, figure: DerivedFigure) -> tuple[float, float] | None:
    """The least and the greatest value of a derived figure of a result, which are one where it rests on no interval.

    None where it has no value somewhere inside the intervals. Of a resource, what it demands may have one too.
    """

    def ends(name: str) -> tuple[Any, Any]:
        declared = FIGURES[name]
        value = result.figure(declared)
        low, high = result.interval(declared) or (value, value)
        items = [item for use in result.resources if use.resource == name for item in use.items]
        if declared.is_resource and items:
            low, high = (sum(item.figure.interval[end] for item in items) for end in (0, 1))
        least, most = (math.nan if end is None else end for end in (low, high))
        return np.array(least, np.float64), np.array(most, np.float64)

    low, high = map(float, derived_ends(figure, ends))
    return None if math.isnan(low) else (low, high)


State = Literal["proved", "refuted", "depends", "not assessed"]
Positions = NDArray[np.intp]


class Decider(ResultModel):
    """The figure that decides: known exactly, it would move the margin most."""

    name: str = Field(description="as an axis names it; of a part or a law with that word before it")
    platform: str = Field(description="the platform that declares it; empty for a figure of a part or a law")
    figure: Figure = Field(description="its value, interval, status and source")
    flips_at: float | None = Field(
        default=None,
        description="the value at which the verdict changes, all other figures at their own, in the unit of the figure;"
        " None where no figure changes it by itself",
    )


class Swing(ResultModel):
    """The effect of one figure by itself on a figure of a result."""

    name: str = Field(description="as an axis names it; of a part or a law with that word before it")
    figure: Figure = Field(description="its value, interval, status and source")
    least: float = Field(description="the least value of the result's figure inside its interval")
    most: float = Field(description="the greatest value of the result's figure inside its interval")


class Verdict(ResultModel):
    """The verdict about a statement: if it holds at every value inside the intervals of all figures that it rests on.

    - ``proved``: at every value. ``refuted``: at none. ``depends``: at some, and ``decides`` names the figure to
      measure first. ``not assessed``: there is no closed form; ``reason`` says why.
    """

    state: State = Field(description="proved, refuted, depends or not assessed")
    figure: str = Field(description="name of the figure that it is about")
    holds: bool | None = Field(default=None, description="whether it holds at the figures' own values")
    margin: float | None = Field(
        default=None, description="by how much it holds at the figures' own values, in the unit of the figure"
    )
    least: float | None = Field(default=None, description="the least margin, or a lower bound of it")
    most: float | None = Field(default=None, description="the greatest margin, or an upper bound of it")
    decides: Decider | None = Field(default=None, description="the figure that decides, where it depends on one")
    reason: str = Field(default="", description="why it is not assessed, or what it depends on besides")
    winner: int | None = Field(default=None, description="of a comparison: the position of the best design")
    rival: int | None = Field(default=None, description="the position of the design that decides against it")
    fit: Fit | None = Field(
        default=None, description="of a comparison: whether the best design fits its part at every value"
    )
    equals: tuple[int, ...] = Field(
        default=(), description="positions of designs that equal the best one at every value; they are no rivals"
    )


def need_verdict(
    result: Result, figure: ResultFigure | str, limit: float, *, at_least: bool = False, strict: bool = False
) -> Verdict:
    """True if a figure of a result is at most ``limit`` (in its unit), or ``at_least`` it.

    ``strict``: a value that is equal to the limit does not do.
    """
    declared = named(figure)
    value = result.figure(declared)
    reason = _unassessed(result, declared)
    if value is None:
        return Verdict(state="not assessed", figure=declared.name, reason=f"there is no {declared.label}")
    margin = value - limit if at_least else limit - value
    holds = margin > 0 or (margin == 0 and not strict)
    if reason:
        return Verdict(state="not assessed", figure=declared.name, holds=holds, margin=margin, reason=reason)
    ends = ends_of(result, declared) if isinstance(declared, DerivedFigure) else None
    if not priced(declared) and (ends is None or ends[0] == ends[1]):
        state: State = "proved" if holds else "refuted"
        verdict = Verdict(state=state, figure=declared.name, holds=holds, margin=margin, least=margin, most=margin)
        return _with_demand(verdict, result, declared, limit, at_least=at_least)
    inputs = Inputs()
    sides = (limit, result) if at_least else (result, limit)
    verdict = _judged(declared, _difference(inputs, declared, *sides), inputs)
    return verdict.model_copy(update={"holds": holds})


def _difference(inputs: Inputs, figure: ResultFigure, ours: Result | float, theirs: Result | float) -> Difference:
    """The excess of a figure of the second over the same figure of the first; a number stands for a limit."""
    if isinstance(figure, DerivedFigure):
        own, its = (Side.of(each, figure, inputs) for each in (ours, theirs))
        return DerivedMargin(own, its, inputs.by_id)
    one, other = (
        inputs.sums(each, figure.name) if isinstance(each, Result) else ((Monomial(each, {}),),)
        for each in (ours, theirs)
    )
    return Margin(one, other, inputs.by_id)


def constraint_verdict(result: Result, constraint: Constraint) -> Verdict:
    """True if a result keeps a constraint; of two bounds, about the one that is harder to keep.

    A design without a part has a share of 0 of what a part has.
    """
    figure = constraint.figure
    budgets = {use.resource: use.budget for use in result.resources}
    if figure.is_resource and result.part is None and not result.reasons:
        keeps = all(bound not in LOWER or limit == 0 for bound, limit in constraint.bounds.items())
        return Verdict(state="proved" if keeps else "refuted", figure=figure.name, holds=keeps)
    scale = budgets.get(figure.name, 1) if constraint.of_part else 1
    verdicts = [
        need_verdict(result, figure, limit * scale, at_least=bound in LOWER, strict=bound in STRICT)
        for bound, limit in constraint.bounds.items()
    ]
    order: tuple[State, ...] = ("refuted", "not assessed", "depends", "proved")
    return min(verdicts, key=lambda verdict: (verdict.holds is not False, order.index(verdict.state)))


def _with_demand(verdict: Verdict, result: Result, figure: ResultFigure, limit: float, *, at_least: bool) -> Verdict:
    """The verdict about a resource over the interval of its demand; of another figure, as it is."""
    items = [item for use in result.resources if use.resource == figure.name for item in use.items]
    least, most = (sum(item.figure.interval[end] for item in items) for end in (0, 1))
    if not figure.is_resource or least == most:
        return verdict
    low, high = (least - limit, most - limit) if at_least else (limit - most, limit - least)
    verdict = verdict.model_copy(update={"least": low, "most": high})
    if (low >= 0) == (high >= 0):
        return verdict
    item = max(items, key=lambda item: item.figure.interval[1] - item.figure.interval[0])
    margin = verdict.margin or 0.0
    decider = Decider(
        name=item.name, platform="", figure=item.figure, flips_at=item.figure.value + (-margin if at_least else margin)
    )
    return verdict.model_copy(update={"state": "depends", "decides": decider})


def winner_verdict(results: Sequence[Result] | Rivals, figure: ResultFigure | str) -> Verdict:
    """True if the best of several results by a figure is the best at every value inside all intervals.

    Results that share an input have one value of it. Those that are infeasible or have no such figure take no part.
    ``winner``, ``rival`` and ``equals`` are positions in ``results``. After a verdict that is not proved, the rest is
    looked at only up to the ``NEAREST`` designs: what lies further off hardly flips first. Of designs that lie further
    off and would have to be simulated, at most ``MOST_SIMULATED`` are looked at; the reason then says so.
    """
    rivals = Listed(results) if isinstance(results, Sequence) else results
    declared = named(figure)
    values = rivals.values(declared)
    held = np.flatnonzero(~np.isnan(values))
    if not len(held):
        return Verdict(state="not assessed", figure=declared.name, reason=f"no design has {declared.label}")
    ranked = held[np.lexsort((held, -values[held] if declared.maximise else values[held]))]
    contest = _Contest(rivals, declared, values, int(ranked[0]))
    contest.look(ranked[1 : NEAREST + 1])
    contest.look_further(ranked[NEAREST + 1 :])
    return contest.verdict()


_OPEN = "not proved: the bounds of the difference leave it open"

NEAREST = 32
"""Designs nearest to the best one that are always looked at."""

MOST_SIMULATED = 64
"""Designs further off that are simulated to be looked at, at most."""


class _Contest:
    """The best of several designs by a figure against the others, by their positions."""

    def __init__(self, rivals: Rivals, figure: ResultFigure, values: Floats, winner: int) -> None:
        self._rivals, self._figure, self._values, self._winner = rivals, figure, values, winner
        self._verdicts: list[Verdict] = []
        self._equals: list[int] = []
        self._left = 0

    @cached_property
    def _margins(self) -> tuple[Floats, Floats]:
        """The bounds of the margin over each that follow from the intervals of the two alone; NaN: none do."""
        assessed = self._rivals.assessed(lambda result: _unassessed_run(result, self._figure))
        low, high = (
            np.where(assessed & assessed[self._winner], end, np.nan) for end in self._rivals.ends(self._figure)
        )
        if self._figure.maximise:
            low, high = -high, -low
        return low - high[self._winner], high - low[self._winner]

    def look(self, others: Positions) -> None:
        """Hold the best one against others one by one. What the intervals prove needs no full result."""
        held = self._rivals.result if priced(self._figure) else self._rivals.shared
        for number in others.tolist():
            ours, theirs = float(self._values[self._winner]), float(self._values[number])
            margin = ours - theirs if self._figure.maximise else theirs - ours
            if priced(self._figure) and not self._rivals.at_hand(number) and self._margins[0][number] > 0:
                least, most = (float(ends[number]) for ends in self._margins)
                verdict = Verdict(
                    state="proved", figure=self._figure.name, holds=True, margin=margin, least=least, most=most
                )
            else:
                verdict = _against(held(self._winner), held(number), self._figure, margin)
            if verdict.least == verdict.most == 0:
                self._equals.append(number)
            else:
                self._verdicts.append(verdict.model_copy(update={"rival": number}))

    def look_further(self, others: Positions) -> None:
        """Hold it against those that lie further off, nearest first, until one verdict is not proved."""
        if not len(others) or not self._proved:
            return
        if priced(self._figure):
            # Intervals that do not even touch: then the better one is the better at every value.
            self._look_one_by_one(others[~(self._margins[0][others] > 0)])
            return
        known = self._rivals.assessed(lambda result: _unassessed_run(result, self._figure))[others]
        first = int(np.argmin(known)) if not known.all() else len(others)
        equal = self._values[others[:first]] == self._values[self._winner]
        self._equals += others[:first][equal].tolist()
        self.look(np.concatenate([others[:first][~equal][:1], others[first : first + 1]]))

    def _look_one_by_one(self, others: Positions) -> None:
        simulated = 0
        for place, number in enumerate(others.tolist()):
            simulated += not self._rivals.at_hand(number)
            if not self._proved:
                return
            if simulated > MOST_SIMULATED:
                self._left = len(others) - place
                return
            self.look(others[place : place + 1])

    @property
    def _proved(self) -> bool:
        return all(each.state == "proved" for each in self._verdicts)

    def verdict(self) -> Verdict:
        """The verdict against the one that is hardest to beat."""
        reason = "all others are equal" if self._equals else "no other design"
        none = Verdict(state="proved", figure=self._figure.name, holds=True, reason=reason)
        hardest = min(self._verdicts, key=_hardness, default=none)
        if self._left and self._proved:
            why = f"{counted(self._left, 'design')} within its interval lie further off and were not compared"
            hardest = hardest.model_copy(update={"state": "depends", "reason": why})
        fit = fit_verdict(self._rivals.result(self._winner))
        return hardest.model_copy(update={"winner": self._winner, "fit": fit, "equals": tuple(self._equals)})


def _hardness(verdict: Verdict) -> tuple[int, float]:
    """The first verdict is the one that says least for the winner: then the one that the smallest change flips."""
    order = ("not assessed", "depends", "refuted", "proved")
    decides, change = verdict.decides, float("inf")
    if decides is not None and decides.flips_at is not None:
        change = abs(decides.flips_at - decides.figure.value) / (abs(decides.figure.value) or 1.0)
    return order.index(verdict.state), change


def _against(winner: Result, other: Result, figure: ResultFigure, margin: float) -> Verdict:
    reason = _unassessed(winner, figure) or _unassessed(other, figure)
    if reason:
        return Verdict(state="not assessed", figure=figure.name, holds=True, margin=margin, reason=reason)
    if not priced(figure):
        return Verdict(state="proved", figure=figure.name, holds=True, margin=margin, least=margin, most=margin)
    inputs = Inputs()
    sides = (other, winner) if figure.maximise else (winner, other)
    return _judged(figure, _difference(inputs, figure, *sides), inputs)


def _unassessed(result: Result, figure: ResultFigure) -> str:
    """The reason for no verdict about a figure of a result; "" if there is one."""
    return _unassessed_run(result, figure) or (_unpriced(result, figure) if priced(figure) else "")


def _unassessed_run(result: Result, figure: ResultFigure) -> str:
    """The reason for no verdict about a figure of a run of this kind, whatever its terms; "" if there may be one."""
    if result.mission is not None or result.fleet is not None:
        kind = "mission" if result.mission is not None else "fleet"
        return f"a {kind} has no closed form: what the robot meets depends on when it arrives"
    names = figure.names if isinstance(figure, DerivedFigure) else (figure.name,)
    if "cycles" in names and (result.part is None or result.external_memory is not None):
        return "the cycles rest on figures of processor or memory"
    return ""


def _unpriced(result: Result, figure: ResultFigure) -> str:
    """The reason for which a figure that rests on intervals is no sum of terms; "" if it is one, or is made of such."""
    if isinstance(figure, DerivedFigure):
        parts = (FIGURES[name] for name in figure.names)
        whys = (_unpriced(result, part) for part in parts if priced(part))
        undefined = "" if ends_of(result, figure) else "it has no value somewhere inside the intervals"
        return next(filter(None, whys), undefined)
    if result.terms is None:
        return "the result has no terms"
    if figure.name == "power" or result.terms.plans(figure.name):
        return ""
    return result.terms.open.get(figure.name, f"{figure.label} is no sum of terms")


def _judged(figure: ResultFigure, margin: Difference, inputs: Inputs) -> Verdict:
    least, most = margin.least(), margin.reversed.least()
    value = float(margin.at())
    state: State = "proved" if least.value > 0 else "refuted" if most.value > 0 else "depends"
    verdict = Verdict(
        state=state, figure=figure.name, holds=value >= 0, margin=value, least=least.value, most=-most.value
    )
    if state != "depends":
        return verdict
    swings = {name: margin.swing(name) for name in margin.varying() if inputs.by_id[name].measurable}
    flips = {name: flip for name in swings if (flip := margin.flip(name)) is not None}
    deciding = max(flips or swings, key=swings.__getitem__, default=None)
    if deciding is None and not isinstance(margin, Margin):
        return verdict.model_copy(update={"reason": _OPEN})
    if deciding is None:
        return verdict.model_copy(update={"reason": "it lies within the waits for clock edges"})
    reason = "" if flips else "no figure changes it by itself, several together do"
    if not flips and not (least.exact and most.exact):
        reason = _OPEN
    each = inputs.by_id[deciding]
    decider = Decider(
        name=each.name, platform=each.platform, figure=inputs.figures[deciding], flips_at=flips.get(deciding)
    )
    return verdict.model_copy(update={"decides": decider, "reason": reason})


def together(result: Result, figure: ResultFigure | str, limit: float) -> tuple[Decider, ...]:
    """The figures that together change whether a figure of a result is at most ``limit``, with the values at which.

    Each is moved by the same share of the way to that end of its interval which is the worse one for what holds now.
    The one that moves the margin most is first. Empty if even these ends change nothing.
    """
    inputs = Inputs()
    margin = _difference(inputs, named(figure), result, limit)
    own = {name: inputs.by_id[name] for name in margin.varying() if inputs.by_id[name].measurable}
    sign = 1.0 if margin.at() >= 0 else -1.0
    ends = {
        name: min((sign * float(margin.at({name: end})), end) for end in (each.value, each.low, each.high))[1]
        for name, each in own.items()
    }

    def at(share: float) -> dict[str, float]:
        return {name: each.value + share * (ends[name] - each.value) for name, each in own.items()}

    if sign * float(margin.at(at(1.0))) >= 0:
        return ()
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if sign * float(margin.at(at(middle))) >= 0 else (low, middle)
    moved = (name for name, each in own.items() if ends[name] != each.value)
    return tuple(
        Decider(name=own[name].name, platform=own[name].platform, figure=inputs.figures[name], flips_at=value)
        for name in sorted(moved, key=margin.swing, reverse=True)
        for value in (at(high)[name],)
    )


def sensitivity(result: Result, figure: ResultFigure | str) -> tuple[Swing, ...]:
    """The effect of each figure with an interval, by itself, on a figure of a result, the widest first.

    Empty if the figure rests on none, or is no sum of terms.
    """
    inputs = Inputs()
    declared = named(figure)
    if isinstance(declared, DerivedFigure):
        if not ends_of(result, declared):
            return ()
    elif not inputs.sums(result, declared.name):
        return ()
    # The margin of a figure against 0 is the figure itself.
    figures = _difference(inputs, declared, 0.0, result)
    swings = []
    for name in figures.varying():
        each = inputs.by_id[name]
        ends = sorted(float(figures.at({name: end})) for end in (each.low, each.high))
        if each.measurable and ends[0] < ends[1]:
            swings.append(Swing(name=each.name, figure=inputs.figures[name], least=ends[0], most=ends[1]))
    return tuple(sorted(swings, key=lambda swing: swing.least - swing.most))
