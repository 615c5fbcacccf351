"""One result as tables."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain
from operator import itemgetter

from more_itertools import map_reduce

from codesign.ground.figures import FIGURES, Figure, label
from codesign.ground.units import counted
from codesign.planners.interface import RobotsQuality
from codesign.system.results.result import DisplayUse, Reason, ResourceUse, Result, StageUse
from codesign.views.report.scenario_tables import end_rows, energy_table, fleet_tables, mission_tables
from codesign.views.report.sentences import (
    ARRIVALS,
    all_arrive,
    arrivals_of,
    arrived_cell,
    certainty_table,
    plan_pace_text,
    question_text,
    sure_cell,
)
from codesign.views.report.wording import (
    ABSENT,
    PACE,
    Cell,
    Column,
    Table,
    axis_text,
    count_cell,
    figure_cell,
    interval_text,
    left,
    pairs,
    part_cell,
    quantity_cell,
    records_table,
    right,
    rows_of,
    share_cell,
    shares_table,
    word,
    words,
    yes_cell,
)

SHORTEST = "path length: the shortest is 8-connected without corner cutting"
"""The shortest path in a ratio of path lengths."""


_FIRST_BOARD = "of the first robot's board"
_SUMS = "decisions, trials and acceleration checks are sums over all robots"
_STRENGTH = ["published", "calibrated", "measured", "assumed"]
_MOST_SOURCES = 100


def result_tables(result: Result) -> tuple[Table, ...]:
    """Everything that a result holds, in reading order, with its sources; what no run gave is left out."""
    overview, *figures = figure_tables(result)
    tables = (overview, result_reasons_table(result), *figures, sources_table([result]))
    return tuple(table for table in tables if table.rows)


def figure_tables(result: Result) -> tuple[Table, ...]:
    """The tables of ``result_tables`` but reasons and sources."""
    tables = (
        overview_table(result),
        *fleet_tables(result),
        *mission_tables(result),
        *_run_tables(result),
        *([certainty_table(result)] if result.terms is not None else []),
        resource_table(result),
        clock_and_power_table(result),
        *_energy_tables(result),
    )
    return tuple(table for table in tables if table.rows)


def overview_table(result: Result) -> Table:
    """The end of a mission or a fleet; what was run, and whether it can be built."""
    rows = [
        *end_rows(result),
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
        rows.append(("final precision", figure_cell(FIGURES["precision"], result.precision)))
    if result.task is not None:
        rows += [("asked", word(question_text(result.task))), ("done for it", word(result.task.text))]
        rows.append((FIGURES["plan_time_worst_s"].label, quantity_cell(result.task.plan_time_worst_s, "s")))
    elif result.time is not None:
        name = "time to the first plan" if result.fleet is None else "time of the run"
        rows.append((name, sure_cell(result, FIGURES["first_plan_s"], result.time.first_plan_s)))
    rows.append(("feasible", yes_cell(result.feasible)))
    arrivals = arrivals_of(result)
    if arrivals is not None and not all_arrive(arrivals[1]):
        # A design that can be built, and yet its plan fails.
        rows.append((arrivals[0], arrived_cell(arrivals[1])))
    return pairs("Design point", rows, result.notes)


def result_reasons_table(result: Result) -> Table:
    """The reasons why the design cannot be built, or is not wanted, and what would mend it."""
    return Table(
        "Why it is not feasible",
        (*left("kind", "what"), *right("demand", "limit", "gap"), *left("what would close the gap")),
        tuple(_reason_cells(reason) for reason in result.reasons),
    )


def _reason_cells(reason: Reason) -> tuple[Cell, ...]:
    """One reason as kind, what, demand, limit, gap and levers. A mapping is refused without numbers."""
    numbers = (None,) * 3 if reason.kind == "mapping" else (reason.demand, reason.limit, reason.gap)
    return (
        word(reason.kind),
        word(label(reason.name)),
        *(quantity_cell(value, reason.unit) for value in numbers),
        word("; ".join(reason.levers) or ABSENT),
    )


def _run_tables(result: Result) -> list[Table]:
    tables = []
    if result.task is not None:
        times = rows_of(result.task, "starts", "reach", "changed_cells", "arrive", always=False)
        tables.append(pairs("Time from request to answer", times))
    if result.time is not None:
        tables.append(_times_table(result))
    if result.cycles is not None:
        tables.append(_cycles_table(result.cycles, _whose_cycles(result)))
    if result.stages is not None:
        note = "cycles = iterations × (precision + 2); block switches are counted by phase only"
        stages = [("", stage) for stage in result.stages]
        tables.append(records_table("Stages", "", stages, StageUse, (note,)))
    if result.utilisation is not None:
        busy = sorted(result.utilisation.items(), key=lambda item: (-item[1], item[0]))
        rows = tuple((_busy_name(result, name), share_cell(share)) for name, share in busy)
        tables.append(Table("Utilisation", (*left("component or link"), *right("busy", unit="1")), rows))
    if result.displays:
        tables.append(records_table("Displays", "display", result.displays.items(), DisplayUse))
    if result.quality is not None:
        tables.append(_quality_table(result))
    if result.details:
        sums = isinstance(result.quality, RobotsQuality)
        tables.append(_details_table(result.details, (_SUMS,) if sums else ()))
    return tables


def _times_table(result: Result) -> Table:
    """The times of what was done. A fleet loads starts and targets, and ends with its last update."""
    time = result.time
    assert time is not None
    rows = rows_of(time)
    if result.fleet is not None:
        rows = [
            ("starts and targets loaded", quantity_cell(time.map_loaded_s, "s")),
            ("last update over", quantity_cell(time.first_plan_s, "s")),
        ]
    elif result.mission is None and (pace := plan_pace_text(result)):
        rows = [*rows, (PACE, word(pace))]
    return pairs(f"Time from the start of the run{', for the first start' if _several(result) else ''}", rows)


def _several(result: Result) -> bool:
    """True if several starts asked for an answer each."""
    return result.task is not None and result.task.starts > 1 and result.task.task != "field"


def _whose_cycles(result: Result) -> str:
    """The robot to which the cycles of a result belong; "" where there is one component that plans."""
    if result.fleet is not None:
        return _FIRST_BOARD
    return "of each update's slowest robot" if isinstance(result.quality, RobotsQuality) else ""


def _busy_name(result: Result, name: str) -> Cell:
    """A component or link. In a fleet, the board that the platform file declares is the first robot's."""
    of_board = name == result.component or name.startswith(f"{result.component}.")
    return Cell(f"{name} ({_FIRST_BOARD})", name) if result.fleet is not None and of_board else word(name)


def _cycles_table(cycles: Mapping[str, int], whose: str) -> Table:
    total = sum(cycles.values())
    rows = ((word(label(phase)), count_cell(count), part_cell(count, total)) for phase, count in cycles.items())
    title = f"Clock cycles by phase, {whose}" if whose else "Clock cycles by phase"
    return shares_table(title, ("phase",), Column("cycles", "", "right"), rows, count_cell(total))


def _quality_table(result: Result) -> Table:
    quality = result.quality
    assert quality is not None
    rows = [(ARRIVALS[type(quality)], arrived_cell(quality))]
    if isinstance(quality, RobotsQuality):
        rows += rows_of(quality, "robots", "robots_arrived")
        missing = {"why robots are missing": quality.shortfall, "what mends it": quality.remedy}
        rows += [(name, word(text)) for name, text in missing.items() if text is not None]
        return pairs("Plan quality", rows)
    rows += rows_of(quality, "starts", "starts_arrived", always=False)
    return pairs("Plan quality", rows, (SHORTEST, *quality.warnings))


def _details_table(details: Mapping[str, float | str], notes: tuple[str, ...]) -> Table:
    """The figures that only one planner has, by the names that the planner gives them."""
    rows = [
        (label(name), word(value) if isinstance(value, str) else quantity_cell(value))
        for name, value in details.items()
    ]
    return pairs("More of this planner", rows, notes)


def resource_table(result: Result) -> Table:
    """Demand against budget, kind by kind, each with its items. Kinds are never added up."""
    rows: list[tuple[Cell, ...]] = []
    strong = []
    for use in result.resources:
        strong.append(len(rows))
        rows += _resource_rows(use)
    columns = (
        *left("resource", "item"),
        *right("demand", "budget"),
        *right("used", unit="1"),
        *right("gap"),
        *left("status"),
    )
    return Table("Resources", columns, tuple(rows), strong=frozenset(strong))


def _resource_rows(use: ResourceUse) -> list[tuple[Cell, ...]]:
    empty = Cell("")
    amounts = (count_cell(use.demand), count_cell(use.budget), part_cell(use.demand, use.budget))
    items = [
        (empty, word(item.name), count_cell(int(item.figure.value)), *[empty] * 3, word(item.figure.status))
        for item in use.items
    ]
    return [(*words(label(use.resource), "all"), *amounts, count_cell(use.gap), empty), *items]


def clock_and_power_table(result: Result) -> Table:
    """The clock and all figures with a source but resources, with their intervals and their status."""
    each = "" if result.fleet is None else " of each board"
    rows: list[tuple[Cell, ...]] = []
    if result.clock is not None:
        rows.append((word("clock"), quantity_cell(result.clock.hz, "Hz"), Cell(""), Cell("")))
    for name, component, figure in _sourced(result):
        board = each if name.endswith("of the FPGA") else ""
        idle = f" of {component}, which has no task" if component else ""
        interval = interval_text(*figure.interval, figure.unit)
        value = quantity_cell(figure.value, figure.unit)
        rows.append((word(f"{name}{board}{idle}"), value, word(interval), word(figure.status)))
    columns = (*left("figure"), *right("value"), *left("interval", "status"))
    return Table("Clock and power", columns, tuple(rows))


def _energy_tables(result: Result) -> list[Table]:
    """Energy of the plan or of the fleet. That of a mission stands among the tables of the mission."""
    if result.energy is None or result.mission is not None:
        return []
    what = "of the run" if result.task is None else "a plan"
    return [energy_table(f"Energy {what}{', mean over the starts' if _several(result) else ''}", result.energy)]


def sources_table(results: Iterable[Result]) -> Table:
    """The sources of the figures: each source once, with its status and the figures that rest on it."""
    figures = chain.from_iterable((*_resources(result), *_sourced(result)) for result in results)
    rows = map_reduce(figures, lambda row: (row[2].status.value, row[2].source), itemgetter(0, 1))
    lines = sorted(rows.items(), key=lambda line: (_STRENGTH.index(line[0][0]), line[0][1]))
    left_out = len(lines) - _MOST_SOURCES
    return Table(
        "Where the figures come from",
        left("status", "figures", "source"),
        tuple(words(status, _listed(names), source) for (status, source), names in lines[:_MOST_SOURCES]),
        (f"{counted(left_out, 'more source')} in the JSON",) if left_out > 0 else (),
    )


def _listed(rows: Iterable[tuple[str, str]]) -> str:
    names = map_reduce(rows, itemgetter(0), itemgetter(1), lambda items: list(filter(None, dict.fromkeys(items))))
    return "; ".join(f"{name}: {', '.join(items)}" if items else name for name, items in names.items())


def _resources(result: Result) -> Iterable[tuple[str, str, Figure]]:
    """Each figure of a resource: the name of the resource, the item that needs it, the figure."""
    return ((label(use.resource), item.name, item.figure) for use in result.resources for item in use.items)


_OF_PROCESSOR = {"power busy": "busy power of the processor", "power idle": "idle power of the processor"}


def _sourced(result: Result) -> Iterable[tuple[str, str, Figure]]:
    """Each figure with a source but resources: its name, the FPGA without a task that it is of or "", the figure."""
    for name, figure in result.processor.items():
        yield _OF_PROCESSOR.get(name, label(name)), "", figure
    if result.clock is not None:
        yield "clock limit", "", result.clock.limit
    if result.power is not None:
        yield "static power of the FPGA", "", result.power.static
        yield "dynamic power of the FPGA", "", result.power.dynamic
    for component, figure in result.idle_fpgas.items():
        yield "static power", component, figure
