"""The records of an explanation: figures, which tables and JSON show."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import reduce
from operator import itemgetter, or_
from typing import Any

from more_itertools import map_reduce
from pydantic import Field

from codesign.ground.figures import FIGURES, Figure
from codesign.ground.units import counted
from codesign.laws import Monomial
from codesign.system.results.ledger import SPENT
from codesign.system.results.model import ResultModel
from codesign.system.results.result import Reason, Result
from codesign.system.results.terms import ENERGY_OVER, Terms, is_edges
from codesign.system.verdicts import Swing, Verdict


class Amount(ResultModel):
    """A part of a time or of an energy."""

    where: str = Field(description="the component or link")
    what: str = Field(description="the phase, the message, or when power is drawn")
    amount: float = Field(description="s or J")
    share: float = Field(description="share of the whole")
    figures: dict[str, Figure] = Field(default={}, description="the figures that it rests on, by name")


class Why(ResultModel):
    """The parts of a figure, the largest first. They add up to ``value``."""

    figure: str = Field(description="name of the declared figure")
    value: float = Field(description="of the figure, in its unit")
    parts: tuple[Amount, ...] = Field(description="its parts")
    note: str = Field(default="", description="why the parts are those of another time, or have no figures")


class Moved(ResultModel):
    """The design with one thing moved: by a lever, by a step, or as it stands elsewhere in the study."""

    what: str = Field(description="what is moved, in words, or the axis")
    before: Any = Field(default=None, description="the value of the axis in the design")
    after: Any = Field(default=None, description="the value of the axis there")
    index: int | None = Field(default=None, description="of the design in the study; None of a run")
    feasible: bool | None = Field(
        default=None, description="whether the whole design is feasible then; None: it was not tried"
    )
    goes: bool | None = Field(
        default=None, description="of a lever: whether the reason goes that it is a lever for; None: it was not tried"
    )
    out: tuple[str, ...] = Field(default=(), description="what then keeps the design out, in words")
    figures: dict[str, float | None] = Field(default={}, description="the objectives, by name")
    better: tuple[str, ...] = Field(default=(), description="objectives that gain")
    worse: tuple[str, ...] = Field(default=(), description="objectives that lose")
    note: str = Field(default="", description="why it was not tried, or cannot be compared")

    @property
    def dominates(self) -> bool:
        """True if it is feasible, better in an objective and worse in none."""
        return bool(self.feasible and self.better and not self.worse)


class WhyOut(ResultModel):
    """A reason against a design, and each of its levers by itself."""

    reason: Reason = Field(description="demand, limit and gap")
    condition: str = Field(default="", description="the condition that it holds in; empty: all together")
    levers: tuple[Moved, ...] = Field(default=(), description="each lever by itself, those that help first")


class Sure(ResultModel):
    """The certainty of a figure of the design, and its place among the others."""

    figure: str = Field(description="name of the declared figure")
    value: float = Field(description="in the unit of the figure")
    least: float | None = Field(default=None, description="the least value inside all intervals")
    most: float | None = Field(default=None, description="the greatest value inside all intervals")
    moved: Swing | None = Field(default=None, description="the figure with an interval that moves it most")
    verdict: Verdict | None = Field(
        default=None, description="whether the best design by it is the best at every value"
    )
    best: int | None = Field(default=None, description="index of the best design by it")
    rival: int | None = Field(default=None, description="index of the design that decides against the best one")


class AxisEffect(ResultModel):
    """The share of the spread of a figure over the feasible designs that one axis moves; see ``axis_effects``."""

    axis: str = Field(description="name of the axis")
    figure: str = Field(description="name of the declared figure")
    main: float | None = Field(description="share of the variance that the axis moves by itself; None: no spread")
    total: float | None = Field(description="share of the variance that is left where all other axes are known")
    complete: bool = Field(description="whether every combination of the axes is feasible and has the figure")
    paired: float = Field(description="share of the designs with a feasible partner that differs in this axis alone")


class Words(ResultModel):
    """The words of a figure in tables."""

    label: str = Field(description="its name in words")
    unit: str = Field(description="its unit; 1 for a number of things or a share")


class Explanation(ResultModel):
    """The explanation of a design."""

    platform: str = Field(description="name of the platform")
    workload: str = Field(description="name of the workload")
    index: int | None = Field(default=None, description="of the design in its study; None of a run")
    axes: dict[str, Any] = Field(default={}, description="its decisions, or what was set")
    condition: str = Field(
        default="", description="the condition in which time and energy are explained, of a study with conditions"
    )
    feasible: bool = Field(description="whether the design is feasible")
    on_front: bool | None = Field(
        default=None, description="whether no other design of the study dominates it; None of a run"
    )
    objectives: dict[str, float | None] = Field(description="the objectives, by name")
    derived: dict[str, Words] = Field(
        default={}, description="label and unit of objectives that the exploration derives, by name"
    )
    result: Result = Field(exclude=True, description="the result that is explained; no part of the JSON")
    time: Why | None = Field(default=None, description="what the time is made of")
    energy: Why | None = Field(default=None, description="what the energy is made of")
    out: tuple[WhyOut, ...] = Field(default=(), description="why the design is out")
    neighbours: tuple[Moved, ...] = Field(
        default=(), description="designs that differ in one axis; those that are better first"
    )
    sure: tuple[Sure, ...] = Field(default=(), description="how sure each objective is")
    effects: tuple[AxisEffect, ...] = Field(
        default=(), description="how much of the spread of each objective each axis of the study moves"
    )
    notes: tuple[str, ...] = Field(default=(), description="what was not explained, and why")

    def __repr__(self) -> str:
        number = "" if self.index is None else f" {self.index}"
        fate = "feasible" if self.feasible else f"out for {counted(len(self.out), 'reason')}"
        better = sum(each.dominates for each in self.neighbours)
        neighbours = counted(better, "better neighbour")
        return f"Explanation({self.workload} on {self.platform}{number}: {fate}, {neighbours})"


def explanation_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of what ``hwsw explain --json`` prints."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **Explanation.model_json_schema(mode="serialization"),
    }


# The parts of the time and the energy of a run: the terms of a plan, or the account of a mission.

Share = tuple[str, str, float, Mapping[str, Figure]]
"""The place, what it is, s or J, and the figures that it rests on."""

WORST = "plan_time_worst_s"
_WHEN = {"always": "at all times", "busy": "while it works", "waiting": "while it waits"}


def why_time(result: Result) -> Why | None:
    """The parts of the time that matters; None if the design was not run."""
    if result.mission is not None:
        return _of_mission(result)
    if result.fleet is not None:
        return _of_fleet(result)
    value = result.figure(FIGURES[WORST])
    if value is not None and result.terms is not None and (plans := result.terms.times.get(WORST, ())):
        slowest = max(plans, key=lambda plan: math.fsum(term.seconds for term in plan))
        inputs = result.terms.inputs
        return _why(WORST, ((each.where, each.what, each.seconds, _inputs(each, inputs)) for each in slowest))
    name = WORST if value is not None else "first_plan_s"
    why = "" if result.terms is None else result.terms.open.get(WORST, "")
    return _by_phase(result, name, why)


def _by_phase(result: Result, name: str, why: str) -> Why | None:
    """The time of the first start by the phases of the component that plans, and the rest."""
    if result.time is None or result.cycles is None or result.clock is None:
        return None
    shares: list[Share] = [
        (result.component, phase, cycles / result.clock.hz, {}) for phase, cycles in result.cycles.items()
    ]
    rest = result.time.first_plan_s - math.fsum(seconds for _, _, seconds, _ in shares)
    if rest > 0:
        shares.append(("links and other components", "all else", rest, {}))
    note = "the parts are those of the first start"
    return _why(name, shares, f"{why}: {note}" if why else note)


def _of_mission(result: Result) -> Why:
    """The time of a mission: the robot drives, stands for an answer, or stands."""
    mission = result.mission
    assert mission is not None, "the caller looks"
    stands = max(0.0, mission.mission_time_s - mission.driving_s - mission.waiting_s)
    shares: list[Share] = [
        ("robot", "drives", mission.driving_s, {}),
        ("robot", "stands for an answer", mission.waiting_s, {}),
        ("robot", "stands for something else", stands, {}),
    ]
    latency = ", ".join(f"{SPENT[each.kind]} at {each.where}" for each in mission.latency[:2])
    note = f"most of the time of plans is {latency}" if latency else ""
    return _why("mission_time_s", shares, note)


def _of_fleet(result: Result) -> Why | None:
    """The time of a fleet by what its updates wait for."""
    fleet = result.fleet
    assert fleet is not None, "the caller looks"
    if result.time is None:
        return None
    shares: list[Share] = [(*_FLEET[name], share * fleet.span_s, {}) for name, share in fleet.shares.items()]
    rest = result.time.first_plan_s - math.fsum(seconds for _, _, seconds, _ in shares)
    return _why("first_plan_s", [*shares, ("fleet", "all else", max(0.0, rest), {})])


_FLEET = {
    "fpga": ("FPGAs", "robots decide"),
    "line": ("line", "updates wait for it"),
    "time_step": ("time step", "updates wait for it"),
}


def why_energy(result: Result) -> Why | None:
    """The parts of the energy; None if the design was not run."""
    if result.mission is not None:
        energy = result.mission.energy
        rows = [("robot", "body", energy.robot_j), *_by_kind(energy)]
        return _why("mission_energy_j", ((where, what, joules, {}) for where, what, joules in rows))
    if result.energy is None:
        return None
    terms = result.terms
    if terms is not None and terms.plans("energy_j") and len(terms.times.get(ENERGY_OVER, ())) == 1:
        return _why("energy_j", _drawn(terms))
    note = "" if terms is None else terms.open.get("energy_j", "")
    rows = _by_kind(result.energy)
    return _why("energy_j", ((where, what, joules, {}) for where, what, joules in rows), note)


def _by_kind(energy: object) -> list[tuple[str, str, float]]:
    held = vars(energy)
    kinds = {"fpga_j": "FPGAs", "processors_j": "processors", "links_j": "links", "memories_j": "memories"}
    return [(words, "working and waiting", held[name]) for name, words in kinds.items()]


def _drawn(terms: Terms) -> Iterable[Share]:
    """The energy of each draw: its power times the time in which it is drawn."""
    (plan,) = terms.times[ENERGY_OVER]
    for draw in terms.draws:
        seconds = math.fsum(term.seconds for term in plan if draw.during(term))
        yield draw.where, _WHEN[draw.when], draw.watts * seconds, _inputs(draw, terms.inputs)


def _inputs(each: Monomial, inputs: Mapping[str, Figure]) -> dict[str, Figure]:
    """The figures that a part rests on; not the clock periods waited, which nobody can measure by themselves."""
    return {name: inputs[name] for name in each.inputs if not is_edges(name)}


def _why(figure: str, shares: Iterable[Share], note: str = "") -> Why:
    """The parts of one place and kind as one, the largest first; parts of nothing are left out."""
    alike = map_reduce(shares, itemgetter(0, 1))
    amounts = {key: sum(share[2] for share in of_key) for key, of_key in alike.items()}
    whole = math.fsum(amounts.values())
    ordered = sorted(amounts.items(), key=lambda item: (-item[1], item[0]))
    parts = tuple(
        Amount(
            where=where,
            what=what,
            amount=amount,
            share=amount / whole if whole else 0.0,
            figures=reduce(or_, (dict(share[3]) for share in alike[where, what])),
        )
        for (where, what), amount in ordered
        if amount
    )
    return Why(figure=figure, value=whole, parts=parts, note=note)
