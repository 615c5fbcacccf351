"""A study as a Parquet file: columns that pandas, Polars and DuckDB open as they are.

The columns are those of ``rows.study_columns``, with the same names and units, and ``reason``: what keeps a point out.
Texts stand once in a dictionary. The points are written in groups, so no more than one group is held besides the study.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.errors import InputError
from codesign.exploration.outcomes import STATES
from codesign.exploration.rows import FigureColumn, axis_column
from codesign.files import written_atomically
from codesign.progress import Show, silent, tracked

if TYPE_CHECKING:
    from codesign.exploration.study import Study

Points = NDArray[np.int64]
"""Some points, by their indices."""

POINTS_A_GROUP = 1 << 17
_LEVEL = 3


def write_parquet(study: Study, path: Path, show: Show = silent) -> None:
    """Write every computed point of a study. The file is there whole, or not at all. ``show`` is told how far it is.

    Raises:
        InputError: pyarrow is not installed. RunError: the file cannot be written.
    """
    arrow, parquet = libraries()
    columns = dict(_columns(study, arrow))
    schema = arrow.schema([(name, each[0]) for name, each in columns.items()], _metadata(study))
    computed = study.outcomes.computed
    groups = [computed[begin : begin + POINTS_A_GROUP] for begin in range(0, len(computed), POINTS_A_GROUP)]
    with (
        written_atomically(path) as target,
        parquet.ParquetWriter(target, schema, compression="zstd", compression_level=_LEVEL) as writer,
    ):
        for group in tracked(groups, show, "rows of Parquet written", len(computed), size=len):
            arrays = [take(group) for _, take in columns.values()]
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
            "a Parquet file needs pyarrow",
            hint="pip install 'hwsw-codesign[parquet]', or pip install pyarrow",
        ) from None
    return pyarrow, parquet


def _columns(study: Study, arrow: Any) -> Iterator[tuple[str, tuple[Any, Callable[[Points], Any]]]]:
    """By name, the type of each column, and what gives its values of some points."""
    judged, outcomes = study.judged, study.outcomes

    def whole(numbers: Callable[[Points], NDArray[Any]]) -> tuple[Any, Callable[[Points], Any]]:
        return arrow.int64(), lambda within: arrow.array(numbers(within), arrow.int64())

    def flags(numbers: Callable[[Points], NDArray[Any]]) -> tuple[Any, Callable[[Points], Any]]:
        return arrow.bool_(), lambda within: arrow.array(numbers(within), arrow.bool_())

    yield "index", whole(lambda within: within)
    if study.conditions:
        yield "design", whole(lambda within: within // judged.conditions)
    for axis, values in study.every_axis.items():
        name, entries = axis_column(axis, values)
        yield name, _axis(study, axis, entries, arrow)
    for column in study.figure_columns:
        yield column.name, _figure(column, arrow)
    yield "feasible", flags(lambda within: judged.feasible_points[within])
    yield "on_front", flags(lambda within: study.on_front[within // judged.conditions])
    yield "state", _words(STATES, lambda within: outcomes.state[within], arrow)
    yield "reason", _words(*_reasons(study), arrow)


def _axis(study: Study, axis: str, entries: Sequence[Any], arrow: Any) -> tuple[Any, Callable[[Points], Any]]:
    """The values of an axis: numbers, or words of a dictionary; null where it does not exist."""

    def levels(within: Points) -> NDArray[np.int32]:
        return study.space.levels(within)[axis]

    for kind, types in ((arrow.bool_(), bool), (arrow.int64(), int), (arrow.float64(), int | float)):
        exact = types is bool or not any(isinstance(entry, bool) for entry in entries)
        if exact and all(isinstance(entry, types) for entry in entries):
            take = arrow.array(entries, kind).take
            return kind, partial(_taken, take, levels, arrow)
    return _words([entry if isinstance(entry, str) else str(entry) for entry in entries], levels, arrow)


def _taken(
    take: Callable[[Any], Any], numbers: Callable[[Points], NDArray[Any]], arrow: Any, within: Points
) -> Any:
    return take(_places(numbers(within), arrow))


def _figure(column: FigureColumn, arrow: Any) -> tuple[Any, Callable[[Points], Any]]:
    """Numbers; null where a point has none. Counts are integers."""

    def take(within: Points) -> Any:
        numbers = column.of(within)
        none = np.isnan(numbers)
        if not column.whole:
            return arrow.array(numbers, arrow.float64(), mask=none)
        return arrow.array(np.rint(np.where(none, 0, numbers)).astype(np.int64), arrow.int64(), mask=none)

    return arrow.int64() if column.whole else arrow.float64(), take


def _words(
    words: Sequence[str], numbers: Callable[[Points], NDArray[Any]], arrow: Any
) -> tuple[Any, Callable[[Points], Any]]:
    """Texts by their numbers in a dictionary; -1: null."""
    dictionary = arrow.array(words, arrow.string())
    return arrow.dictionary(arrow.int32(), arrow.string()), lambda within: arrow.DictionaryArray.from_arrays(
        _places(numbers(within), arrow), dictionary
    )


def _places(numbers: NDArray[Any], arrow: Any) -> Any:
    return arrow.array(numbers.astype(np.int32), mask=numbers < 0)


def _reasons(study: Study) -> tuple[list[str], Callable[[Points], NDArray[np.int32]]]:
    """Every text of what keeps a point out, and the number of the text of each point; -1: nothing does.

    The text of a point names each limit that it passes, such as ``resource slices; clock fpga``. That of a failed point
    is its message.
    """
    outcomes = study.outcomes
    texts: dict[str, int] = {"": 0}

    def number(reasons: Sequence[Any]) -> int:
        return texts.setdefault("; ".join(f"{each.kind} {each.name}" for each in reasons), len(texts))

    code = np.asarray(outcomes.each(lambda template: number(template.reasons), 0), np.int64)
    late = np.array([*(number((reason,)) for reason in outcomes.reasons), 0], np.int64)[outcomes.reason]
    failed = np.zeros(len(outcomes), np.int64)
    for index, message in outcomes.failures.items():
        failed[index] = texts.setdefault(message, len(texts))
    parts = [code, late]
    for broken in study.judged.broken_points:
        parts.append(np.zeros(len(outcomes), np.int64))
        parts[-1][broken.which] = texts.setdefault(f"constraint {broken.name}", len(texts))
    words, numbers = [*texts], failed
    for part in parts:
        pairs, which = np.unique(numbers * len(words) + part, return_inverse=True)
        each = [divmod(pair, len(words)) for pair in pairs.tolist()]
        joined = ["; ".join(filter(None, (words[one], words[other]))) for one, other in each]
        # What has a number keeps it.
        place = {text: number for number, text in enumerate(dict.fromkeys((*words, *joined)))}
        words, numbers = [*place], np.array([place[text] for text in joined], np.int64)[which]
    used, which = np.unique(numbers, return_inverse=True)
    kept = [words[number] for number in used.tolist()]
    places = np.array([number if text else -1 for number, text in enumerate(kept)], np.int32)[which]
    return kept, lambda within: places[within]


def _metadata(study: Study) -> dict[str, str]:
    """Where the points come from."""
    provenance = study.provenance
    texts = {} if provenance is None else provenance.stamped().constants
    named = {"platform": study.platform, "workload": study.workload, **texts}
    return {f"hwsw.{name}": str(text) for name, text in named.items()}
