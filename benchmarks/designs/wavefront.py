"""Arrays of the wave: both nodes, both read-outs, shared elements; each option by itself on a few sizes."""

from __future__ import annotations

from functools import partial
from typing import Any

from benchmarks.designs import FEW, Design, Placed, free_map


def array(rows: int, columns: int, style: str = "delay_line", **parameters: Any) -> Design:
    """An array that ends at a start, unless the parameters say otherwise."""
    return Design(style, parameters, partial(free_map, rows, columns))


OPTIONS: tuple[dict[str, Any], ...] = (
    {"read_out": "chain"},
    {"corner_cutting": False},
    {"stop": "whole_map"},
    {"paths": "safe"},
    {"penalty": {"distance": 2, "delay": 3}},
)
RESOURCES = [
    array(8, 8, register_bits=8),
    array(16, 16, register_bits=11),
    array(12, 20, register_bits=9),
    array(8, 8, "adder_comparator", register_bits=8),
    array(4, 6, "adder_comparator", register_bits=11),
    array(16, 16, register_bits=8, element_cells=8),
    array(16, 16, register_bits=11, element_cells=4),
    *(array(8, 8, register_bits=8, **options) for options in OPTIONS),
    array(12, 20, register_bits=11, read_out="chain"),
]

CLOCKS = [
    Placed(array(16, 16), "LFE5U-85F-8", FEW),
    Placed(array(8, 8), "LFE5U-85F-8"),
    Placed(array(16, 16, read_out="chain"), "LFE5U-85F-8", FEW),
    Placed(array(8, 8), "GW2A-18-7", FEW),
    Placed(array(32, 32), "LFE5U-85F-8", FEW),
    Placed(array(8, 8, "adder_comparator"), "LFE5U-85F-8", FEW),
    Placed(array(32, 32, element_cells=32), "LFE5U-85F-8", FEW),
    Placed(array(16, 16), "GW2A-18-7", FEW),
]
