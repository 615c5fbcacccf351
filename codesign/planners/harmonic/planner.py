"""Harmonic control as a plug-in: what ``codesign.planners.interface.Planner`` asks for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from codesign.planners.harmonic.parameters import DecideParameters, LoadParameters, RelaxParameters, Stop
from codesign.planners.harmonic.relax import Relaxation, relax
from codesign.planners.interface import Messages, Problem, Quality


class Harmonic:
    """Block-synchronous harmonic control: tasks ``load``, ``relax`` and ``decide``."""

    name = "harmonic"
    description = (
        "A potential without local maxima, relaxed block by block at rising precision; Girau et al. 2008"
    )
    planning_task = "relax"
    problem_model = None

    @property
    def tasks(self) -> Mapping[str, type[BaseModel]]:
        """The tasks of a mapping, with their parameter models."""
        return {"load": LoadParameters, "relax": RelaxParameters, "decide": DecideParameters}

    def check(self, problem: Problem, parameters: RelaxParameters) -> tuple[str, str] | None:
        """A block must not be larger than the map, and equal blocks must be able to part it as often as asked."""
        height, width = parameters.block_shape(problem.rows, problem.columns)
        if height > problem.rows or width > problem.columns:
            key = "block" if parameters.block is not None else "blocks"
            return (
                key,
                f"a block of {height} × {width} nodes on a map of {problem.rows} × {problem.columns} cells",
            )
        if parameters.blocks is not None:
            made = -(-problem.rows // height), -(-problem.columns // width)
            if made != parameters.blocks:
                asked = f"{parameters.blocks[0]} × {parameters.blocks[1]}"
                size = f"{problem.rows} × {problem.columns}"
                what = (
                    f"{asked} equal blocks do not part a map of {size} cells: blocks of {height} × {width} "
                )
                return "blocks", f"{what}nodes make {made[0]} × {made[1]}, or {made[0] * made[1]}"
        return None

    def plan(self, problem: Problem, parameters: RelaxParameters) -> Relaxation:
        """Relax the field without a clock."""
        return relax(
            problem.free,
            problem.goals,
            block=parameters.block_shape(problem.rows, problem.columns),
            iterations=parameters.iterations,
            schedule=parameters.precisions,
            termination=parameters.termination,
            stop_without_local_maxima=parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA,
            record_visits=False,
        )

    def messages(self, problem: Problem) -> Messages:
        """The map, two bits a cell (free, obstacle or goal), and a direction, two components of 32 bits."""
        return Messages("map", 2 * problem.free.size, "decision", 64)

    def quality(self, problem: Problem, plan: Relaxation) -> Quality:
        """What following the field is worth."""
        from codesign.planners.harmonic.quality import quality

        return quality(problem, plan.field)

    def identity(self, plan: Relaxation) -> str:
        """The digest of the final field."""
        return plan.field.digest()

    def figures(self, plan: Relaxation) -> dict[str, Any]:
        """The stages and the final precision."""
        stages = [
            {"stage": index, "cycles": stage.cycles, **asdict(stage)}
            for index, stage in enumerate(plan.stages)
        ]
        return {"stages": stages, "precision": plan.precision}

    def trajectory(
        self, problem: Problem, plan: Relaxation, start: tuple[int, int]
    ) -> tuple[NDArray[np.float64], bool]:
        """The way of a robot that follows the decision module from ``start``."""
        from codesign.planners.harmonic.trajectory import Ascent

        way = Ascent(plan.field, problem.free, problem.goals).follow(start)
        return way.points, way.arrived


PLANNER = Harmonic()
