"""The share of the spread of a figure that each axis moves: shares of the variance over the feasible designs.

On a full grid, where every combination of the axes has the figure, the shares are the indices of Sobol, exactly:

- main: Var(E[y | x_i]) / Var(y), what the axis moves by itself;
- total: E[Var(y | all other axes)] / Var(y), what it moves by itself and together with others.

Designs that are out leave holes in the grid. Then the same two questions are asked of the designs that are there:

- main: how much variance the additive model μ + Σ a_i(x_i), fitted by least squares, loses without the axis;
- total: the variance inside the groups of designs that differ in this axis alone, which is left where all other axes
  are known.

On a full grid both are the indices above, because the axes are then orthogonal. With holes they need not add up:
what two axes move only together counts for neither main share. An axis with few pairs (``paired``) says little: a group
of one design has no variance, so its total share is a lower bound.

An axis may exist for some values of another only. The other then moves what depends on it, too: its main share is what
the model without all of these axes loses when it is left out, and they are free in its groups. (These are sums of
squares of type II, and a nested axis is a term that holds the axis it depends on.)
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import ResultFigure
from codesign.inputs.axes import When, ordered
from codesign.study.groups import Groups
from codesign.study.table import Table
from codesign.system.explanation import AxisEffect

NO_SPREAD = 1e-12
"""A figure does not vary if its standard deviation is below this share of its largest value."""

Levels = NDArray[np.intp]
Values = NDArray[np.float64]


def axis_effects(table: Table, figures: Sequence[ResultFigure]) -> tuple[AxisEffect, ...]:
    """The effect of each axis with several values on each figure, over the feasible designs that have it.

    Over conditions the figures are the aggregated ones. Axes are in the order of the study, the figures of each in the
    order given.
    """
    names = [name for name, values in table.axes.items() if len(values) > 1]
    inside = [[names.index(each) for each in inside_of(table.when, name) if each in names] for name in names]
    judged = table.judged
    effects = []
    for figure in figures:
        column = judged.figure(figure)
        held = np.flatnonzero(judged.feasible & ~judged.unreached & ~np.isnan(column))
        of_axes = table.decisions.levels(held)
        levels = [_last_of_equals(table, name)[of_axes[name]] for name in names]
        values = column[held]
        matrix = np.array(levels, np.intp).reshape(len(names), len(held)).T
        shares = variance_shares(matrix, values, inside)
        effects += [
            AxisEffect(
                axis=name, figure=figure.name, main=main, total=total, complete=len(held) == judged.count, paired=paired
            )
            for name, (main, total, paired) in zip(names, shares, strict=True)
        ]
    order = {name: place for place, name in enumerate(names)}
    return tuple(sorted(effects, key=lambda effect: order[effect.axis]))


def _last_of_equals(table: Table, name: str) -> Levels:
    """For each value of an axis the number of the last one that is equal as JSON; behind them, of no value."""
    texts = {json.dumps(value): place for place, value in enumerate(table.axes[name])}
    return np.array([*(texts[json.dumps(value)] for value in table.axes[name]), len(table.axes[name])], np.intp)


def inside_of(when: When, axis: str) -> list[str]:
    """The axes that exist for some values of an axis only, by themselves or by others between them."""
    inside: list[str] = []
    for other in ordered(when, when):
        if any(each == axis or each in inside for each in when[other]):
            inside.append(other)
    return inside


def variance_shares(
    levels: Levels, values: Values, inside: Sequence[Sequence[int]] | None = None
) -> list[tuple[float | None, float | None, float]]:
    """The main share, the total share, and the share of designs with a partner, of each axis.

    Args:
        levels: designs × axes, the number of the value of each axis. values: of each design, finite.
        inside: of each axis those that exist for some of its values only.

    >>> grid = np.array([(a, b) for a in range(2) for b in range(2)])
    >>> variance_shares(grid, np.array([0.0, 1.0, 2.0, 3.0]))  # y = 2 a + b
    [(0.8, 0.8, 1.0), (0.2, 0.2, 1.0)]
    """
    count, axes = levels.shape
    if not count:
        return [(None, None, 0.0)] * axes
    centred = values - values.mean()
    whole = float(centred @ centred)
    varies = whole > count * (NO_SPREAD * float(np.abs(values).max())) ** 2
    model = _Additive(levels, centred) if varies else None
    explained = 0.0 if model is None else model.explained()
    shares: list[tuple[float | None, float | None, float]] = []
    for axis in range(axes):
        nested = [] if inside is None else list(inside[axis])
        left, paired = _inside_groups(np.delete(levels, [axis, *nested], axis=1), centred)
        main = None
        if model is not None:
            both = model.explained(nested) if nested else explained
            main = (both - model.explained([axis, *nested])) / whole
        total = left / whole if varies else None
        shares.append((_share(main), _share(total), paired))
    return shares


def _share(value: float | None) -> float | None:
    """A share without the last bits of its sums, which could make 0 a little less."""
    return None if value is None else min(max(round(value, 12), 0.0), 1.0)


def _inside_groups(others: Levels, centred: Values) -> tuple[float, float]:
    """The sum of squares inside the groups of equal rows, and the share of the rows in groups of several."""
    # The group of a row in mixed radix over the other axes; renumbered where most numbers are not met.
    number = np.zeros(len(centred), np.int64)
    for column in others.T:
        number = number * (int(column.max()) + 1) + column
    if len(centred) and number.max() > 4 * len(centred):
        number = Groups.of(number).which
    # Σ over groups of Σ (y - mean of the group)².
    sizes = np.bincount(number)
    means = np.bincount(number, centred) / np.maximum(sizes, 1)
    left = centred - means[number]
    return float(left @ left), float((sizes[number] > 1).mean())


class _Additive:
    """The additive model of a figure by its normal equations, of all axes or without one of them.

    A column of the model says whether a design has one value of one axis. The products of two columns are counts.
    """

    def __init__(self, levels: Levels, centred: Values) -> None:
        sizes = levels.max(axis=0) + 1 if len(levels) else np.zeros(levels.shape[1], np.intp)
        self._axis = np.repeat(np.arange(len(sizes)), sizes)
        width = len(self._axis)
        columns = [column + begin for column, begin in zip(levels.T, np.cumsum(sizes) - sizes, strict=True)]
        # Xᵀ X and Xᵀ y of the model's columns X: (Xᵀ X)[i, j] counts the designs with value i and value j, and
        # (Xᵀ y)[i] sums the figure over the designs with value i.
        self._products = np.zeros((width, width))
        self._sums = np.zeros(width)
        for number, left in enumerate(columns):
            self._sums += np.bincount(left, centred, minlength=width)
            for right in columns[number:]:
                counts = np.bincount(left * width + right, minlength=width * width).reshape(width, width)
                self._products += counts if left is right else counts + counts.T

    def explained(self, without: Sequence[int] = ()) -> float:
        """The sum of squares that the model explains without some axes."""
        kept = np.flatnonzero(~np.isin(self._axis, without))
        if not len(kept):
            return 0.0
        fitted = np.linalg.lstsq(self._products[np.ix_(kept, kept)], self._sums[kept], rcond=1e-10)[0]
        return float(fitted @ self._sums[kept])
