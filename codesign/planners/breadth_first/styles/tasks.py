"""The task ``track`` placed by itself: state Path on another FPGA, or a loop over directions on a processor."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

from codesign.ground.figures import Figure, Status, weakest
from codesign.ground.models import Part
from codesign.planners.breadth_first.plan.parameters import MemoryPlace, SearchParameters
from codesign.planners.breadth_first.plan.planner import PLANNER
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan
from codesign.planners.breadth_first.styles import resources, timing
from codesign.planners.breadth_first.styles.state_machine import StateMachine
from codesign.planners.breadth_first.styles.timing import PATH, TRACK, step
from codesign.planners.interface import Path, Problem
from codesign.planners.job import Demand, Job, Line
from codesign.planners.map_flood import CELL_KERNEL
from codesign.planners.styles import HostTask, Step, TaskStyle


class PathMachine(TaskStyle):
    """State Path alone: c_path cycles a cell, as in the whole machine, with the directions in block RAM."""

    planner = "breadth_first"
    task = TRACK
    style = "state_machine"
    description = "state Path alone, with the directions in block RAM beside it"
    component_type = "fpga"

    def demand(self, job: Job[Problem, SearchParameters]) -> Demand:
        """The directions; logic of the whole state machine, which is an upper bound."""
        problem, part = job.problem, job.chip
        bits = resources.address_bits(*problem.shape, job.parameters.address)
        rams = resources.block_rams(1 << bits, resources.DIRECTION_BITS, part)
        law = f"{1 << bits:,} words of {resources.DIRECTION_BITS} bits"
        bound = "upper bound: the whole state machine"
        logic = resources.items(problem, SearchParameters(), part)
        return Demand(
            items=(
                *(
                    Line.item("path", item.resource, item.amount, Status.ASSUMED, bound, (0, item.figure.interval[1]))
                    for item in logic
                    if item.name == "state machine"
                ),
                Line.item("directions", "block_rams", rams, Status.MEASURED, law),
            )
        )

    def clock_limit(self, job: Job[Problem, SearchParameters]) -> Figure:
        """The limit of the whole machine, Hz: the task by itself was not placed."""
        machine = StateMachine().clock_limit(job)
        return replace(
            machine, status=weakest(machine.status, Status.ASSUMED), source=f"as the whole machine: {machine.source}"
        )

    def steps(self, job: Job[Problem, SearchParameters]) -> Generator[Step, None, Path]:
        """State Path; one cycle where the search found no path."""
        plan: BreadthFirstPlan = job.plan
        cycles = timing.path_cycles(len(plan.path), MemoryPlace.BLOCK_RAM, 0) if plan.reached else 1
        yield step(PATH, cycles, 1)
        return PLANNER.path_from(job.problem, plan, job.position)

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """The power law of the whole machine, W."""
        return StateMachine().power(demand, clock, part)


class HostTracking(HostTask):
    """A unit for each cell of the path. It reads one side where a search reads four: an upper bound. Assumed."""

    planner = "breadth_first"
    task = TRACK
    description = "from the goal back along the directions of discovery"
    kernel = CELL_KERNEL

    def outcome(self, job: Job[Problem, SearchParameters]) -> tuple[int, Path]:
        """The path from the position."""
        plan: BreadthFirstPlan = job.plan
        return max(1, len(plan.path)), PLANNER.path_from(job.problem, plan, job.position)


TASK_STYLES = (PathMachine(), HostTracking())
