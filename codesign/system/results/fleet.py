"""The figures of a fleet's run: how fast the updates follow each other, what sets their pace, what the display saw.

Times are in seconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from pydantic import Field

from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.system.results.model import ResultModel

Pacemaker = Literal["fpga", "line", "time_step"]
PACEMAKERS: tuple[Pacemaker, ...] = ("fpga", "line", "time_step")


class Spread(ResultModel):
    """Some spans of time: their median, 95th percentile and worst, s; each is one of them."""

    median_s: float = Field(description="median, s")
    share_95_s: float = Field(title="95th percentile", description="95th percentile, s")
    worst_s: float = Field(description="worst, s")


class Frames(ResultModel):
    """The coordinates of all robots in messages to the display, one message an update.

    ``made`` = ``skipped`` + ``dropped`` + ``shown`` + ``under_way``. A free-running fleet skips none, it waits.
    """

    receiver: str = Field(description="the component that draws them")
    bits: int = Field(title="bits of a frame", description="bits of one message, framing left out")
    made: int = Field(description="messages made, one an update")
    skipped: int = Field(description="not sent, as the one before was not in the line's FIFO yet")
    dropped: dict[str, int] = Field(description="lost, by reason")
    shown: int = Field(description="drawn")
    late: int = Field(
        title="of these later than a time step",
        description="of those shown, later than a time step after their update was decided",
    )
    under_way: int = Field(title="under way at the end", description="at the end of the run")
    age: Spread | None = Field(description="from the decision of an update to its picture")


class FleetFigures(ResultModel):
    """The figures of one run of scenario ``fleet``."""

    robots: int = Field(description="robots of the fleet")
    fpgas: int = Field(
        title="FPGAs", description="one for each robot, all alike: the platform file declares one of them"
    )
    ended: str = Field(description="why the run ended")
    completed: bool = Field(description="whether all robots stand at their targets and no two touched on the way")
    updates: int = Field(description="updates of all velocities that were done")
    span_s: float = Field(
        title="time of all updates", description="from the begin of the first update to the end of the last, s"
    )
    robots_s: float = Field(
        title="time that passed for the robots",
        description="time that passed for the robots, s: of a fleet in real time the same as span_s; a free-running"
        " fleet simulates its robots, and takes them one time step on with every update",
    )
    arrived_s: float | None = Field(
        title="time until the last arrival",
        description="from the begin of the first update until the last arrival of a robot, s, by the clock of span_s;"
        " None where none arrived",
    )
    time_step_s: float = Field(description="time step of the planner, s")
    decide: Spread | None = Field(description="from the begin of an update until the last robot has decided")
    period: Spread | None = Field(description="from the begin of an update to its end, where the next one begins")
    updates_a_second: float = Field(description="that were done")
    reachable_a_second: float = Field(
        title="updates a second that FPGAs and line allow, at most",
        description="an upper bound of what FPGA and line allow in the long run: the lesser of the two rates, each by"
        " its mean. A FIFO shorter than a frame, and decisions that vary, keep a fleet below it",
    )
    pace: Pacemaker | None = Field(description="what most of the time went into")
    shares: dict[Pacemaker, float] = Field(
        description="shares of the time: robots decided, waited for the line, waited for the time step"
    )
    missed_updates: int = Field(
        title="updates longer than the time step",
        description="that took longer to decide than the time step; in real time they act late",
    )
    frames: Frames | None = Field(description="messages of coordinates to the display; None where there is none")
    fpga_busy_s: float = Field(
        title="busy time of all FPGAs together", description="the sum over the FPGAs of all robots, s"
    )
    fpga_utilisation: tuple[float, float] = Field(description="of the least and the most busy FPGA")


def spread(spans: Sequence[int]) -> Spread | None:
    """Median, 95th percentile and worst of some spans, ps; None of none."""
    if not spans:
        return None
    ordered = sorted(spans)

    def rank(percent: int) -> float:
        return ordered[max(0, -(-len(ordered) * percent // 100) - 1)] / PICOSECONDS_PER_SECOND

    return Spread(median_s=rank(50), share_95_s=rank(95), worst_s=rank(100))
