"""One result as tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from codesign.figures import label
from codesign.inputs.exploration import DEFAULT_OBJECTIVES
from codesign.planners.interface import Quality, RobotsQuality
from codesign.report.cost_tables import physical_table, resource_table, sources_table
from codesign.report.fields import records_table, rows_of, shown_fields
from codesign.report.fleet_tables import fleet_end, fleet_headline, fleet_tables, fleet_times_table
from codesign.report.mission_tables import mission_end, mission_headline, mission_tables
from codesign.report.table import Cell, Table, left, pairs, right, word
from codesign.report.wording import (
    ABSENT,
    axis_text,
    count_cell,
    figure_cell,
    number_cell,
    part_cell,
    quantity_text,
    share_cell,
    time_cell,
)
from codesign.results.result import DisplayUse, Reason, Result, StageUse

SHORTEST = "path length: the shortest is 8-connected without corner cutting"
"""What a ratio of path lengths is held against."""


def result_tables(result: Result) -> tuple[Table, ...]:
    """Everything that a result holds, in reading order, with its sources; what no run gave is left out."""
    overview, *figures = figure_tables(result)
    tables = (overview, result_reasons_table(result), *figures, sources_table([result]))
    return tuple(table for table in tables if table.rows)


def figure_tables(result: Result) -> tuple[Table, ...]:
    """The tables of ``result_tables`` but reasons and sources."""
    return (
        overview_table(result),
        *fleet_tables(result),
        *mission_tables(result),
        *_run_tables(result),
        *((resource_table(result),) if result.resources else ()),
        *((physical_table(result),) if result.clock or result.power or result.energy else ()),
    )


def overview_table(result: Result) -> Table:
    """How a mission or a fleet ended; what was run, and whether it can be built."""
    rows = [
        *(() if result.mission is None else mission_end(result.mission)),
        *(() if result.fleet is None else fleet_end(result.fleet)),
        ("platform", word(result.platform)),
        ("workload", word(result.workload)),
        ("planner", word(result.planner)),
        ("style", word(f"{result.style} on {result.component}")),
    ]
    if result.part is not None:
        rows.append(("part", word(result.part)))
    if result.external_memory is not None:
        rows.append(("external memory", word(result.external_memory)))
    rows += [
        (f"{task}.{name}", word(axis_text(name, value)))
        for task, parameters in result.parameters.items()
        for name, value in parameters.items()
        if value is not None
    ]
    if result.blocks is not None:
        rows.append(("blocks", count_cell(result.blocks)))
    if result.precision is not None:
        rows.append(("final precision", Cell(f"{result.precision} bits", result.precision)))
    if result.time is not None:
        name = "time to the first plan" if result.fleet is None else "time of the run"
        rows.append((name, time_cell(result.time.first_plan_s)))
    rows.append(("feasible", feasible_cell(result)))
    arrivals = arrivals_of(result)
    if arrivals is not None and arrivals[1] < arrivals[2]:
        # A design that can be built, and yet its plan fails.
        rows.append((arrivals[0], arrived_cell(arrivals)))
    return pairs("Design point", rows, result.notes)


def arrivals_of(result: Result) -> tuple[str, int, int] | None:
    """Where ways were tried: what should arrive, how many did, and of how many."""
    quality = result.quality
    if isinstance(quality, RobotsQuality):
        return "robots that arrive", quality.robots_arrived, quality.robots
    if quality is None or quality.starts == 0:
        return None
    return "starts that arrive", quality.starts_arrived, quality.starts


def arrived_cell(arrivals: tuple[str, int, int]) -> Cell:
    """How many of them, as ``63 of 64``."""
    return Cell(f"{arrivals[1]} of {arrivals[2]}", arrivals[1])


def headline(result: Result) -> tuple[tuple[str, str], ...]:
    """The few figures that a reader looks for first, as (figure, what it is)."""
    told = [("feasible" if result.feasible else "not feasible", "")]
    if result.mission is not None:
        return (*told, *mission_headline(result.mission))
    if result.fleet is not None:
        return (*told, *fleet_headline(result))
    for figure in DEFAULT_OBJECTIVES:
        value = result.figure(figure)
        if value is not None:
            told.append((figure_cell(figure, value).text, figure.label))
    return tuple(told)


def result_reasons_table(result: Result) -> Table:
    """Why the design cannot be built, or is not wanted, with what would mend it."""
    return Table(
        "Why it is not feasible",
        (*left("kind", "what"), *right("demand", "limit", "gap"), *left("what would close the gap")),
        tuple(reason_cells(reason) for reason in result.reasons),
    )


def reason_cells(reason: Reason) -> tuple[Cell, ...]:
    """One reason as kind, what, demand, limit, gap and levers."""
    return (
        word(reason.kind),
        word(label(reason.name)),
        *(
            Cell(quantity_text(value, reason.unit), value)
            for value in (reason.demand, reason.limit, reason.gap)
        ),
        word("; ".join(reason.levers) or ABSENT),
    )


def _run_tables(result: Result) -> list[Table]:
    tables = []
    if result.time is not None and result.fleet is not None:
        tables.append(fleet_times_table(result.time))
    elif result.time is not None:
        tables.append(pairs("Time from the start of the run", rows_of(result.time)))
    if result.cycles is not None:
        tables.append(_cycles_table(result.cycles, _whose_cycles(result)))
    if result.stages is not None:
        tables.append(_stages_table(result.stages))
    if result.utilisation is not None:
        busy = sorted(result.utilisation.items(), key=lambda item: (-item[1], item[0]))
        tables.append(
            Table(
                "Utilisation",
                (*left("component or link"), *right("busy", unit="1")),
                tuple((_busy_name(result, name), share_cell(share)) for name, share in busy),
            )
        )
    if result.displays:
        tables.append(displays_table(result.displays))
    if result.quality is not None:
        tables.append(_quality_table(result))
    if result.details:
        sums = isinstance(result.quality, RobotsQuality)
        tables.append(details_table(result.details, (_SUMS,) if sums else ()))
    return tables


_FIRST_BOARD = "of the first robot's board"
_SUMS = "decisions, trials and acceleration checks are sums over all robots"


def _whose_cycles(result: Result) -> str:
    """Of several robots, whose cycles a result holds; "" where there is one component that plans."""
    if result.fleet is not None:
        return _FIRST_BOARD
    return "of each update's slowest robot" if isinstance(result.quality, RobotsQuality) else ""


def _busy_name(result: Result, name: str) -> Cell:
    """A component or link; of a fleet's boards, the one that the platform file declares is the first robot's."""
    of_board = name == result.component or name.startswith(f"{result.component}.")
    return Cell(f"{name} ({_FIRST_BOARD})", name) if result.fleet is not None and of_board else word(name)


def _cycles_table(cycles: dict[str, int], whose: str) -> Table:
    total = sum(cycles.values())
    lines = [
        (word(label(phase)), count_cell(count), part_cell(count, total)) for phase, count in cycles.items()
    ]
    return Table(
        f"Clock cycles by phase, {whose}" if whose else "Clock cycles by phase",
        (*left("phase"), *right("cycles"), *right("share", unit="1")),
        (*lines, (word("all"), count_cell(total), part_cell(total, total))),
        strong=frozenset([len(lines)]),
    )


def _stages_table(stages: Sequence[StageUse]) -> Table:
    fields = shown_fields(StageUse)
    return Table(
        "Stages",
        tuple(field.column for field in fields),
        tuple(tuple(cell for _, cell in rows_of(stage)) for stage in stages),
        ("cycles = iterations × (precision + 2); block switches are counted by phase only",),
    )


def displays_table(displays: Mapping[str, DisplayUse]) -> Table:
    """What each display read, and what its memory was too slow for."""
    return records_table("Displays", "display", displays.items(), DisplayUse)


def _quality_table(result: Result) -> Table:
    quality = result.quality
    assert quality is not None
    rows = _robots_rows(quality) if isinstance(quality, RobotsQuality) else _grid_rows(quality)
    notes = () if isinstance(quality, RobotsQuality) else (SHORTEST, *quality.warnings)
    return pairs("Plan quality", rows, notes)


def _grid_rows(quality: Quality) -> list[tuple[str, Cell]]:
    arrived = Cell(f"{quality.starts_arrived} of {quality.starts}", quality.starts_arrived)
    return [("starts that arrive", arrived), *rows_of(quality, "starts", "starts_arrived", always=False)]


def _robots_rows(quality: RobotsQuality) -> list[tuple[str, Cell]]:
    arrived = Cell(f"{quality.robots_arrived} of {quality.robots}", quality.robots_arrived)
    told = {"why robots are missing": quality.shortfall, "what mends it": quality.remedy}
    return [
        ("robots that arrive", arrived),
        *rows_of(quality, "robots", "robots_arrived"),
        *((name, word(text)) for name, text in told.items() if text is not None),
    ]


def details_table(details: Mapping[str, float | str], notes: tuple[str, ...] = ()) -> Table:
    """The figures that only one planner has, by the names that the planner gives them."""
    cells = (
        (name, Cell(value) if isinstance(value, str) else number_cell(value))
        for name, value in details.items()
    )
    return pairs("More of this planner", [(label(name), cell) for name, cell in cells], notes)


def feasible_cell(result: Result | None) -> Cell:
    """Whether a result is feasible, as a word."""
    return Cell("yes" if result.feasible else "no", result.feasible) if result else Cell("not run")
