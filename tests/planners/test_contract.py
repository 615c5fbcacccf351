"""The shipped suite on our five planners, and the figures that only they have to keep."""

from __future__ import annotations

import pytest

from codesign.figures import RESOURCES
from codesign.memo import Memo
from codesign.planners.breadth_first.plug_in import PLUG_IN as BREADTH_FIRST
from codesign.planners.harmonic.plug_in import PLUG_IN as HARMONIC
from codesign.planners.interface import COMMAND, LOAD, LOWER_BOUND
from codesign.planners.relaxation.plug_in import PLUG_IN as RELAXATION
from codesign.planners.velocity_obstacle.plug_in import PLUG_IN as VELOCITY_OBSTACLE
from codesign.planners.wavefront.plug_in import PLUG_IN as WAVEFRONT
from codesign.system import catalog
from codesign.testing import Case, PlugInContract, cases_of
from codesign.testing.case import drained


class TestHarmonic(PlugInContract):
    plug_in = HARMONIC
    parameters = (
        {"block": (12, 16), "iterations": 6, "schedule": (7, 15, 23)},
        {"blocks": (3, 2), "iterations": 1, "schedule": (9, 40), "termination": "published"},
        {"blocks": (1, 1), "iterations": 40, "schedule": (70,), "stop": "schedule_end"},
    )


class TestBreadthFirst(PlugInContract):
    plug_in = BREADTH_FIRST
    parameters = ({}, {"micro_architecture": "pipelined"})


class TestWavefront(PlugInContract):
    plug_in = WAVEFRONT
    parameters = ({}, {"stop": "starts"}, {"paths": "safe", "tile": (8, 8)})


class TestVelocityObstacle(PlugInContract):
    plug_in = VELOCITY_OBSTACLE
    parameters = ({}, {"updates": 40})
    problems = tuple({"robots": {"count": count, "arrangement": "circle"}} for count in (4, 5))


class TestRelaxation(PlugInContract):
    plug_in = RELAXATION
    parameters = (
        {"method": "sor", "omega": 1.8, "tolerance": 1e-9},
        {"method": "mam", "omega": 1.7, "r": 1.5},
        {"method": "direct"},
    )


SUITES = (TestHarmonic, TestBreadthFirst, TestWavefront, TestVelocityObstacle, TestRelaxation)
CASES = [case for suite in SUITES for case in cases_of(suite.plug_in, suite.parameters, suite.problems)]
each_case = pytest.mark.parametrize("case", CASES, ids=str)


def test_every_installed_plug_in_runs_the_suite() -> None:
    assert [each for each in catalog.plug_ins() if each not in [suite.plug_in for suite in SUITES]] == []


@each_case
def test_the_catalog_has_what_the_plug_in_registers(case: Case) -> None:
    name = case.planner.name
    assert catalog.planners()[name] is case.planner
    assert tuple(catalog.styles_of(name).values()) == case.styles
    assert tuple(each for each in catalog.task_styles().values() if each.planner == name) == case.task_styles


# Bits of the map (or the robots) and of the answer, on the suite's problem, where parameters do not change them.
SENT: dict[str, tuple[int, int]] = {
    "harmonic": (2 * 24 * 32, 64),
    "breadth_first": (2 * 24 * 32, 2 * 3),
    "wavefront": (2 * 24 * 32, 64),
    "relaxation": (2 * 24 * 32, 64),
    "velocity_obstacle": (4 * 4 * 16, 4 * 2 * 16),
}


@each_case
def test_flows_bring_what_one_plan_sends(case: Case) -> None:
    flows = case.planner.flows(case.problem, case.parameters)
    ends = [(flow.sender, flow.receiver, flow.bits) for flow in flows]
    brought = [bits for *way, bits in ends if way == [LOAD, case.planner.planning_task]]
    answered = [bits for _, receiver, bits in ends if receiver == COMMAND]
    assert (brought, answered) == tuple([bits] for bits in SENT[case.planner.name])


@each_case
def test_the_answering_task_has_a_phase_of_its_own(case: Case) -> None:
    for style in case.styles:
        whole = set(case.work(style).phases)
        gone = whole - set(case.work(style, inside=case.answer_elsewhere).phases)
        # Software that searches breadth first has its path in the cost of a cell.
        in_the_kernel = (case.planner.name, style.component_type) == ("breadth_first", "processor")
        assert len(gone) == (0 if case.answer == case.planner.planning_task or in_the_kernel else 1)


@each_case
def test_only_published_circuits_tell_what_the_answering_task_takes(case: Case) -> None:
    for style in case.styles:
        whole, left = case.demand(style), case.demand(style, case.answer_elsewhere)
        less = {kind for kind in RESOURCES if left.total(kind) < whole.total(kind)}
        known = (case.planner.name, style.style) == ("harmonic", "bit_serial")
        assert less == ({"slices", "lut4", "flip_flops"} if known else set())
        if style.component_type == "fpga":
            powers = [style.power(demand, 50_000_000, case.part) for demand in (whole, left)]
            assert (powers[1][1].value < powers[0][1].value) == bool(less)


@each_case
def test_coarse_runs_share_what_the_memo_holds(case: Case) -> None:
    for style in case.styles:
        memo = Memo()
        for _ in range(2):
            case.work(style, memo=memo, detail=False)
        assert memo.hits, "the second coarse run found nothing to share"


def test_a_lower_bound_ends_in_the_same_bits_with_fewer_cycles() -> None:
    lower = [case for case in CASES if "lower_bound" in case.planner.policies]
    assert lower
    for case in lower:
        (ended,) = cases_of(case.plug_in, [{**case.given, "stop": "schedule_end"}])
        ((_, maker),) = catalog.task_styles_of(case.planner.name, LOWER_BOUND).items()
        bound = drained(maker.steps(ended.problem, ended.parameters, None, (0.0, 0.0)))
        assert bound.cycles == int(ended.problem.free.sum())
        for style in ended.styles:
            cold, warm = ended.work(style), ended.work(style, start=bound.made)
            assert ended.same(warm.made)
            assert warm.phases["relax"] < cold.phases["relax"]
