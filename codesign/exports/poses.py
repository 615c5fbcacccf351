"""A table of the positions of robots: ``hwsw trace export FILE --poses OUT``."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Iterator
from typing import Any

from codesign.records import PoseRecord, PositionsRecord, Record

POSE_KINDS: tuple[type[Record], ...] = (PoseRecord, PositionsRecord)


def poses_csv(records: Iterable[Record]) -> Iterator[str]:
    """A table of positions and times of each robot in CSV, a line at a time.

    Columns: ``time_ps`` (exact), ``source``, ``robot`` (its number in a fleet, 0 alone), ``row`` and ``column`` in
    cells, ``heading`` in radians and ``speed`` in m/s (empty for a fleet).
    """
    yield _line("time_ps", "source", "robot", "row", "column", "heading", "speed")
    for record in records:
        if isinstance(record, PoseRecord):
            yield _line(
                record.time, record.source, 0, record.row, record.column, record.heading, record.speed
            )
        elif isinstance(record, PositionsRecord):
            for robot, (row, column) in enumerate(record.positions.tolist()):
                yield _line(record.time, record.source, robot, row, column, "", "")


_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def _line(*values: Any) -> str:
    out = io.StringIO()
    # A spreadsheet would read some names as formulas.
    safe = (
        f"'{value}" if isinstance(value, str) and value.startswith(_FORMULA) else value for value in values
    )
    csv.writer(out, lineterminator="\n").writerow(safe)
    return out.getvalue()
