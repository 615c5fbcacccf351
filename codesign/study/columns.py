"""The columns of a study as files have them: CSV, data frames and Parquet are views of one list of columns.

Each name ends with the unit of its numbers. pandas, Polars and DuckDB open the Parquet file as it is: its texts stand
once in a dictionary, and it has one column more, ``reason``: what keeps a point out. Its points are written in groups,
so no more than one group is held besides the study.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.files import written_atomically
from codesign.ground.numbering import Numbering
from codesign.ground.progress import Show, silent, tracked
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.study.conditions import Scalar, axis_column
from codesign.study.constraints import Floats
from codesign.study.groups import Groups
from codesign.study.outcomes import STATES
from codesign.study.table import Table

Points = NDArray[np.int64]
"""Some points, by their indices."""

POINTS_A_GROUP = 1 << 17
_LEVEL = 3
_KINDS: tuple[tuple[str, Any], ...] = (("bool_", bool), ("int64", int), ("float64", int | float))
"""The types of columns in Parquet of which every value is one of these."""


@dataclass(frozen=True)
class Column:
    """One column. ``of``: the numbers of some points; NaN: none. ``whole``: these are counts.

    ``words``: what the numbers stand for, by their place there; -1: nothing.
    """

    name: str
    of: Callable[[Points], NDArray[Any]]
    words: Sequence[Scalar] | None = None
    whole: bool = False

    def entries(self, points: Points) -> list[Scalar]:
        """The values of some points; None where a point has none, and counts as integers."""
        numbers = self.of(points)
        if self.words is not None:
            # The number -1 takes the last one.
            held = [*self.words, None]
            return [held[number] for number in numbers.tolist()]
        entries: list[Scalar] = numbers.tolist()
        for place in np.flatnonzero(np.isnan(numbers)).tolist():
            entries[place] = None
        return [each if each is None else round(each) for each in entries] if self.whole else entries  # type: ignore[arg-type]

    def array(self, points: Points, arrow: Any) -> Any:
        """The values of some points as an array of pyarrow."""
        numbers = self.of(points)
        if self.words is not None:
            places = arrow.array(numbers.astype(np.int32), mask=numbers < 0)
            for kind, types in _KINDS:
                exact = types is bool or not any(isinstance(word, bool) for word in self.words)
                if exact and all(isinstance(word, types) for word in self.words):
                    return arrow.array(self.words, getattr(arrow, kind)()).take(places)
            words = arrow.array([word if isinstance(word, str) else str(word) for word in self.words])
            return arrow.DictionaryArray.from_arrays(places, words.cast(arrow.string()))
        none = np.isnan(numbers)
        if self.whole:
            numbers = np.rint(np.where(none, 0, numbers)).astype(np.int64)
        return arrow.array(numbers, mask=none)


def columns_of(table: Table) -> Iterator[Column]:
    """The columns of a study; see ``study_columns``."""
    judged, outcomes = table.judged, table.outcomes
    yield Column("index", lambda points: points)
    if table.conditions:
        yield Column("design", lambda points: points // judged.conditions)
    for axis, values in table.every_axis.items():
        name, entries = axis_column(axis, values)
        yield Column(name, partial(_levels, table, axis), entries)
    for figure in dict.fromkeys((*table.objectives, *table.figures.values(), *FIGURES.values())):
        if np.isnan(outcomes.column(figure)).all():
            continue
        yield Column(figure.column, partial(outcomes.column, figure), whole=figure.counted == "count")
        if not np.isnan(outcomes.bounds(figure)[0]).all():
            for end in (0, 1):
                name = f"{figure.column}_{('low', 'high')[end]}"
                yield Column(name, partial(_end, table, figure, end))
    yield Column("feasible", lambda points: judged.feasible_points[points])
    yield Column("on_front", lambda points: table.on_front[points // judged.conditions])
    yield Column("state", lambda points: outcomes.state[points], STATES)


def _end(table: Table, figure: ResultFigure, end: int, points: Points) -> Floats:
    return table.outcomes.bounds(figure, points)[end]


def _levels(table: Table, axis: str, points: Points) -> NDArray[np.int32]:
    return table.space.levels(points)[axis]


def study_columns(table: Table, points: Points | None = None) -> dict[str, list[Scalar]]:
    """The columns of a study by name, with one entry a point, by the indices of points; by default of all computed.

    The columns are ``index``, the axes, the declared figures that any point has (the objectives first), ``feasible``,
    ``on_front`` and ``state``. Behind a figure that rests on intervals stand its least and its greatest value, in the
    columns ``FIGURE_low`` and ``FIGURE_high``. Over conditions, ``design`` and the conditions too. An axis of
    quantities, such as ``100 MHz``, is a column of numbers in the base unit. Its name ends with that unit:
    ``fabric.clock_hz``. Lists and mappings are JSON texts. A figure that a point does not have is None.
    """
    indices = table.outcomes.computed if points is None else points
    return {column.name: column.entries(indices) for column in columns_of(table)}


def provenance_columns(table: Table, points: NDArray[np.int64]) -> dict[str, list[Scalar]]:
    """The columns that say where some points come from, for what is written.

    They are the same for all points, but for the digest of the platform.
    """
    columns: dict[str, list[Scalar]] = {}
    provenance = table.provenance
    if provenance is None:
        return columns
    digests, single = provenance.platform_digests, table.platform
    names = [single] * len(points)
    if PLATFORM_AXIS in table.every_axis:
        values = [*map(str, table.every_axis[PLATFORM_AXIS]), single]
        levels = table.space.levels(points)[PLATFORM_AXIS]
        names = [values[level] for level in levels.tolist()]
    for name, text in provenance.stamped().constants.items():
        if name == "workload_digest":
            columns["platform_digest"] = [digests.get(platform) for platform in names]
        columns[name] = [text] * len(points)
    return columns


def write_parquet(table: Table, path: Path, show: Show = silent) -> None:
    """Write every computed point of a study. The file is there whole, or not at all. ``show`` is told how far it is.

    Raises:
        InputError: pyarrow is not installed. RunError: the file cannot be written.
    """
    arrow, parquet = libraries()
    columns, computed = [*columns_of(table), _reason_column(table)], table.outcomes.computed
    kinds = [(column.name, column.array(computed[:0], arrow).type) for column in columns]
    schema = arrow.schema(kinds, _metadata(table))
    groups = [computed[begin : begin + POINTS_A_GROUP] for begin in range(0, len(computed), POINTS_A_GROUP)]
    with (
        written_atomically(path) as target,
        parquet.ParquetWriter(target, schema, compression="zstd", compression_level=_LEVEL) as writer,
    ):
        for group in tracked(groups, show, "rows of Parquet written", len(computed), size=len):
            arrays = [column.array(group, arrow) for column in columns]
            writer.write_table(arrow.Table.from_arrays(arrays, schema=schema))


def libraries() -> tuple[Any, Any]:
    """pyarrow, and its module for Parquet.

    Raises:
        InputError: it is not installed.
    """
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        raise InputError(
            "a Parquet file needs pyarrow", hint="pip install 'hwsw-codesign[parquet]', or pip install pyarrow"
        ) from None
    return pyarrow, parquet


def _reason_column(table: Table) -> Column:
    """Every text of what keeps a point out, and the number of the text of each point; -1: nothing does.

    The text of a point names each limit that it passes, such as ``resource slices; clock fpga``. That of a failed point
    is its message.
    """
    outcomes = table.outcomes
    texts = Numbering({"": 0})

    def number(reasons: Sequence[Any]) -> int:
        return texts["; ".join(f"{each.kind} {each.name}" for each in reasons)]

    code = np.asarray(outcomes.each(lambda template: number(template.reasons), 0), np.int64)
    late = np.array([*(number((reason,)) for reason in outcomes.reasons), 0], np.int64)[outcomes.reason]
    failed = np.zeros(len(outcomes), np.int64)
    for index, message in outcomes.failures.items():
        failed[index] = texts[message]
    parts = [code, late]
    for broken in table.judged.broken_points:
        parts.append(np.zeros(len(outcomes), np.int64))
        parts[-1][broken.which] = texts[f"constraint {broken.name}"]
    words, numbers = [*texts], failed
    for part in parts:
        pairs = numbers * len(words) + part
        groups = Groups.of(pairs)
        each = [divmod(pair, len(words)) for pair in pairs[groups.firsts].tolist()]
        joined = ["; ".join(filter(None, (words[one], words[other]))) for one, other in each]
        # What has a number keeps it.
        place = {text: number for number, text in enumerate(dict.fromkeys((*words, *joined)))}
        words, numbers = [*place], np.array([place[text] for text in joined], np.int64)[groups.which]
    groups = Groups.of(numbers)
    kept = [words[number] for number in numbers[groups.firsts].tolist()]
    places = np.array([number if text else -1 for number, text in enumerate(kept)], np.int32)[groups.which]
    return Column("reason", lambda within: places[within], kept)


def _metadata(table: Table) -> dict[str, str]:
    """The origin of the points: platform, workload and provenance."""
    provenance = table.provenance
    texts = {} if provenance is None else provenance.stamped().constants
    named = {"platform": table.platform, "workload": table.workload, **texts}
    return {f"hwsw.{name}": str(text) for name, text in named.items()}
