"""The greatest length that a drive may have."""

from __future__ import annotations

from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.scenario import Drive

EVENTS_OF_A_TURN = 20
"""Events that a turn of the control loop counts for: its scan and its path take about as long as so many messages."""

LONG_DRIVE = 36_001
"""Turns of the longest drive by default: an hour, ten turns a second, the first at 0. Measured: half a minute on a map
of 16 × 16 cells."""


def longest_turns(scenario: Drive) -> int:
    """Turns of the control loop by which a drive has ended: at its limit, or by its events."""
    by_events = scenario.events // EVENTS_OF_A_TURN
    return min(scenario.limit // scenario.control_period, by_events) + 1


def outlook(scenario: Drive) -> str | None:
    """A warning that a drive may become long, for before it begins; None where it becomes no longer than usual."""
    if longest_turns(scenario) <= LONG_DRIVE:
        return None
    seconds = f"{scenario.limit / PICOSECONDS_PER_SECOND:,.10g} s of simulated time"
    return (
        f"a long drive: it may take {longest_turns(scenario):,} turns of the control loop, and ends after {seconds}"
        f" or {scenario.events:,} events at the latest; a lower scenario.limit or scenario.events ends it sooner"
    )
