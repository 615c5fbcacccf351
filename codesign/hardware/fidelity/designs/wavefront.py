"""Arrays of the wave: both nodes, both read-outs, shared elements; each option by itself on a few sizes."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

from codesign.hardware.fidelity.designs import FEW, ONE, Design, Placed, free_map, scattered_map


def array(rows: int, columns: int, style: str = "delay_line", **parameters: Any) -> Design:
    """An array that ends at a start, unless the parameters say otherwise."""
    return Design(style, parameters, partial(free_map, rows, columns))


def tiles(rows: int, columns: int, tile: tuple[int, int], register_bits: int, **parameters: Any) -> Design:
    """An array of one tile, on a map of ``rows`` × ``columns``."""
    return array(rows, columns, "tiled", tile=tile, register_bits=register_bits, **parameters)


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
    *(array(4, 4, ADDERS, register_bits=bits) for bits in (4, 5, 6, 7)),
    array(3, 4, ADDERS, register_bits=5, **CORNERS),
    array(3, 4, ADDERS, register_bits=5, **SAFE),
    array(3, 4, ADDERS, register_bits=5, **CHAIN),
    array(3, 4, ADDERS, register_bits=5, **PENALTY),
    array(7, 9, register_bits=9, **CORNERS, **FIELD),
    array(10, 9, register_bits=10, **CHAIN),
    array(6, 9, register_bits=9, **SAFE, **CORNERS),
    array(16, 9, register_bits=10, element_cells=8, **SAFE),
    *(array(6, 5, ADDERS, register_bits=bits) for bits in (5, 6, 10)),
    array(5, 4, ADDERS, register_bits=10, **CORNERS),
    array(5, 5, ADDERS, register_bits=9, **SAFE),
    array(5, 4, ADDERS, register_bits=5, **CORNERS),
    array(5, 5, ADDERS, register_bits=6, **SAFE),
    array(12, 20, register_bits=9),
    array(16, 16, register_bits=11),
    tiles(8, 8, (4, 4), 8),
    tiles(12, 20, (6, 5), 9),
    tiles(32, 32, (8, 8), 11),
    tiles(64, 64, (16, 16), 12),
    tiles(128, 128, (16, 8), 12),
    tiles(40, 100, (5, 10), 12, course="complete"),
    tiles(16, 16, (4, 8), 9, **CORNERS),
    tiles(24, 24, (8, 4), 10, **FIELD),
    tiles(16, 24, (4, 6), 9, **SAFE),
    tiles(30, 30, (6, 6), 10, **SAFE, **CORNERS),
    tiles(16, 16, (8, 4), 9, **PENALTY),
    replace(tiles(12, 12, (6, 4), 8), job={"inside": frozenset({"propagate"})}),
    tiles(48, 48, (12, 12), 11),
    tiles(20, 36, (10, 9), 10, **FIELD),
    tiles(28, 28, (7, 7), 10, **SAFE),
    tiles(100, 60, (10, 6), 12, course="complete"),
    # Plain tiles of all proportions, on maps of four; the last three are held out.
    *(
        array(2 * rows, 2 * columns, "tiled", tile=(rows, columns))
        for rows, columns in ((4, 3), (8, 3), (4, 10), (7, 5), (9, 8), (5, 7), (10, 4), (6, 9), (8, 6))
    ),
]

CLOCKS = [
    *(Placed(array(side, side), "LFE5U-85F-8") for side in (8, 12, 16, 24)),
    Placed(array(8, 8), "GW2A-18-7"),
    *(Placed(array(side, side, **CHAIN), "LFE5U-85F-8") for side in (8, 12, 16)),
    *(Placed(array(side, side, ADDERS), "LFE5U-85F-8") for side in (4, 5, 6)),
    *(Placed(array(side, side, element_cells=k), "LFE5U-85F-8") for side, k in ((8, 4), (16, 4), (16, 8))),
    *(
        Placed(array(*shape, "tiled", tile=tile), "LFE5U-85F-8", FEW)
        for shape, tile in (((8, 6), (4, 3)), ((16, 16), (4, 4)), ((18, 18), (6, 6)), ((32, 32), (8, 8)))
    ),
    Placed(array(16, 16, "tiled", tile=(4, 4)), "LFE5U-85F-6", FEW),
    Placed(array(48, 48, "tiled", tile=(12, 12)), "LFE5U-85F-8", ONE),
    *(Placed(array(side, side), "LFE5U-85F-6", FEW) for side in (8, 16)),
    Placed(array(4, 4, ADDERS), "LFE5U-85F-6", FEW),
    # Options by themselves.
    *(Placed(array(8, 8, **options), "LFE5U-85F-8", ONE) for options in (CORNERS, SAFE, PENALTY, FIELD)),
    Placed(array(16, 16, **CORNERS, **SAFE), "LFE5U-85F-8", ONE),
    Placed(array(16, 16, "tiled", tile=(4, 4), **CORNERS), "LFE5U-85F-8", ONE),
    Placed(array(16, 16, "tiled", tile=(4, 4), **SAFE), "LFE5U-85F-8", ONE),
    Placed(array(4, 4, ADDERS, **CORNERS), "LFE5U-85F-8", ONE),
]


def scattered(side: int, seed: int, style: str, **parameters: Any) -> Design:
    """A square map with obstacles."""
    return Design(style, parameters, partial(scattered_map, side, side, seed), seed=seed)


ACTIVITIES = [
    *(scattered(side, seed, "delay_line") for side, seed in ((8, 1), (8, 2), (12, 3), (16, 4), (24, 5))),
    *(scattered(side, seed, ADDERS) for side, seed in ((6, 1), (8, 2), (12, 3))),
    *(scattered(side, seed, "tiled", tile=(8, 8)) for side, seed in ((16, 1), (16, 2), (24, 3))),
]
