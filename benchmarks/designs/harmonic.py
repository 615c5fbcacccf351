"""Harmonic arrays of one block and of several, plain and pipelined."""

from __future__ import annotations

from functools import partial
from typing import Any

from benchmarks.designs import Design, free_map


def array(rows: int, columns: int, pipeline: int, **parameters: Any) -> Design:
    block = {"rows": rows, "columns": columns}
    return Design(
        "bit_serial", {"block": block, "pipeline": pipeline, **parameters}, partial(free_map, rows, columns)
    )


SIZES = (6, 6), (6, 12), (12, 12), (12, 24)
