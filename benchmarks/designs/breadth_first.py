"""Breadth-first engines: every micro-architecture and address, on square and oblong maps."""

from __future__ import annotations

from functools import partial

from benchmarks.designs import Design, Placed, free_map

MICRO_ARCHITECTURES = "three_cycles", "two_cycles", "pipelined"


def engine(rows: int, columns: int, micro_architecture: str, address: str = "side_by_side") -> Design:
    parameters = {"micro_architecture": micro_architecture, "address": address, "display": "none"}
    return Design("state_machine", parameters, partial(free_map, rows, columns))


CLOCKS = [
    Placed(engine(*shape, micro), part)
    for part in ("LFE5U-85F-8", "GW2A-18-7", "LFE5U-85F-6")
    for shape in ((30, 30), (100, 100), (15, 15), (60, 60))
    for micro in MICRO_ARCHITECTURES
    if not (part == "LFE5U-85F-6" and shape in ((15, 15), (60, 60)))
] + [Placed(engine(*shape, "pipelined", "linear"), "LFE5U-85F-8") for shape in ((30, 30), (90, 40))]
