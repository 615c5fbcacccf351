"""The parameters that are worth a try: paths that a robot can follow, and tiles that fit the part."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from codesign.ground.errors import MapError
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.styles import Architecture, Designs, Family
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.plan import from_farthest

DESIGNS: Designs = tuple(({"stop": stop, "corner_cutting": False},) for stop in ("starts", "whole_map"))
"""A robot cannot pass between two obstacles that touch at a corner."""

MOST_CELLS = 2**18
"""Cells of the map times starts up to which tiles are visited for each start by itself. A search would take minutes
beyond. The wave over the whole map takes at least as long on the array, and one computation for all starts."""

TILE_SIDES = (8, 16, 24, 32, 48, 64, 96, 128, 192, 256)
MOST_TILES = 3
"""The number of tiles that are tried, the largest that fit: a larger tile is visited less often, a smaller one has a
faster clock."""


def exact_families(
    style: Architecture, job: Job[Problem, Any], designs: Iterable[Mapping[str, Any]]
) -> Iterator[Family]:
    """Each design by itself, with the units that it takes from the farthest start: no other start takes more."""
    for design in designs:
        parameters = style.settled(PropagateParameters.model_validate(dict(design)))
        units: dict[str, int] = {}
        try:
            asked = from_farthest(job.problem, parameters)
            for step in style.work(replace(job, problem=asked, parameters=parameters, detail=False)):
                kernel = step.kernel or style.kernel
                units[kernel] = units.get(kernel, 0) + int(step.cycles.sum())
        except MapError:
            # No wave comes to a start: every run of the design says so.
            units = {}
        cells = design.get("element_cells")
        yield Family((design,), units, {} if cells is None else {"cells an element": (cells, cells)})
