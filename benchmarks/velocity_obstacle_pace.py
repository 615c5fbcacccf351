"""What sets the pace of a fleet that runs as fast as it can: the circuits, or the line to the display.

A frame of coordinates is one message an update. With C characters a message, T seconds a character (``frame_bits`` /
baud), F characters in the sender's FIFO and D seconds in which the robots decide one update, the frames of a
free-running fleet follow each other, once the line has filled up, in

    max(C T, D)                    where C ≤ F: the message goes into the FIFO while the line is at the one before
    max(C T, D + (C - F - 1) T)    where C > F: the circuit is held until the last F characters wait, and one is sent

D is that of the update itself, and no two updates need the same. Where C > F, the mean over a run is that of this
formula over its updates; with the mean D in place of each, it would come out too short, as the formula is convex.
Where C ≤ F, what the FIFO still holds makes up for a slow update: the mean lies between the two, and follows
character by character (``LineLaw.mean_period``). Simulated runs are held against this in the tests: each of their
updates may wait for a clock edge besides.

So the line sets the pace where C T > D: n · 2 · 16 bits / data_bits · frame_bits / baud > D. Where D is the greater, a
FIFO that is shorter than the message still costs (C - F - 1) T.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.plan.planner import COORDINATE_BITS
from codesign.planners.velocity_obstacle.plan.problem import generate
from codesign.planners.velocity_obstacle.published import CLOCK, Style
from codesign.planners.velocity_obstacle.styles.timing import run_cycles


@dataclass(frozen=True)
class LineLaw:
    """A serial line: ``baud`` bits a second, frames of ``frame_bits``, ``data_bits`` in each; a FIFO of some depth."""

    baud: int
    data_bits: int = 8
    frame_bits: Fraction = Fraction(10)
    fifo_depth: int = 16

    def characters(self, robots: int) -> int:
        """Characters of the coordinates of so many robots."""
        return -(-2 * COORDINATE_BITS * robots // self.data_bits)

    def message(self, robots: int) -> Fraction:
        """Time of the coordinates of so many robots on the line, s.

        >>> float(LineLaw(115_200).message(8))
        0.002777777777777778
        """
        return self.characters(robots) * self.frame_bits / self.baud

    def period(self, robots: int, decide: Fraction) -> Fraction:
        """Time between two updates of a free-running fleet that decides each in ``decide`` seconds, s."""
        held = max(0, self.characters(robots) - self.fifo_depth - 1) * self.frame_bits / self.baud
        return max(self.message(robots), decide + held)

    def mean_period(self, robots: int, decides: Sequence[Fraction]) -> Fraction:
        """Mean time from frame to frame of a free-running fleet, s, whose updates are decided in ``decides`` seconds.

        From the first frame's begin on the line to the last one's: two updates or more.
        """
        character, each = self.frame_bits / self.baud, self.characters(robots)
        now, free, firsts = Fraction(0), Fraction(0), list[Fraction]()
        for number, decide in enumerate(decides, 1):
            firsts.append(max(now + decide, free))
            free = firsts[-1] + each * character
            # The circuit goes on once all characters so far but those that the FIFO holds have begun.
            now, held = now + decide, number * each - self.fifo_depth - 1
            if held >= 0:
                now = max(now, firsts[held // each] + held % each * character)
        return (firsts[-1] - firsts[0]) / (len(firsts) - 1)

    def robots_within(self, decide: Fraction) -> int:
        """The most robots whose coordinates the line takes in ``decide`` seconds."""
        return int(decide * self.baud / self.frame_bits * self.data_bits / (2 * COORDINATE_BITS))


def baud_needed(robots: int, decide: Fraction, data_bits: int = 8, frame_bits: Fraction = Fraction(10)) -> Fraction:
    """The baud rate from which on the line takes all coordinates in ``decide`` seconds.

    >>> float(baud_needed(8, Fraction(1, 10)))
    3200.0
    """
    return LineLaw(1, data_bits, frame_bits).message(robots) / decide


@dataclass(frozen=True)
class PaceRow:
    """One fleet at one baud rate. ``decide``: the mean of its updates, s; ``period``: of the free-running fleet, s,
    its mean over the updates of a run; ``pace``: what takes longer, deciding on average or a message;
    ``in_real_time``: whether the line takes a frame each time step."""

    robots: int
    baud: int
    decide: Fraction
    message: Fraction
    period: Fraction
    pace: Literal["fpga", "line"]
    in_real_time: bool


def decide_times(
    robots: int, style: Style, parameters: AvoidParameters, arrangement: str, clock: int = CLOCK
) -> tuple[Fraction, ...]:
    """The time of each update of a run, s: that of its slowest robot."""
    cycles = run_cycles(style, avoid(generate(arrangement, robots, seed=1), parameters), parameters).each
    return tuple(Fraction(amount, clock) for amount in cycles.tolist())


def pace_table(
    counts: Sequence[int],
    bauds: Sequence[int],
    *,
    style: Style = Style.PIPELINED,
    parameters: AvoidParameters | None = None,
    arrangement: str = "random",
    clock: int = CLOCK,
) -> tuple[PaceRow, ...]:
    """For each number of robots and baud rate, what sets the pace; 8 data bits, no parity, one stop bit.

    ``clock``: Hz. The robots are those of ``generate`` with seed 1.
    """
    parameters = parameters or AvoidParameters()
    step = Fraction(parameters.step_ps, 10**12)
    rows = []
    for robots in counts:
        decides = decide_times(robots, style, parameters, arrangement, clock)
        decide = sum(decides, Fraction(0)) / len(decides)
        for baud in bauds:
            line = LineLaw(baud)
            message = line.message(robots)
            pace: Literal["fpga", "line"] = "line" if message > decide else "fpga"
            rows.append(
                PaceRow(robots, baud, decide, message, line.mean_period(robots, decides), pace, message <= step)
            )
    return tuple(rows)
