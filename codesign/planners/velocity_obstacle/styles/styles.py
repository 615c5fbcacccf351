"""The three styles of section III on an FPGA; each robot carries one."""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure
from codesign.ground.late import late
from codesign.ground.models import Part
from codesign.planners.job import Demand, Job
from codesign.planners.styles import Architecture, Memory, Step, task_record
from codesign.planners.velocity_obstacle.plan.arithmetic import fixed
from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles import levers, power, resources, timing

if TYPE_CHECKING:
    from codesign.planners.velocity_obstacle.styles import updates
else:
    updates = late("codesign.planners.velocity_obstacle.styles.updates")


@dataclass(frozen=True)
class CircuitDemand(Demand):
    """A demand with the values that its power depends on: the style that gives its rest, and the robots."""

    style: Style = Style.SEQUENTIAL
    robots: int = 2


class Circuit(Architecture):
    """One of the three styles: units, scheduled by ``schedule``; laws in ``resources``, ``power``, ``timing``.

    The memory of an exploration keeps whole runs: units and styles change cycles, never a choice.
    """

    planner = "velocity_obstacle"
    component_type = "fpga"
    description = "update and detection units on a schedule: one of each, pipelined, or one for each robot"

    def __init__(self, style: Style) -> None:
        self.style = style.value
        self._style = style

    def demand(self, job: Job[RobotsProblem, AvoidParameters]) -> CircuitDemand:
        """Resources by unit, and the words of the array of velocities. Nothing is placed apart from ``avoid``."""
        parameters, part = job.parameters, job.chip
        robots = job.problem.count
        units = resources.units_of(self._style, robots, parameters)
        return CircuitDemand(
            items=resources.items(self._style, robots, parameters, part, constants(job)),
            bounds=(levers.array_bound(parameters, part), *levers.unit_bounds(self._style, parameters)),
            levers=levers.resource_levers(self._style, robots, parameters, part),
            style=resources.rest_style(self._style, units),
            robots=robots,
        )

    def clock_limit(self, job: Job[RobotsProblem, AvoidParameters]) -> Figure:
        """The fastest published clock, Hz."""
        circuit = resources.structure(self._style, job.problem.count, job.parameters)
        return timing.clock_limit(job.chip, circuit)

    def memory(self, job: Job[RobotsProblem, AvoidParameters]) -> Memory:
        """One component of each velocity of the array; a deep array is cut over several block RAMs."""
        parameters = job.parameters
        words = parameters.speeds * parameters.directions
        return Memory(min(parameters.width, resources.ram_width(words)), {"velocities": words})

    def work(self, job: Job[RobotsProblem, AvoidParameters]) -> Generator[Step, None, Avoidance]:
        """Phases of ``timing.PHASES``: with ``detail`` once for each update, without it each phase of the run at once.

        No task of it is placed by itself, and every run begins at the starts: ``start`` and ``inside`` change nothing.
        An update takes as long as its slowest robot. A unit of ``verify`` is a trial.
        """
        plan = avoid(job.problem, job.parameters) if job.detail else _whole(job)
        cycles = timing.run_cycles(self._style, plan, job.parameters)
        if job.detail:
            for checks, trials in zip(cycles.checks.tolist(), cycles.trials.tolist(), strict=True):
                yield from _steps(cycles.costs, checks, trials)
            return plan
        sums = dict.fromkeys(timing.PHASES, 0)
        for checks, trials in zip(cycles.checks.tolist(), cycles.trials.tolist(), strict=True):
            for phase, amount in cycles.costs.phases(checks, trials).items():
                sums[phase] += amount
        for phase, amount in sums.items():
            if amount:
                yield Step(phase, np.array([amount], np.int64), ram_addresses=timing.addresses(phase))
        return plan

    def updates(self, job: Job[RobotsProblem, AvoidParameters]) -> updates.Updates:
        """The closed loop with the cycles of every robot's own circuit, update by update: for scenario ``fleet``."""
        problem, parameters = job.problem, job.parameters
        return updates.Updates(problem, parameters, timing.update_costs(self._style, problem.count, parameters))

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static and dynamic power at ``clock`` Hz, W, of one robot's circuit."""
        assert isinstance(demand, CircuitDemand), "power follows from a demand of this style"
        return power.power(demand.style, demand.robots, clock, part)


def constants(job: Job[RobotsProblem, AvoidParameters]) -> dict[str, int]:
    """The constant factors of the circuit's products, by their names in the Verilog; none that words cannot hold."""
    try:
        numbers = fixed(job.problem, job.parameters)
    except InputError:
        # The planner refuses the width, with its fault.
        return {}
    return {"RADIUS": math.isqrt(numbers.radius_squared), "STEP": numbers.step, "HALF_SQUARE": numbers.half_square}


def _whole(job: Job[RobotsProblem, AvoidParameters]) -> Avoidance:
    """The run from the memory of an exploration: units do not change it."""
    units = {"detector", "unit", "update_units", "detect_units"}
    key = ("velocity_obstacle", job.problem.digest, job.parameters.model_dump_json(exclude=units))
    return job.shared(key, lambda: avoid(job.problem, job.parameters))


def _steps(costs: timing.UpdateCosts, checks: int, trials: int) -> Generator[Step, None, None]:
    """The phases of one update as steps."""
    for phase, amount in costs.phases(checks, trials).items():
        if not amount:
            continue
        cycles = np.full(trials, costs.trial, np.int64) if phase == timing.VERIFY else np.array([amount], np.int64)
        yield Step(phase, cycles, task_record(phase, amount), timing.addresses(phase))
