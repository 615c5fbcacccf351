"""Breadth-first engines: every micro-architecture and address, on square and oblong maps."""

from __future__ import annotations

from functools import partial
from typing import Any

from codesign.hardware.fidelity.designs import ONE, Design, Placed, free_map, scattered_map


def engine(
    rows: int,
    columns: int,
    micro_architecture: str,
    address: str = "side_by_side",
    display: str = "none",
    **parameters: Any,
) -> Design:
    """An engine on a free map of ``rows`` × ``columns``."""
    parameters |= {"micro_architecture": micro_architecture, "address": address, "display": display}
    return Design("state_machine", parameters, partial(free_map, rows, columns))


ENGINES = "three_cycles", "two_cycles", "pipelined"

CLOCKS = [
    *(Placed(engine(side, side, each), "LFE5U-85F-8") for side in (30, 60, 100) for each in ENGINES),
    Placed(engine(100, 100, "pipelined"), "LFE5U-85F-6"),
    Placed(engine(30, 30, "pipelined", "linear"), "LFE5U-85F-8"),
    *(Placed(engine(side, side, "pipelined", "linear"), "LFE5U-85F-8", ONE) for side in (60, 100)),
    Placed(engine(30, 30, "pipelined"), "LFE5U-85F-6", ONE),
    *(Placed(engine(60, 60, "three_cycles", display=each), "LFE5U-85F-8", ONE) for each in ("copy", "shared")),
    Placed(engine(60, 60, "two_cycles", queue_words=256), "LFE5U-85F-8", ONE),
]

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
    engine(60, 60, "two_cycles", queue_words=256),
    engine(100, 100, "pipelined", queue_words=1024),
    engine(100, 100, "three_cycles", queue_words=1000),
    engine(30, 30, "pipelined", queue_words=100),
    engine(90, 40, "two_cycles", queue_words=500),
    engine(120, 80, "three_cycles", queue_words=2048),
]

ACTIVITIES = [
    Design(
        "state_machine",
        {"micro_architecture": each, "display": "none"},
        partial(scattered_map, side, side, seed),
        seed=seed,
    )
    for each in ("three_cycles", "two_cycles", "pipelined")
    for side, seed in ((30, 1), (60, 2), (60, 3))
]
