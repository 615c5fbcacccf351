"""Robots of every style, with a few numbers of robots and units."""

from __future__ import annotations

from functools import partial
from typing import Any

from benchmarks.designs import FEW, Design, Placed
from codesign.planners.velocity_obstacle.plan.problem import generate


def robot(count: int, style: str, **parameters: Any) -> Design:
    return Design(style, parameters, partial(generate, "circle", count))


CLOCKS = [
    Placed(robot(2, "sequential"), "LFE5U-85F-8", FEW),
    Placed(robot(4, "hybrid"), "LFE5U-85F-8", FEW),
    Placed(robot(4, "pipelined"), "LFE5U-85F-8"),
    Placed(robot(2, "sequential"), "GW2A-18-7", FEW),
]
