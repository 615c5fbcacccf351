"""What a fleet's run came to, as tables, and in a sentence what set its pace and what would move it.

The sentence rests on the closed forms of ``benchmarks.velocity_obstacle_pace``, with the mean time in which
the robots decide. A result tells what a message takes on the line only where that is longer than deciding; where it is
not, what doubling would give is told as a bound.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from codesign.planners.interface import RobotsQuality
from codesign.report.fields import records_table, row_of, rows_of
from codesign.report.table import Cell, Table, left, pairs, right, word, words
from codesign.report.wording import (
    ABSENT,
    ENDED,
    PACE,
    count_cell,
    plural,
    quantity_text,
    share_cell,
    share_text,
    time_cell,
)
from codesign.results.fleet import Spread

if TYPE_CHECKING:
    from codesign.results.fleet import FleetFigures, Frames, Pacemaker
    from codesign.results.result import Result, Times

_WENT_INTO: dict[Pacemaker, str] = {
    "fpga": "robots decide",
    "line": "waiting for the line",
    "time_step": "waiting for the time step",
}
_SAME = 0.02
"""Rates closer than this share are told as one."""


def fleet_tables(result: Result) -> tuple[Table, ...]:
    """The tables of a fleet, in reading order; () where the result is of none."""
    fleet = result.fleet
    if fleet is None:
        return ()
    tables = [_fleet_table(result, fleet), _shares_table(fleet)]
    spans = _spans_table(fleet)
    tables += [spans] if spans.rows else []
    tables += [] if fleet.frames is None else [_frames_table(fleet.frames)]
    return tuple(tables)


def fleet_headline(result: Result) -> tuple[tuple[str, str], ...]:
    """The few figures of a fleet that a reader looks for first, as (figure, what it is): collisions before all."""
    fleet, quality = result.fleet, result.quality
    told: list[tuple[str, str]] = []
    if isinstance(quality, RobotsQuality):
        number, _, noun = plural(quality.collisions, "pair").partition(" ")
        told += [(number, f"{noun} of robots collided")]
        told += [(f"{quality.robots_arrived} of {quality.robots}", "robots at their targets")]
    if fleet is not None:
        told += [
            (quantity_text(fleet.span_s, "s"), f"for {plural(fleet.updates, 'update')}"),
            (quantity_text(fleet.updates_a_second, ""), "updates a second"),
        ]
    if result.energy is not None:
        told.append((quantity_text(result.energy.energy_j, "J"), "energy of the run"))
    return tuple(told)


def fleet_end(fleet: FleetFigures) -> tuple[tuple[str, Cell], ...]:
    """Why the run ended, and whether all robots came to their targets."""
    done = Cell("yes" if fleet.completed else "no", fleet.completed)
    return (ENDED, word(fleet.ended)), ("all robots at their targets", done)


def fleet_times_table(time: Times) -> Table:
    """When starts and targets stood in the FPGAs, and when the last update was over."""
    rows = [("starts and targets loaded", time.map_loaded_s), ("last update over", time.first_plan_s)]
    return pairs("Time from the start of the run", [(name, time_cell(at)) for name, at in rows])


def pace_text(fleet: FleetFigures) -> str:
    """What sets the pace of a fleet and what would move it, as sentences; "" where no update was done."""
    if fleet.pace is None or not fleet.updates:
        return ""
    decide, message = _decide_s(fleet), _message_s(fleet)
    if fleet.shares["time_step"] > 0.0 or fleet.missed_updates:
        return _in_real_time(fleet, decide, message)
    if message is not None:
        return _held_by_line(fleet, decide, message)
    if fleet.pace == "line":
        return (
            f"the line: updates wait for it {share_text(fleet.shares['line'])} of the time, though a message takes it"
            f" no longer than the {_seconds(decide)} in which the robots decide. A FIFO that is shorter than a message"
            " holds them, or what has to be sent again"
        )
    return _held_by_robots(fleet, decide)


def _held_by_line(fleet: FleetFigures, decide: float, message: float) -> str:
    """Period = max(message, decide + what a short FIFO holds); of that a message's time at the most."""
    period = 1.0 / fleet.updates_a_second
    told = (
        f"the line: a message of all coordinates takes it {_seconds(message)}, while the robots decide in"
        f" {_seconds(decide)} on average; {share_text(fleet.shares['line'])} of the time is waiting for it."
        f" Twice the baud gives {_between(1 / (decide + message / 2), 1 / max(decide, message / 2))} updates a second"
        f" in place of {_rate(fleet.updates_a_second)}"
    )
    if decide > 0.0:
        told += (
            f"; from about {_times(message / decide)} times the baud on, the robots' decisions set the pace"
        )
    if period > (1 + _SAME) * message:
        told += f". A FIFO that holds a whole message gives up to {_rate(fleet.reachable_a_second)}"
    return told


def _held_by_robots(fleet: FleetFigures, decide: float) -> str:
    waiting = fleet.shares["line"] / fleet.updates_a_second
    told = (
        f"the robots' decisions: {_seconds(decide)} on average, {share_text(fleet.shares['fpga'])} of the time."
        f" Twice the clock gives {'up to ' if waiting else ''}{_rate(1 / (decide / 2 + waiting))} updates a second in"
        f" place of {_rate(fleet.updates_a_second)}"
    )
    if waiting / (decide + waiting) > _SAME:
        told += f"; a faster line, or a FIFO that holds a whole message, up to {_rate(1 / decide)}"
    return told


def _in_real_time(fleet: FleetFigures, decide: float, message: float | None) -> str:
    step = fleet.time_step_s
    if fleet.missed_updates and fleet.decide is not None:
        told = (
            f"the robots' decisions: {plural(fleet.missed_updates, 'update')} of {fleet.updates:,} took longer than the"
            f" time step of {_seconds(step)} and acted late: the robots drove on meanwhile. The longest took"
            f" {_times(fleet.decide.worst_s / fleet.time_step_s)} time steps. At another clock the robots take"
            " other courses: run it to see how many updates are late there"
        )
    else:
        told = (
            f"the time step of {_seconds(step)}, as asked for: the robots decide in {_seconds(decide)} on average, and"
            f" FPGAs and line would allow {_rate(fleet.reachable_a_second)} updates a second at most. A shorter time"
            " step, or pace free_running, makes use of that"
        )
    frames = fleet.frames
    if frames is not None and frames.skipped:
        told += f". {plural(frames.skipped, 'frame')} of {frames.made:,} are skipped"
        if message is not None and message > step:
            told += (
                f", as the line takes {_seconds(message)} for each: {_times(message / step)} times the baud"
            )
            told += " shows all"
    return told


def _fleet_table(result: Result, fleet: FleetFigures) -> Table:
    quality, (least, most) = result.quality, fleet.fpga_utilisation
    first = ("collisions", "closest_approach") if isinstance(quality, RobotsQuality) else ()
    rows = [
        *(row_of(quality, name) for name in first),
        *fleet_end(fleet),
        *rows_of(fleet),
        ("most of the time goes into", words(_WENT_INTO[fleet.pace])[0] if fleet.pace else Cell(ABSENT)),
        ("busy share of the least busy FPGA", share_cell(least)),
        ("busy share of the most busy FPGA", share_cell(most)),
    ]
    told = pace_text(fleet)
    return pairs("Fleet", [*rows, *([(PACE, Cell(told, told))] if told else [])])


def _shares_table(fleet: FleetFigures) -> Table:
    lines = (
        (*words(_WENT_INTO[name]), time_cell(share * fleet.span_s), share_cell(share))
        for name, share in fleet.shares.items()
    )
    return Table(
        "Where the time of the updates went",
        (*left("what"), *right("time", unit="s"), *right("share", unit="1")),
        tuple(lines),
        ("robots decide: from the begin of an update until the last of them has decided",),
    )


def _spans_table(fleet: FleetFigures) -> Table:
    spans = {
        "robots decide": fleet.decide,
        "from update to update": fleet.period,
        "age of a frame when shown": None if fleet.frames is None else fleet.frames.age,
    }
    known = [(name, span) for name, span in spans.items() if span is not None]
    return records_table("Times of an update", "what", known, Spread)


def _frames_table(frames: Frames) -> Table:
    """All that were made, by what became of them."""
    rows = [
        *rows_of(frames),
        *((f"dropped: {reason}", count_cell(count)) for reason, count in frames.dropped.items()),
    ]
    return pairs(f"Frames to {frames.receiver}", rows, ("made = shown + skipped + dropped + under way",))


def _decide_s(fleet: FleetFigures) -> float:
    """Mean time in which the robots decide, s."""
    return fleet.shares["fpga"] * fleet.span_s / fleet.updates


def _message_s(fleet: FleetFigures) -> float | None:
    """What a message takes on the slowest link, s, where that is more than the robots need; else None: not told."""
    if fleet.frames is None or not fleet.reachable_a_second:
        return None
    slowest = 1.0 / fleet.reachable_a_second
    return slowest if slowest > (1 + 1e-9) * _decide_s(fleet) else None


def _between(low: float, high: float) -> str:
    if high <= (1 + _SAME) * low:
        return f"about {_rate(low)}"
    return f"{_rate(low)} to {_rate(high)}"


def _rate(value: float) -> str:
    return f"{value:.3g}" if value < 100 else f"{value:,.0f}"


_times = _rate


def _seconds(value: float) -> str:
    """A mean: three significant digits are as many as it is worth."""
    return quantity_text(float(f"{value:.3g}"), "s")
