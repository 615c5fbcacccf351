"""The tables of a mission and of a fleet: their figures, where time and energy went, the messages of each link."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from codesign.ground.errors import printable
from codesign.ground.records import Record, Subject
from codesign.ground.units import counted, format_time
from codesign.planners.interface import RobotsQuality
from codesign.system.results.ledger import SPENT
from codesign.system.results.mission import Account, LatencyShare, LeverRun, LinkUse, Mission, MissionEnergy
from codesign.system.results.result import Energy, FleetFigures, Frames, Pacemaker, Result, Spread
from codesign.views.bags import BagFacts, latency
from codesign.views.report.sentences import bottleneck_text, pace_text
from codesign.views.report.wording import (
    ABSENT,
    ENDED,
    PACE,
    Cell,
    Column,
    Shown,
    Table,
    count_cell,
    formed_cell,
    left,
    number_cell,
    pairs,
    part_cell,
    quantity_cell,
    quantity_text,
    records_table,
    right,
    row_of,
    rows_of,
    share_cell,
    shares_table,
    shown_fields,
    word,
    words,
    yes_cell,
)

NOT_DECLARED = "not declared"
"""Stands in place of the energy of links or memories if none of them has a declared power."""

SHORTEST_DRIVE = (
    "the shortest path is the any-angle path of the robot's middle from the start over the cells of the goals, without"
    " what appears or moves: no robot drives less"
)

_CONTACTS = 20
_TIME = Column("time", "s", "right")

_WENT_INTO: dict[Pacemaker, str] = {
    "fpga": "robots decide",
    "line": "waiting for the line",
    "time_step": "waiting for the time step",
}


def end_rows(result: Result) -> tuple[tuple[str, Cell], ...]:
    """The end of the mission or the fleet, and whether it completed; () for a plan alone."""
    if result.mission is not None:
        return _mission_end(result.mission)
    return () if result.fleet is None else _fleet_end(result.fleet)


def mission_tables(result: Result) -> tuple[Table, ...]:
    """The tables of a mission, in reading order, and of any run's places and links; () where it has none of them."""
    mission = result.mission
    tables: list[Table] = []
    if mission is not None:
        tables.append(mission_table(mission))
        if mission.levers:
            tables.append(levers_table(mission))
        if mission.contact_points:
            tables.append(contacts_table(mission))
        for what, shares in (("plans", mission.latency), ("control turns", mission.control)):
            tables += [latency_table(f"Where the time of {what} went", shares)] if shares else []
        tables.append(energy_table("Energy of the mission", mission.energy))
    if len(set(result.places.values())) > 1:
        roles = {name: role for role, name in result.roles.items()}
        places = tuple(words(task, name, roles.get(name, ABSENT)) for task, name in result.places.items())
        tables.append(Table("Where each task runs", left("task", "component", "role"), places))
    if mission is not None and mission.account:
        tables.append(account_table(mission.account))
    if result.links:
        tables.append(links_table(result.links))
    return tuple(tables)


def _mission_end(mission: Mission) -> tuple[tuple[str, Cell], ...]:
    return (ENDED, word(mission.ended)), ("mission completed", yes_cell(mission.reached))


def mission_table(mission: Mission) -> Table:
    """The figures of the mission itself."""
    pace = bottleneck_text(mission)
    rows = [*_mission_end(mission), *rows_of(mission), *([(PACE, word(pace))] if pace else [])]
    return pairs("Mission", rows, (SHORTEST_DRIVE,) if mission.shortest_m is not None else ())


def levers_table(mission: Mission) -> Table:
    """The mission as it is, and run again with each lever moved by itself."""
    as_it_is = LeverRun(
        path="none",
        before="",
        after="",
        reached=mission.reached,
        mission_time_s=mission.mission_time_s,
        mission_energy_j=mission.energy.mission_energy_j,
        missed_deadlines=mission.missed_deadlines,
    )
    fields = shown_fields(LeverRun)
    return Table(
        "Levers, each run by itself",
        (*left("lever", "from", "to", "reached"), *(field.column for field in fields), *left("not run as")),
        tuple(
            (
                *words(run.path, run.before, ABSENT if run.after is None else run.after),
                yes_cell(run.reached),
                *(field.cell(vars(run)[field.name]) for field in fields),
                word(run.refused or ""),
            )
            for run in (as_it_is, *(mission.levers or ()))
        ),
        strong=frozenset([0]),
    )


def contacts_table(mission: Mission) -> Table:
    """The contacts of the robot: when, where and how fast it ran against something."""
    shown = mission.contact_points[:_CONTACTS]
    rest = mission.contacts - len(shown)
    return Table(
        "Contacts",
        (_TIME, *right("row", "column"), *right("speed", unit="m/s")),
        tuple(
            (
                quantity_cell(contact.time_s, "s"),
                *(formed_cell(place, "{:.3f}") for place in (contact.row, contact.column)),
                quantity_cell(contact.speed_m_s, "m/s"),
            )
            for contact in shown
        ),
        (f"the first {len(shown)}; {counted(rest, 'contact')} more",) if rest else (),
    )


def energy_table(title: str, energy: Energy | MissionEnergy) -> Table:
    """Energy by the parts that took any. The declared figure of the record is the sum of its other fields."""
    fields = shown_fields(type(energy))
    (total,) = (field for field in fields if field.is_declared)
    joules = vars(energy)
    all_of_it = joules[total.name]
    parts = [
        (word(field.label), *_energy_cells(field, joules[field.name], all_of_it))
        for field in fields
        if field.name not in (total.name, "idle_fpgas_j") and (joules[field.name] or field.label in energy.not_declared)
    ]
    notes = [
        f"{kind} whose power is not declared count as 0 J: {', '.join(names)}"
        for kind, names in energy.not_declared.items()
    ]
    if energy.idle_fpgas_j:
        notes.insert(0, f"FPGAs without any task drew {quantity_text(energy.idle_fpgas_j, 'J')} of it")
    column = Column("energy", "J", "right")
    return shares_table(title, ("part",), column, parts, total.cell(all_of_it), tuple(notes))


def _energy_cells(field: Shown, joules: float, total: float) -> tuple[Cell, Cell]:
    return (field.cell(joules), part_cell(joules, total)) if joules else (Cell(NOT_DECLARED), Cell(ABSENT))


def account_table(accounts: Mapping[str, Account]) -> Table:
    """The time of each component and link, by what it was spent on."""
    title = "Where the time of each component and link went"
    table = records_table(title, "component or link", accounts.items(), Account)
    rows = zip(table.rows, accounts.values(), strict=True)
    return replace(
        table,
        columns=(*table.columns, *right("busy", unit="1")),
        rows=tuple((*row, share_cell(busy_share(account))) for row, account in rows),
        notes=("compute of a robot: it moves; wait: how long work or messages waited for it, all of them together",),
    )


def busy_share(account: Account) -> float:
    """The share of the mission in which a component computed or a link carried: all but its idle time."""
    busy = account.compute_s + account.transfer_s
    total = busy + account.idle_s
    return min(busy / total, 1.0) if total > 0.0 else 0.0


def latency_table(title: str, shares: tuple[LatencyShare, ...]) -> Table:
    """The shares of a time: the kind of work, the component or link, how long, and its share."""
    rows = (
        (*words(SPENT[share.kind], share.where), quantity_cell(share.seconds, "s"), share_cell(share.share))
        for share in shares
    )
    return shares_table(title, ("spent on", "where"), _TIME, rows)


def links_table(links: Mapping[str, LinkUse]) -> Table:
    """The messages of each link: what became of them, and how busy it was."""
    reasons = tuple(
        f"{name}: {counted(count, 'message')} dropped: {reason}"
        for name, use in links.items()
        for reason, count in use.dropped.items()
    )
    reasons += tuple(
        f"{name}: {counted(count, 'damaged message')} {message!r} taken for what was sent: what wrong bits in it do is"
        " not simulated, or they mean nothing"
        for name, use in links.items()
        for message, count in use.ignored_damage.items()
    )
    return records_table("Messages on links", "link", links.items(), LinkUse, reasons)


def fleet_tables(result: Result) -> tuple[Table, ...]:
    """The tables of a fleet, in reading order; () where the result has none."""
    fleet = result.fleet
    if fleet is None:
        return ()
    spans = _spans_table(fleet)
    return (
        _fleet_table(result, fleet),
        _shares_table(fleet),
        *((spans,) if spans.rows else ()),
        *(() if fleet.frames is None else (_frames_table(fleet.frames),)),
    )


def _fleet_end(fleet: FleetFigures) -> tuple[tuple[str, Cell], ...]:
    return (ENDED, word(fleet.ended)), ("all robots at their targets without a contact", yes_cell(fleet.completed))


def _fleet_table(result: Result, fleet: FleetFigures) -> Table:
    quality, (least, most) = result.quality, fleet.fpga_utilisation
    first = ("collisions", "closest_approach") if isinstance(quality, RobotsQuality) else ()
    pace = pace_text(fleet)
    rows = [
        *(row_of(quality, name) for name in first),
        *_fleet_end(fleet),
        *rows_of(fleet),
        ("most of the time goes into", word(_WENT_INTO[fleet.pace]) if fleet.pace else Cell(ABSENT)),
        ("busy share of the least busy FPGA", share_cell(least)),
        ("busy share of the most busy FPGA", share_cell(most)),
        *([(PACE, word(pace))] if pace else []),
    ]
    return pairs("Fleet", rows)


def _shares_table(fleet: FleetFigures) -> Table:
    rows = (
        (word(_WENT_INTO[name]), quantity_cell(share * fleet.span_s, "s"), share_cell(share))
        for name, share in fleet.shares.items()
    )
    note = "robots decide: from the begin of an update until the last of them has decided"
    return shares_table("Where the time of the updates went", ("spent on",), _TIME, rows, notes=(note,))


def _spans_table(fleet: FleetFigures) -> Table:
    spans = {
        "robots decide": fleet.decide,
        "from update to update": fleet.period,
        "age of a frame when shown": None if fleet.frames is None else fleet.frames.age,
    }
    measured = [(name, span) for name, span in spans.items() if span is not None]
    return records_table("Times of an update", "span", measured, Spread)


def _frames_table(frames: Frames) -> Table:
    """All frames that were made, by what became of them."""
    dropped = ((f"dropped: {reason}", count_cell(count)) for reason, count in frames.dropped.items())
    rows = [*rows_of(frames), *dropped]
    return pairs(f"Frames to {frames.receiver}", rows, ("made = shown + skipped + dropped + under way",))


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
            number_cell(number),
            formed_cell(each.time, "{:.3f}"),
            Cell(f"({each.place[0]:.2f}, {each.place[1]:.2f}) m"),
            Cell(f"{each.cell}" if each.toured else "left out"),
            Cell("-" if answer is None else format_time(round(answer * 1e12)), answer),
        ]
        if board is not None:
            simulated = latencies[leg] if each.toured and leg < len(latencies) else None
            row.append(Cell("-") if simulated is None else Cell(format_time(simulated), simulated * 1e-12))
        rows.append((*row, number_cell(each.plans), formed_cell(each.reached, "{:.3f}")))
    drawn = facts.obstacles
    notes = [
        f"{counted(len(drawn.obstacles), 'obstacle')} of {drawn.hits:,} rays that hit cells which the map has free"
    ]
    notes += [printable(remark) for remark in facts.remarks]
    return Table("goals", columns, tuple(rows), tuple(notes))
