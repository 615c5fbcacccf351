"""The headline of a result, and in a sentence what sets the pace of a plan, a mission or a fleet and what would help.

The sentence about a fleet rests on the closed forms of ``benchmarks/velocity_obstacle_pace`` of the repository, with
the mean time in which the robots decide. A result gives the time of a message on the line only where it is longer than
deciding. Otherwise the effect of doubling is given as a bound.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from codesign.ground.units import counted
from codesign.inputs.exploration import DEFAULT_OBJECTIVES
from codesign.planners.quality import Quality, RobotsQuality
from codesign.system.results.fleet import FleetFigures
from codesign.system.results.mission import Mission
from codesign.system.results.result import Result
from codesign.system.results.task import TaskFigures, reach_text
from codesign.views.report.fields import row_of
from codesign.views.report.table import Cell
from codesign.views.report.wording import figure_cell, quantity_text, share_text

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
