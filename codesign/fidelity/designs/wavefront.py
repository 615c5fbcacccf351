"""Arrays of the wave: both nodes, both read-outs, shared elements; each option by itself on a few sizes."""

from __future__ import annotations

from functools import partial
from typing import Any

from codesign.fidelity.designs import FEW, Design, Placed, free_map, scattered_map


def array(rows: int, columns: int, style: str = "delay_line", **parameters: Any) -> Design:
    """An array that ends at a start, unless the parameters say otherwise."""
    return Design(style, parameters, partial(free_map, rows, columns))


FIELD: dict[str, Any] = {"stop": "whole_map"}
CORNERS: dict[str, Any] = {"corner_cutting": False}
SAFE: dict[str, Any] = {"paths": "safe"}
PENALTY: dict[str, Any] = {"penalty": {"distance": 2, "delay": 3}}
CHAIN: dict[str, Any] = {"read_out": "chain"}
ADDERS = "adder_comparator"

RESOURCES = [
    array(4, 4, register_bits=8),
    array(6, 8, register_bits=11),
    array(4, 4, register_bits=8, **CHAIN),
    array(6, 8, register_bits=11, **CHAIN),
    array(4, 4, register_bits=8, **CORNERS),
    array(4, 4, register_bits=8, **FIELD),
    array(4, 4, register_bits=8, **SAFE),
    array(5, 6, register_bits=9, **SAFE, **CHAIN),
    array(4, 4, register_bits=8, **PENALTY),
    array(6, 4, register_bits=8, course="complete"),
    array(8, 6, register_bits=8, element_cells=8),
    array(8, 4, register_bits=11, element_cells=4),
    array(16, 4, register_bits=9, element_cells=16, **CORNERS, **FIELD),
    array(8, 4, register_bits=8, element_cells=4, **SAFE, **PENALTY),
    array(4, 5, register_bits=10, element_cells=2),
    array(8, 5, register_bits=8, element_cells=4, **SAFE),
    array(8, 3, register_bits=9, element_cells=4, **FIELD),
    array(4, 4, ADDERS, register_bits=8),
    array(4, 6, ADDERS, register_bits=11),
    array(4, 5, ADDERS, register_bits=9),
    array(3, 4, ADDERS, register_bits=9, **CORNERS),
    array(3, 4, ADDERS, register_bits=8, **SAFE),
    array(3, 4, ADDERS, register_bits=9, **CHAIN),
    array(3, 4, ADDERS, register_bits=9, **PENALTY),
    array(7, 9, register_bits=9, **CORNERS, **FIELD),
    array(10, 9, register_bits=10, **CHAIN),
    array(6, 9, register_bits=9, **SAFE, **CORNERS),
    array(16, 9, register_bits=10, element_cells=8, **SAFE),
    array(6, 5, ADDERS, register_bits=10),
    array(5, 4, ADDERS, register_bits=10, **CORNERS),
    array(5, 5, ADDERS, register_bits=9, **SAFE),
    array(12, 20, register_bits=9),
    array(16, 16, register_bits=11),
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


def scattered(side: int, seed: int, style: str, **parameters: Any) -> Design:
    """A square map with obstacles."""
    return Design(style, parameters, partial(scattered_map, side, side, seed), seed=seed)


ACTIVITIES = [
    *(scattered(side, seed, "delay_line") for side, seed in ((8, 1), (8, 2), (12, 3), (16, 4), (24, 5))),
    *(scattered(side, seed, ADDERS) for side, seed in ((6, 1), (8, 2), (12, 3))),
    *(scattered(side, seed, "tiled", tile=(8, 8)) for side, seed in ((16, 1), (16, 2), (24, 3))),
]
