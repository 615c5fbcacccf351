"""The circuits of Dubey et al. (2013): schedules, resources, power, and the paper's tables as golden values."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from findings_page import check_figures, check_statements, figures
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.figures import Status
from codesign.inputs import load_part, load_platform
from codesign.memo import Memo
from codesign.part import Part
from codesign.planners.reproduction import Reproduction, Use
from codesign.planners.styles import RESOURCES
from codesign.planners.velocity_obstacle import published
from codesign.planners.velocity_obstacle.paper.reproduce import velocity_obstacle
from codesign.planners.velocity_obstacle.plan import AvoidParameters, RobotsProblem, generate
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Detector, Responsibility, Unit
from codesign.planners.velocity_obstacle.plan.planner import PLANNER
from codesign.planners.velocity_obstacle.styles import ARCHITECTURES, Style, levers, power, resources
from codesign.planners.velocity_obstacle.styles.schedule import (
    DETECT,
    UPDATE,
    Task,
    Units,
    makespan,
    module_cycles,
    products,
    schedule,
    trial_cycles,
    trial_schedule,
)
from codesign.planners.velocity_obstacle.styles.timing import PHASES, cycles_of_trial, run_cycles
from codesign.system.fit import fit

CIRCUITS = {circuit.style: circuit for circuit in ARCHITECTURES}


@pytest.fixture(scope="module")
def part() -> Part:
    return load_part("XC3S500E-4")


@pytest.fixture(scope="module")
def problem() -> RobotsProblem:
    return generate("circle", 3, arena=(90.0, 90.0), seed=2)


def drained(steps: Any) -> tuple[list[Any], Any]:
    found = []
    while True:
        try:
            found.append(next(steps))
        except StopIteration as done:
            return found, done.value


# Schedules


@pytest.mark.parametrize("robots", range(2, 65))
def test_the_laws_of_table_ii_come_out_of_the_units(robots: int) -> None:
    parameters = AvoidParameters()
    assert cycles_of_trial(Style.SEQUENTIAL, robots, parameters) == 17 * robots - 10
    assert cycles_of_trial(Style.PIPELINED, robots, parameters) == 10 * robots + 4
    assert cycles_of_trial(Style.HYBRID, robots, parameters) == 17


def test_table_ii_is_met_exactly() -> None:
    for style, listed in published.TABLE_II.items():
        for robots, cycles in listed.items():
            assert cycles_of_trial(style, robots, AvoidParameters()) == cycles


def test_cycles_of_the_modules_come_out_of_their_products() -> None:
    assert (len(products(UPDATE)), len(products(DETECT))) == (6, 9)
    assert module_cycles(UPDATE, Unit.SERIAL) == published.UPDATE_CYCLES
    assert module_cycles(DETECT, Unit.SERIAL) == published.DETECT_CYCLES
    assert module_cycles(UPDATE, Unit.PARALLEL) == 2
    assert module_cycles(DETECT, Unit.PARALLEL) == 3
    assert module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT) == 7
    assert module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT, approaching=True) == 9
    assert module_cycles(DETECT, Unit.SERIAL, Detector.PUBLISHED, approaching=True) == 10


def test_other_unit_counts_lie_between_the_published_styles() -> None:
    lanes = [trial_cycles(8, Units(count, count), 7, 10) for count in range(1, 9)]
    assert lanes[0] == 84
    assert lanes[-1] == 17
    assert all(later <= earlier for earlier, later in pairwise(lanes))
    # A second detector alone: the one update unit is then the limit, n updates and the last detection.
    assert trial_cycles(8, Units(1, 2), 7, 10) == 7 * 8 + 10


@settings(max_examples=100, deadline=None)
@given(
    st.integers(2, 20),
    st.integers(1, 20),
    st.integers(1, 20),
    st.integers(1, 12),
    st.integers(1, 12),
    st.booleans(),
)
def test_a_schedule_keeps_its_rules_and_bounds(
    robots: int, update: int, detect: int, update_cycles: int, detect_cycles: int, shared: bool
) -> None:
    slots = trial_schedule(robots, Units(update, detect, shared), update_cycles, detect_cycles)
    ends = [slot.end for slot in slots]
    for slot in slots:
        assert all(ends[earlier] <= slot.begin for earlier in slot.task.after)
    lanes: dict[tuple[str, int], list[tuple[int, int]]] = {}
    for slot in slots:
        lanes.setdefault((slot.task.unit, slot.unit), []).append((slot.begin, slot.end))
    assert len(lanes) <= (1 if shared else update + detect)
    for busy in lanes.values():
        assert all(first[1] <= second[0] for first, second in pairwise(sorted(busy)))
    length = makespan(slots)
    work = robots * update_cycles, (robots - 1) * detect_cycles
    counts = (1, 1) if shared else (update, detect)
    least = max(
        update_cycles + detect_cycles, *(-(-one // count) for one, count in zip(work, counts, strict=True))
    )
    assert least <= length <= sum(work)
    if shared:
        assert length == sum(work)


def test_the_list_schedule_is_the_best_one_for_few_robots() -> None:
    """Against all orders of the updates and detections, tried one by one."""
    from itertools import permutations

    def greedy(order: tuple[int, ...], tasks: list[Task], counts: dict[str, int]) -> int:
        free = {kind: [0] * count for kind, count in counts.items()}
        ends: dict[int, int] = {}
        waiting = list(order)
        while waiting:
            index = next(one for one in waiting if all(earlier in ends for earlier in tasks[one].after))
            waiting.remove(index)
            task = tasks[index]
            lane = min(range(len(free[task.unit])), key=lambda one: free[task.unit][one])
            begin = max([free[task.unit][lane], *(ends[earlier] for earlier in task.after)])
            ends[index] = free[task.unit][lane] = begin + task.cycles
        return max(ends.values())

    for update, detect in ((1, 1), (1, 2), (2, 1), (2, 2)):
        tasks = [slot.task for slot in trial_schedule(4, Units(update, detect), 7, 10)]
        counts = {UPDATE: update, DETECT: detect}
        best = min(greedy(order, tasks, counts) for order in permutations(range(len(tasks))))
        assert makespan(schedule(tasks, counts)) == best


# Resources


def test_table_i_within_its_rounding(part: Part) -> None:
    for style, (slices, luts, _) in published.TABLE_I.items():
        need = levers.totals(style, 2, AvoidParameters(), part)
        assert abs(100 * need["lut4"] / 9312 - luts) <= 0.5
        assert abs(100 * need["slices"] / 4656 - slices) <= 0.5


@pytest.mark.parametrize(("robots", "wanted"), [(2, 6), (4, 16), (8, 36)])
def test_multipliers_of_the_hybrid_circuit(robots: int, wanted: int, part: Part) -> None:
    assert levers.totals(Style.HYBRID, robots, AvoidParameters(), part)["multipliers"] == wanted
    assert levers.totals(Style.PIPELINED, robots, AvoidParameters(), part)["multipliers"] == 5


@pytest.mark.parametrize(("width", "wanted"), [(16, 4), (17, 8), (18, 9)])
def test_multipliers_of_a_detector_as_synthesised(width: int, wanted: int) -> None:
    passive = AvoidParameters(width=width, responsibility=Responsibility.FULL)
    assert resources.unit_multipliers(DETECT, passive) == wanted
    assert resources.unit_multipliers(UPDATE, passive) == 1


def test_parallel_units_as_synthesised() -> None:
    parallel = AvoidParameters(unit=Unit.PARALLEL)
    assert resources.unit_multipliers(UPDATE, parallel) == 6
    assert resources.unit_multipliers(DETECT, parallel) == 18
    passive = parallel.model_copy(update={"responsibility": Responsibility.FULL})
    assert resources.unit_multipliers(DETECT, passive) == 18


@settings(max_examples=200, deadline=None)
@given(st.integers(8, 24), st.booleans(), st.data())
def test_factors_of_a_detector_fit_the_bits_they_are_given(width: int, half: bool, data: Any) -> None:
    responsibility = Responsibility.HALF if half else Responsibility.FULL
    bits = resources.factor_bits(AvoidParameters(width=width, responsibility=responsibility))
    limit = 2 ** (width - 1)
    component = st.one_of(st.sampled_from([-limit, limit - 1]), st.integers(-limit, limit - 1))
    x, y = (data.draw(component) - data.draw(component) for _ in range(2))
    # Velocities are bounded as vectors: each of a length below the limit.
    lengths = [data.draw(st.tuples(component, component)) for _ in range(3)]
    own, now, other = ((a * 7 // 10, b * 7 // 10) for a, b in lengths)
    vx, vy = ((2 * a - b - c) if half else (a - c) for a, b, c in zip(own, now, other, strict=True))
    values = {
        "rx": x,
        "ry": y,
        "vx": vx,
        "vy": vy,
        "r_sq": x * x + y * y,
        "vab_sq": vx * vx + vy * vy,
        "dotp": x * vx + y * vy,
        "cross": x * vy - y * vx,
    }
    for name, value in values.items():
        assert abs(value) <= 2 ** bits[name], name


def test_hybrid_with_8_robots_is_infeasible_by_three_budgets_and_says_what_mends_it(part: Part) -> None:
    parameters = AvoidParameters()
    problem = generate("circle", 8)
    circuit = CIRCUITS["hybrid"]
    held = fit(
        circuit.demand(problem, parameters, part),
        part,
        50_000_000,
        circuit.clock_limit(problem, parameters, part),
    )
    reasons = {reason.name: reason for reason in held.reasons}
    assert set(reasons) == {"slices", "lut4", "multipliers"}
    assert (reasons["multipliers"].demand, reasons["multipliers"].limit) == (36, 20)
    advice = " ".join(reasons["multipliers"].levers)
    assert "4, with 4 detect_units, fit XC3S500E, 27 cycles" in advice
    assert "pipelined fits XC3S500E, 84 cycles" in advice
    assert "at least 36 multipliers" in advice
    mended = AvoidParameters(update_units=4, detect_units=4)
    assert not levers.shortages(Style.HYBRID, 8, mended, part)
    assert cycles_of_trial(Style.HYBRID, 8, mended) == 27
    for update, detect in ((5, 4), (4, 5)):
        more = AvoidParameters(update_units=update, detect_units=detect)
        assert levers.shortages(Style.HYBRID, 8, more, part)


@pytest.mark.parametrize("kind", ["update_units", "detect_units"])
def test_the_sequential_style_refuses_units_that_it_cannot_have(kind: str, part: Part) -> None:
    problem = generate("circle", 8)
    for style, circuit in CIRCUITS.items():
        for count in (None, 1, 2, 4):
            parameters = AvoidParameters.model_validate({kind: count})
            limit = circuit.clock_limit(problem, parameters, part)
            held = fit(circuit.demand(problem, parameters, part), part, 50_000_000, limit)
            refused = [reason for reason in held.reasons if reason.name == f"{kind} of the sequential style"]
            assert bool(refused) == (style == "sequential" and (count or 1) > 1)
            for reason in refused:
                assert (reason.demand, reason.limit) == (count, 1)
                assert f"avoid.{kind}: 1, or left out" in " ".join(reason.levers)


@pytest.mark.parametrize("robots", [2, 4])
def test_hybrid_with_2_and_4_robots_fits(robots: int, part: Part) -> None:
    assert not levers.shortages(Style.HYBRID, robots, AvoidParameters(), part)


def test_every_lever_names_a_lanes_that_fits(part: Part) -> None:
    for robots in (5, 8, 12, 16):
        for width in (16, 18):
            parameters = AvoidParameters(width=width)
            lanes = levers.widest_lanes(robots, parameters, part)
            assert lanes is not None
            assert not levers.shortages(Style.HYBRID, robots, lanes, part)


@settings(max_examples=60, deadline=None)
@given(st.integers(2, 63), st.sampled_from(Style), st.integers(8, 23))
def test_demand_never_falls_with_robots_or_width(robots: int, style: Style, width: int) -> None:
    part = load_part("XC3S500E-4")
    parameters = AvoidParameters(width=width)
    need = levers.totals(style, robots, parameters, part)
    more_robots = levers.totals(style, robots + 1, parameters, part)
    wider = levers.totals(style, robots, parameters.model_copy(update={"width": width + 1}), part)
    for kind in RESOURCES:
        assert more_robots[kind] >= need[kind]
        assert wider[kind] >= need[kind]


def test_the_mapper_packs_denser_only_near_the_end() -> None:
    ratio = resources.slice_ratio(Style.HYBRID)
    assert resources.slices_of(Style.HYBRID, 6518, 4656) == int(np.ceil(ratio * 3259))
    assert resources.slices_of(Style.HYBRID, 8320, 4656) == int(0.97 * 4656)
    assert resources.slices_of(Style.HYBRID, 9200, 4656) == 4600
    assert resources.slices_of(Style.HYBRID, 11_924, 4656) == 5962


def test_an_array_too_large_for_a_block_ram_is_a_bound(part: Part) -> None:
    large = AvoidParameters(directions=512, speeds=64)
    (bound,) = CIRCUITS["pipelined"].demand(generate("circle", 2), large, part).bounds
    assert bound.demand == 512 * 64 > bound.limit == 16_384
    assert "at most 32" in bound.levers[0].advice


# Power


def test_power_is_fitted_to_2_and_4_robots_and_holds_for_8() -> None:
    law = power.power_fit()
    assert law.form == "√n"
    assert all(abs(law.power(style, n) / mw - 1) < 0.02 for style, n, mw in power.rows((2, 4)))
    assert power.power_miss() == pytest.approx(0.031, abs=0.001)
    assert all(law.residual <= power.fit_power(form).residual for form in power.FORMS)


def test_intervals_of_power_hold_every_row(part: Part) -> None:
    for style, listed in published.TABLE_III.items():
        for robots, milliwatts in listed.items():
            demand = CIRCUITS[style].demand(generate("circle", robots), AvoidParameters(), part)
            static, dynamic = CIRCUITS[style].power(demand, published.CLOCK, part)
            low, high = dynamic.interval
            assert low <= milliwatts / 1e3 - static.value <= high
            assert dynamic.status is Status.CALIBRATED


def test_dynamic_power_follows_the_clock_and_another_part_is_assumed(part: Part) -> None:
    circuit = CIRCUITS["pipelined"]
    demand = circuit.demand(generate("circle", 4), AvoidParameters(), part)
    slow, fast = (circuit.power(demand, clock, part)[1].value for clock in (25_000_000, 50_000_000))
    assert fast == pytest.approx(2 * slow)
    other = circuit.power(demand, 50_000_000, load_part("XC2VP30-6"))[1]
    assert other.status is Status.ASSUMED


# Work


@pytest.mark.parametrize("style", list(CIRCUITS))
def test_coarse_and_fine_steps_cost_the_same(style: str, problem: RobotsProblem) -> None:
    circuit, parameters, memo = CIRCUITS[style], AvoidParameters(), Memo()
    plan = PLANNER.plan(problem, parameters)
    told = []
    for detail in (True, False, False):
        steps, drawn = drained(circuit.work(problem, parameters, memo=memo, detail=detail))
        assert PLANNER.identity(drawn) == PLANNER.identity(plan)
        assert all(int(step.cycles.min()) >= 1 for step in steps if len(step.cycles))
        sums: dict[str, int] = {}
        for step in steps:
            sums[step.phase] = sums.get(step.phase, 0) + int(step.cycles.sum())
        told.append(sums)
    assert memo.hits == 1
    assert told[0] == told[1] == told[2]
    assert set(told[0]) == set(PHASES)
    cycles = run_cycles(Style(style), plan, parameters)
    assert sum(told[0].values()) == int(cycles.each.sum())


def test_an_update_takes_as_long_as_its_slowest_robot(problem: RobotsProblem) -> None:
    parameters = AvoidParameters()
    plan = PLANNER.plan(problem, parameters)
    cycles = run_cycles(Style.PIPELINED, plan, parameters)
    assert (cycles.each >= cycles.costs.of_robot(plan.checks, plan.trials).max(axis=1)).all()
    assert (cycles.trials[:, None] * cycles.costs.trial <= cycles.each[:, None]).all()


def test_units_change_cycles_and_no_choice(problem: RobotsProblem) -> None:
    memo = Memo()
    found = set()
    for update, detect, detector in ((None, None, "published"), (2, 1, "published"), (1, 2, "cross_product")):
        parameters = AvoidParameters(update_units=update, detect_units=detect, detector=Detector(detector))
        steps, plan = drained(CIRCUITS["hybrid"].work(problem, parameters, memo=memo, detail=False))
        found.add(PLANNER.identity(plan))
        assert steps
    assert len(found) == 1
    assert (memo.misses, memo.hits) == (1, 2)
    other = AvoidParameters(detection=Detection.PUBLISHED, margin=0.0)
    drained(CIRCUITS["hybrid"].work(problem, other, memo=memo, detail=False))
    assert memo.misses == 2


def test_records_tell_every_phase_of_an_update(problem: RobotsProblem) -> None:
    steps, plan = drained(CIRCUITS["sequential"].work(problem, AvoidParameters()))
    stories = [step.record(0, int(step.cycles.sum()), "fpga") for step in steps]
    assert [story.task for story in stories[:5]] == list(PHASES)
    assert all(story.cycles == story.end for story in stories)
    assert sum(story.task == "pid" for story in stories) == plan.updates


# Platform and reproduction


def test_the_platform_is_the_board_of_the_paper() -> None:
    platform = load_platform("nexys2")
    component = platform.components["fpga"]
    assert component.clock.value == published.CLOCK
    assert component.part.startswith(published.PART)


@pytest.fixture(scope="module")
def reproduction() -> Reproduction:
    return velocity_obstacle(quick=True)


def test_every_row_of_the_paper_is_there(reproduction: Reproduction) -> None:
    tables = [row.table for row in reproduction.rows]
    assert (tables.count("Table I"), tables.count("Table II"), tables.count("Table III")) == (9, 9, 9)
    held_out = [
        row
        for row in reproduction.rows
        if row.use is Use.HELD_OUT and row.table == "Table III" and row.error is not None
    ]
    assert len(held_out) == 2
    known = [row.quantity for row in reproduction.rows if row.use is Use.KNOWN]
    runs = [f"{robots} robots, full run: updates" for robots in (2, 4, 8)]
    assert known == ["hybrid, 4 robots, on XC3S500E", *runs]
    assert all(abs(row.error or 1.0) < 0.04 for row in held_out)
    assert all(row.error == 0 for row in reproduction.rows if row.table == "Table II")
    fits = {
        row.quantity: (row.published, row.modelled)
        for row in reproduction.rows
        if "on XC3S500E" in row.quantity
    }
    assert all(said == found for said, found in fits.values())
    assert len(fits) == 3


def test_runs_of_the_reproduction_have_no_collision(reproduction: Reproduction) -> None:
    rows = {row.quantity: row.modelled for row in reproduction.rows}
    for robots in (2, 4, 8):
        assert rows[f"{robots} robots, full run: collisions"] == 0
        assert rows[f"{robots} robots, full run: robots that arrived"] == robots
        assert 400 <= rows[f"{robots} robots, full run: updates"] <= 500
    share = rows["same velocity chosen in fixed point and in doubles"]
    assert isinstance(share, float)
    assert share > 90.0


def test_findings_are_made_from_the_data(reproduction: Reproduction) -> None:
    check_statements(reproduction)
    same = ["A power law", "The sequential", "The pipelined", "The LUTs", "The hybrid", "Six products"]
    check_figures(reproduction, [*same, "Table II", "The serial port", "Reconfiguring"])
    assert figures(reproduction, "Equation 4")["and a margin of one cell: collisions"] == "0"
    assert figures(reproduction, "Where 16 bits")["beyond the bound"] == "0"
    assert reproduction.note.startswith("A quick run")
    assert {plot.name for plot in reproduction.figures} == {
        "dubey2013-cycles",
        "dubey2013-power",
        "dubey2013-ways",
    }
