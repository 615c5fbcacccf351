"""Run one bound system: the host sends the map, the planner works on its clock, the answer comes back."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from codesign.errors import InputError, choose_hint
from codesign.memo import Memo
from codesign.records import Listener, MapRecord, SummaryRecord, TrajectoryRecord
from codesign.spec import Platform, Workload
from codesign.spec.components import ProcessorComponent
from codesign.system.bind import System, bind
from codesign.system.build import Machine, build
from codesign.system.fit import fit, source
from codesign.system.result import Energy, Power, Reason, Result, Source, Times

if TYPE_CHECKING:
    from codesign.components import Granularity
    from codesign.maps import OccupancyGrid

TRACED_TRAJECTORIES = 16

MAX_BYTES = 4 * 2**30
"""Most memory that the field of one run may need, by an estimate."""

# Assumed: the field of a stage, that of the stage before, its planes and the block under way; distances and labels.
_WORDS_AT_ONCE = 4
_BYTES_A_CELL = 64


def simulate(
    platform: Platform,
    workload: Workload,
    *,
    listeners: Sequence[Listener] = (),
    granularity: str = "run_ahead",
    memo: Memo | None = None,
    grid: OccupancyGrid | None = None,
) -> Result:
    """Simulate one design point; see ``codesign.simulate``.

    ``listeners`` take the records of the run. ``memo`` shares the functional work of design points that have it in
    common; the figures are the same with and without. ``grid``: the workload's map, where it was read already.

    Raises:
        SpecError: platform, workload and map do not belong together.
    """
    system = bind(platform, workload, grid=grid)
    return simulate_system(system, listeners=listeners, granularity=granularity, memo=memo)


def simulate_system(
    system: System,
    *,
    listeners: Sequence[Listener] = (),
    granularity: str = "run_ahead",
    memo: Memo | None = None,
) -> Result:
    """Simulate a bound system: fit it, and where it fits, run it.

    Raises:
        InputError: an unknown granularity, or a run that would need more than ``MAX_BYTES`` of memory.
    """
    from codesign.components import Granularity

    if granularity not in list(Granularity):
        raise InputError(
            f"granularity {granularity!r} is unknown",
            "granularity",
            choose_hint(granularity, list(Granularity)),
        )
    head = _head(system)
    fields, reasons = _fitted(system)
    head |= fields
    if reasons:
        return Result(**head, feasible=False, reasons=reasons)
    _check_memory(system)
    machine = build(system, listeners)
    plan = _plan_once(system, machine, Granularity(granularity), memo)
    result = Result(**head, feasible=True, **_run_fields(system, machine, plan, head.get("power"), memo))
    for component in machine.components:
        component.report_utilisation()
    if listeners:
        machine.tell(SummaryRecord(machine.now, "run", result.model_dump(mode="json")))
    return result


def _check_memory(system: System) -> None:
    """Refuse what this machine would be ended for: a field of long words on a large map.

    Raises:
        InputError: with the size.
    """
    precisions = getattr(system.planning, "precisions", None)
    if not precisions or not hasattr(system.problem, "free"):
        return
    words = max(precisions) // 64 + 1
    needed = system.problem.free.size * (_WORDS_AT_ONCE * 8 * words + _BYTES_A_CELL)
    if needed > MAX_BYTES:
        raise InputError(
            f"{system.problem.free.size:,} cells at {max(precisions)} bits would need about"
            f" {needed / 2**30:.1f} GiB of memory, more than {MAX_BYTES // 2**30}",
            f"mapping.{system.planner.planning_task}",
            "end the schedule at a lower precision, or take a smaller map",
        )


def _plan_once(system: System, machine: Machine, granularity: Granularity, memo: Memo | None) -> Any:
    """Scenario ``plan_once``: load the map, plan, decide, answer. Returns the plan."""
    problem = system.problem
    if machine.listening:
        goals = np.array(problem.goals, np.int32).reshape(-1, 2)
        machine.tell(MapRecord(0, "map", problem.free, goals, problem.resolution))
    messages = system.planner.messages(problem)
    done: list[Any] = []

    def mission() -> Generator[Any, Any, None]:
        yield from machine.carry_to_planner(messages.problem, messages.problem_bits)
        machine.map_loaded = machine.now
        steps = system.architecture.work(problem, system.planning, memo=memo, detail=machine.listening)
        plan = yield from machine.execute(steps, granularity)
        machine.planned = machine.now
        yield from machine.carry_back(messages.answer, messages.answer_bits)
        machine.answered = machine.now
        done.append(plan)

    machine.environment.process(mission())
    machine.environment.run()
    plan = done[0]
    if machine.listening:
        for start in problem.starts[:TRACED_TRAJECTORIES]:
            points, arrived = system.planner.trajectory(problem, plan, start)
            machine.tell(TrajectoryRecord(machine.now, "robot", points, arrived))
    return plan


def _head(system: System) -> dict[str, Any]:
    parameters = {name: model.model_dump(mode="json") for name, model in system.parameters.items()}
    count = getattr(system.planning, "block_count", None)
    return {
        "platform": system.platform.name,
        "workload": system.workload.name,
        "planner": system.planner.name,
        "style": system.architecture.style,
        "component": system.component,
        "part": None if system.part is None else system.part.full_name,
        "parameters": parameters,
        "blocks": None if count is None else count(system.problem.rows, system.problem.columns),
    }


def _fitted(system: System) -> tuple[dict[str, Any], tuple[Reason, ...]]:
    """What the design takes of its part, as fields of a result, and why it does not fit where it does not."""
    problem, parameters, part = system.problem, system.planning, system.part
    demand = system.architecture.demand(problem, parameters, part)
    if part is None:
        return {"processor": _processor_figures(system)}, fit(demand, None, system.clock, None).reasons
    held = fit(demand, part, system.clock, system.architecture.clock_limit(problem, parameters, part))
    static, dynamic = system.architecture.power(demand, system.clock, part)
    power = Power(static=source(static), dynamic=source(dynamic))
    return {"resources": held.resources, "clock": held.clock, "power": power}, held.reasons


def _processor_figures(system: System) -> dict[str, Source]:
    """What the time and the energy of a processor rest on."""
    spec = system.platform.components[system.component]
    assert isinstance(spec, ProcessorComponent), "what has no part is a processor"
    figures = {f"cost of {kernel}": source(cost) for kernel, cost in spec.costs.items()}
    return figures | {"power busy": source(spec.power.busy), "power idle": source(spec.power.idle)}


def _run_fields(
    system: System, machine: Machine, plan: Any, power: Power | None, memo: Memo | None
) -> dict[str, Any]:
    planner, problem = system.planner, system.problem
    key = ("quality", planner.name, problem.digest, planner.identity(plan))
    quality = (Memo() if memo is None else memo).get(key, lambda: planner.quality(problem, plan))
    times = Times(
        map_loaded_ps=machine.map_loaded, planned_ps=machine.planned, first_plan_ps=machine.answered
    )
    return {
        "time": times,
        "cycles": machine.cycles(),
        **planner.figures(plan),
        "energy": _energy(machine, power),
        "utilisation": {
            # A run that takes no time, as of a host whose costs are 0, keeps nobody busy.
            component.name: component.busy / max(machine.now, 1)
            for component in machine.components
        },
        "quality": quality,
    }


def _energy(machine: Machine, power: Power | None) -> Energy:
    """Static power over the whole time and dynamic power over the busy time; processors by their own figures."""
    span = machine.now / 1e12
    fpga = 0.0
    if power is not None:
        busy = machine.planner.busy / 1e12
        fpga = power.static.value * span + power.dynamic.value * busy
    processors = 0.0
    for processor, spec in machine.processors:
        busy = processor.busy / 1e12
        processors += spec.power.busy.value * busy + spec.power.idle.value * (span - busy)
    return Energy(fpga_j=fpga, processors_j=processors, total_j=fpga + processors)
