"""Families of designs: every design is in one, and no design undercuts a bound of its family."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any
from unittest.mock import Mock

import numpy as np
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign import maps
from codesign.ground.models import Part
from codesign.inputs.library import load_part
from codesign.planners.harmonic import styles as harmonic
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.planner import PLANNER as HARMONIC
from codesign.planners.harmonic.styles.bit_serial import BitSerial
from codesign.planners.harmonic.styles.designs import lasts_of
from codesign.planners.interface import Problem
from codesign.planners.job import Job, short_resources, sum_by_resource
from codesign.planners.relaxation import styles as relaxation
from codesign.planners.relaxation.plan.parameters import RelaxParameters as RelaxationParameters
from codesign.planners.styles import Architecture, Family
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.styles import AdderComparator, DelayLine, Software, Tiled
from codesign.planners.wavefront.styles.tile import tiled_items
from codesign.planners.wavefront.styles.tile_families import PROMISING
from codesign.study.advice.search import _Open

PART = load_part("XC4VLX160-12")


def problem(seed: int, shape: tuple[int, int], density: float, starts: int = 2) -> Problem:
    rng = np.random.default_rng(seed)
    free = rng.random(shape) >= density
    free[0, 0] = True
    cells = np.argwhere(free)
    goal = tuple(int(part) for part in cells[rng.integers(len(cells))])
    reached = np.argwhere(maps.reachable(free, [goal], corner_cutting=False))
    chosen = reached[rng.integers(len(reached), size=starts)]
    return Problem(free, (goal,), tuple(dict.fromkeys((int(row), int(column)) for row, column in chosen)))


def part_of(share: float, block_rams: int) -> Part:
    """A part with a share of the resources of one, and so many block RAMs."""
    scaled = {
        kind: replace(figure, value=block_rams if kind == "block_rams" else int(figure.value * share))
        for kind, figure in PART.resources.items()
    }
    return PART.model_copy(update={"resources": scaled})


def leaves(families: Iterator[Family], above: tuple[Family, ...] = ()) -> Iterator[tuple[dict[str, Any], list[Family]]]:
    """Every design, with the families that it is in."""
    for family in families:
        path = (*above, family)
        if family.parts is not None:
            yield from leaves(family.parts(), path)
        for design in family.chain:
            yield dict(design), list(path)


def units(style: Architecture, job: Job[Any, Any]) -> dict[str, int]:
    """Cycles, or units by kernel, of one run."""
    sums: dict[str, int] = {}
    for step in style.work(replace(job, detail=False)):
        kernel = (step.kernel or style.kernel) if style.component_type == "processor" else ""
        sums[kernel] = sums.get(kernel, 0) + int(step.cycles.sum())
    return sums


def runs(style: Architecture, job: Job[Any, Any], raw: dict[str, Any]) -> list[dict[str, int]]:
    """The units of a design from each start, tracked and all."""
    model = PropagateParameters.model_validate(raw)
    asked = [replace(job, problem=job.problem.asked_from(start)) for start in job.problem.starts]
    return [units(style, replace(each, parameters=style.settled(model))) for each in asked]


def is_undercut(bound: dict[str, int], found: list[dict[str, int]]) -> bool:
    """True if every start takes less of some unit."""
    return all(any(run.get(kernel, 0) < least for kernel, least in bound.items()) for run in found)


maps_drawn = st.tuples(st.integers(0, 10**6), st.tuples(st.integers(1, 12), st.integers(1, 14)), st.floats(0, 0.45))


@given(maps_drawn, st.floats(0.001, 0.02), st.integers(4, 40), st.booleans())
@settings(max_examples=examples(12))
def test_every_tile_is_in_a_family_whose_bounds_hold(
    drawn: tuple[int, tuple[int, int], float], share: float, block_rams: int, tracked: bool
) -> None:
    here, part = problem(*drawn), part_of(share, block_rams)
    job = Job(here, None, part=part, inside=None if tracked else frozenset({"load", "propagate"}))
    style, (rows, columns) = Tiled(), here.shape
    found: dict[tuple[str, int, int], int] = {}
    unfit: list[tuple[str, dict[str, tuple[int, int]]]] = []
    top = list(style.families(job))
    assert sum(family.count for family in top) == 2 * rows * columns
    for design, path in leaves(iter(top)):
        cycles = max(run[""] for run in runs(style, job, design))
        model = PropagateParameters.model_validate(design)
        sized = replace(job, parameters=model)
        for family in path:
            least = replace(job, parameters=PropagateParameters.model_validate(family.least))
            assert family.units[""] <= cycles
            assert style.clock_limit(sized).value <= style.clock_limit(least).value + 1e-6
            if not family.clock_alone and short_resources(style.items(least), part):
                assert short_resources(style.items(sized), part)
        family = path[-1]
        if family.sharper is None:
            unfit += [(stop, dict(family.ranges)) for stop in ("starts", "whole_map")]
            continue
        found[design["stop"], *design["tile"]] = 1
        assert family.sharper(10**9)[""] == cycles
        assert family.units[""] <= family.sharper(cycles // 2)[""] <= cycles
        assert family.sharper(cycles // 2)[""] > cycles // 2
    for stop, ranges in unfit:
        (top_row, last_row), (left, right) = ranges["tile rows"], ranges["tile columns"]
        for tile in ((row, column) for row in range(top_row, last_row + 1) for column in range(left, right + 1)):
            found[stop, *tile] = found.get((stop, *tile), 0) or 1
            model = PropagateParameters(stop=stop, corner_cutting=False, tile=tile)
            assert short_resources(style.items(replace(job, parameters=model)), part)
    assert len(found) == 2 * rows * columns


@given(maps_drawn, st.booleans())
@settings(max_examples=examples(12))
def test_whole_arrays_and_software_know_their_units(drawn: tuple[int, tuple[int, int], float], tracked: bool) -> None:
    job = Job(problem(*drawn), None, part=PART, inside=None if tracked else frozenset({"load", "propagate"}))
    for style, count in ((DelayLine(), 4), (AdderComparator(), 2), (Software(), 2)):
        families = list(style.families(job))
        designs = [design for design, _ in leaves(iter(families))]
        sharing = len({design.get("element_cells") for design in designs})
        assert len(designs) == len({str(design) for design in designs}) == count * sharing
        for design, (family,) in leaves(iter(families)):
            found = runs(style, job, design)
            assert not is_undercut(dict(family.units), found)
            assert dict(family.units) in found


def arrives(job: Job[Any, Any]) -> bool:
    """True if the field of a design leads from every start to a goal."""
    plan = HARMONIC.plan(job)
    return all(HARMONIC.trajectory(job.problem, plan, start)[1] for start in job.problem.starts)


@given(maps_drawn, st.floats(0.01, 0.3), st.integers(4, 60), st.booleans())
@settings(max_examples=examples(15))
def test_no_block_undercuts_the_iterations_of_the_whole_map(
    drawn: tuple[int, tuple[int, int], float], share: float, block_rams: int, decides: bool
) -> None:
    here, part = problem(*drawn, starts=1), part_of(share, block_rams)
    tasks = {"load", "lower_bound", "relax", "detect"} | ({"decide"} if decides else set())
    job, style = Job(here, None, part=part, inside=frozenset(tasks)), BitSerial()
    found: set[tuple[int, int]] = set()
    unfit: set[tuple[int, int]] = set()
    top = list(style.families(job))
    for design, path in leaves(iter(top)):
        shape = tuple(design["block"])
        sized = replace(job, parameters=RelaxParameters.model_validate(design))
        for family in path:
            least = replace(job, parameters=RelaxParameters.model_validate(dict(family.least or family.chain[0])))
            assert style.clock_limit(sized).value <= style.clock_limit(least).value + 1e-6
            if not family.clock_alone and short_resources(style.demand(least).items, part):
                assert short_resources(style.demand(sized).items, part)
        ranges = path[-1].ranges
        if (shape[0], shape[0]) != ranges["block rows"] or (shape[1], shape[1]) != ranges["block columns"]:
            last_row, last_column = ranges["block rows"][1], ranges["block columns"][1]
            unfit |= set(product(range(shape[0], last_row + 1), range(shape[1], last_column + 1)))
            continue
        found.add(shape)
        if design["schedule"]["last"] > 31 or (sum(shape) % 5 and len(found) > 4):
            continue
        if not arrives(sized):
            continue
        cycles = units(style, sized)[""]
        for family in path:
            assert family.units[""] <= cycles
            assert family.sharper is None or family.units[""] <= family.sharper(10**9)[""] <= cycles
    # One block RAM has to hold the words of all blocks.
    shapes = set(product(range(1, here.rows + 1), range(1, here.columns + 1)))
    assert {shape for shape in shapes if lasts_of(here.shape, shape, part)} <= found | unfit <= shapes


@given(maps_drawn)
@settings(max_examples=examples(15))
def test_programs_take_no_fewer_units_than_their_bounds(drawn: tuple[int, tuple[int, int], float]) -> None:
    job = Job(problem(*drawn, starts=1), None)
    for planner in (harmonic, relaxation):
        for style in planner.ARCHITECTURES:
            if style.component_type != "processor":
                continue
            model = RelaxParameters if planner is harmonic else RelaxationParameters
            for design, (family,) in leaves(style.families(job)):
                if design.get("schedule", {}).get("last", 0) <= 47:
                    sized = replace(job, parameters=model.model_validate(design))
                    assert family.units
                    if planner is harmonic and not arrives(sized):
                        continue
                    ran = units(style, sized)
                    assert not is_undercut(dict(family.units), [ran])


@given(st.tuples(st.integers(1, 60), st.integers(1, 60)), st.tuples(st.integers(0, 40), st.integers(0, 40)))
@settings(max_examples=examples(60))
def test_the_smallest_tile_takes_least_on_its_own_map(tile: tuple[int, int], more: tuple[int, int]) -> None:
    # What cannot fit rests on it: larger tiles, and more of them, take no less of any resource.
    here = problem(1, (60, 60), 0.2)
    parameters = PropagateParameters(tile=tile, register_bits=9, corner_cutting=False)
    layout = Tiled().layout(Job(here, parameters, part=PART))
    larger = min(60, tile[0] + more[0]), min(60, tile[1] + more[1])
    small, large = (tiled_items(layout, tile, tile, PART), tiled_items(layout, (60, 60), larger, PART))
    for resource, count in sum_by_resource(small).items():
        assert count <= sum_by_resource(large)[resource]


def test_a_large_map_is_listed_quickly_and_its_best_tile_stands_first() -> None:
    free = maps.rooms(96, 96, room=(12, 12), door=2, seed=1).free
    end = maps.nearest_free(free, (90, 90))
    assert end is not None
    here = Problem(free, ((1, 1),), (end,))
    families = list(Tiled().families(Job(here, None, part=part_of(0.3, 60))))
    first, *_, rest = families
    assert len(families) <= PROMISING + 1
    assert rest.clock_alone
    assert len(list(rest.parts() if rest.parts else ())) <= 2 * 7
    assert sum(family.count for family in families) == 2 * 96 * 96
    assert first.sharper is not None
    assert len(first.chain) == 1


def test_all_blocks_but_the_promising_ones_are_left_out_in_one_step() -> None:
    here = problem(1, (90, 80), 0.2, starts=1)
    *_, rest = BitSerial().families(Job(here, None, part=PART))
    assert rest.clock_alone
    assert rest.ranges == {"block rows": (1, 90), "block columns": (1, 80)}
    assert rest.count > 10_000
    assert rest.parts is not None
    classes = list(rest.parts())
    assert sum(family.count for family in classes) == rest.count
    assert all(family.units[""] >= rest.units[""] for family in classes)


def test_parts_of_parts_are_looked_at_to_any_depth() -> None:
    def nested(depth: int) -> Iterator[Family]:
        yield Family((), count=depth, parts=partial(nested, depth - 1) if depth else None)

    arrangement = Mock(families=lambda: nested(3000), parts=lambda family: family.parts())
    opened, laboratory, counts = _Open(arrangement), Mock(), []
    while (family := opened.next(laboratory)) is not None:
        counts.append(family.count)
        opened.push(family)
    assert counts == list(range(3000, -1, -1))
