"""A table of the positions of robots: ``hwsw trace export FILE --poses OUT``."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from codesign.ground.records import Record, Subject, kinds_about

POSE_KINDS = kinds_about(Subject.POSE, Subject.FLEET)


def poses_csv(records: Iterable[Record]) -> Iterator[str]:
    """A table of positions and times of each robot in CSV, a line at a time.

    Columns: ``time_ps`` (exact), ``source``, ``robot`` (its number in a fleet, 0 alone), ``row`` and ``column`` in
    cells, ``heading`` in radians and ``speed`` in m/s (empty for a fleet).
    """
    yield _line("time_ps", "source", "robot", "row", "column", "heading", "speed")
    for record in records:
        write = _ROWS.get(record.ROLE.about)
        if write is not None:
            yield from (_line(record.time, record.source, *row) for row in write(record))


_ROWS: dict[Subject, Callable[[Any], list[tuple[Any, ...]]]] = {
    Subject.POSE: lambda record: [(0, record.row, record.column, record.heading, record.speed)],
    Subject.FLEET: lambda record: [(n, *place, "", "") for n, place in enumerate(record.positions.tolist())],
}
"""The robot and what stands behind it in the rows of a record."""

_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def _line(*values: Any) -> str:
    out = io.StringIO()
    # A spreadsheet would read some names as formulas.
    safe = (f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value for value in values)
    csv.writer(out, lineterminator="\n").writerow(safe)
    return out.getvalue()
