"""The circuits of velocity obstacles that resource laws are fitted to: units and widths, two robots and more."""

from __future__ import annotations

from functools import partial
from typing import Any

from codesign.fidelity.designs import FEW, Design, Placed
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


WIDTHS = (16, 12, 20, 24, 18, 14, 22, 10)
VARIANTS: tuple[dict[str, Any], ...] = (
    {},
    {"detector": "cross_product"},
    {"unit": "parallel"},
    {"unit": "parallel", "detector": "cross_product"},
)
RESOURCES = (
    *(design("hybrid", 2, width) for width in WIDTHS),
    *(design("pipelined", 2, width) for width in (16, 24, 12)),
    *(design("sequential", 4, width) for width in (16,)),
    *(design("hybrid", 2, width, **options) for options in VARIANTS[1:] for width in WIDTHS[:5]),
)

CLOCKS = [
    Placed(design("sequential", 2, 16), "LFE5U-85F-8", FEW),
    Placed(design("hybrid", 4, 16), "LFE5U-85F-8", FEW),
    Placed(design("pipelined", 4, 16), "LFE5U-85F-8"),
    Placed(design("sequential", 2, 16), "GW2A-18-7", FEW),
]
