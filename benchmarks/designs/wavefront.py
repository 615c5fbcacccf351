"""Arrays of the wave: nodes with and without a chain to read them out, adders, and elements for several cells."""

from __future__ import annotations

from functools import partial
from typing import Any

from benchmarks.designs import Design, Placed, free_map


def array(side: int, style: str = "delay_line", **parameters: Any) -> Design:
    return Design(style, parameters, partial(free_map, side, side))


CLOCKS = [
    Placed(array(side, **parameters), part)
    for part in ("LFE5U-85F-8", "GW2A-18-7")
    for side in (8, 16, 32)
    for parameters in ({}, {"read_out": "chain"})
    if not (part == "GW2A-18-7" and side == 32)
] + [
    Placed(array(12), "LFE5U-85F-8"),
    Placed(array(16, "adder_comparator"), "LFE5U-85F-8"),
    Placed(array(32, element_cells=32), "LFE5U-85F-8"),
]
