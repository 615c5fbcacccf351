"""Points priced side by side, against a simulation of each of them."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES
from codesign.ground.memo import Memo
from codesign.inputs import Platform, Workload, design_point
from codesign.inputs.exploration import Exploration
from codesign.study.blocks import block_of, plan_of, read_block, read_plan
from codesign.study.bounds import least
from codesign.study.evaluation import Pricer
from codesign.study.explored import Explored
from codesign.study.partition import Alone, Together, apart, parted
from codesign.study.pricing.computation import Computation, record
from codesign.study.pricing.price import PRICED, Priced, why_alone
from codesign.study.shared import Parts
from codesign.study.space import Space
from codesign.study.store import EntryState
from codesign.system.results.result import Result
from codesign.system.scenarios import bind, simulate

SMALL = {
    "harmonic": "  relax: {component: fabric, block: [6, 9], iterations: 6, schedule: {first: 7, step: 8, last: 31}}",
    "decide elsewhere": "  relax: {component: fabric, block: [6, 9], iterations: 4, schedule: [15, 31]}\n"
    "  decide: {component: host}",
    "host": "  relax: {component: host, block: [6, 9], iterations: 4, schedule: [15, 31]}",
    "breadth_first": "  search: {component: fabric}",
    "wavefront": "  propagate: {component: fabric, style: tiled, tile: [6, 9], paths: shortest}",
}
"""Mappings on a map of 12 × 18 cells, by what they show."""

BESIDE = {
    "components": {"spare": {"type": "fpga", "part": "XC3S500E-4", "clock": "50 MHz"}},
    "links": {"line": {"type": "ideal", "between": ["host", "spare"]}},
}
"""A board beside the one that plans."""

ON_BOTH = {
    "two boards": "  relax: {component: fpga, block: [6, 9], iterations: 4, schedule: [15, 31], pockets: filled}\n"
    "  decide: {component: spare}\n  load: {component: host}"
}

TASKS = ("task: path, starts: {count: 5, seed: 1}", "task: field, starts: {count: 3, seed: 1}")


def workload_of(folder: Path, name: str, task: str = TASKS[0]) -> Workload:
    planner = name if name in ("breadth_first", "wavefront") else "harmonic"
    path = folder / "small.yaml"
    path.write_text(
        f"kind: workload\nname: small\nplanner: {planner}\nproblem:\n"
        "  map: {generate: rooms, rows: 12, columns: 18, room: [5, 5], door: 2, seed: 3}\n"
        f"  goals: [[2, 2]]\n  {task.replace(', starts', chr(10) + '  starts')}\nmapping:\n{(SMALL | ON_BOTH)[name]}\n"
    )
    return codesign.load_workload(path)


def explored_of(platform: Platform, workload: Workload, axes: Mapping[str, Sequence[Any]]) -> Explored:
    section = Exploration(axes={name: tuple(values) for name, values in axes.items()})
    return Explored.of(platform, workload.model_copy(update={"explore": section}))


def priced_of(platform: Platform, workload: Workload, axes: Mapping[str, Sequence[Any]]) -> list[Any]:
    """Each point's axes, with the outcomes that it was priced in and its place there; None: simulated by itself."""
    explored = explored_of(platform, workload, axes)
    space = Space(explored.section.every_axis, "")
    pricer = Pricer(explored, space)
    points: list[Any] = [None] * len(space)
    works = [*parted(explored, space, np.arange(len(space)))]
    # All at once: the groups of one kind are priced side by side.
    for work, done in zip(works, pricer.batch(works, math.inf)[0], strict=True):
        for place, index in enumerate(work.indices):
            points[index] = (space.values(index), done.priced, place)
    return points


def assert_equal(priced: Priced, place: int, result: Result) -> None:
    """A priced point has every figure, every end of an interval and every reason of the result."""
    template = priced.templates[priced.which[place]]
    for name, figure in FIGURES.items():
        value: float | None = priced.figures[name][place] if name in PRICED else template.figure(figure)
        assert (None if value is None or np.isnan(value) else value) == result.figure(figure), name
    for name in PRICED:
        ends = priced.lows[name][place], priced.highs[name][place]
        assert (None if np.isnan(ends[0]) else ends) == result.interval(FIGURES[name]), name
    late = priced.reason[place]
    assert (*template.reasons, *([priced.reasons[late]] if late >= 0 else [])) == result.reasons
    assert (template.feasible and late < 0) == result.feasible
    assert template.resources == result.resources
    assert (template.part, template.places, template.parameters) == (result.part, result.places, result.parameters)
    if result.task is not None:
        assert template.task is not None
        assert (template.task.question, template.task.arrive) == (result.task.question, result.task.arrive)
    for name, link in (result.links or {}).items() if result.feasible else ():
        assert template.links is not None
        assert template.links[name] == link.model_copy(update={"utilisation": 0.0, "queued_s": 0.0})
    for name, share in (template.utilisation or {}).items() if result.feasible else ():
        assert result.utilisation is not None
        assert (result.utilisation[name] > 0) == (share > 0), name


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("name", SMALL)
def test_priced_points_equal_their_simulations(tmp_path: Path, name: str, task: str) -> None:
    workload = workload_of(tmp_path, name, task)
    platform = codesign.load_platform("virtex4-pci")
    axes = {
        "fabric.part": ["XC2V6000-4", "XC4VLX160-12"],
        "fabric.clock": ["33333333 Hz", "100 MHz", "400 MHz"],
        "pci.clock": ["33 MHz", "47123457 Hz"],
        "pci.burst_words": [4, 64],
        "host.costs.way_following": ["1 us", "3.6 us"],
    }
    memo = Memo()
    points = priced_of(platform, workload, axes)
    assert len(points) == 48
    assert sum(priced is None for _, priced, _ in points) == 8, "400 MHz is above the block RAMs of the XC2V6000-4"
    for values, priced, place in points:
        if priced is None:
            with pytest.raises(SpecError):
                design_point(platform, workload, values)
            continue
        assert_equal(priced, place, simulate(*design_point(platform, workload, values), memo=memo))


@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_prices(tmp_path: Path, data: st.DataObject) -> None:
    name = data.draw(st.sampled_from(sorted(SMALL)))
    workload = workload_of(tmp_path, name, data.draw(st.sampled_from(TASKS)))
    platform = codesign.load_platform(data.draw(st.sampled_from(["zynq", "nexys2", "virtex4-pci"])))
    hertz = st.integers(10**5, 10**9).map("{} Hz".format)
    axes: dict[str, Any] = {"fabric.clock": data.draw(st.lists(hertz, min_size=1, max_size=3, unique=True))}
    for link, spec in platform.links.items():
        if spec.type == "serial":
            axes[f"{link}.baud"] = data.draw(st.lists(st.integers(300, 10**7), min_size=1, max_size=2, unique=True))
        elif spec.type == "bus":
            axes[f"{link}.width"] = data.draw(
                st.lists(st.sampled_from([8, 16, 32, 64]), min_size=1, max_size=2, unique=True)
            )
    for values, priced, place in priced_of(platform, workload, axes):
        if priced is None:
            # Only a point that no run accepts has no price: its clock is too fast, or a cost is missing.
            with pytest.raises(SpecError):
                simulate(*design_point(platform, workload, values))
            continue
        assert_equal(priced, place, simulate(*design_point(platform, workload, values)))


@pytest.mark.parametrize("name", ["harmonic", "host", "breadth_first", "wavefront"])
def test_a_bound_of_one_machine_on_which_nothing_waits_is_what_it_costs(tmp_path: Path, name: str) -> None:
    """All edges of the two clocks are one; what is rounded up to picoseconds aside."""
    workload, platform = workload_of(tmp_path, name), codesign.load_platform("virtex4-pci")
    explored = explored_of(platform, workload, {"fabric.clock": ["50 MHz"], "pci.clock": ["50 MHz"]})
    (work,) = parted(explored, Space(explored.section.every_axis, ""), np.arange(1))
    assert isinstance(work, Together)
    point = design_point(platform, workload, {"fabric.clock": "50 MHz", "pci.clock": "50 MHz"})
    system, result = bind(*point), simulate(*point)
    bounds = least(system, work.specs, work.specs, record(system, Memo()))
    for figure, (bound,) in bounds.items():
        value = result.figure(FIGURES[figure])
        assert value is not None
        assert bound <= value <= bound * (1 + 1e-5), figure


def test_work_on_another_board_and_before_the_map_is_sent_is_priced(tmp_path: Path) -> None:
    tree = codesign.load_platform("virtex4-pci").document.tree
    tree = {**tree, **{kind: {**tree[kind], **more} for kind, more in BESIDE.items()}}
    platform = codesign.load_platform(tree)
    workload = workload_of(tmp_path, "two boards")
    axes = {"fpga.clock": ["60 MHz", "100 MHz"], "spare.clock": ["31 MHz", "50 MHz"]}
    for values, priced, place in priced_of(platform, workload, axes):
        assert priced is not None
        assert_equal(priced, place, simulate(*design_point(platform, workload, values)))


def test_what_is_drawn_from_the_memory_of_the_design_is_simulated_by_itself() -> None:
    platform, workload = codesign.load_platform("virtex2pro-vga"), codesign.load_workload("breadth-first")
    assert why_alone(bind(platform, workload)).startswith("display screen takes cycles of the memory")
    point = design_point(platform, workload, {"search.component": "powerpc", "search.style": "software"})
    assert "display" not in why_alone(bind(*point))


def test_a_replan_is_priced_from_the_change_on(tmp_path: Path) -> None:
    workload = workload_of(
        tmp_path, "harmonic", "task: replan, starts: {count: 2, seed: 1}\n  change: {blocked: [[6, 9]]}"
    )
    platform = codesign.load_platform("virtex4-pci")
    for values, priced, place in priced_of(platform, workload, {"fabric.clock": ["90 MHz", "100 MHz"]}):
        assert priced is not None
        assert_equal(priced, place, simulate(*design_point(platform, workload, values)))


def test_a_computation_reads_back(tmp_path: Path) -> None:
    system = bind(codesign.load_platform("virtex4-pci"), workload_of(tmp_path, "harmonic"))
    computation = record(system, Memo())
    again = Computation.read(computation.model_dump_json())
    assert again == computation


def test_blocks_read_back_and_refuse_what_is_cut(tmp_path: Path) -> None:
    platform, workload = codesign.load_platform("virtex4-pci"), workload_of(tmp_path, "wavefront")
    axes = {"fabric.clock": ["1 MHz", "100 MHz", "400 MHz"], "pci.width": [16, 32]}
    explored = explored_of(platform, workload, axes)
    space = Space(explored.section.every_axis, "")
    (work,) = parted(explored, space, np.arange(len(space)))
    priced = Pricer(explored, space)(work).priced
    assert priced is not None
    data, kept = block_of(priced, Parts())
    again = read_block(data, Parts())
    for name in PRICED:
        np.testing.assert_array_equal(again.figures[name], priced.figures[name])
        np.testing.assert_array_equal(again.lows[name], priced.lows[name])
    assert again.reasons == priced.reasons
    assert again.templates == kept.templates == priced.templates
    for size in range(0, len(data), 97):
        with pytest.raises((ValueError, KeyError, TypeError)):
            read_block(data[:size], Parts())
    assert isinstance(work, Together)
    ((key, numbers),) = read_plan(plan_of([work]), len(space))
    assert key == work.key
    np.testing.assert_array_equal(numbers, work.numbers)


def test_points_that_a_component_refuses_are_simulated_by_themselves(tmp_path: Path) -> None:
    platform, workload = codesign.load_platform("virtex4-pci"), workload_of(tmp_path, "wavefront")
    explored = explored_of(platform, workload, {"fabric.clock": ["100 MHz", "2 GHz", "90 MHz"]})
    works = list(parted(explored, Space(explored.section.every_axis, ""), np.arange(3)))
    assert [(type(work), work.indices) for work in works] == [(Together, (0, 2)), (Alone, (1,))]


def test_other_work_is_simulated_by_itself() -> None:
    explored = explored_of(
        codesign.load_platform("virtex2pro-dimm"),
        codesign.load_workload("breadth-first-external"),
        {"fabric.clock": ["50 MHz", "60 MHz"]},
    )
    space = Space(explored.section.every_axis, "")
    pricer = Pricer(explored, space)
    for work in parted(explored, space, np.arange(2)):
        together = pricer(work)
        assert together.priced is None
        assert together.apart
        alone = [pricer(each) for each in apart(pricer.space, work, 1)]
        assert sum(len(done.entries) for done in alone) == len(work.indices)
        assert all(entry.state is EntryState.DONE for done in alone for entry in done.entries)


def test_a_computation_is_done_once_for_all_prices(tmp_path: Path) -> None:
    platform, workload = codesign.load_platform("virtex4-pci"), workload_of(tmp_path, "harmonic")
    axes = {"relax.iterations": [2, 6], "fabric.part": ["XC2V6000-4", "XC4VLX160-12"]}
    explored = explored_of(platform, workload, axes)
    space = Space(explored.section.every_axis, "")
    first = Pricer(explored, space)
    done = [first(work) for work in parted(explored, space, np.arange(4))]
    assert [each.simulated for each in done] == [1, 1]
    known = dict(itertools.chain.from_iterable(each.computations.items() for each in done))
    # Other prices of the same computations, in another study.
    explored = explored_of(platform, workload, axes | {"fabric.clock": ["50 MHz", "75 MHz"]})
    space = Space(explored.section.every_axis, "other")
    again = Pricer(explored, space, computations=known)
    assert [again(work).simulated for work in parted(explored, space, np.arange(8))] == [0, 0]
