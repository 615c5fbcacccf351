"""The named figures of a mission, with their units, as part of a ``Result``."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from codesign.ground.figures import described
from codesign.system.results.ledger import Spent
from codesign.system.results.model import ResultModel

CONTACT_POINTS = 100
"""Contacts that a result lists; it counts them all."""


LIVELOCK = 10
"""Plans broken off in a row, with no answer between them, that are reported as a livelock. Assumed."""


class LinkUse(ResultModel):
    """The messages of one link: ``sent`` = ``delivered`` + all ``dropped`` + ``in_flight``, always."""

    sent: int = Field(description="messages handed to it: delivered + dropped + in flight")
    delivered: int = Field(description="messages that arrived")
    dropped: dict[str, int] = Field(default={}, title="dropped", description="messages given up, by reason")
    in_flight: int = Field(description="messages under way or waiting at the end")
    retransmissions: int = Field(title="sent again", description="times that a message was sent again")
    undetected: int = Field(
        title="damaged unnoticed", description="messages delivered damaged, which no checksum noticed"
    )
    ignored_damage: dict[str, int] = Field(
        default={},
        description="by message: those of them that were taken for what was sent, as the simulation does not know what"
        " their bits mean, or as the wrong ones mean nothing",
    )
    late: int = Field(description="messages that came later than the line takes, as its errors declare")
    bits: int = Field(description="bits delivered, without framing and checksums")
    utilisation: float = Field(title="busy", description="share of the time in which something was on the wire")
    queued_s: float = Field(description="time that messages waited, all together")


class Account(ResultModel):
    """The time of one component or link, s, by what it was spent on."""

    compute_s: float = Field(description="time in which the component worked, s")
    transfer_s: float = Field(description="time in which the link carried, s")
    wait_s: float = Field(description="time that work or messages waited for it, all together, s")
    idle_s: float = Field(description="the rest of the mission, s")


class LatencyShare(ResultModel):
    """A share of some time."""

    kind: Spent = Field(
        description="what the time was spent on; behind: a request waited for another plan; broken_off: in plans that"
        " were broken off; failed: in plans that failed, and the pause after; unfinished: in the plan that the"
        " mission's end cut"
    )
    where: str = Field(description="the component or link")
    seconds: float = Field(description="how long, all together, s")
    share: float = Field(description="share of the whole")


class Bottleneck(ResultModel):
    """The bottleneck: the lever that was found to help most, or else the place where the time was seen to go."""

    name: str = Field(description="what the best lever moves, or the component or link that the time was spent at")
    kind: Spent | Literal["drive", "lever"] = Field(
        description="what it spends the time on; drive: the robot's own motion; lever: it was found by running levers"
    )
    share: float = Field(
        description="share of the mission's time (drive), of the time of plans, or of that of the control loop's turns;"
        " of a lever the share of the mission's time that it saves"
    )
    text: str = Field(description="the same in words")


class LeverRun(ResultModel):
    """The mission run again with one value of the design moved, and nothing else."""

    path: str = Field(description="the axis that was moved")
    before: str = Field(description="its value in the design")
    after: str | None = Field(default=None, description="its value in this run")
    refused: str | None = Field(
        default=None, description="why it was not run, or does not fit; then there are no figures"
    )
    reached: bool | None = Field(default=None, description="whether the mission did all that it was to do")
    mission_time_s: float | None = Field(default=None, description=described("mission_time_s"))
    mission_energy_j: float | None = Field(default=None, description=described("mission_energy_j"))
    missed_deadlines: int | None = Field(default=None, description=described("missed_deadlines"))
    ended: str | None = Field(default=None, description="why the mission ended")


class MissionEnergy(ResultModel):
    """Energy of a mission, J."""

    fpga_j: float = Field(title="FPGAs", description="of all FPGAs of the platform, J")
    idle_fpgas_j: float = Field(
        default=0.0, description="the part of it that FPGAs without any task drew: their static power, J"
    )
    processors_j: float = Field(description="of the processors, J")
    links_j: float = Field(description="of the links, J")
    memories_j: float = Field(description="of the external memories, J")
    robot_j: float = Field(description="of the robot's body, moving and standing, J")
    mission_energy_j: float = Field(description=described("mission_energy_j", ": the sum of these"))
    not_declared: dict[str, tuple[str, ...]] = Field(
        default={},
        description="names of the links and memories whose power the platform does not declare: they count as 0 J",
    )


class ContactPoint(ResultModel):
    """A contact: the robot ran against something and stood at once."""

    time_s: float = Field(description="when")
    row: float = Field(description="of the robot's middle, cells")
    column: float = Field(description="of the robot's middle, cells")
    speed_m_s: float = Field(description="that the robot lost")


class Mission(ResultModel):
    """The figures of a drive."""

    ended: str = Field(description="why the mission ended")
    reached: bool = Field(description="whether it did all that it was to do")
    mission_time_s: float = Field(description=described("mission_time_s"))
    goals_reached: int = Field(description="goals reached, those of the tour included")
    plans: int = Field(description="plans that were answered, the first of each goal included")
    broken_off: int = Field(
        default=0, title="plans broken off", description="plans that were broken off before their answer"
    )
    broken_off_in_a_row: int = Field(
        default=0,
        title="plans broken off in a row, at most",
        description="the most of them with no answer between them; 10 and more are a livelock",
    )
    replans: int = Field(description=described("replans"))
    replan_latency_median_s: float | None = Field(
        default=None,
        title="replan latency, median",
        description="from the scan that asked for a plan to the answer, median, s",
    )
    replan_latency_95_s: float | None = Field(
        default=None, title="replan latency, 95th percentile", description=described("replan_latency_95_s")
    )
    replan_latency_worst_s: float | None = Field(
        default=None, title="replan latency, worst", description="the same, worst, s"
    )
    distance_m: float = Field(title="distance driven", description="driven, m")
    shortest_m: float | None = Field(
        default=None,
        title="shortest path",
        description="lower bound of what can be driven: shortest any-angle path of the robot's middle from the start"
        " over the cells of the goals in order, without what appears or moves",
    )
    distance_ratio: float | None = Field(
        default=None,
        title="distance over the shortest",
        description=described("distance_ratio", "; None where there is no path, or nothing to drive"),
    )
    clearance_least_m: float | None = Field(
        default=None, title="clearance, least", description=described("clearance_least_m")
    )
    clearance_mean_m: float | None = Field(
        default=None, title="clearance, mean", description="the same, mean over the length of the path"
    )
    turns: int = Field(title="turns of the control loop", description="turns of the control loop that began")
    missed_deadlines: int = Field(description=described("missed_deadlines"))
    safety_stops: int = Field(description=described("safety_stops"))
    contacts: int = Field(description=described("contacts"))
    contact_points: tuple[ContactPoint, ...] = Field(
        default=(), description=f"the contacts in order, the first {CONTACT_POINTS} of them"
    )
    deferred_obstacles: int = Field(
        default=0,
        title="obstacles that waited for the robot",
        description="times that an obstacle waited to come until the robot had left its place",
    )
    driving_s: float = Field(title="time driving", description="time in which the robot moved")
    waiting_s: float = Field(
        title="time standing for an answer", description="time in which it stood and a plan or an answer was under way"
    )
    known_share: float = Field(title="cells known at the end", description=described("known_share"))
    energy: MissionEnergy = Field(description="energy of the mission")
    account: dict[str, Account] = Field(description="where the time of each component and link went")
    latency: tuple[LatencyShare, ...] = Field(
        default=(),
        description="where the time from each scan that asked for a plan to the answer, or the request's end, went;"
        " largest first",
    )
    control: tuple[LatencyShare, ...] = Field(
        default=(), description="where the time of turns of the control loop went, largest first"
    )
    bottleneck: Bottleneck | None = Field(
        default=None,
        description="what sets the pace: found by levers where they were run, else where the time was seen to go; None"
        " where no time passed",
    )
    levers: tuple[LeverRun, ...] | None = Field(
        default=None, description="the mission with one value moved each, the best first; None: not run"
    )
