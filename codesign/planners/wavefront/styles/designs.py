"""The parameters that are worth a try: paths that a robot can follow."""

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

BEYOND = "other delays of a step, any-angle courses, safe paths, penalties, several steps an answer"
"""The designs that no style proposes: their paths are of another kind."""


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
