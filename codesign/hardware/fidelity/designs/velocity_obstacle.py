"""The circuits of velocity obstacles that resource laws are fitted to: units and widths, two robots and more."""

from __future__ import annotations

from functools import partial
from typing import Any

from codesign.hardware.fidelity.designs import ONE, Design, Placed
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem, generate

NARROW = 15
"""Below this width the words are too narrow for the robots of the paper's arena."""


def robots(count: int, width: int) -> RobotsProblem:
    """Robots on a circle: in the paper's arena, or in one that words of ``width`` bits suffice for."""
    if width >= NARROW:
        return generate("circle", count)
    return generate("circle", count, radius=0.25, speed=24.0, acceleration=96.0, arena=(15.0, 15.0))


def design(style: str, count: int, width: int, **options: Any) -> Design:
    """A style with its own units."""
    return Design(style, {"width": width, **options}, partial(robots, count, width))


CROSS: dict[str, Any] = {"detector": "cross_product"}
PARALLEL: dict[str, Any] = {"unit": "parallel"}
RESOURCES = (
    design("hybrid", 2, 16),
    design("hybrid", 4, 10),
    design("hybrid", 3, 24),
    design("pipelined", 4, 20, responsibility="full"),
    design("sequential", 8, 18, range=40.0),
    design("hybrid", 8, 12, update_units=3, detect_units=4),
    design("hybrid", 2, 16, **PARALLEL),
    design("pipelined", 3, 24, **PARALLEL, detection="published"),
    design("sequential", 4, 16, **CROSS, detection="published"),
    design("pipelined", 4, 24, **CROSS),
    design("hybrid", 4, 12, **CROSS, update_units=2, detect_units=1),
    design("hybrid", 3, 12, **PARALLEL, **CROSS),
    design("pipelined", 6, 20, **PARALLEL, **CROSS, range=40.0),
    # Held out of the laws:
    design("hybrid", 5, 22),
    design("pipelined", 6, 14),
    design("hybrid", 8, 15, update_units=4, detect_units=3),
    design("hybrid", 4, 20, **CROSS),
    design("hybrid", 4, 18, **PARALLEL),
    design("sequential", 2, 16, **PARALLEL, **CROSS),
)

CLOCKS = [
    Placed(design("hybrid", 2, 16), "LFE5U-85F-8"),
    Placed(design("sequential", 2, 16), "LFE5U-85F-8"),
    Placed(design("sequential", 4, 16), "LFE5U-85F-8"),
    Placed(design("sequential", 2, 24), "LFE5U-85F-8"),
    *(Placed(design("hybrid", 2, 16, **options), "LFE5U-85F-8", ONE) for options in (PARALLEL, CROSS)),
]
