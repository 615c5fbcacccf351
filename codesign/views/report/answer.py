"""The answer of a run: one sentence and five figures, before all tables.

The sentence says what was run, whether it is feasible, the time that matters against what was asked, and what limits
it. All figures are declared ones (``FIGURES``): ``FIRST`` names them by kind of run, the time that matters first.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from codesign.ground.figures import FIGURES, label
from codesign.ground.units import counted
from codesign.inputs.constraint import UPPER, Constraint, limit_text
from codesign.planners.quality import Quality, RobotsQuality
from codesign.study.constraints import with_constraints
from codesign.system.results.result import Reason, ResourceUse, Result
from codesign.system.verdicts import constraint_verdict
from codesign.views.report.certainty import need_text, sure_cell
from codesign.views.report.render import printable
from codesign.views.report.sentences import (
    ARRIVALS,
    all_arrive,
    arrivals_of,
    arrived_cell,
    bottleneck_text,
    pace_text,
    plan_pace_text,
)
from codesign.views.report.table import Cell
from codesign.views.report.wording import ABSENT, figure_cell, quantity_text, share_text

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
        rows[-1] = ("power", Cell(quantity_text(result.processor["power busy"].value, "W")))
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
    return Cell(f"{label(use.resource)}: {_part_text(_share(use))}, {use.demand:,} of {use.budget:,}", _share(use))


def _share(use: ResourceUse) -> float:
    return use.demand / use.budget


def _part_text(share: float) -> str:
    return share_text(share) if share <= 1 else f"{100 * share:.4g} %"


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
    missed = "; ".join(_against(reason) for reason in broken)
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
    collided = []
    if isinstance(quality, RobotsQuality) and not quality.collisions:
        collided = ["no robots collided"]
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
    return f"{_against(first)}{more}{remedy}"


def _against(reason: Reason) -> str:
    if reason.words:
        return reason.words
    demand, limit = (quantity_text(value, reason.unit) for value in (reason.demand, reason.limit))
    return f"{label(reason.name)}: {demand} against {limit}"


def _first_sentence(text: str) -> str:
    return text.partition(". ")[0]
