"""Shortest and safe paths by a wave with delays as costs (Möller and Paschke 1998)."""

from codesign.planners.wavefront.plan.grid import UNREACHED
from codesign.planners.wavefront.plan.tracking import octile_length, skeleton, track
from codesign.planners.wavefront.plan.wave import (
    longest_distance,
    obstacle_potentials,
    propagate,
    register_bits,
    stop_cycle,
)

__all__ = [
    "UNREACHED",
    "longest_distance",
    "obstacle_potentials",
    "octile_length",
    "propagate",
    "register_bits",
    "skeleton",
    "stop_cycle",
    "track",
]
