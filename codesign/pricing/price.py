"""The outcomes of machines side by side: what each costs, and what they share."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.figures import FIGURES
from codesign.inputs.components import DisplayComponent, FpgaComponent, MemoryComponent
from codesign.memo import Memo
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.pricing.machines import Column, Machines, Specs
from codesign.results.mission import LinkUse
from codesign.results.result import Reason, ResourceUse, Result
from codesign.results.task import times_of
from codesign.scenarios.plan_once import task_figures
from codesign.scenarios.requests import Requests, requests_of
from codesign.system.bind import System
from codesign.system.calibrated import laws_of
from codesign.system.fit import clock_reason, fit_part
from codesign.system.outcome import head_fields, quality_of
from codesign.system.trials import arrival_reason, arrivals_of
from codesign.units import PICOSECONDS_PER_SECOND

Numbers = NDArray[np.intp]

PRICED = ("plan_time_worst_s", "plan_time_mean_s", "plan_time_95_s", "first_plan_s", "cycles", "power", "energy_j")
"""The figures that prices move. All others are those of the template."""


def why_not(system: System) -> str:
    """Why a design point is simulated by itself, though others compute the same; "" where it is priced."""
    platform = system.platform
    if system.scenario.type != "plan_once":
        return f"scenario {system.scenario.type} is simulated event by event"
    if system.workload.tasks:
        return "tasks of the workload's own use the same components and links"
    if system.external is not None:
        return "accesses to an external memory depend on its rows"
    for name, spec in platform.components.items():
        if isinstance(spec, DisplayComponent):
            return f"display {name} takes cycles of the memory that it reads"
        if isinstance(spec, MemoryComponent) and spec.power is not None:
            return f"memory {name} draws power"
    ends: set[frozenset[str]] = set()
    for name, link in platform.links.items():
        if link.errors is not None or link.outages:
            return f"link {name} loses messages or is down"
        pairs = {frozenset({a, b}) for a in link.between for b in link.between if a != b}
        if pairs & ends:
            return f"of link {name} and those beside it each message takes the fastest"
        ends |= pairs
    return ""


@dataclass(frozen=True, eq=False)
class Priced:
    """The outcomes of machines side by side, one entry a machine.

    - ``templates``: results without what prices move; ``which``: the template of each machine, intp.
    - ``figures``: those of ``PRICED`` by name, float64; NaN: none.
    - ``reasons``: why clocks are too fast; ``reason``: of each machine, intp, -1: it is not.
    """

    templates: tuple[Result, ...]
    which: Numbers
    figures: Mapping[str, Column]
    reasons: tuple[Reason, ...]
    reason: Numbers


@dataclass(frozen=True, eq=False)
class _Board:
    """The use of one FPGA by a design, of each of its models.

    ``fits``: resources and reasons by kind of part; ``kind``: of each model. ``watts``: static and dynamic power of
    each model, W. ``too_fast``: of each model, None where its clock is not.
    """

    fits: list[tuple[tuple[ResourceUse, ...], tuple[Reason, ...]]]
    kind: Numbers
    static: Column
    dynamic: Column
    too_fast: list[Reason | None]


def price(system: System, specs: Specs, memo: Memo) -> Priced:
    """The outcomes of a bound system on machines that compute the same; see ``why_not``."""
    boards = {
        name: _board(system, specs, name)
        for name, spec in system.platform.components.items()
        if isinstance(spec, FpgaComponent)
    }
    count = specs.count
    fit_of = np.zeros(count, np.intp)
    fits: list[tuple[str, tuple[Reason, ...]]] = []
    reasons: list[Reason] = []
    reason = np.full(count, -1, np.intp)
    templates, which = _fitted(system, specs, boards)
    for name, board in boards.items():
        for number, each in enumerate(board.too_fast):
            if each is not None:
                reason[specs.which[name] == number] = len(reasons)
                reasons.append(each)
    del fit_of, fits
    runs = np.array([not template.reasons for template in templates])[which] & (reason < 0)
    figures = {name: np.full(count, math.nan) for name in PRICED}
    planning = boards.get(system.component)
    watts = {name: (board.static[specs.which[name]], board.dynamic[specs.which[name]]) for name, board in boards.items()}
    shown = next((name for name in (system.component, *_apart(system)) if name in boards), None)
    if shown is not None:
        static, dynamic = watts[shown]
        figures["power"] = static + dynamic
    del planning
    if runs.any():
        fields, priced = _run(system, specs, watts, memo)
        for name, values in priced.items():
            figures[name] = np.where(runs, values, math.nan)
        ran = [_ran(template, fields) for template in templates]
        which = np.where(runs, which + len(templates), which)
        templates = (*templates, *ran)
    return Priced(tuple(templates), which, figures, tuple(reasons), reason)


def _fitted(
    system: System, specs: Specs, boards: Mapping[str, _Board]
) -> tuple[tuple[Result, ...], Numbers]:
    """A result without a run for each kind of part, and the one of each machine."""
    head = head_fields(system)
    used = [name for name in (system.component, *_apart(system)) if name in boards]
    if not used:
        return (Result.model_construct(**head, feasible=True),), np.zeros(specs.count, np.intp)
    key = np.zeros(specs.count, np.intp)
    for name in used:
        key = key * len(boards[name].fits) + boards[name].kind[specs.which[name]]
    numbers, which = np.unique(key, return_inverse=True)
    templates = []
    for number in numbers:
        machine = int(np.argmax(key == number))
        resources: tuple[ResourceUse, ...] = ()
        reasons: tuple[Reason, ...] = ()
        # In the order of fit_system: the planning FPGA last, its resources shown.
        for name in reversed(used):
            model = specs.which[name][machine]
            resources, more = boards[name].fits[boards[name].kind[model]]
            reasons = (*more, *reasons)
        fields = dict(head)
        if system.part is not None:
            model = specs.models[system.component][specs.which[system.component][machine]]
            fields["part"] = model.chip.full_name  # type: ignore[attr-defined]
        templates.append(
            Result.model_construct(**fields, feasible=not reasons, reasons=reasons, resources=resources)
        )
    return tuple(templates), np.asarray(which.reshape(-1), np.intp)


def _apart(system: System) -> list[str]:
    """The FPGAs of tasks that do not plan."""
    places = system.placement.places
    return [
        places[task]
        for task in system.placement.styles
        if task not in system.placement.inside
        and isinstance(system.platform.components[places[task]], FpgaComponent)
    ]


def _board(system: System, specs: Specs, name: str) -> _Board:
    models: Sequence[Any] = specs.models[name]
    style, job, task = _design_on(system, name)
    kinds: dict[Any, int] = {}
    kind: list[int] = []
    laws_by_kind: list[Any] = []
    fits: list[tuple[tuple[ResourceUse, ...], tuple[Reason, ...]]] = []
    static: list[float] = []
    dynamic: list[float] = []
    too_fast: list[Reason | None] = []
    for model in models:
        part = model.chip
        key = part.full_name, None if model.calibrated is None else model.calibrated.name
        if key not in kinds:
            kinds[key] = len(fits)
            if style is None:
                laws_by_kind.append(None)
                fits.append(((), ()))
            else:
                laws = laws_of(style, model, task)
                own = Job(job.problem, job.parameters, part=part) if task else _on_part(job, part)
                demand = laws.demand(own)
                laws_by_kind.append((laws, laws.power_demand(own, demand), laws.clock_limit(own)))
                fits.append(fit_part(demand, part))
        kind.append(kinds[key])
        if style is None:
            static.append(part.static_power.value)
            dynamic.append(0.0)
            too_fast.append(None)
            continue
        laws, demand, limit = laws_by_kind[kinds[key]]
        clock = int(model.clock.value)
        watts = laws.power(demand, clock)
        static.append(watts[0].value)
        dynamic.append(watts[1].value)
        too_fast.append(clock_reason(clock, limit))
    return _Board(fits, np.array(kind, np.intp), np.array(static), np.array(dynamic), too_fast)


def _on_part(job: Job[Any, Any], part: Any) -> Job[Any, Any]:
    from dataclasses import replace

    return replace(job, part=part)


def _design_on(system: System, name: str) -> tuple[Any, Job[Any, Any], str]:
    """The style of the design on an FPGA, its job, and its task where that does not plan; no style: no task is on it."""
    if name == system.component:
        return system.architecture, system.job, ""
    for task, style in system.placement.styles.items():
        if system.placement.places[task] == name and task not in system.placement.inside:
            return style, system.job, task
    return None, system.job, ""


def _run(
    system: System, specs: Specs, watts: Mapping[str, tuple[Column, Column]], memo: Memo
) -> tuple[dict[str, Any], dict[str, Column]]:
    """The fields of a result that all machines share, and the figures that prices move."""
    machines = Machines(system, specs)
    requests = requests_of(machines, watts, memo)
    first = requests.first.answer
    figures, quality = system.planner.figures(first.plan), quality_of(machines, first, memo)
    arrivals = arrivals_of(system, first.problem, quality)
    times = times_of([request.answer.parts for request in requests.all])
    short = arrival_reason(arrivals)
    of_first = {name: float(np.broadcast_to(value, specs.count)[0]) for name, value in times.items()}
    fields = {
        **figures,
        "quality": quality,
        "task": task_figures(system, arrivals, of_first),
        "reasons": () if short is None else (short,),
        "utilisation": {name: float(each.busy[0] > 0) for name, each in {**machines.by_name, **machines.links}.items()},
        "links": {name: _link_use(link) for name, link in machines.links.items()},
        "displays": {},
    }
    cycles = machines.cycles()
    priced = {
        **{name: times[name] for name in PRICED if name in times},
        "first_plan_s": requests.first.before.answered / PICOSECONDS_PER_SECOND,
        "cycles": np.broadcast_to(np.asarray(sum(cycles.values()), np.float64), specs.count),
        "energy_j": _mean_energy(requests),
    }
    return fields, priced


def _mean_energy(requests: Requests) -> Column:
    """The mean of the requests, each machine's sum rounded once."""
    parts = [request.joules["energy_j"] for request in requests.all]
    if all(part is parts[0] for part in parts):
        # A product is rounded once, as the sum of so many equals is.
        return np.asarray(parts[0] * len(parts) / len(parts))
    return np.array([math.fsum(values) / len(parts) for values in zip(*parts, strict=True)])


def _link_use(link: Any) -> LinkUse:
    """The account of a link: how many messages and bits, which no price moves."""
    return LinkUse.model_construct(sent=link.sent, delivered=link.sent, bits=link.bits, dropped={}, in_flight=0)


def _ran(template: Result, fields: Mapping[str, Any]) -> Result:
    """A template with what a run gave."""
    reasons = (*template.reasons, *fields["reasons"])
    update = {**fields, "reasons": reasons, "feasible": not reasons}
    return template.model_copy(update=update)


assert all(name in FIGURES for name in PRICED)
_ = Problem
