"""A study as raw columns: what a CSV file and a data frame hold, each name with the unit of its numbers."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import InputError
from codesign.exploration.constraints import Floats
from codesign.exploration.outcomes import STATES, Outcomes, Some
from codesign.figures import FIGURES, ResultFigure
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.units import PICOSECONDS_PER_SECOND, SCALES, Dimension, parse_quantity

if TYPE_CHECKING:
    from codesign.exploration.study import Study

Scalar = float | int | str | bool | None

_SUFFIXES = {
    Dimension.TIME: "s",
    Dimension.FREQUENCY: "hz",
    Dimension.DATA: "bits",
    Dimension.DATA_RATE: "bits_s",
    Dimension.SPEED: "m_s",
    Dimension.ACCELERATION: "m_s2",
    Dimension.TURN_RATE: "rad_s",
}
"""The end of a column's name by dimension, where it is not the base unit in lower case."""


def study_columns(study: Study, points: NDArray[np.int64] | None = None) -> dict[str, list[Scalar]]:
    """The columns of a study by name, with one entry a point, by the indices of points; by default of all computed.

    The columns are ``index``, the axes, the declared figures that any point has (the objectives first), ``feasible``,
    ``on_front`` and ``state``. Behind a figure that rests on intervals stand its least and its greatest value, in the
    columns ``FIGURE_low`` and ``FIGURE_high``. Over conditions, ``design`` and the conditions too. An axis of
    quantities, such as ``100 MHz``, is a column of numbers in the base unit. Its name ends with that unit:
    ``fabric.clock_hz``. Lists and mappings are JSON texts. A figure that a point does not have is None.
    """
    judged = study.judged
    indices = study.outcomes.computed if points is None else points
    columns: dict[str, list[Scalar]] = {"index": indices.tolist()}
    if study.conditions:
        columns["design"] = [*(indices // judged.conditions).tolist()]
    levels = study.space.levels(indices)
    for axis, values in study.every_axis.items():
        name, entries = axis_column(axis, values)
        # The number -1 of an axis that does not exist takes the last one.
        entries.append(None)
        columns[name] = [entries[level] for level in levels[axis].tolist()]
    for column in study.figure_columns:
        columns[column.name] = _entries(column.of(indices), whole=column.whole)
    columns["feasible"] = judged.feasible_points[indices].tolist()
    columns["on_front"] = study.on_front[indices // judged.conditions].tolist()
    columns["state"] = [STATES[state] for state in study.outcomes.state[indices].tolist()]
    return columns


@dataclass(frozen=True)
class FigureColumn:
    """A column of a study with a figure, or with an end of its interval.

    ``of``: of some points, float64; NaN: none. ``whole``: it counts.
    """

    name: str
    of: Callable[[Some], Floats]
    whole: bool = False


def figure_columns(study: Study) -> list[FigureColumn]:
    """The columns of the figures that any point has, the objectives first; behind each the ends of its interval."""
    outcomes, columns = study.outcomes, []
    for figure in dict.fromkeys((*study.objectives, *study.figures.values(), *FIGURES.values())):
        if np.isnan(outcomes.column(figure)).all():
            continue
        columns.append(
            FigureColumn(figure.column, partial(outcomes.column, figure), figure.counted == "count")
        )
        if not np.isnan(outcomes.bounds(figure)[0]).all():
            columns += [
                FigureColumn(f"{figure.column}_{end}", partial(_end, outcomes, figure, number))
                for number, end in enumerate(("low", "high"))
            ]
    return columns


def _end(outcomes: Outcomes, figure: ResultFigure, number: int, within: Some) -> Floats:
    """The least or the greatest value of a figure inside all intervals, of some points."""
    return outcomes.bounds(figure, within)[number]


def _entries(column: Floats, *, whole: bool = False) -> list[Scalar]:
    """Numbers as a file has them: None in place of NaN, and counts as integers."""
    entries: list[Scalar] = column.tolist()
    for place in np.flatnonzero(np.isnan(column)).tolist():
        entries[place] = None
    return [each if each is None else round(each) for each in entries] if whole else entries  # type: ignore[arg-type]


def provenance_columns(study: Study, points: NDArray[np.int64]) -> dict[str, list[Scalar]]:
    """The columns that say where some points come from, for what is written.

    They are the same for all points, but for the digest of the platform.
    """
    columns: dict[str, list[Scalar]] = {}
    provenance = study.provenance
    if provenance is None:
        return columns
    digests, single = provenance.platform_digests, study.platform
    names = [single] * len(points)
    if PLATFORM_AXIS in study.every_axis:
        values = [*map(str, study.every_axis[PLATFORM_AXIS]), single]
        levels = study.space.levels(points)[PLATFORM_AXIS]
        names = [values[level] for level in levels.tolist()]
    for name, text in provenance.stamped().constants.items():
        if name == "workload_digest":
            columns["platform_digest"] = [digests.get(platform) for platform in names]
        columns[name] = [text] * len(points)
    return columns


def axis_column(axis: str, values: Sequence[Any]) -> tuple[str, list[Scalar]]:
    """The name of an axis' column, and the entry for each value."""
    for dimension in Dimension:
        numbers = [_quantity(value, dimension) for value in values]
        if numbers and None not in numbers:
            suffix = _SUFFIXES.get(dimension, SCALES[dimension].base.lower())
            return f"{axis}_{suffix}", [*numbers]
    return axis, [
        value if isinstance(value, str | int | float | None) else json.dumps(value, sort_keys=True)
        for value in values
    ]


def order_of(axis: str, values: Sequence[Any]) -> int:
    """1 where the values of an axis are numbers or quantities that rise, -1 where they fall; else 0.

    >>> order_of("fpga.clock", ["50 MHz", "100 MHz"]), order_of("workload.variant", ["base", "deep"])
    (1, 0)
    """
    entries = axis_column(axis, values)[1]
    numbers = [each for each in entries if isinstance(each, int | float) and not isinstance(each, bool)]
    steps = np.diff(np.array(numbers, np.float64))
    if len(numbers) < len(entries):
        return 0
    return int((steps > 0).all()) - int((steps < 0).all()) if len(steps) else 1


def _quantity(value: Any, dimension: Dimension) -> float | int | None:
    """The number in a quantity's base unit (seconds of a time); None where the value is no such quantity."""
    try:
        exact = parse_quantity(value, dimension) if isinstance(value, str) else None
    except InputError:
        return None
    if exact is None:
        return None
    if dimension is Dimension.TIME:
        return float(Fraction(exact, PICOSECONDS_PER_SECOND))
    return exact if isinstance(exact, int) else float(exact)
