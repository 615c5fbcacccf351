"""Results held against constraints: a reason for each bound that a figure does not keep."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.inputs.constraint import LOWER, STRICT, Bound, Constraint
from codesign.inputs.derived import DerivedFigure
from codesign.system.results.result import Reason, Result

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Why = tuple[str, Flags]
"""A reason, and what it is the reason of."""


def figure_of(result: Result, figure: ResultFigure) -> float | None:
    """One figure as designs are compared by it. A design that needs no chip takes none of a chip's resources."""
    if isinstance(figure, DerivedFigure):
        return figure.of(lambda name: figure_of(result, FIGURES[name]))
    value = result.figure(figure)
    placed = not any(reason.kind == "mapping" for reason in result.reasons)
    if value is None and figure.is_resource and result.part is None and not result.resources and placed:
        return 0.0
    return value


def with_constraints(result: Result, constraints: tuple[Constraint, ...]) -> Result:
    """The result with a reason for every constraint that it does not satisfy.

    A figure that a feasible point does not have (no start arrives, so no path length) satisfies no
    constraint; one that a point lacks because it does not fit, and was never run, is not held against it.
    """
    unreached = result.mission is not None and not result.mission.reached
    reasons = [
        reason
        for limit in constraints
        for reason in unsatisfied(
            limit,
            lambda name: figure_of(result, FIGURES[name]),
            budget_of(result, limit),
            feasible=result.feasible,
            unreached=unreached,
        )
    ]
    if not reasons:
        return result
    return result.model_copy(update={"feasible": False, "reasons": (*result.reasons, *reasons)})


def budget_of(result: Result, constraint: Constraint) -> int | None:
    """The budget of the part of a resource that a constraint bounds by a share; None if it bounds none so."""
    if not constraint.of_part:
        return None
    return next((use.budget for use in result.resources if use.resource == constraint.figure.name), None)


def unsatisfied(
    constraint: Constraint,
    figure: Callable[[str], float | None],
    budget: int | None,
    *,
    feasible: bool,
    unreached: bool,
) -> list[Reason]:
    """A reason for each bound that the value of the constrained figure does not keep; see ``broken_bounds``.

    ``figure``: the value of a declared figure by its name.
    """
    own = constraint.figure
    value = own.of(figure) if isinstance(own, DerivedFigure) else figure(own.name)

    def column(name: str) -> Floats:
        held = figure(name)
        return np.array([math.nan if held is None else held], np.float64)

    bounds = broken_bounds(
        constraint,
        np.array([math.nan if value is None else value], np.float64),
        np.array([math.nan if budget is None else budget], np.float64),
        feasible=np.array([feasible]),
        unreached=np.array([unreached]),
        whys=lambda: whys_of(own, column),
    )
    return [bound.reason(0) for bound in bounds]


def bound_names(constraint: Constraint) -> dict[Bound, str]:
    """The name of each bound of a constraint, as its reason has it."""
    names = {bound: f"{constraint.figure} {bound.replace('_', ' ')}" for bound in constraint.bounds}
    if not constraint.of_part:
        return names
    return {bound: f"{name} {100 * constraint.bounds[bound]:.6g} %" for bound, name in names.items()}


def whys_of(figure: ResultFigure, columns: Callable[[str], Floats]) -> list[Why]:
    """The reasons for no value of a figure, with the entries that lack it: see ``DerivedFigure.whys``."""
    return figure.whys(columns) if isinstance(figure, DerivedFigure) else []


@dataclass(frozen=True, eq=False)
class Broken:
    """A bound that some values do not keep: ``which`` of them, as indices; of each the numbers of its reason."""

    name: str
    unit: str
    which: NDArray[np.intp]
    demand: Floats
    limit: Floats
    gap: Floats

    def reason(self, place: int) -> Reason:
        """The reason of the value at a place in ``which``."""
        numbers = (float(each[place]) for each in (self.demand, self.limit, self.gap))
        demand, limit, gap = numbers
        return Reason(kind="constraint", name=self.name, demand=demand, limit=limit, gap=gap, unit=self.unit)


def broken_bounds(
    constraint: Constraint,
    values: Floats,
    budgets: Floats,
    *,
    feasible: Flags,
    unreached: Flags,
    whys: Callable[[], Sequence[Why]] = tuple,
) -> list[Broken]:
    """The bounds of a constraint that any of the values does not keep, in the order of the bounds.

    A value that is missing (NaN) keeps no bound where it is ``feasible``; elsewhere it is not held against it.
    ``budgets``: what the parts have of a resource that is bounded by a share, NaN: none; one for all, or one each. A
    design without a part has a share of 0. ``unreached``: whether the mission of each ended before its goals. ``whys``:
    why values are missing, and which; what it does not name is missing without a reason.
    """
    figure, held = constraint.figure, ~np.isnan(values)
    scale = np.broadcast_to(np.where(np.isnan(budgets) | (budgets == 0), 1.0, budgets), values.shape)
    # Of a share the quotient is compared: it is exact where the limit is, which the product is not.
    shares = values / scale
    broken, names = [], bound_names(constraint)
    for bound, limit in constraint.bounds.items():
        sign, name = 1 if bound in LOWER else -1, names[bound]
        over = sign * (limit - shares)
        which = np.flatnonzero(held & ~((over < 0) | ((over == 0) & (bound not in STRICT))))
        most = limit * scale[which]
        gap = np.maximum(0.0, sign * (most - values[which]))
        parts = [Broken(name, figure.unit, which, values[which], most, gap)]
        for why, lacking in _lacking(~held & feasible, unreached, whys):
            which = np.flatnonzero(lacking)
            ends = np.zeros(len(which)), np.full(len(which), limit), np.full(len(which), abs(limit))
            parts.append(Broken(f"{name}: {why}", figure.unit, which, *ends))
        broken += [part for part in parts if len(part.which)]
    return broken


def _lacking(missing: Flags, unreached: Flags, whys: Callable[[], Sequence[Why]]) -> Iterator[Why]:
    """The missing values by the reason, each once."""
    yield "goals not reached", missing & unreached
    left = missing & ~unreached
    for why, where in whys() if left.any() else ():
        yield why, left & where
        left &= ~where
    yield "no such figure", left
