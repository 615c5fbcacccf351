"""The outcomes of machines side by side: what each costs, and what they share."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.figures import FIGURES, Figure, ResultFigure
from codesign.ground.memo import Same
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.components import DisplayComponent
from codesign.study.pricing.boards import FORMS, Board, Numbers, PartUse, boards_of
from codesign.study.pricing.computation import Computation, Recorded, alike
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


@dataclass(frozen=True, eq=False)
class Group:
    """Machines that compute the same, with the use of their FPGAs, and what they compute.

    - ``system``: bound; one that ``why_alone`` lets price. ``specs``: of the machines.
    - ``templates``: results without a run. ``which``: the template of each machine, intp.
    - ``reasons``, ``reason``: see ``Priced``. ``runs``: of each machine, whether it fits at its clock.
    - ``computation``: what they compute; None where none of them runs.
    """

    system: System
    specs: Specs
    boards: Mapping[str, Board]
    templates: tuple[Result, ...]
    which: Numbers
    reasons: tuple[Reason, ...]
    reason: Numbers
    runs: NDArray[np.bool_]
    computation: Computation | None

    @classmethod
    def of(cls, system: System, specs: Specs, computed: Callable[[], Computation]) -> Group:
        """The group of these machines. ``computed`` is called where any of them runs, and its faults are raised."""
        boards = boards_of(system, specs)
        templates, which = _fitted(system, specs, boards)
        reason, reasons = _too_fast(specs, boards)
        runs = np.array([not template.reasons for template in templates])[which] & (reason < 0)
        computation = computed() if runs.any() else None
        return cls(system, specs, boards, templates, which, reasons, reason, runs, computation)

    @property
    def kind(self) -> Hashable:
        """Machines of groups of one kind do like acts, on like components."""
        system, placement = self.system, self.system.placement
        styles = tuple((task, style.planner, style.style) for task, style in placement.styles.items())
        wired = Same(self.specs.models), self.specs.shape, tuple(placement.places.items()), placement.inside
        of = system.component, system.planner.name, system.architecture.style, styles
        return *wired, *of, None if self.computation is None else self.computation.kind


def price(groups: Sequence[Group]) -> list[Priced]:
    """The outcomes of groups of machines, in order. Equal to those of single runs to the last bit.

    Raises:
        RunError: a time is beyond 64 bits.
    """
    priced: dict[int, Priced] = {}
    for numbers in map_reduce(range(len(groups)), lambda number: groups[number].kind).values():
        priced |= zip(numbers, _side_by_side([groups[number] for number in numbers]), strict=True)
    return [priced[number] for number in range(len(groups))]


def _side_by_side(groups: Sequence[Group]) -> list[Priced]:
    """The outcomes of groups of one kind."""
    first, *others = groups
    specs = first.specs.beside(group.specs for group in others)
    figures, lows, highs = ({name: np.full(specs.count, math.nan) for name in PRICED} for _ in range(3))
    watts = {
        name: np.concatenate([group.boards[name].watts[group.specs.which[name]] for group in groups])
        for name in first.boards
    }
    for name in tuple(first.system.designs)[:1]:
        # The power of the FPGA that plans, or else of the one with a task, fit or not.
        for columns, sums in zip((figures, lows, highs), watts[name].sum(axis=1).T, strict=True):
            columns["power"][:] = sums
    templates = [group.templates for group in groups]
    which = [group.which for group in groups]
    if first.computation is not None:
        chosen = np.flatnonzero(np.concatenate([group.runs for group in groups]))
        own = specs.subset(chosen)
        drawn = {name: column[chosen] for name, column in watts.items()}
        fields, priced, intervals = _run(groups, own, drawn)
        for name, values in priced.items():
            figures[name][chosen] = values
        for name, (low, high) in intervals.items():
            lows[name][chosen], highs[name][chosen] = low, high
        ran = [
            [_ran(template, each) for template in group.templates] for group, each in zip(groups, fields, strict=True)
        ]
        which = [np.where(group.runs, group.which + len(group.templates), group.which) for group in groups]
        templates = [(*before, *after) for before, after in zip(templates, ran, strict=True)]
    ends = np.cumsum([group.specs.count for group in groups]).tolist()
    outcomes = []
    for group, results, numbers, end in zip(groups, templates, which, ends, strict=True):
        rows = slice(end - group.specs.count, end)
        low, value, high = ({name: column[rows] for name, column in each.items()} for each in (lows, figures, highs))
        outcomes.append(Priced(results, numbers, value, low, high, group.reasons, group.reason))
    return outcomes


def _fitted(system: System, specs: Specs, boards: Mapping[str, Board]) -> tuple[tuple[Result, ...], Numbers]:
    """A result without a run for each combination of parts, and the one of each machine."""
    head, used = head_fields(system), tuple(system.designs)
    key = np.zeros(specs.count, np.intp)
    for name in used:
        key = key * len(boards[name].uses) + boards[name].kind[specs.which[name]]
    _, firsts, which = np.unique(key, return_index=True, return_inverse=True)
    of_processor: PartUse = (), (), ()
    if system.part is None:
        # Machines that compute the same have processors of one memory.
        of_processor = fit_part(system.architecture.demand(system.job), None)
    templates = []
    for first in firsts:
        resources, bounds, reasons = of_processor
        uses = {name: boards[name].use(specs.which[name][first]) for name in used}
        for use in uses.values():
            own, limits, more = use.fit
            # One object for designs that have one fit: it is then written once.
            resources = resources or own
            bounds, reasons = ((*bounds, *limits), (*reasons, *more)) if bounds or reasons else (limits, more)
        fields = dict(head)
        if system.part is not None:
            fields["part"] = uses[system.component].part.full_name
        templates.append(
            Result.model_construct(**fields, feasible=not reasons, reasons=reasons, resources=resources, bounds=bounds)
        )
    return tuple(templates), which.reshape(-1)


def _too_fast(specs: Specs, boards: Mapping[str, Board]) -> tuple[Numbers, tuple[Reason, ...]]:
    """The number of the reason of each machine, and the reasons."""
    reason = np.full(specs.count, -1, np.intp)
    reasons: list[Reason] = []
    for name, board in boards.items():
        late = [number for number, each in enumerate(board.too_fast) if each is not None]
        numbers = np.full(len(board.too_fast), -1, np.intp)
        numbers[late] = np.arange(len(late)) + len(reasons)
        reason = np.where(numbers[specs.which[name]] < 0, reason, numbers[specs.which[name]])
        reasons += filter(None, board.too_fast)
    return reason, tuple(reasons)


Ends = Mapping[str, tuple[Any, Any]]
"""The least and the greatest value of figures, by name."""


def _run(
    groups: Sequence[Group], specs: Specs, drawn: Mapping[str, Column]
) -> tuple[list[dict[str, Any]], dict[str, Column], Ends]:
    """The machines of ``groups`` that run, side by side.

    Args:
        groups: of one kind. specs: of their machines that run, group by group.
        drawn: what each FPGA draws, machines × static and dynamic × value, least and greatest.

    Returns:
        The fields of a result that the machines of each group share; the figures that prices move; and their intervals.
    """
    computations = [group.computation for group in groups if group.computation is not None]
    system, repeats = groups[0].system, [int(group.runs.sum()) for group in groups]
    requests, of_starts = (
        alike([computation.requests for computation in computations], repeats),
        computations[0].of_starts,
    )
    watts = {name: (column[:, 0, 0], column[:, 1, 0]) for name, column in drawn.items()}
    played = [Machines(system, specs).play(request, watts) for request in requests]
    parts = [parts_of(each, request) for each, request in zip(played, requests, strict=True)]
    times = times_of([parts[number] for number in of_starts])
    first, machines = requests[0], played[0].machines
    priced = {
        **{name: values for name, values in times.items() if name in PRICED},
        "first_plan_s": played[0].times[first.before or first.answered] / PICOSECONDS_PER_SECOND,
        "cycles": np.asarray(sum(machines.cycles().values()), np.float64),
        "energy_j": mean_of_requests([played[number].joules["energy_j"] for number in of_starts]),
    }
    links = {
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
    }
    busy = {name: each.busy > 0 for name, each in {**machines.by_name, **machines.links}.items()}
    fields = [
        {
            **computation.figures,
            "quality": computation.quality,
            "task": computation.task,
            "reasons": () if computation.short is None else (computation.short,),
            "utilisation": {name: float(each[begin]) for name, each in busy.items()},
            "links": links,
        }
        for computation, begin in zip(computations, np.cumsum([0, *repeats[:-1]]).tolist(), strict=True)
    ]
    return fields, priced, _ends(groups, specs, played, of_starts, drawn)


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


def _ends(
    groups: Sequence[Group],
    specs: Specs,
    played: Sequence[Played],
    of_starts: Sequence[int],
    drawn: Mapping[str, Column],
) -> Ends:
    """The intervals of the times of a plan and of its energy. See ``_run``.

    ``played``: the requests that differ. ``of_starts``: the number of the request of each start.
    """
    system, names = groups[0].system, (*TIMES, "energy_j")
    # Machines whose terms have the same inputs are priced at once.
    key = np.zeros(specs.count, np.intp)
    for name in drawn:
        boards = [(group.boards[name], group.specs.which[name][group.runs]) for group in groups]
        key = key * FORMS + np.concatenate([board.form[which] for board, which in boards])
        if len(drawn) > 1:
            # Two FPGAs of one part have one input, which those of two parts have not.
            key = key * len(boards[0][0].uses) + np.concatenate([board.kind[which] for board, which in boards])
    lows, highs = ({name: np.full(specs.count, math.nan) for name in names} for _ in range(2))
    owner = np.repeat(np.arange(len(groups)), [int(group.runs.sum()) for group in groups])
    for number in np.unique(key):
        chosen = np.flatnonzero(key == number)
        own = groups[owner[chosen[0]]].boards
        powers = {
            name: _power(own[name].powers[specs.which[name][chosen[0]]], column[chosen])
            for name, column in drawn.items()
        }
        ledgers = [_of_some(each.ledger, chosen) for each in played]
        first = ledgers[0] if played[0].first is played[0].ledger else _of_some(played[0].first, chosen)
        requests = [ledgers[number] for number in of_starts]
        terms = plan_terms(system, specs.subset(chosen), first, requests, powers, shares={}, ends_only=True)
        for name, (low, high) in terms.intervals(names).items():
            lows[name][chosen], highs[name][chosen] = low, high
    return {name: (lows[name], highs[name]) for name in names}


def _power(of_first: tuple[Figure, Figure], drawn: Column) -> Power:
    """The power of an FPGA on many machines. ``drawn``: machines × static and dynamic × value, least and greatest."""
    static, dynamic = (
        Figure(value, figure.unit, figure.status, figure.source, low, high)
        for figure, (value, low, high) in zip(of_first, drawn.transpose(1, 2, 0), strict=True)
    )
    return Power.model_construct(static=static, dynamic=dynamic)


def _of_some(ledger: Ledger, chosen: Numbers) -> Ledger:
    """The books of some of the machines."""
    some = Ledger()
    amounts: Mapping[Any, Any] = ledger.work
    some.work = {work: amount[chosen] if np.ndim(amount) else amount for work, amount in amounts.items()}
    for key, spent in ledger.spent.items():
        of_all: Any = spent
        some.spent[key] = of_all[chosen] if np.ndim(of_all) else of_all
    return some
