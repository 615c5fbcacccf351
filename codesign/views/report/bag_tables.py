"""The goals of a bag as a table: when the robot's own planner answered, and when a board would have."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from codesign.ground.errors import printable
from codesign.ground.records import Record, Subject
from codesign.ground.units import counted, format_time
from codesign.views.bags import BagFacts, latency
from codesign.views.report.wording import Cell, Table, left, right


def board_latencies(records: Iterable[Record]) -> list[int | None]:
    """Of each goal of a simulated mission in turn, the time from the goal to the first plan after it, ps.

    None where no plan came before the next goal.
    """
    latencies: list[int | None] = []
    given = 0
    for record in records:
        if record.ROLE.about is Subject.GOALS:
            given = record.time
            latencies.append(None)
        elif record.ROLE.about is Subject.PLAN and latencies and latencies[-1] is None:
            latencies[-1] = record.time - given
    return latencies


def goals_table(facts: BagFacts, board: str | None = None, latencies: Sequence[int | None] = ()) -> Table:
    """A row for each goal. ``latencies``: what ``board`` answers the goals of the tour in, ps."""
    columns = (*right("goal"), *right("given", unit="s"), *left("place", "cell"), *right("recorded answer"))
    if board is not None:
        columns += right(f"{board} answers")
    columns += (*right("plans"), *right("reached", unit="s"))
    rows, leg, before = [], -1, None
    for number, each in enumerate(facts.goals, 1):
        if each.toured and each.cell != before:
            leg, before = leg + 1, each.cell
        answer = latency(each)
        row = [
            Cell(str(number), number),
            Cell(f"{each.time:.3f}", each.time),
            Cell(f"({each.place[0]:.2f}, {each.place[1]:.2f}) m"),
            Cell(f"{each.cell}" if each.toured else "left out"),
            Cell("-" if answer is None else format_time(round(answer * 1e12)), answer),
        ]
        if board is not None:
            simulated = latencies[leg] if each.toured and leg < len(latencies) else None
            row.append(Cell("-") if simulated is None else Cell(format_time(simulated), simulated * 1e-12))
        row += [
            Cell(str(each.plans), each.plans),
            Cell("-" if each.reached is None else f"{each.reached:.3f}", each.reached),
        ]
        rows.append(tuple(row))
    drawn = facts.obstacles
    notes = [
        f"{counted(len(drawn.obstacles), 'obstacle')} of {drawn.hits:,} rays that hit cells which the map has free"
    ]
    notes += [printable(remark) for remark in facts.remarks]
    return Table("goals", columns, tuple(rows), tuple(notes))
