"""What a mission comes to: named figures with units, as part of a ``Result``."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from codesign.spec.exploration import ResultFigure


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", json_schema_serialization_defaults_required=True)


class LinkUse(_Model):
    """The messages of one link: ``sent`` = ``delivered`` + all ``dropped`` + ``in_flight``, always."""

    sent: int
    delivered: int
    dropped: dict[str, int] = Field(default={}, description="messages given up, by reason")
    in_flight: int
    retransmissions: int
    undetected: int = Field(description="messages delivered damaged, which no checksum noticed")
    late: int
    bits: int = Field(description="bits delivered, without framing and checksums")
    utilisation: float = Field(description="share of the time in which something was on the wire")
    queued_s: float = Field(description="time that messages waited, all together")


class Account(_Model):
    """Where the time of one component or link went, s.

    ``compute_s``: a component worked. ``transfer_s``: a link carried. ``wait_s``: work or messages waited for it, all
    together. ``idle_s``: the rest of the mission.
    """

    compute_s: float
    transfer_s: float
    wait_s: float
    idle_s: float


class LatencyShare(_Model):
    """A share of some time: what it was spent on (compute, wait, transfer), and where."""

    kind: Literal["compute", "wait", "transfer"]
    where: str
    seconds: float
    share: float


class Bottleneck(_Model):
    """What sets the pace, and what would move it.

    ``share``: of the mission's time (the robot itself), of the time of plans, or of that of the control loop's turns.
    """

    name: str
    kind: Literal["drive", "compute", "wait", "transfer"]
    share: float
    text: str


class MissionEnergy(_Model):
    """Energy of a mission, J."""

    fpga_j: float
    processors_j: float
    links_j: float
    memories_j: float
    robot_j: float
    total_j: float


class Mission(_Model):
    """The figures of a drive."""

    ended: str = Field(description="why the mission ended")
    reached: bool = Field(description="whether it did all that it was to do")
    time_s: float = Field(description="simulated time at the end")
    goals_reached: int
    plans: int = Field(description="plans that were answered, the first of each goal included")
    replans: int = Field(description="plans asked for because of what was seen on the way, and answered")
    replan_latency_median_s: float | None = Field(
        default=None, description="from the scan that asked for a plan to the answer; replans only"
    )
    replan_latency_95_s: float | None = None
    replan_latency_worst_s: float | None = None
    distance_m: float
    shortest_m: float | None = Field(
        default=None, description="shortest 8-connected way on the true map of the start, corners not cut"
    )
    distance_ratio: float | None = None
    clearance_least_m: float | None = Field(
        default=None, description="least distance from the robot's middle to an obstacle of the true map"
    )
    clearance_mean_m: float | None = None
    turns: int = Field(description="turns of the control loop that began")
    missed_deadlines: int
    safety_stops: int
    contacts: int = Field(description="times that the robot ran against something, and stood")
    driving_s: float = Field(description="time in which the robot moved")
    waiting_s: float = Field(description="time in which it stood and a plan or an answer was under way")
    known_share: float = Field(description="share of the map's cells that the robot knows at the end")
    energy: MissionEnergy
    account: dict[str, Account]
    latency: tuple[LatencyShare, ...] = Field(
        default=(), description="where the time of plans went, largest first"
    )
    control: tuple[LatencyShare, ...] = Field(
        default=(), description="where the time of turns of the control loop went, largest first"
    )
    bottleneck: Bottleneck | None = None

    def figures(self) -> dict[ResultFigure, float | None]:
        """Its figures as objectives and constraints name them; the time of a mission that failed is none."""
        return {
            ResultFigure.MISSION_TIME: self.time_s if self.reached else None,
            ResultFigure.MISSION_ENERGY: self.energy.total_j if self.reached else None,
            ResultFigure.DISTANCE_RATIO: self.distance_ratio,
            ResultFigure.REPLANS: self.replans,
            ResultFigure.REPLAN_LATENCY: self.replan_latency_95_s,
            ResultFigure.MISSED_DEADLINES: self.missed_deadlines,
            ResultFigure.SAFETY_STOPS: self.safety_stops,
            ResultFigure.CONTACTS: self.contacts,
            ResultFigure.MISSION_CLEARANCE: self.clearance_least_m,
            ResultFigure.KNOWN_SHARE: self.known_share,
        }
