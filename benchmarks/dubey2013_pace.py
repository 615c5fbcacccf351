"""The table of what sets the pace of a fleet: ``python -m benchmarks.dubey2013_pace``.

Nothing of it is published: the paper says that coordinates go through a serial port, and not how fast. It stands in
docs/velocity_obstacle.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import groupby

from benchmarks.velocity_obstacle_pace import LineLaw, PaceRow, baud_needed, decide_times, pace_table
from codesign.planners.velocity_obstacle.plan import AvoidParameters
from codesign.planners.velocity_obstacle.published import Style

ROBOTS = (2, 4, 8, 16, 32, 64)
BAUDS = {9_600: "9,600 Bd", 115_200: "115,200", 921_600: "921,600", 3_000_000: "3 M", 12_000_000: "12 M"}
PARAMETERS = AvoidParameters(range=20.0, turn=135.0)
"""With which crowds of 64 arrive."""
ARRANGEMENT, STYLE = "random", Style.PIPELINED


def pace_lines(counts: Sequence[int] = ROBOTS) -> tuple[str, ...]:
    """The table in Markdown, a line for each number of robots: frames a second, bold where the FPGA sets the pace."""
    rows = pace_table(counts, tuple(BAUDS), style=STYLE, parameters=PARAMETERS, arrangement=ARRANGEMENT)
    head = ("robots", "D, mean", *BAUDS.values(), "FPGA sets the pace from")
    return (
        f"| {' | '.join(head)} |",
        f"|{'---:|' * len(head)}",
        *(_line(robots, tuple(of)) for robots, of in groupby(rows, key=lambda row: row.robots)),
    )


def _line(robots: int, rows: tuple[PaceRow, ...]) -> str:
    decide = rows[0].decide
    cells = [f"**{_rate(row.period)}**" if row.pace == "fpga" else _rate(row.period) for row in rows]
    micro, mega = float(decide * 10**6), float(baud_needed(robots, decide) / 10**6)
    shown = f"{micro:.1f}" if micro < 100 else f"{micro:.0f}"
    return f"| {robots} | {shown} µs | {' | '.join(cells)} | {mega:.1f} MBd |"


def _rate(period: Fraction) -> str:
    rate = float(1 / period)
    return f"{rate:,.0f}" if rate >= 10 else f"{rate:.1f}"


def pace_remarks() -> tuple[str, ...]:
    """What the table leaves open: a deep FIFO where the FPGA sets the pace, and the robots of a line in real time."""
    robots, baud = ROBOTS[-1], max(BAUDS)
    decides = decide_times(robots, STYLE, PARAMETERS, ARRANGEMENT)
    deep = LineLaw(baud, fifo_depth=LineLaw(baud).characters(robots)).mean_period(robots, decides)
    most = len(decides) / sum(decides, Fraction(0))
    step = Fraction(PARAMETERS.step_ps, 10**12)
    held = ", ".join(f"{LineLaw(each).robots_within(step)} at {each:,} baud" for each in (9_600, 115_200))
    return (
        f"{robots} robots at {baud:,} baud, FIFO as deep as the message: {_rate(deep)} of {float(most):,.0f} at most",
        f"in real time, {float(1 / step):g} updates a second, the line keeps up with {held}",
        f"8 robots need {float(baud_needed(8, step)):,.0f} baud for it",
    )


if __name__ == "__main__":
    print("\n".join((*pace_lines(), "", *pace_remarks())))
