"""What a mission came to, as tables: its figures, where time and energy went, the messages of each link."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from codesign.report.fields import records_table, rows_of
from codesign.report.table import Cell, Table, left, pairs, right, word, words
from codesign.report.wording import (
    ABSENT,
    ENDED,
    PACE,
    count_cell,
    number_cell,
    plural,
    quantity_text,
    share_cell,
    share_text,
)
from codesign.results.ledger import SPENT
from codesign.results.mission import Account, LinkUse

if TYPE_CHECKING:
    from collections.abc import Mapping

    from codesign.results.mission import LatencyShare, Mission, MissionEnergy
    from codesign.results.result import Result

NOT_DECLARED = "not declared"
"""In place of the energy of links or memories none of which has a declared power."""

SHORTEST_WAY = (
    "the shortest path is the any-angle path of the robot's middle from the start over the cells of the goals, without"
    " what appears or moves: no robot drives less"
)

_CONTACTS = 20


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
        if mission.latency:
            tables.append(latency_table(mission.latency))
        if mission.control:
            tables.append(control_table(mission.control))
        tables.append(energy_table(mission.energy))
    if len(set(result.places.values())) > 1:
        tables.append(places_table(result.places))
    if mission is not None and mission.account:
        tables.append(account_table(mission.account, mission.mission_time_s))
    if result.links:
        tables.append(links_table(result.links))
    return tuple(tables)


def mission_headline(mission: Mission) -> tuple[tuple[str, str], ...]:
    """The few figures that a reader looks for first, as (figure, what it is)."""
    told = [("reached" if mission.reached else "not reached", "")]
    told.append((quantity_text(mission.mission_time_s, "s"), "mission time"))
    if mission.distance_ratio is not None:
        told.append((number_cell(mission.distance_ratio).text, "times the shortest path"))
    told.append((quantity_text(mission.replans, ""), "replans"))
    if mission.replan_latency_95_s is not None:
        told.append((quantity_text(mission.replan_latency_95_s, "s"), "replan latency, 95th percentile"))
    told.append((quantity_text(mission.energy.mission_energy_j, "J"), "energy"))
    for count, noun in ((mission.contacts, "contact"), (mission.missed_deadlines, "missed deadline")):
        if count:
            number, _, name = plural(count, noun).partition(" ")
            told.append((number, name))
    return tuple(told)


def bottleneck_text(mission: Mission) -> str:
    """What sets the pace and what would move it, as a sentence; "" where nobody knows."""
    found = mission.bottleneck
    if found is None:
        return ""
    # The mission's own sentence begins with the name.
    begins = found.text.startswith(found.name)
    return found.text if begins else f"{found.name} ({found.kind}, {share_text(found.share)}): {found.text}"


def mission_end(mission: Mission) -> tuple[tuple[str, Cell], ...]:
    """Why the mission ended, and whether all was done."""
    done = Cell("yes" if mission.reached else "no", mission.reached)
    return (ENDED, word(mission.ended)), ("did all that it was to do", done)


def mission_table(mission: Mission) -> Table:
    """The figures of the mission itself."""
    rows = [
        *mission_end(mission),
        *rows_of(mission),
    ]
    if mission.bottleneck is not None:
        rows.append((PACE, word(bottleneck_text(mission))))
    return pairs("Mission", rows, (SHORTEST_WAY,) if mission.shortest_m is not None else ())


def levers_table(mission: Mission) -> Table:
    """The mission as it is, and run again with each lever moved by itself."""
    without = (
        *words("none", "", ""),
        *_run_cells(
            mission.reached, mission.mission_time_s, mission.energy.mission_energy_j, mission.missed_deadlines
        ),
        Cell(""),
    )
    return Table(
        "Levers, each run by itself",
        (
            *left("lever", "from", "to", "reached"),
            *right("mission time", unit="s"),
            *right("energy", unit="J"),
            *right("missed deadlines"),
            *left("not run as"),
        ),
        (
            without,
            *(
                (
                    *words(one.path, one.before, one.after or ABSENT),
                    *_run_cells(one.reached, one.mission_time_s, one.mission_energy_j, one.missed_deadlines),
                    word(one.refused or ""),
                )
                for one in mission.levers or ()
            ),
        ),
        strong=frozenset([0]),
    )


def _run_cells(
    reached: bool | None, time_s: float | None, energy_j: float | None, missed: int | None
) -> tuple[Cell, ...]:
    return (
        Cell(ABSENT) if reached is None else Cell("yes" if reached else "no", reached),
        _seconds(time_s),
        Cell(ABSENT) if energy_j is None else _joules(energy_j),
        Cell(ABSENT) if missed is None else count_cell(missed),
    )


def contacts_table(mission: Mission) -> Table:
    """When, where and how fast the robot ran against something."""
    shown = mission.contact_points[:_CONTACTS]
    rest = mission.contacts - len(shown)
    return Table(
        "Contacts",
        (*right("time", unit="s"), *right("row", "column"), *right("speed", unit="m/s")),
        tuple(
            (
                _seconds(one.time_s),
                Cell(f"{one.row:.3f}", one.row),
                Cell(f"{one.column:.3f}", one.column),
                Cell(quantity_text(one.speed_m_s, "m/s"), one.speed_m_s),
            )
            for one in shown
        ),
        (f"the first {len(shown)}; {plural(rest, 'contact')} more",) if rest else (),
    )


def energy_table(energy: MissionEnergy) -> Table:
    """Energy of the mission by what took it."""
    total = energy.mission_energy_j
    lines = [
        (word(name), *_energy_cells(joules, total))
        for name, joules in (
            ("FPGA", energy.fpga_j),
            ("processors", energy.processors_j),
            ("links", energy.links_j),
            ("memories", energy.memories_j),
            ("robot", energy.robot_j),
        )
        if joules or name in energy.not_declared
    ]
    notes = not_declared_notes(energy.not_declared)
    if energy.idle_fpgas_j:
        notes = (f"FPGAs without any task drew {quantity_text(energy.idle_fpgas_j, 'J')} of it", *notes)
    return Table(
        "Energy of the mission",
        (*left("what"), *right("energy", unit="J"), *right("share", unit="1")),
        (
            *lines,
            (
                word("all"),
                _joules(energy.mission_energy_j),
                _part(energy.mission_energy_j, energy.mission_energy_j),
            ),
        ),
        notes,
        strong=frozenset([len(lines)]),
    )


def _energy_cells(joules: float, total: float) -> tuple[Cell, Cell]:
    return (_joules(joules), _part(joules, total)) if joules else (Cell(NOT_DECLARED), Cell(ABSENT))


def not_declared_notes(names: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    """What counts as 0 J only since the platform declares no power of it."""
    return tuple(
        f"{kind} whose power is not declared count as 0 J: {', '.join(of_kind)}"
        for kind, of_kind in names.items()
    )


def account_table(accounts: Mapping[str, Account], time_s: float) -> Table:
    """Where the time of each component and link went."""
    table = records_table(
        "Where the time of each component and link went", "component or link", accounts.items(), Account
    )
    busy = [_part(account.compute_s + account.transfer_s, time_s) for account in accounts.values()]
    return replace(
        table,
        columns=(*table.columns, *right("busy", unit="1")),
        rows=tuple((*row, cell) for row, cell in zip(table.rows, busy, strict=True)),
        notes=(
            "compute of a robot: it moves; wait: how long work or messages waited for it, all of them together",
        ),
    )


def latency_table(shares: tuple[LatencyShare, ...]) -> Table:
    """Where the time from each scan that asked for a plan to the answer, or the request's end, went."""
    return _shares_table("Where the time of plans went", shares)


def control_table(shares: tuple[LatencyShare, ...]) -> Table:
    """Where the time from a scan to the command that follows from it went, over all turns of the control loop."""
    return _shares_table("Where the time of control turns went", shares)


def _shares_table(title: str, shares: tuple[LatencyShare, ...]) -> Table:
    return Table(
        title,
        (*left("what", "where"), *right("time", unit="s"), *right("share", unit="1")),
        tuple(
            (*words(SPENT[one.kind], one.where), _seconds(one.seconds), share_cell(one.share))
            for one in shares
        ),
    )


def links_table(links: Mapping[str, LinkUse]) -> Table:
    """The messages of each link: what became of them, and how full it was."""
    reasons = tuple(
        f"{name}: {plural(count, 'message')} dropped: {reason}"
        for name, use in links.items()
        for reason, count in use.dropped.items()
    )
    reasons += tuple(
        f"{name}: {plural(count, 'damaged message')} {message!r} taken for what was sent: what wrong bits in it do is"
        " not simulated, or they mean nothing"
        for name, use in links.items()
        for message, count in use.ignored_damage.items()
    )
    return records_table("Messages on links", "link", links.items(), LinkUse, reasons)


def places_table(places: Mapping[str, str]) -> Table:
    """The component on which each task runs."""
    return Table(
        "Where each task runs", left("task", "component"), tuple(words(*pair) for pair in places.items())
    )


def _seconds(value: float | None) -> Cell:
    return Cell(ABSENT) if value is None else Cell(quantity_text(value, "s"), value)


def _joules(value: float) -> Cell:
    return Cell(quantity_text(value, "J"), value)


def _part(part: float, whole: float) -> Cell:
    return Cell(ABSENT) if whole <= 0 else share_cell(min(part / whole, 1.0))
