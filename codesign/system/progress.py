"""How far a mission is while it is simulated, and how long it may become at most."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from codesign.inputs import Workload
from codesign.inputs.scenario import Drive
from codesign.units import PICOSECONDS_PER_SECOND

EVENTS_OF_A_TURN = 20
"""Events that a turn of the control loop counts for: its scan and its way take about as long as so many messages."""

LONG_DRIVE = 36_001
"""Turns of the longest drive by default: an hour, ten turns a second, the first at 0. Measured: half a minute on a map
of 16 × 16 cells."""


@dataclass(frozen=True)
class MissionProgress:
    """What a drive has come to. ``time`` and ``limit``: ps. ``events`` and ``most_events``: each turn counts for its
    scan and its way too. ``turns``: of the control loop. The drive ends at ``limit`` or ``most_events`` at the latest.
    """

    time: int
    limit: int
    events: int
    most_events: int
    turns: int

    @property
    def share(self) -> float:
        """How much of the longest drive possible is over, 0 to 1."""
        return min(max(self.time / max(self.limit, 1), self.events / self.most_events), 1.0)


ProgressOfMission = Callable[[MissionProgress], None]


def longest_turns(scenario: Drive) -> int:
    """Turns of the control loop by which a drive has ended: at its limit, or by its events."""
    by_events = scenario.events // EVENTS_OF_A_TURN
    return min(scenario.limit // scenario.control_period, by_events) + 1


def outlook(workload: Workload) -> str | None:
    """What a long drive may come to, said before it begins; None where it is no drive, or none longer than usual."""
    scenario = workload.scenario
    if not isinstance(scenario, Drive) or longest_turns(scenario) <= LONG_DRIVE:
        return None
    seconds = f"{scenario.limit / PICOSECONDS_PER_SECOND:,.10g} s of simulated time"
    return (
        f"a long drive: it may take {longest_turns(scenario):,} turns of the control loop, and ends after {seconds}"
        f" or {scenario.events:,} events at the latest; a lower scenario.limit or scenario.events ends it sooner"
    )
