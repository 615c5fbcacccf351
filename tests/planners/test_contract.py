"""The shipped suite on every installed plug-in, and figures that the planners measured here have to keep."""

from __future__ import annotations

from dataclasses import replace

import pytest

from codesign.ground.figures import RESOURCES
from codesign.ground.memo import Memo
from codesign.planners.interface import COMMAND, LOAD, LOWER_BOUND
from codesign.planners.plug_in import Samples
from codesign.system import catalog
from codesign.testing import Case, PlugInContract, cases_of
from codesign.testing.case import drained


class TestInstalledPlugIns(PlugInContract):
    """Every plug-in that is installed, ours included."""


CASES = [case for plug_in in catalog.plug_ins() for case in cases_of(plug_in)]
each_case = pytest.mark.parametrize("case", CASES, ids=str)


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

ANSWER_COUNTED = {
    ("harmonic", "bit_serial"),
    ("wavefront", "delay_line"),
    ("wavefront", "adder_comparator"),
    ("wavefront", "tiled"),
}
"""Planners and styles that have lines of the demand for the answering task."""

each_measured_case = pytest.mark.parametrize("case", [case for case in CASES if case.planner.name in SENT], ids=str)


@each_measured_case
def test_flows_bring_what_one_plan_sends(case: Case) -> None:
    flows = case.planner.flows(case.job)
    ends = [(flow.sender, flow.receiver, flow.bits) for flow in flows]
    brought = [bits for *way, bits in ends if way == [LOAD, case.planner.planning_task]]
    answered = [bits for _, receiver, bits in ends if receiver == COMMAND]
    assert (brought, answered) == tuple([bits] for bits in SENT[case.planner.name])


@each_measured_case
def test_the_answering_task_has_a_phase_of_its_own(case: Case) -> None:
    for style in case.styles:
        whole = set(case.work(style).phases)
        gone = whole - set(case.work(style, inside=case.answer_elsewhere).phases)
        # Software that searches breadth first has its path in the cost of a cell.
        in_the_kernel = (case.planner.name, style.component_type) == ("breadth_first", "processor")
        assert len(gone) == (0 if case.answer == case.planner.planning_task or in_the_kernel else 1)


@each_measured_case
def test_only_circuits_of_this_package_count_what_the_answering_task_takes(case: Case) -> None:
    for style in case.styles:
        whole, left = case.demand(style), case.demand(style, case.answer_elsewhere)
        less = {kind for kind in RESOURCES if left.total(kind) < whole.total(kind)}
        takes_less = (case.planner.name, style.style) in ANSWER_COUNTED
        assert less == ({"slices", "lut4", "flip_flops"} if takes_less else set())
        if style.component_type == "fpga":
            powers = [style.power(demand, 50_000_000, case.part) for demand in (whole, left)]
            assert (powers[1][1].value < powers[0][1].value) == bool(less)


@each_measured_case
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
        (ended,) = cases_of(replace(case.plug_in, samples=Samples(parameters=[{**case.given, "stop": "schedule_end"}])))
        ((_, maker),) = catalog.task_styles_of(case.planner.name, LOWER_BOUND).items()
        bound = drained(maker.steps(ended.job))
        assert bound.cycles == int(ended.problem.free.sum())
        for style in ended.styles:
            cold, warm = ended.work(style), ended.work(style, start=bound.result)
            assert ended.same(warm.result)
            assert warm.phases["relax"] < cold.phases["relax"]
