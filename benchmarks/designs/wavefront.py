"""Arrays of the wave: nodes with and without a chain to read them out, adders, and elements for several cells."""

from __future__ import annotations

from functools import partial
from typing import Any

from benchmarks.designs import FEW, Design, Placed, free_map


def array(side: int, style: str = "delay_line", **parameters: Any) -> Design:
    return Design(style, parameters, partial(free_map, side, side))


CLOCKS = [
    Placed(array(16), "LFE5U-85F-8", FEW),
    Placed(array(8), "LFE5U-85F-8"),
    Placed(array(16, read_out="chain"), "LFE5U-85F-8", FEW),
    Placed(array(8), "GW2A-18-7", FEW),
    Placed(array(32), "LFE5U-85F-8", FEW),
    Placed(array(8, "adder_comparator"), "LFE5U-85F-8", FEW),
    Placed(array(32, element_cells=32), "LFE5U-85F-8", FEW),
    Placed(array(16), "GW2A-18-7", FEW),
]
