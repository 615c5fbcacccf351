"""The wavefront planner as a plug-in: what ``codesign.planners.interface.Planner`` asks for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from codesign.errors import MapError
from codesign.planners.interface import Messages, Problem, Quality
from codesign.planners.wavefront.parameters import (
    MAX_TILES,
    LoadParameters,
    PropagateParameters,
    TrackParameters,
)
from codesign.planners.wavefront.plan import WavefrontPlan, compute_plan, known_plan
from codesign.planners.wavefront.wave import register_bits


class Wavefront:
    """Shortest and safe paths by a wave: tasks ``load``, ``propagate`` and ``track``."""

    name = "wavefront"
    planning_task = "propagate"
    problem_model = None
    description = "shortest and safe paths by a wave of delays 2 and 3 (Möller and Paschke 1998)"

    @property
    def tasks(self) -> Mapping[str, type[BaseModel]]:
        """The tasks of a mapping, with their parameter models."""
        return {"load": LoadParameters, "propagate": PropagateParameters, "track": TrackParameters}

    def check(self, problem: Problem, parameters: PropagateParameters) -> tuple[str, str] | None:
        """A wave that waits for its starts has to reach them; tiles are no larger than the map, nor too many."""
        if parameters.tile is not None:
            height, width = parameters.tile
            if height > problem.rows or width > problem.columns:
                text = (
                    f"a tile of {height} × {width} nodes on a map of {problem.rows} × {problem.columns} cells"
                )
                return "tile", text
            count = parameters.tile_count(problem.rows, problem.columns)
            if count > MAX_TILES:
                return "tile", f"{count:,} tiles of {height} × {width} nodes, more than {MAX_TILES:,}"
        try:
            known_plan(problem, parameters)
        except MapError as fault:
            return "stop", fault.what
        return None

    def plan(self, problem: Problem, parameters: PropagateParameters) -> WavefrontPlan:
        """Run the wave without a clock."""
        return compute_plan(problem, parameters)

    def messages(self, problem: Problem) -> Messages:
        """The map, F and Z of every cell, and the next cell of the way, row and column of 32 bits."""
        return Messages("map", 2 * problem.free.size, "next cell", 64)

    def quality(self, problem: Problem, plan: WavefrontPlan) -> Quality:
        """What the ways are worth."""
        from codesign.planners.wavefront.quality import quality

        return quality(problem, plan)

    def identity(self, plan: WavefrontPlan) -> str:
        """The digest of the potentials and the rule of the ways."""
        return plan.digest

    def figures(self, plan: WavefrontPlan) -> dict[str, Any]:
        """How far the wave came, and how wide a register has to be for it."""
        details: dict[str, Any] = {
            "largest_potential": plan.largest_potential,
            "reached_cells": plan.reached_cells,
            "register_bits_needed": register_bits(plan.largest_potential),
        }
        if plan.stop_potential is not None:
            details["stop_potential"] = plan.stop_potential
        return {"details": details}

    def trajectory(
        self, problem: Problem, plan: WavefrontPlan, start: tuple[int, int]
    ) -> tuple[NDArray[np.float64], bool]:
        """The way from ``start`` by the rule of the plan; ``start`` alone where the wave did not come.

        Raises:
            MapError: a start outside of the map or on an obstacle.
        """
        from codesign.planners.wavefront.grid import check_cells

        check_cells([start], problem.free, "start")
        if plan.potentials[start] < 0:
            return np.array([start], np.float64), False
        return plan.tracker.follow(start).astype(np.float64), True


PLANNER = Wavefront()
