"""A block or tile larger than the map is one more partial one: it is built as declared, its rest is obstacle."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import Ground
from reference_harmonic import relax_reference

from codesign.ground.memo import Memo
from codesign.inputs import load_part
from codesign.maps import OccupancyGrid
from codesign.planners.harmonic.plan.relax import relax
from codesign.planners.harmonic.styles import resources, timing
from codesign.planners.harmonic.styles.resources import largest_block, resource_levers
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.styles import timing as wave_timing
from codesign.system import Result, catalog
from codesign.system.results.result import reach_text
from codesign.system.scenarios import simulate

TASKS = {"harmonic": "relax", "wavefront": "propagate"}


@st.composite
def problems(draw: st.DrawFn, side: int = 9) -> Problem:
    """A random map with a goal in its first column, which is free, and a start there."""
    rows, columns = draw(st.integers(2, side)), draw(st.integers(1, side))
    free = np.random.default_rng(draw(st.integers(0, 10**6))).random((rows, columns)) >= draw(st.floats(0, 0.5))
    free[:, 0] = True
    goal = draw(st.integers(0, rows - 1)), 0
    return Problem(free, (goal,), (goal,))


def sides(problem: Problem, draw: st.DataObject, most_blocks: int = 4) -> tuple[int, int]:
    """Rows and columns of 1 to ``most_blocks`` blocks, up to twice those of the map."""
    across = most_blocks // 2
    rows, columns = (draw.draw(st.integers(-(-side // across), 2 * side)) for side in (problem.rows, problem.columns))
    return rows, columns


def planned(placement: str, problem: Problem, setting: dict[str, Any]) -> Result:
    platform, workload = _point(placement, repr(setting))
    asked = workload.problem.model_copy(update={"goals": problem.goals, "starts": problem.starts})
    workload = workload.model_copy(update={"problem": asked})
    return simulate(platform, workload, grid=OccupancyGrid(problem.free))


@cache
def _point(placement: str, setting: str) -> Any:
    import ast

    once = {"scenario": {"=": {"type": "plan_once"}}}
    task = TASKS[placement.partition("-")[0]]
    with TemporaryDirectory() as folder:
        slow = {"components": {"fpga": {"clock": "50 MHz"}}}
        mapping = {task: ast.literal_eval(setting)}
        return Ground(Path(folder)).point(placement, mapping=mapping, workload=once, platform=slow)


def of_design(result: Any) -> list[str]:
    """The notes but those of the clock, which is not sure on a part that no law was fitted to, and of the map."""
    of_map = [note for note in result.notes if note.startswith("problem.goals: ")]
    assert of_map == list(reach_notes(result.task.reach))
    return [note for note in result.notes if not note.startswith(("fpga.clock: ", "problem.goals: "))]


def reach_notes(share: float) -> Iterator[str]:
    if share < 1:
        yield f"problem.goals: {reach_text([share])}"


@given(problem=problems(), data=st.data())
@settings(max_examples=60)
def test_no_block_changes_a_bit_of_the_field(problem: Problem, data: st.DataObject) -> None:
    block, iterations = sides(problem, data, 18), data.draw(st.sampled_from([1, 3, 50]))
    schedule = data.draw(st.sampled_from([[9], [4, 15], [7, 40, 70]]))
    asked: dict[str, Any] = {"iterations": iterations, "schedule": schedule}
    whole = relax_reference(problem.free, problem.goals, block=problem.free.shape, **asked)
    same = relax_reference(problem.free, problem.goals, block=block, **asked)
    larger = relax(problem.free, problem.goals, block=block, **asked)
    assert larger.field == whole.field == same.field
    assert larger.stages == same.stages
    if block[0] >= problem.rows and block[1] >= problem.columns:
        assert larger.stages == whole.stages


@given(problem=problems(), data=st.data())
@settings(max_examples=30)
def test_a_design_is_that_of_the_declared_block(problem: Problem, data: st.DataObject) -> None:
    block = sides(problem, data)
    beyond = block[0] > problem.rows or block[1] > problem.columns
    inside = min(block[0], problem.rows), min(block[1], problem.columns)
    wide, narrow = (planned("harmonic", problem, {"block": list(each)}) for each in (block, inside))
    assert wide.feasible
    demand = {use.resource: use.demand for use in wide.resources}
    grid = -(-problem.rows // block[0]), -(-problem.columns // block[1])
    # The schedule of the placement has the stages 15, 31, 47 and 63.
    machine = resources.Machine(*block, 63, True, *grid, stages=4)
    assert demand == resources.totals(machine, "Virtex-4") | {"multipliers": 0}
    assert wide.blocks == narrow.blocks
    assert wide.stages == narrow.stages
    assert wide.quality == narrow.quality
    assert of_design(narrow) == []
    assert [note.partition(":")[0] for note in of_design(wide)] == ["relax.block"] * beyond
    assert wide.parameters["relax"]["block"] == list(block)
    # The OR tree spans the nodes that are built, whatever lies under them.
    assert wide.cycles is not None
    assert narrow.cycles is not None
    assert wide.stages is not None
    passes = sum(stage.cycles for stage in wide.stages)
    drops = [
        divmod(each.cycles["relax"] - passes, timing.dropped_pass_cycles(*shape))
        for each, shape in ((wide, block), (narrow, inside))
    ]
    assert drops[0] == drops[1]
    assert drops[0][1] == 0
    # The words of all memories that are built are loaded.
    assert wide.blocks is not None
    words = [2 * wide.blocks * resources.memories(*shape, *grid) for shape in (block, inside)]
    assert wide.cycles["load"] - narrow.cycles["load"] == words[0] - words[1]
    same = {"relax": 0, "load": 0}
    assert {**wide.cycles, **same} == {**narrow.cycles, **same}


@given(problem=problems(), data=st.data())
@settings(max_examples=20)
def test_software_computes_the_cells_of_the_map_and_no_others(problem: Problem, data: st.DataObject) -> None:
    block = sides(problem, data)
    inside = min(block[0], problem.rows), min(block[1], problem.columns)
    wide, narrow = (planned("harmonic-host", problem, {"block": list(each)}) for each in (block, inside))
    assert wide.cycles == narrow.cycles
    assert wide.time == narrow.time
    assert of_design(narrow) == []
    assert [note.partition(":")[0] for note in of_design(wide)] == ["relax.block"] * (block != inside)


@given(problem=problems(), data=st.data())
@settings(max_examples=30)
def test_a_tile_may_be_larger_than_the_map(problem: Problem, data: st.DataObject) -> None:
    tile = sides(problem, data)
    inside = min(tile[0], problem.rows), min(tile[1], problem.columns)
    raw = {"style": "tiled", "stop": "whole_map"}
    wide, narrow = (planned("wavefront", problem, {**raw, "tile": list(each)}) for each in (tile, inside))
    assert wide.feasible
    assert wide.quality == narrow.quality
    assert wide.details == narrow.details
    assert [note.partition(":")[0] for note in of_design(wide)] == ["propagate.tile"] * (tile != inside)
    parameters = PropagateParameters(tile=tile, stop="whole_map", corner_cutting=False)  # type: ignore[arg-type]
    style = catalog.styles_of("wavefront")["tiled"]
    job = Job(problem, parameters, part=load_part("XC4VLX160-12"))
    demand = style.demand(job)
    (flip_flops,) = [item.amount for item in demand.items if (item.name, item.resource) == ("nodes", "flip_flops")]
    # Three of the delay line, F, Z and the register.
    assert flip_flops == tile[0] * tile[1] * (5 + style.bits(job))  # type: ignore[attr-defined]
    assert {use.resource: use.demand for use in wide.resources if use.demand} == {
        kind: demand.total(kind) for kind in ("slices", "lut4", "flip_flops", "block_rams")
    }
    # The potentials of the nodes are the same; a visit exchanges all rows of the tile that is built.
    assert wide.cycles is not None
    assert narrow.cycles is not None
    assert wide.cycles["propagate"] == narrow.cycles["propagate"]
    tiles = parameters.tile_count(problem.rows, problem.columns)
    exchanges = [wave_timing.exchange_cycles(shape, tiles) for shape in (tile, inside)]
    scans = [wave_timing.scan_cycles(shape[1], tiles) for shape in (tile, inside)]
    visits = (narrow.cycles["exchange"] - scans[1]) // exchanges[1]
    assert wide.cycles["exchange"] - scans[0] == visits * exchanges[0]


def test_the_case_of_the_report() -> None:
    """36 × 66 nodes on 81 × 65 cells: three blocks, each of which holds one column of obstacles beyond the map."""
    problem = Problem(np.ones((81, 65), bool), ((40, 32),), ((0, 0),))
    result = planned("harmonic", problem, {"block": [36, 66], "iterations": 50, "schedule": [15]})
    assert (result.feasible, result.blocks) == (True, 3)
    (note,) = result.notes
    assert note == (
        "relax.block: a block of 36 × 66 nodes is larger than the map of 81 × 65 cells: it holds 36 × 65 cells,"
        " its other nodes hold obstacles"
    )


@pytest.mark.parametrize("name", ["XC2V6000-4", "XC3S500E-4"])
def test_the_block_that_a_lever_names_is_no_larger_than_the_map(name: str) -> None:
    part, shape = load_part(name), (30, 40)
    machine = resources.Machine(96, 96, 63)
    levers = resource_levers(shape, machine, (63,), part, resources.word_depth(part))
    fits = largest_block(resources.Machine(*shape, 63), part)
    assert fits is not None
    texts = {lever.advice for each in levers.values() for lever in each if lever.parameter == "relax.block"}
    assert len(texts) == 1
    assert f"at most {fits[0]} × {fits[1]} " in texts.pop()


def test_check_prints_the_note(hwsw: Any, tmp_path: Path) -> None:
    once = {"scenario": {"=": {"type": "plan_once"}}}
    files = Ground(tmp_path).files("harmonic", mapping={"relax": {"block": [20, 16]}}, workload=once)
    done = hwsw("check", *files)
    assert done.exit_code == 0
    assert "note: relax.block: a block of 20 × 16 nodes is larger than the map of 16 × 16 cells" in done.output
    assert "no fault found" in done.output
    shown = hwsw("run", *files)
    assert shown.exit_code == 0
    assert "it holds 16 × 16 cells" in " ".join(shown.output.split())


def test_stages_are_shared_by_blocks_that_hold_the_same_cells() -> None:
    """The schedule of visits is that of the cells, so an exploration computes it once."""
    problem, memo = Problem(np.ones((9, 7), bool), ((4, 3),), ((0, 0),)), Memo()
    style, model = catalog.styles_of("harmonic")["bit_serial"], catalog.planner("harmonic").tasks["relax"]
    misses = []
    for block in ((9, 7), (9, 12), (18, 7)):
        parameters = model.model_validate({"block": block, "iterations": 4, "schedule": (15,)})
        for _ in style.work(Job(problem, parameters, memo=memo, detail=False)):
            pass
        misses.append(memo.misses)
    assert misses[0] > 0
    assert set(misses) == {misses[0]}
