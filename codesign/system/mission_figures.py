"""The figures of a mission under the names that objectives and constraints use."""

from __future__ import annotations

from codesign.spec.exploration import ResultFigure
from codesign.system.mission_result import Mission


def mission_figures(mission: Mission) -> dict[ResultFigure, float | None]:
    """Each figure of a mission in the unit of ``ResultFigure``; None for what it does not have.

    Time, energy and distance of a mission that ended before its goals are None: they would be less the earlier it
    failed. What was counted on the way, and how long plans took, stands as it is.
    """
    reached = mission.reached
    return {
        ResultFigure.MISSION_TIME: mission.time_s if reached else None,
        ResultFigure.MISSION_ENERGY: mission.energy.total_j if reached else None,
        ResultFigure.DISTANCE_RATIO: mission.distance_ratio if reached else None,
        ResultFigure.REPLANS: float(mission.replans),
        ResultFigure.REPLAN_LATENCY: mission.replan_latency_95_s,
        ResultFigure.MISSED_DEADLINES: float(mission.missed_deadlines),
        ResultFigure.SAFETY_STOPS: float(mission.safety_stops),
        ResultFigure.CONTACTS: float(mission.contacts),
        ResultFigure.MISSION_CLEARANCE: mission.clearance_least_m,
        ResultFigure.KNOWN_SHARE: mission.known_share,
    }
