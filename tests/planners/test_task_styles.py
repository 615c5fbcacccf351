"""Tasks placed by themselves cost what they cost inside, and starts spare the relaxation in doubles its sweeps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from codesign import maps
from codesign.ground.errors import InputError
from codesign.ground.figures import Status
from codesign.ground.memo import Memo
from codesign.hardware.calibrate.host_costs import all_probes
from codesign.inputs import load_part, load_platform
from codesign.planners.breadth_first.plan.parameters import SearchParameters
from codesign.planners.breadth_first.styles import ARCHITECTURES as BREADTH_FIRST
from codesign.planners.breadth_first.styles import TASK_STYLES as BREADTH_FIRST_TASKS
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.plan import solve
from codesign.planners.relaxation.plan.parameters import RelaxParameters
from codesign.planners.relaxation.plan.planner import PLANNER
from codesign.planners.relaxation.styles import ARCHITECTURES as RELAXATION
from codesign.planners.relaxation.styles import TASK_STYLES as RELAXATION_TASKS
from codesign.planners.relaxation.styles.host import SEARCH_UNITS
from codesign.planners.wavefront.plan.parameters import Course, Paths, PropagateParameters
from codesign.planners.wavefront.plan.planner import PLANNER as WAVEFRONT_PLANNER
from codesign.planners.wavefront.styles import ARCHITECTURES as WAVEFRONT
from codesign.planners.wavefront.styles import TASK_STYLES as WAVEFRONT_TASKS
from codesign.system import catalog

FREE = maps.rooms(30, 40, room=(12, 12), door=3, wall=1, seed=3).free
GOAL = maps.nearest_free(FREE, (15, 20))
assert GOAL is not None
START = maps.nearest_free(maps.reachable(FREE, [GOAL]), (1, 1))
assert START is not None
PROBLEM = Problem(FREE, (GOAL,), (START,))
AT = (float(START[0]), float(START[1]))


def drain(steps: Any) -> tuple[list[Any], Any]:
    yielded = []
    while True:
        try:
            yielded.append(next(steps))
        except StopIteration as done:
            return yielded, done.value


def cycles(steps: list[Any], phase: str | None = None) -> int:
    return sum(int(step.cycles.sum()) for step in steps if phase in {None, step.phase})


def style_of(styles: Any, name: str, component_type: str = "processor") -> Any:
    return next(each for each in styles if (each.style, each.component_type) == (name, component_type))


def test_path_of_a_search_costs_the_same_on_another_fpga() -> None:
    machine, parameters = BREADTH_FIRST[0], SearchParameters()
    steps, plan = drain(machine.work(Job(PROBLEM, parameters)))
    alone = style_of(BREADTH_FIRST_TASKS, "state_machine", "fpga")
    apart, (points, arrived) = drain(alone.steps(Job(PROBLEM, parameters, plan=plan, position=AT)))
    assert cycles(apart) == cycles(steps, "path")
    assert arrived
    assert points.tolist() == plan.path.tolist()
    part = load_platform("virtex2pro").components["fpga"].chip  # type: ignore[union-attr]
    job = Job(PROBLEM, parameters, part=part)
    demand, whole = alone.demand(job), machine.demand(job)
    for kind in ("slices", "lut4", "flip_flops", "block_rams"):
        assert 0 < demand.total(kind) < whole.total(kind)
    by_itself, whole_machine = alone.clock_limit(job), machine.clock_limit(job)
    assert (by_itself.value, by_itself.interval) == (whole_machine.value, whole_machine.interval)
    # The task by itself was not placed.
    assert by_itself.status is Status.ASSUMED
    host, _ = drain(style_of(BREADTH_FIRST_TASKS, "software").steps(Job(PROBLEM, parameters, plan=plan, position=AT)))
    assert cycles(host) == len(plan.path)


@pytest.mark.parametrize("course", list(Course))
def test_tracking_costs_the_same_on_a_host(course: Course) -> None:
    parameters = PropagateParameters(course=course, steps=3)
    software = style_of(WAVEFRONT, "software")
    steps, plan = drain(software.work(Job(PROBLEM, parameters)))
    alone = style_of(WAVEFRONT_TASKS, "software")
    apart, (points, arrived) = drain(alone.steps(Job(PROBLEM, parameters, plan=plan, position=AT)))
    assert cycles(apart) == cycles(steps, "track")
    assert arrived
    prepared = [step for step in apart if step.kernel == "wavefront_map_cell"]
    assert cycles(prepared) == PROBLEM.free.size
    assert cycles(apart) - cycles(prepared) == (3 if course is Course.LOCAL else len(points) - 1)
    again, _ = drain(alone.again(Job(PROBLEM, parameters, plan=plan, position=AT)))
    assert cycles(again) == cycles(apart) - cycles(prepared)
    nowhere, (left, there) = drain(alone.steps(Job(PROBLEM, parameters, plan=plan, position=(-5.0, 0.0))))
    assert (cycles(nowhere), left.tolist(), there) == (cycles(prepared) + 1, [[-5.0, 0.0]], False)


@pytest.mark.parametrize("course", list(Course))
@pytest.mark.parametrize("paths", list(Paths))
def test_tracking_costs_the_same_in_the_fabric(course: Course, paths: Paths) -> None:
    parameters = PropagateParameters(course=course, steps=3, paths=paths)
    array, alone = (style_of(WAVEFRONT, "delay_line", "fpga"), style_of(WAVEFRONT_TASKS, "sequential", "fpga"))
    steps, plan = drain(array.work(Job(PROBLEM, parameters)))
    apart, (points, arrived) = drain(alone.steps(Job(PROBLEM, parameters, plan=plan, position=AT)))
    assert cycles(apart) == cycles(steps, "track")
    assert arrived
    # Two cycles before the first step; then eight addresses and two cycles to the last word, for safe paths too.
    assert cycles(apart) == 2 + 10 * (3 if course is Course.LOCAL else len(points) - 1)
    part = load_platform("virtex2pro").components["fpga"].chip  # type: ignore[union-attr]
    demand = alone.demand(Job(PROBLEM, parameters, part=part))
    # Small beside any array, and as much memory as the potentials that are sent to it need.
    assert 0 < demand.total("slices") < array.demand(Job(PROBLEM, parameters, part=part)).total("slices") / 50
    (sent,) = [f.bits for f in WAVEFRONT_PLANNER.flows(Job(PROBLEM, parameters)) if f.name == "potentials"]
    depth, width = max(part.block_ram_shapes)
    assert demand.total("block_rams") >= sent / (depth * width)
    assert 0 < alone.clock_limit(Job(PROBLEM, parameters, part=part)).value <= part.block_ram_clock.value
    static, dynamic = alone.power(demand, 50_000_000, part)
    assert static == part.static_power
    assert 0 < dynamic.low < dynamic.value < dynamic.high


def test_descent_costs_the_same_by_itself() -> None:
    parameters = RelaxParameters(method="sor", omega=1.8, tolerance=1e-9)
    steps, plan = drain(RELAXATION[0].work(Job(PROBLEM, parameters)))
    apart, (points, _) = drain(RELAXATION_TASKS[0].steps(Job(PROBLEM, parameters, plan=plan, position=AT)))
    assert cycles(apart) == cycles(steps, "search") == SEARCH_UNITS * (len(points) - 1)
    # A drive asks for the next cell only, from wherever the robot is.
    for position in (AT, (-5.0, 0.0)):
        again, _ = drain(RELAXATION_TASKS[0].again(Job(PROBLEM, parameters, plan=plan, position=position)))
        assert [(step.phase, step.cycles.tolist()) for step in again] == [("search", [SEARCH_UNITS])]


@pytest.mark.parametrize("method", ["gs", "sor", "am", "mam", "red_black", "jacobi", "half_sweep_am", "direct"])
def test_sweeps_go_on_from_an_old_potential(method: str) -> None:
    closed = FREE.copy()
    closed[START[0] + 2, START[1] + 2] = False
    how: dict[str, Any] = {"method": method, "tolerance": 1e-10, "boundary": "high_walls"}
    if method in {"sor", "red_black", "am", "mam", "half_sweep_am"}:
        how["omega"] = 1.6
    if method == "mam":
        how["r"] = 1.5
    before = solve(FREE, [GOAL], **how)
    cold, warm = solve(closed, [GOAL], **how), solve(closed, [GOAL], start=before.potential, **how)
    assert np.abs(warm.potential - cold.potential).max() < 1e-7
    assert (warm.potential[~closed] == 1.0).all()
    assert warm.potential[GOAL] == 0.0
    if method != "direct":
        assert warm.iterations < cold.iterations
        # Nothing changed: one iteration tells, or a few where a mean of half sweeps is filled in at the end.
        assert solve(FREE, [GOAL], start=before.potential, **how).iterations <= 3


def test_a_start_is_part_of_what_is_remembered() -> None:
    parameters = RelaxParameters(method="sor", omega=1.8, tolerance=1e-9)
    memo = Memo()
    cold, plan = drain(RELAXATION[0].work(Job(PROBLEM, parameters, memo=memo)))
    warm, again = drain(RELAXATION[0].work(Job(PROBLEM, parameters, memo=memo, start=PLANNER.start_of(plan))))
    assert cycles(warm) < cycles(cold)
    assert again.solution.iterations < plan.solution.iterations


@pytest.mark.parametrize("start", [np.zeros((2, 2)), np.zeros(FREE.shape, int), np.full(FREE.shape, np.nan)])
def test_a_start_of_another_shape_or_no_number_is_refused(start: Any) -> None:
    with pytest.raises(InputError, match="a start of"):
        solve(FREE, [GOAL], method="sor", start=start)


def test_every_kernel_of_a_task_is_measured_and_shipped_hosts_have_its_cost() -> None:
    kernels = {style.kernel for style in catalog.task_styles().values() if style.kernel}
    assert kernels <= set(all_probes())
    for name in ("virtex2-pci", "virtex4-pci", "pc-epyc", "pc-3400mhz"):
        hosts = [part for part in load_platform(name).components.values() if part.type == "processor"]
        assert all(kernels <= set(host.costs) for host in hosts)


def test_software_refuses_laws_of_chips() -> None:
    task = style_of(WAVEFRONT_TASKS, "software")
    for call in (
        lambda: task.clock_limit(Job(PROBLEM, PropagateParameters())),
        lambda: task.power(task.demand(Job(PROBLEM, PropagateParameters())), 1, load_part("XC2V6000-4")),
    ):
        with pytest.raises(InputError, match="declare it in the platform"):
            call()
