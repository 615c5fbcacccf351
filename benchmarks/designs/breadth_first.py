"""Breadth-first engines: every micro-architecture and address, on square and oblong maps."""

from __future__ import annotations

from functools import partial

from benchmarks.designs import Design, Placed, free_map

MICRO_ARCHITECTURES = "three_cycles", "two_cycles", "pipelined"


def engine(
    rows: int, columns: int, micro_architecture: str, address: str = "side_by_side", display: str = "none"
) -> Design:
    parameters = {"micro_architecture": micro_architecture, "address": address, "display": display}
    return Design("state_machine", parameters, partial(free_map, rows, columns))


CLOCKS = [
    Placed(engine(*shape, micro), part)
    for part in ("LFE5U-85F-8", "GW2A-18-7", "LFE5U-85F-6")
    for shape in ((30, 30), (100, 100), (15, 15), (60, 60))
    for micro in MICRO_ARCHITECTURES
    if not (part == "LFE5U-85F-6" and shape in ((15, 15), (60, 60)))
] + [Placed(engine(*shape, "pipelined", "linear"), "LFE5U-85F-8") for shape in ((30, 30), (90, 40))]

RESOURCES = [
    engine(15, 15, "three_cycles"),
    engine(30, 30, "pipelined"),
    engine(60, 60, "two_cycles"),
    engine(100, 100, "three_cycles"),
    engine(100, 100, "pipelined"),
    engine(200, 200, "pipelined"),
    engine(20, 20, "three_cycles", "linear"),
    engine(90, 90, "two_cycles", "linear"),
    engine(40, 70, "pipelined", "linear"),
    engine(30, 30, "three_cycles", display="shared"),
    engine(100, 100, "two_cycles", "linear", "shared"),
    engine(60, 60, "pipelined", display="copy"),
    engine(40, 50, "three_cycles"),
    engine(80, 30, "pipelined"),
    engine(50, 50, "two_cycles", "linear"),
    engine(120, 60, "three_cycles", display="shared"),
    engine(130, 130, "two_cycles", "linear"),
    engine(150, 90, "three_cycles"),
    engine(250, 130, "pipelined"),
]
