"""Harmonic arrays of one block and of several, plain and pipelined."""

from __future__ import annotations

from functools import partial
from typing import Any

from codesign.fidelity.designs import FEW, Design, Placed, free_map


def array(rows: int, columns: int, pipeline: int, **parameters: Any) -> Design:
    """One array of ``rows`` × ``columns`` nodes; further parameters make it one of several blocks."""
    common = {"iterations": 6, "schedule": {"first": 7, "step": 8, "last": 63}}
    settings = {"block": (rows, columns), "pipeline": pipeline, **common, **parameters}
    return Design("bit_serial", settings, partial(free_map, rows, columns))


CLOCKS = [
    *(
        Placed(array(*size, pipeline), "LFE5U-85F-8", seeds)
        for size, seeds in (
            ((6, 12), FEW),
            ((12, 24), (1, 2, 3, 4, 5)),
            ((6, 6), FEW),
            ((12, 12), (1, 2, 3, 4, 5)),
        )
        for pipeline in (1, 0)
    ),
    Placed(array(6, 12, 1), "GW2A-18-7", FEW),
    Placed(array(6, 12, 0), "GW2A-18-7", FEW),
    Placed(array(6, 12, 1), "LFE5U-85F-6", FEW),
    Placed(array(6, 12, 0), "LFE5U-85F-6", FEW),
    Placed(array(12, 24, 1), "GW2A-18-7", (1, 2, 3)),
    Placed(array(12, 12, 0), "GW2A-18-7"),
]
