"""The parts of the time and the energy of a run: the terms of a plan, or the account of a mission."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import reduce
from operator import itemgetter, or_

from more_itertools import map_reduce

from codesign.ground.figures import FIGURES, Figure
from codesign.laws import Monomial
from codesign.system.explanation.records import Amount, Why
from codesign.system.results.ledger import SPENT
from codesign.system.results.result import Result
from codesign.system.results.terms import ENERGY_OVER, Terms, is_edges

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
