"""The outcomes of machines side by side: what each costs, and what they share."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.components import DisplayComponent
from codesign.study.pricing.boards import Board, Numbers, PartUse, boards_of
from codesign.study.pricing.computation import Computation, Recorded
from codesign.study.pricing.machines import Column, Machines, Played, Specs, Times
from codesign.system.bind import System
from codesign.system.fit import fit_part
from codesign.system.outcome import head_fields
from codesign.system.results.ledger import Ledger
from codesign.system.results.mission import LinkUse
from codesign.system.results.result import Power, Reason, Result, times_of
from codesign.system.scenarios.requests import mean_of_requests
from codesign.system.terms import TIMES, plan_terms

PRICED = ("plan_time_worst_s", "plan_time_mean_s", "plan_time_95_s", "first_plan_s", "cycles", "power", "energy_j")
"""The figures that prices move, by name. All others are the template's."""

assert FIGURES.keys() >= set(PRICED)

_HELD = {"mission", "precision", "quality", "resources", "task"}
"""Parts of a result that a template has, and no price moves. A figure of any other part is of whole results."""


def why_alone(system: System) -> str:
    """The reason why a design point is simulated by itself, though others compute the same; "" if it is priced."""
    return next(_reasons_alone(system), "")


def _reasons_alone(system: System) -> Iterator[str]:
    platform = system.platform
    for figure in FIGURES.values():
        if _is_of_whole_results(figure):
            yield f"figure {figure.name} is computed of whole results"
    if system.scenario.type != "plan_once":
        yield f"scenario {system.scenario.type} is simulated event by event"
    if system.workload.tasks:
        yield "tasks of the workload's own use the same components and links"
    if system.external is not None:
        yield "accesses to an external memory depend on its rows"
    for name, display in platform.of(DisplayComponent).items():
        if display.beside == system.component:
            yield f"display {name} takes cycles of the memory that the design works in"
    ends: set[frozenset[str]] = set()
    for name, link in platform.links.items():
        if link.errors is not None or link.outages:
            yield f"link {name} loses messages or is down"
        pairs = {frozenset({one, other}) for one in link.between for other in link.between if one != other}
        if pairs & ends:
            yield f"of link {name} and those beside it each message takes the fastest"
        ends |= pairs


def _is_of_whole_results(figure: ResultFigure) -> bool:
    """True if a figure may rest on what prices move, and pricing does not know how."""
    part = figure.path.partition(".")[0]
    moved = part not in _HELD or (part == "task" and figure.unit == "s") or figure.value is not None
    return moved and figure.name not in PRICED


@dataclass(frozen=True, eq=False)
class Priced:
    """The outcomes of machines side by side, one entry a machine.

    - ``templates``: results without what prices move. ``which``: the template of each machine, intp.
    - ``figures``: by name as in ``PRICED``, float64. ``lows``, ``highs``: the ends of their intervals. NaN: none.
    - ``reasons``: why clocks are too fast. ``reason``: of each machine, intp; -1: its clock is not.
    """

    templates: tuple[Result, ...]
    which: Numbers
    figures: Mapping[str, Column]
    lows: Mapping[str, Column]
    highs: Mapping[str, Column]
    reasons: tuple[Reason, ...]
    reason: Numbers


def price(system: System, specs: Specs, computed: Callable[[], Computation]) -> Priced:
    """The outcomes of a bound system on machines that compute the same.

    Equal to single runs to the last bit. ``system`` is one that ``why_alone`` lets price. ``computed`` gives
    what it computes (``record``); it is called where any of the machines fits.

    Raises:
        RunError: a time is beyond 64 bits. All that ``computed`` raises.
    """
    boards = boards_of(system, specs)
    used = tuple(system.designs)
    templates, which = _fitted(system, specs, boards, used)
    reason, reasons = _too_fast(specs, boards)
    figures, lows, highs = ({name: np.full(specs.count, math.nan) for name in PRICED} for _ in range(3))
    if used:
        _put_power(specs, used[0], boards[used[0]], figures, lows, highs)
    runs = np.array([not template.reasons for template in templates])[which] & (reason < 0)
    if runs.any():
        computation = computed()
        played, fields, priced = _run(system, specs, boards, computation)
        for name, values in priced.items():
            figures[name][runs] = values[runs]
        parts = _kinds(specs, boards)
        for number in np.unique(parts[runs]):
            chosen = np.flatnonzero(runs & (parts == number))
            own, powers = specs.subset(chosen), _powers(specs, boards, chosen)
            ends = _intervals_of(system, own, chosen, played, computation.of_starts, powers)
            for name, (low, high) in ends.items():
                lows[name][chosen], highs[name][chosen] = low, high
        ran = [_ran(template, fields) for template in templates]
        which = np.where(runs, which + len(templates), which)
        templates = (*templates, *ran)
    return Priced(templates, which, figures, lows, highs, reasons, reason)


def _fitted(
    system: System, specs: Specs, boards: Mapping[str, Board], used: Sequence[str]
) -> tuple[tuple[Result, ...], Numbers]:
    """A result without a run for each combination of parts, and the one of each machine."""
    head, key = head_fields(system), _kinds(specs, {name: boards[name] for name in used})
    numbers, firsts, which = np.unique(key, return_index=True, return_inverse=True)
    of_processor: PartUse = (), (), ()
    if system.part is None:
        # Machines that compute the same have processors of one memory.
        of_processor = fit_part(system.architecture.demand(system.job), None)
    templates = []
    for first in firsts[: len(numbers)]:
        resources, bounds, reasons = of_processor
        for name in used:
            board = boards[name]
            uses, limits, more = board.fits[board.kind[specs.which[name][first]]]
            # One object for designs that have one fit: it is then written once.
            resources = resources or uses
            bounds, reasons = ((*bounds, *limits), (*reasons, *more)) if bounds or reasons else (limits, more)
        fields = dict(head)
        if system.part is not None:
            board = boards[system.component]
            fields["part"] = board.parts[board.kind[specs.which[system.component][first]]].full_name
        templates.append(
            Result.model_construct(**fields, feasible=not reasons, reasons=reasons, resources=resources, bounds=bounds)
        )
    return tuple(templates), which.reshape(-1)


def _kinds(specs: Specs, boards: Mapping[str, Board]) -> Numbers:
    """A number for each combination of the kinds of these FPGAs, one entry a machine."""
    key = np.zeros(specs.count, np.intp)
    for name, board in boards.items():
        key = key * len(board.fits) + board.kind[specs.which[name]]
    return key


def _too_fast(specs: Specs, boards: Mapping[str, Board]) -> tuple[Numbers, tuple[Reason, ...]]:
    """The number of the reason of each machine, and the reasons."""
    reason = np.full(specs.count, -1, np.intp)
    reasons: list[Reason] = []
    for name, board in boards.items():
        for number, each in enumerate(board.too_fast):
            if each is not None:
                reason[specs.which[name] == number] = len(reasons)
                reasons.append(each)
    return reason, tuple(reasons)


def _put_power(
    specs: Specs,
    name: str,
    board: Board,
    figures: Mapping[str, Column],
    lows: Mapping[str, Column],
    highs: Mapping[str, Column],
) -> None:
    """The power of the FPGA that plans, or else of the one with a task, fit or not."""
    which = specs.which[name]
    static, dynamic = board.watts(which)
    figures["power"][:] = static + dynamic
    ends = np.array(
        [
            [sum(figure.interval[end] for figure in (power.static, power.dynamic)) for end in (0, 1)]
            for power in board.powers
        ]
    )[which]
    lows["power"][:], highs["power"][:] = ends[:, 0], ends[:, 1]


def _powers(specs: Specs, boards: Mapping[str, Board], chosen: Numbers) -> dict[str, Power]:
    """The power of each FPGA on some machines of one part each: figures, or arrays of them."""
    powers = {}
    for name, board in boards.items():
        own = Specs({name: board.powers}, {name: specs.which[name][chosen]}, len(chosen))
        powers[name] = Power.model_construct(
            static=own.of_figures(name, lambda power: power.static),
            dynamic=own.of_figures(name, lambda power: power.dynamic),
        )
    return powers


def _run(
    system: System, specs: Specs, boards: Mapping[str, Board], computation: Computation
) -> tuple[list[Played], dict[str, Any], dict[str, Column]]:
    """The requests on the machines, the fields of a result that all share, and the figures that prices move."""
    watts = {name: board.watts(specs.which[name]) for name, board in boards.items()}
    played = [Machines(system, specs).play(request, watts) for request in computation.requests]
    parts = [parts_of(each, request) for each, request in zip(played, computation.requests, strict=True)]
    times = times_of([parts[number] for number in computation.of_starts])
    first, machines = computation.requests[0], played[0].machines
    components = {**machines.by_name, **machines.links}
    fields = {
        **computation.figures,
        "quality": computation.quality,
        "task": computation.task,
        "reasons": () if computation.short is None else (computation.short,),
        "utilisation": {name: float(each.busy[0] > 0) for name, each in components.items()},
        "links": {
            name: LinkUse(
                sent=link.acts,
                delivered=link.acts,
                dropped={},
                in_flight=0,
                retransmissions=0,
                undetected=0,
                ignored_damage={},
                late=0,
                bits=link.amount,
                utilisation=0.0,
                queued_s=0.0,
            )
            for name, link in machines.links.items()
        },
    }
    priced = {
        **{name: values for name, values in times.items() if name in PRICED},
        "first_plan_s": played[0].times[first.before or first.answered] / PICOSECONDS_PER_SECOND,
        "cycles": np.broadcast_to(np.asarray(sum(machines.cycles().values()), np.float64), specs.count),
        "energy_j": mean_of_requests([played[number].joules["energy_j"] for number in computation.of_starts]),
    }
    return played, fields, priced


def parts_of(played: Played, request: Recorded) -> tuple[Times, Times, Times]:
    """Picoseconds until the map was there, of planning, and until the answer was received (``Answer.parts``)."""
    asked, loaded, planned, answered = (
        played.times[number] for number in (request.asked, request.loaded, request.planned, request.answered)
    )
    return loaded - asked, planned - loaded, answered - planned


def _ran(template: Result, fields: Mapping[str, Any]) -> Result:
    """A template with what a run gave."""
    reasons = (*template.reasons, *fields["reasons"])
    return template.model_copy(update={**fields, "reasons": reasons, "feasible": not reasons})


def _intervals_of(
    system: System,
    specs: Specs,
    chosen: Numbers,
    played: Sequence[Played],
    of_starts: Sequence[int],
    powers: Mapping[str, Power],
) -> dict[str, tuple[Any, Any]]:
    """The least and the greatest value of each time of a plan and of its energy, by figure.

    Args:
        system: that the machines are of. specs: of the ``chosen`` ones alone, which have one part in each FPGA.
        played: the requests that differ, on all machines. of_starts: the number of the request of each start.
        powers: of each FPGA on the chosen machines.
    """
    ledgers = [_of_some(each.ledger, chosen) for each in played]
    replans = played[0].first is not played[0].ledger
    first = _of_some(played[0].first, chosen) if replans else ledgers[0]
    requests = [ledgers[number] for number in of_starts]
    terms = plan_terms(system, specs, first, requests, powers, shares={}, ends_only=True)
    return dict(terms.intervals((*TIMES, "energy_j")))


def _of_some(ledger: Ledger, chosen: Numbers) -> Ledger:
    """The books of some of the machines."""
    some = Ledger()
    some.work = ledger.work
    for key, spent in ledger.spent.items():
        of_all: Any = spent
        some.spent[key] = of_all[chosen] if np.ndim(of_all) else of_all
    return some
