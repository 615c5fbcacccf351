"""The answer of a run: one sentence and five figures, before all tables.

The sentence says what was run, whether it is feasible, the time that matters against what was asked, and what limits
it. All figures are declared ones (``FIGURES``): ``FIRST`` names them by kind of run, the time that matters first.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from codesign.ground.figures import FIGURES, Figure, ResultFigure, label, named
from codesign.ground.units import counted
from codesign.inputs.constraint import UPPER, Constraint, limit_text
from codesign.inputs.exploration import DEFAULT_OBJECTIVES
from codesign.planners.interface import Quality, RobotsQuality
from codesign.study.constraints import with_constraints
from codesign.system.results.mission import Mission
from codesign.system.results.result import FleetFigures, Reason, ResourceUse, Result, TaskFigures, reach_text
from codesign.system.results.terms import priced
from codesign.system.verdicts import Decider, Fit, Verdict, constraint_verdict, fit_verdict, sensitivity, winner_verdict
from codesign.views.report.render import printable
from codesign.views.report.wording import (
    ABSENT,
    Cell,
    Table,
    ends_text,
    figure_cell,
    interval_text,
    left,
    part_text,
    quantity_text,
    right,
    row_of,
    share_text,
    word,
)

if TYPE_CHECKING:
    from codesign.study import Study

# The headline of a result, and in a sentence what sets the pace of a plan, a mission or a fleet and what would help.

Headline = tuple[tuple[str, str], ...]
"""The few figures that a reader looks for first, as (value, label)."""

_OF_MISSION = ("mission_time_s", "distance_ratio", "replans", "replan_latency_95_s")
_IF_ANY = ("contacts", "missed_deadlines")
_LISTED = 3
"""Components and links that the sentence about a plan names, the busiest first."""
_MEMORY_BOUND = 0.5
"""A component that plans waits for its memory if the memory is busy for more than this share of its own busy time."""
_SAME = 0.02
"""Two rates that differ by less than this share are given as one."""


def headline(result: Result) -> Headline:
    """True if the design is feasible, and the figures of its mission, its fleet or its plan."""
    feasible = (("feasible" if result.feasible else "not feasible", ""),)
    if result.mission is not None:
        return feasible + mission_headline(result.mission)
    if result.fleet is not None:
        return feasible + fleet_headline(result)
    values = ((figure, result.figure(figure)) for figure in DEFAULT_OBJECTIVES)
    return feasible + tuple(
        (figure_cell(figure, value, result.interval(figure)).text, figure.label)
        for figure, value in values
        if value is not None
    )


def question_text(task: TaskFigures) -> str:
    """The question in words, such as ``path from each of 64 starts; maze of 72 × 132 cells, goal (3, 128)``."""
    asked = _ASKED[task.task].format(
        starts="one start" if task.starts == 1 else f"each of {task.starts:,} starts",
        cells=counted(task.changed_cells or 0, "cell"),
    )
    return f"{asked}; {task.map}" if task.map else asked


_ASKED = {
    "path": "task path, from {starts}",
    "field": "task field, an answer in every cell that leads to a goal, judged from {starts}",
    "replan": "task replan, from {starts} after a change of {cells}",
    "robots": "the paths of all robots",
}


def questions_of(results: Iterable[Result | None]) -> dict[str, TaskFigures]:
    """The tasks that results were asked, by the digest of the question."""
    return {result.task.question: result.task for result in results if result is not None and result.task}


def asked_notes(results: Iterable[Result | None]) -> tuple[str, ...]:
    """At the head of results side by side: what was asked of them all, or that they were not asked the same."""
    tasks = questions_of(results)
    if not tasks:
        return ()
    first, *others = map(question_text, tasks.values())
    if not others:
        return (f"asked: {first}",)
    return (
        f"{len(tasks)} different questions were asked, as map, goals, starts or task differ: compare results of one"
        f" question only. The first is {first}",
    )


def reach_notes(results: Iterable[Result | None]) -> tuple[str, ...]:
    """From which share of the free cells a path leads to a goal, where that is not all of them in every result."""
    tasks = (result.task for result in results if result is not None)
    shares = [task.reach for task in tasks if task is not None and task.reach is not None]
    return (reach_text(shares),) if shares and min(shares) < 1 else ()


def mission_headline(mission: Mission) -> Headline:
    """True if a mission reached its goals, and its first figures."""
    return (
        ("reached" if mission.reached else "not reached", ""),
        *_rows(mission, *(name for name in _OF_MISSION if vars(mission)[name] is not None)),
        *_rows(mission.energy, "mission_energy_j"),
        *_rows(mission, *(name for name in _IF_ANY if vars(mission)[name])),
    )


def fleet_headline(result: Result) -> Headline:
    """The first figures of a fleet: collisions before all."""
    fleet, quality = result.fleet, result.quality
    rows: list[tuple[str, str]] = []
    if isinstance(quality, RobotsQuality):
        number, _, pairs = counted(quality.collisions, "pair").partition(" ")
        rows += [(number, f"{pairs} of robots collided")]
        rows += [(arrived_cell(quality).text, "robots at their targets")]
    if fleet is not None:
        rows += [(quantity_text(fleet.span_s, "s"), f"for {counted(fleet.updates, 'update')}")]
        rows += _rows(fleet, "updates_a_second")
    if result.energy is not None:
        rows += [(cell.text, "energy of the run") for _, cell in [row_of(result.energy, "energy_j")]]
    return tuple(rows)


def _rows(record: Any, *names: str) -> Headline:
    """Figures of a record; the label of a count of 1 is in the singular."""
    rows = (row_of(record, name) for name in names)
    return tuple((cell.text, label.removesuffix("s") if cell.text == "1" else label) for label, cell in rows)


def arrivals_of(result: Result) -> tuple[str, Quality | RobotsQuality] | None:
    """The label of what arrives, and the quality that counts it; None where no path was tried."""
    quality = result.quality
    if quality is None or not _arrivals(quality)[1]:
        return None
    return ARRIVALS[type(quality)], quality


ARRIVALS: dict[type, str] = {Quality: "starts that arrive", RobotsQuality: "robots that arrive"}
"""The name of what arrives at a goal, by the record that counts it."""


def _arrivals(quality: Quality | RobotsQuality) -> tuple[int, int]:
    if isinstance(quality, RobotsQuality):
        return quality.robots_arrived, quality.robots
    return quality.starts_arrived, quality.starts


def all_arrive(quality: Quality | RobotsQuality) -> bool:
    """True if all starts or robots arrive."""
    arrived, tried = _arrivals(quality)
    return arrived == tried


def arrived_cell(quality: Quality | RobotsQuality) -> Cell:
    """The number of starts or robots that arrive, as ``63 of 64``."""
    arrived, tried = _arrivals(quality)
    return Cell(f"{arrived} of {tried}", arrived)


def bottleneck_text(mission: Mission) -> str:
    """The pace of a mission: what sets it and what would change it, as a sentence; "" if it is not known."""
    bottleneck = mission.bottleneck
    if bottleneck is None:
        return ""
    # The mission's own sentence begins with the name.
    if bottleneck.text.startswith(bottleneck.name):
        return bottleneck.text
    return f"{bottleneck.name} ({bottleneck.kind}, {share_text(bottleneck.share)}): {bottleneck.text}"


def run_pace_text(result: Result) -> str:
    """The pace of a mission, a fleet or a plan: what sets it; "" if it is not known."""
    if result.mission is not None:
        return bottleneck_text(result.mission)
    return plan_pace_text(result) if result.fleet is None else pace_text(result.fleet)


def plan_pace_text(result: Result) -> str:
    """The part that takes the time of one plan, and what helps first; "" if no time passed, or no component is busy.

    The shares are the busy shares of the component that plans, its external memory, the links and the other components
    that have a task.
    """
    busy = result.utilisation or {}
    planning = busy.get(result.component, 0.0)
    memory = busy.get(result.external_memory or "", 0.0)
    links = {name: busy.get(name, 0.0) for name in result.links or {}}
    others = {name: busy.get(name, 0.0) for name in result.places.values() if name != result.component}
    if not (planning or any(links.values()) or any(others.values())):
        return ""
    spent = [(f"planning on {result.component}", planning)]
    spent += [(f"link {name}", share) for name, share in links.items() if share]
    spent += [(name, share) for name, share in others.items() if share]
    (name, most), *rest = sorted(spent, key=lambda each: -each[1])[:_LISTED]
    texts = [f"{name} takes {share_text(most)} of the time"]
    texts += [f"memory {result.external_memory} is busy {share_text(memory)} of it"] if memory else []
    texts += [f"{name} takes {share_text(share)}" for name, share in rest]
    remedy = f"a faster {name} helps first" if most > planning else _faster_planning(result, memory / planning)
    return f"{', '.join(texts)}: {remedy}"


def _faster_planning(result: Result, waiting: float) -> str:
    """The change that speeds up the component that plans; ``waiting``: busy time of its memory over its own."""
    if waiting > _MEMORY_BOUND:
        return f"a faster memory {result.external_memory} helps first"
    if result.clock is None:
        return f"a faster {result.component} helps first"
    limit = result.clock.limit.value
    if result.clock.hz >= limit:
        return f"its clock is at the limit of {quantity_text(limit, 'Hz')}; a faster part helps first"
    return f"a faster clock of {result.component} helps first"


def pace_text(fleet: FleetFigures) -> str:
    """The pace of a fleet: what sets it and what would change it, as sentences; "" if no update was done."""
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
            " holds them, or messages that are sent again"
        )
    return _held_by_robots(fleet, decide)


def _held_by_line(fleet: FleetFigures, decide: float, message: float) -> str:
    """The period is max(message, decide + the time that a short FIFO holds, at most the time of a message)."""
    period = 1.0 / fleet.updates_a_second
    text = (
        f"the line: a message of all coordinates takes it {_seconds(message)}, while the robots decide in"
        f" {_seconds(decide)} on average; {share_text(fleet.shares['line'])} of the time is waiting for it."
        f" Twice the baud gives {_between(1 / (decide + message / 2), 1 / max(decide, message / 2))} updates a second"
        f" in place of {_rate(fleet.updates_a_second)}"
    )
    if decide > 0.0:
        text += f"; from about {_rate(message / decide)} times the baud on, the robots' decisions set the pace"
    if period > (1 + _SAME) * message:
        text += f". A FIFO that holds a whole message gives up to {_rate(fleet.reachable_a_second)}"
    return text


def _held_by_robots(fleet: FleetFigures, decide: float) -> str:
    waiting = fleet.shares["line"] / fleet.updates_a_second
    text = (
        f"the robots' decisions: {_seconds(decide)} on average, {share_text(fleet.shares['fpga'])} of the time."
        f" Twice the clock gives {'up to ' if waiting else ''}{_rate(1 / (decide / 2 + waiting))} updates a second in"
        f" place of {_rate(fleet.updates_a_second)}"
    )
    if waiting / (decide + waiting) > _SAME:
        text += f"; a faster line, or a FIFO that holds a whole message, up to {_rate(1 / decide)}"
    return text


def _in_real_time(fleet: FleetFigures, decide: float, message: float | None) -> str:
    step = fleet.time_step_s
    if fleet.missed_updates and fleet.decide is not None:
        text = (
            f"the robots' decisions: {counted(fleet.missed_updates, 'update')} of {fleet.updates:,} took longer than"
            f" the time step of {_seconds(step)} and acted late: the robots drove on meanwhile. The longest took"
            f" {_rate(fleet.decide.worst_s / fleet.time_step_s)} time steps. At another clock the robots take"
            " other courses: run it to see how many updates are late there"
        )
    else:
        text = (
            f"the time step of {_seconds(step)}, as asked for: the robots decide in {_seconds(decide)} on average, and"
            f" FPGAs and line would allow {_rate(fleet.reachable_a_second)} updates a second at most. A shorter time"
            " step, or pace free_running, makes use of that"
        )
    frames = fleet.frames
    if frames is not None and frames.skipped:
        text += f". {counted(frames.skipped, 'frame')} of {frames.made:,} are skipped"
        if message is not None and message > step:
            text += f", as the line takes {_seconds(message)} for each:"
            text += f" {_rate(message / step)} times the baud shows all"
    return text


def _decide_s(fleet: FleetFigures) -> float:
    """Mean time in which the robots decide, s."""
    return fleet.shares["fpga"] * fleet.span_s / fleet.updates


def _message_s(fleet: FleetFigures) -> float | None:
    """Time of a message on the slowest link, s; None where it is no longer than the robots need to decide."""
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


def _seconds(value: float) -> str:
    """A mean, to three significant digits."""
    return quantity_text(float(f"{value:.3g}"), "s")


# How sure a result or a winner is, in a reader's words and as a table.

HOLDS = "holds within the assumed intervals"
EXACT = "holds: it rests on no assumed figure"
IF_IT_FITS = ", if the design fits"
_READ = {"W/(slice Hz)": ("W", 1e6, " a slice and MHz")}
"""Units that nobody writes: the one that is written, its size, and what stands behind it."""


def sure_cell(result: Result | None, figure: ResultFigure, value: float | None) -> Cell:
    """A figure of a result with its interval, where it has one."""
    return figure_cell(figure, value, None if result is None else result.interval(figure))


def _is_assumed(verdict: Verdict) -> bool:
    return priced(named(verdict.figure)) or verdict.least != verdict.most


def verdict_text(verdict: Verdict) -> str:
    """A verdict in a line."""
    decides = verdict.decides
    if verdict.state == "depends" and decides is not None:
        return _deciding_text(verdict, decides)
    alone = verdict.rival is None and verdict.winner is not None
    proved = verdict.reason if alone else HOLDS if _is_assumed(verdict) else EXACT
    proved += IF_IT_FITS if verdict.fit is not None and verdict.fit.fits != "yes" else ""
    texts = {
        "proved": proved,
        "refuted": "fails within all of the assumed intervals",
        "depends": verdict.reason,
        "not assessed": f"not assessed: {verdict.reason}",
    }
    return texts[verdict.state]


def need_text(verdict: Verdict) -> str:
    """True if a need is met, and how sure that is: ``met (proved)``, ``met, flips at …``."""
    if verdict.holds is None:
        return f"missed: {verdict.reason}"
    fate, decides = "met" if verdict.holds else "missed", verdict.decides
    if verdict.state in {"proved", "refuted"}:
        return f"{fate} ({'proved' if verdict.holds else 'at every value'})"
    if verdict.state == "depends" and decides is not None:
        return f"{fate}, {_deciding_text(verdict, decides)}"
    return f"{fate} ({verdict_text(verdict)})"


def _deciding_text(verdict: Verdict, decides: Decider) -> str:
    """The figure that a verdict depends on, in words."""
    stands = figure_text(decides.figure)
    if decides.flips_at is None:
        return f"rests on {decides.name} ({stands}) and others: {verdict.reason}"
    return f"flips at {decides.name} = {_flip_text(decides)} ({stands})"


def figure_text(figure: Figure) -> str:
    """The status, the value and the interval of a figure: ``assumed 10 ns, 5 to 20``."""
    unit, scale, behind = _READ.get(figure.unit, (figure.unit, 1.0, ""))
    low, high = figure.interval
    value = quantity_text(figure.value * scale, unit)
    ends = ends_text(value, low * scale, high * scale, unit)
    return f"{figure.status} {value}{f', {ends}' if ends else ''}{behind}"


def named_figure(name: str, figure: Figure) -> str:
    """A figure by its name, with its status, its value and its interval in brackets."""
    return f"{name} ({figure_text(figure)})"


def _flip_text(decides: Decider) -> str:
    """The value at which a verdict changes, to four digits. Of a number of things the first one behind it."""
    value, figure = decides.flips_at, decides.figure
    assert value is not None, "asked of a figure that flips"
    if isinstance(figure.value, int) and figure.unit == "1":
        return quantity_text(math.ceil(value) if value > figure.value else math.floor(value), "1")
    unit, scale, behind = _READ.get(figure.unit, (figure.unit, 1.0, ""))
    return f"{quantity_text(float(f'{value * scale:.4g}'), unit)}{behind}"


def measure_text(verdict: Verdict) -> str:
    """The measurement most worth making, in a sentence; "" where nothing is to be decided."""
    decides = verdict.decides
    if decides is None or verdict.state != "depends":
        return ""
    how = ": hwsw calibrate host does it on the machine itself" if ".costs." in decides.name else ""
    return f"measure {decides.name} first{how}"


def fit_text(fit: Fit) -> str:
    """True if a design fits at every value, in a line."""
    if fit.fits == "yes" or fit.demand is None or fit.limit is None:
        return "yes, at every value of its demand and of its clock limit" if fit.fits == "yes" else fit.fits
    unit = "" if fit.figure is None or fit.figure.unit == "1" else fit.figure.unit
    demand, limit = (_span(*ends, unit) for ends in (fit.demand, fit.limit))
    return f"{fit.fits}: {label(fit.decides)} {demand} against a limit of {limit}"


def _span(low: float, high: float, unit: str) -> str:
    return interval_text(low, high, unit) or quantity_text(low, unit)


@dataclass(frozen=True)
class Winner:
    """The best of several designs by a figure: its name, its value with its interval, and how sure that is.

    ``rival``: the name of the design that decides against it.
    """

    figure: ResultFigure
    name: str
    cell: Cell
    verdict: Verdict
    rival: str

    @property
    def sure(self) -> str:
        """The certainty that it wins, and against which design."""
        against = f" against {self.rival}" if self.verdict.state != "proved" else ""
        return f"{verdict_text(self.verdict)}{against}"


def winner_of(names: Sequence[str], results: Sequence[Result | None], figure: ResultFigure) -> Winner | None:
    """The best of several designs by a figure; None if no other has another value."""
    compared = [(name, result) for name, result in zip(names, results, strict=True) if result is not None]
    if sum(result.feasible and result.figure(figure) is not None for _, result in compared) < 2:
        return None
    verdict = winner_verdict([result for _, result in compared], figure)
    assert verdict.winner is not None, "two designs have the figure"
    if verdict.rival is None:
        return None
    name, best = compared[verdict.winner]
    cell = sure_cell(best, figure, best.figure(figure))
    return Winner(figure, name, cell, verdict, compared[verdict.rival][0])


def winner_text(winner: Winner) -> str:
    """The winner in a line, with the measurement most worth making."""
    measure = measure_text(winner.verdict)
    return f"{winner.figure.aim}: {winner.name}, {winner.sure}{f'; {measure}' if measure else ''}"


def winners_certainty_table(study: Study) -> Table:
    """For each objective that rests on intervals the best feasible point, and whether it is the best at every value.

    Empty over conditions: there designs are compared, not points.
    """
    rows = []
    for objective in () if study.conditions else filter(priced, study.objectives):
        verdict = study.rivals.verdict(objective)
        if verdict.winner is None:
            continue
        best = study.points[int(study.rivals.points[verdict.winner])]
        rival = ABSENT if verdict.rival is None else str(study.rivals.points[verdict.rival])
        value = figure_cell(objective, best.figure(objective), best.interval(objective))
        cells = Cell(str(best.index), best.index), value, word(verdict_text(verdict)), word(rival)
        rows.append((word(objective.aim), *cells))
    columns = (*left("best"), *right("point", "value"), *left("how sure", "against point"))
    return Table("How sure the best points are", columns, tuple(rows))


def certainty_table(result: Result) -> Table:
    """Each figure that rests on others with an interval: its least and greatest value, and what moves it most."""
    rows = []
    for figure in filter(priced, FIGURES.values()):
        value, interval = result.figure(figure), result.interval(figure)
        if value is None:
            continue
        if interval is None:
            reason = "" if result.terms is None else result.terms.open.get(figure.name, "")
            rows += [_row(figure, value, None, reason)] if reason else []
            continue
        most = next(iter(sensitivity(result, figure)), None)
        rows.append(_row(figure, value, interval, "" if most is None else named_figure(most.name, most.figure)))
    limited = result.part is not None or result.bounds
    notes = (f"fits: {fit_text(fit_verdict(result))}",) if limited else ()
    columns = (*left("figure"), *right("value", "least", "most"), *left("moved most by"))
    return Table("How sure", columns, tuple(rows), notes)


def _row(figure: ResultFigure, value: float, interval: tuple[float, float] | None, moved: str) -> tuple[Cell, ...]:
    ends = [Cell("")] * 2 if interval is None else [figure_cell(figure, end) for end in interval]
    return word(figure.label), figure_cell(figure, value), *ends, word(moved)


FIRST = {
    "plan": ("plan_time_worst_s", "energy_j", "power"),
    "mission": ("mission_time_s", "mission_energy_j", "replan_latency_95_s", "distance_ratio"),
    "fleet": ("first_plan_s", "energy_j", "power"),
}
"""Declared figures by kind of run; the first is the time that matters. The tightest resource follows, then arrivals."""


@dataclass(frozen=True)
class Answer:
    """A run in one sentence, its first figures as (label, cell), and the notes that qualify them."""

    sentence: str
    figures: tuple[tuple[str, Cell], ...]
    notes: tuple[str, ...]

    @property
    def sentence_text(self) -> str:
        """The sentence as a line for a terminal."""
        return printable(self.sentence)

    @property
    def text(self) -> str:
        """The answer as lines for a terminal."""
        width = max(len(name) for name, _ in self.figures)
        lines = [self.sentence_text, ""]
        lines += [f"{name:<{width}}   {printable(cell.text)}" for name, cell in self.figures]
        lines += [f"note: {printable(note)}" for note in self.notes]
        return "\n".join(lines) + "\n"


def answer(result: Result, asked: Iterable[Constraint] = (), needs: Sequence[Constraint] = ()) -> Answer:
    """The answer of a run.

    ``asked``: the constraints of the workload. ``needs``: those that the result has reasons for where it misses them.
    The time and all figures are held to both.
    """
    warnings = result.quality.warnings if isinstance(result.quality, Quality) else ()
    rows = tuple((f"need {limit_text(need)}", Cell(_need_text(result, need))) for need in needs)
    sentence = _sentence(result, (*asked, *needs))
    return Answer(sentence, (*_figures(result), *rows), (*result.notes, *warnings))


def _need_text(result: Result, need: Constraint) -> str:
    """True if a need is met. Nothing is known of it where the design does not fit and was not run."""
    if not result.simulated and result.figure(need.figure) is None:
        return "not known: the design was not run"
    return need_text(constraint_verdict(result, need))


def _kind(result: Result) -> str:
    if result.mission is not None:
        return "mission"
    return "plan" if result.fleet is None else "fleet"


def _figures(result: Result) -> tuple[tuple[str, Cell], ...]:
    kind = _kind(result)
    rows = [
        (FIGURES[name].label, sure_cell(result, FIGURES[name], result.figure(FIGURES[name]))) for name in FIRST[kind]
    ]
    if kind == "plan" and result.power is None and "power busy" in result.processor:
        rows[-1] = ("busy power of the processor", Cell(quantity_text(result.processor["power busy"].value, "W")))
    rows.append(("tightest resource", _tightest(result)))
    arrivals = arrivals_of(result)
    if kind != "mission":
        name, cell = ARRIVALS[Quality], Cell(ABSENT)
        if arrivals is not None:
            name, cell = arrivals[0], arrived_cell(arrivals[1])
        rows.append((name, cell))
    return tuple(rows)


def _tightest(result: Result) -> Cell:
    """The resource of the part with the largest share in use."""
    uses = [use for use in result.resources if use.budget > 0]
    if not uses:
        return Cell("none: no FPGA plans" if result.part is None else ABSENT)
    use = max(uses, key=_share)
    return Cell(f"{label(use.resource)}: {part_text(_share(use))}, {use.demand:,} of {use.budget:,}", _share(use))


def _share(use: ResourceUse) -> float:
    return use.demand / use.budget


def _sentence(result: Result, asked: tuple[Constraint, ...]) -> str:
    head = f"{result.workload} on {result.platform} ({result.planner}, {result.style} on {result.component})"
    if any(reason.kind != "constraint" for reason in result.reasons):
        return f"{head} is not feasible: {_why_not(result.reasons)}."
    parts = {"mission": _mission_parts, "fleet": _fleet_parts, "plan": _plan_parts}[_kind(result)](result, asked)
    wrong = _shortcomings(result, asked)
    verdict = f"fits, but {' and '.join(wrong)}" if wrong else "is feasible"
    return f"{head} {verdict}: {'; '.join(part for part in parts if part)}."


def _shortcomings(result: Result, asked: tuple[Constraint, ...]) -> list[str]:
    """The shortcomings of a design that fits."""
    wrong = []
    if result.mission is not None and not result.mission.reached:
        wrong.append("the mission ends without its goal")
    arrivals = arrivals_of(result)
    if result.mission is None and arrivals is not None and not all_arrive(arrivals[1]):
        what, _, _ = arrivals[0].partition(" ")
        wrong.append(f"only {arrived_cell(arrivals[1]).text} {what} arrive")
    if isinstance(result.quality, RobotsQuality) and result.quality.collisions:
        wrong.append(f"{counted(result.quality.collisions, 'pair')} of robots collide")
    # What the result already has as a reason is asked for once.
    broken = dict.fromkeys(with_constraints(result, asked).reasons)
    missed = "; ".join(reason_text(reason, ": ") for reason in broken)
    return [*wrong, f"misses what is asked for ({missed})"] if broken else wrong


def _plan_parts(result: Result, asked: tuple[Constraint, ...]) -> list[str]:
    name = FIRST["plan"][0]
    return [f"{FIGURES[name].label} {_time_text(result, name, asked)}", plan_pace_text(result)]


def _mission_parts(result: Result, asked: tuple[Constraint, ...]) -> list[str]:
    mission = result.mission
    assert mission is not None, "the kind of run says so"
    wrong = [
        counted(count, word)
        for count, word in ((mission.contacts, "contact"), (mission.missed_deadlines, "missed deadline"))
        if count
    ]
    # A mission that ended early has no figure of its time.
    time = quantity_text(mission.mission_time_s, "s") + _limit_text(FIRST["mission"][0], asked)
    pace = _first_sentence(bottleneck_text(mission))
    helps = mission.bottleneck is not None and mission.bottleneck.kind == "lever"
    return [
        f"{mission.ended} after {time}",
        ", ".join(wrong),
        f"{'what helps first is' if helps else 'the pace is set by'} {pace}" if pace else "",
    ]


def _fleet_parts(result: Result, asked: tuple[Constraint, ...]) -> list[str]:
    fleet, quality = result.fleet, result.quality
    assert fleet is not None, "the kind of run says so"
    collided = ["no robots collided"] if isinstance(quality, RobotsQuality) and not quality.collisions else []
    pace = _first_sentence(pace_text(fleet))
    ended = f"{fleet.ended} after {_time_text(result, FIRST['fleet'][0], asked)}"
    return [ended, *collided, f"the pace is set by {pace}" if pace else ""]


def _time_text(result: Result, name: str, asked: tuple[Constraint, ...]) -> str:
    """The time that matters, and the limit that is asked for it."""
    figure = FIGURES[name]
    return figure_cell(figure, result.figure(figure)).text + _limit_text(name, asked)


def _limit_text(name: str, asked: tuple[Constraint, ...]) -> str:
    limits = [
        (limit, bound == "at_most")
        for each in asked
        if each.figure.name == name
        for bound, limit in each.bounds.items()
        if bound in UPPER
    ]
    if not limits:
        return ""
    limit, reached = min(limits)
    words = "at most" if reached else "less than"
    return f" where {words} {quantity_text(limit, FIGURES[name].unit)} is asked for"


def _why_not(reasons: tuple[Reason, ...]) -> str:
    """The reason that passes its limit by the largest factor, how many more there are, and the first remedy."""
    first = max(reasons, key=lambda reason: reason.demand / reason.limit if reason.limit else 0.0)
    more = f" and {counted(len(reasons) - 1, 'more reason')}" if len(reasons) > 1 else ""
    remedy = f"; {first.levers[0]}" if first.levers else ""
    return f"{reason_text(first, ': ')}{more}{remedy}"


def reason_text(reason: Reason, joint: str = " ", *, gap: bool = False) -> str:
    """A reason in a line, without its levers; with its ``gap`` where it has one and this is asked for.

    >>> reason_text(Reason(kind="resource", name="slices", demand=40000, limit=33792, gap=6208, unit=""))
    'slices 40,000 against 33,792'
    """
    if reason.words:
        return reason.words
    demand, limit = (quantity_text(value, reason.unit) for value in (reason.demand, reason.limit))
    text = f"{label(reason.name)}{joint}{demand} against {limit}"
    return f"{text} (gap {quantity_text(reason.gap, reason.unit)})" if gap else text


def _first_sentence(text: str) -> str:
    return text.partition(". ")[0]
