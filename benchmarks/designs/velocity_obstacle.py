"""Robots of every style, with a few numbers of robots and units."""

from __future__ import annotations

from functools import partial
from typing import Any

from benchmarks.designs import Design, Placed
from codesign.planners.velocity_obstacle.plan.problem import generate


def robot(count: int, style: str, **parameters: Any) -> Design:
    return Design(style, parameters, partial(generate, "circle", count))


CLOCKS = [
    Placed(robot(*of), part)
    for part in ("LFE5U-85F-8", "GW2A-18-7")
    for of in ((2, "sequential"), (2, "hybrid"), (4, "pipelined"), (4, "hybrid"), (8, "sequential"))
]
