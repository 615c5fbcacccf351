"""A study as raw columns: what a CSV file and a data frame hold, each name with the unit of its numbers."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from codesign.errors import InputError
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


def study_columns(study: Study) -> dict[str, list[Scalar]]:
    """The columns of a study by name, with one entry a point, in the order of the points.

    The columns are ``index``, the axes, the declared figures that any point has (the objectives first), ``feasible``,
    ``on_front`` and ``state``. Behind a figure that rests on intervals stand its least and its greatest value, in the
    columns ``FIGURE_low`` and ``FIGURE_high``. Over conditions, ``design`` and the conditions too. An axis of
    quantities, such as ``100 MHz``, is a column of numbers in the base unit. Its name ends with that unit:
    ``fabric.clock_hz``. Lists and mappings are JSON texts. A figure that a point does not have is None.
    """
    count = len(study.world.each)
    front = {index for first in study.front for index in (first, *study.same.get(first, ()))}
    columns: dict[str, list[Scalar]] = {"index": [point.index for point in study.points]}
    if study.conditions:
        columns["design"] = [point.index // count for point in study.points]
    for axis, values in study.every_axis.items():
        name, numbers = _axis_column(axis, values)
        columns[name] = [numbers.get(_text(point.axes.get(axis))) for point in study.points]
    for figure in dict.fromkeys((*study.objectives, *FIGURES.values())):
        values_of_points = [_typed(figure, point.figure(figure)) for point in study.points]
        if any(value is not None for value in values_of_points):
            columns[figure.column] = values_of_points
            columns |= _ends(study, figure)
    columns["feasible"] = [point.feasible for point in study.points]
    columns["on_front"] = [point.index // count in front for point in study.points]
    columns["state"] = [point.state for point in study.points]
    return columns


def _ends(study: Study, figure: ResultFigure) -> dict[str, list[Scalar]]:
    """The least and the greatest value of a figure inside all intervals, of each point; empty where none has them."""
    results = (point.result for point in study.points)
    ends = [None if result is None else result.interval(figure) for result in results]
    if not any(ends):
        return {}
    return {
        f"{figure.column}_{name}": [None if each is None else each[place] for each in ends]
        for place, name in enumerate(("low", "high"))
    }


def provenance_columns(study: Study) -> dict[str, list[Scalar]]:
    """The columns that say where the points come from, for what is written.

    They are the same for all points, but for the digest of the platform.
    """
    columns: dict[str, list[Scalar]] = {}
    provenance = study.provenance
    if provenance is None:
        return columns
    digests, single = provenance.platform_digests, study.platform
    names = [str(point.axes.get(PLATFORM_AXIS, single)) for point in study.points]
    for name, text in provenance.stamped().constants.items():
        if name == "workload_digest":
            columns["platform_digest"] = [digests.get(platform) for platform in names]
        columns[name] = [text] * len(study.points)
    return columns


def _typed(figure: ResultFigure, value: float | None) -> Scalar:
    return round(value) if figure.counted == "count" and value is not None else value


def _text(value: Any) -> str:
    return json.dumps(value, sort_keys=True)


def _axis_column(axis: str, values: Sequence[Any]) -> tuple[str, Mapping[str, Scalar]]:
    """The name of an axis' column, and the entry for each value by its JSON text."""
    for dimension in Dimension:
        numbers = [_quantity(value, dimension) for value in values]
        if numbers and None not in numbers:
            suffix = _SUFFIXES.get(dimension, SCALES[dimension].base.lower())
            texts = map(_text, values)
            return f"{axis}_{suffix}", dict(zip(texts, numbers, strict=True))
    plain = [value if isinstance(value, str | int | float | None) else _text(value) for value in values]
    return axis, dict(zip(map(_text, values), plain, strict=True))


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
