"""Cycles of all modules, and the clock.

The cycles of pos_vel_update and coll_detect are published, and follow from their products (``schedule``). The paper
says of the other modules only that their cycles do not depend on the number of robots. Here they take as many as in the
RTL of this package (``rtl``), which ``hwsw verify`` holds against these laws, cycle for cycle. One multiplier serves
them in turn, one product a cycle:

- load: the target, then position and velocity of each robot, a word a cycle;
- target check: two squares of the distance to the target, and a cycle to compare;
- velocity selector: the direction by halving an octant, two products each time, and a cycle to mirror it, once an
  update; then one cycle a candidate to read it from the array;
- acceleration check: two squares and a cycle to compare, and for a candidate that passes two more cycles for the
  acceleration itself;
- PID control: three products an axis, and a cycle to sum up.

A trial of the paper (Table II) is one candidate. The number of trials of an update follows from a run only.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.planners.clock_law import Placement, Registers, on_family
from codesign.planners.measured import clock_rows
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, Detection
from codesign.planners.velocity_obstacle.published import CLOCK, FAMILY, PAPER, Style
from codesign.planners.velocity_obstacle.styles.resources import (
    DETECT,
    UPDATE,
    halvings,
    module_cycles,
    trial_cycles,
    units_of,
)

LOAD, TARGET_CHECK, SELECT, ACCELERATION_CHECK, VERIFY, PID = (
    "load",
    "target_check",
    "velocity_selector",
    "acceleration_check",
    "verify",
    "pid",
)
PHASES = (LOAD, TARGET_CHECK, SELECT, ACCELERATION_CHECK, VERIFY, PID)
"""The phases of an update, in order; ``verify`` is pos_vel_update and coll_detect, the cycles of Table II."""

FASTEST_SHOWN = 100_000_000
"""Hz: a product of two 33-bit numbers in one cycle, four multipliers of 5 ns and two levels of carries. Assumed."""


@dataclass(frozen=True)
class UpdateCosts:
    """Cycles of one update: once, for each candidate, and for each trial."""

    load: int
    target_check: int
    select_once: int
    select_candidate: int
    check_candidate: int
    check_trial: int
    trial: int
    pid: int

    def of_robot(self, checks: NDArray[np.int32], trials: NDArray[np.int32]) -> NDArray[np.int64]:
        """Cycles of all phases for robots with these numbers of candidates and trials, int64.

        A robot that has arrived looks at no candidate and selects nothing.
        """
        candidates, tried = checks.astype(np.int64), trials.astype(np.int64)
        once = np.where(candidates > 0, self.select_once, 0)
        each = (self.select_candidate + self.check_candidate) * candidates
        return np.asarray(
            self.load + self.target_check + once + each + (self.check_trial + self.trial) * tried + self.pid
        )

    def phases(self, checks: int, trials: int) -> dict[str, int]:
        """The cycles of each phase of one update of one robot."""
        return {
            LOAD: self.load,
            TARGET_CHECK: self.target_check,
            SELECT: (self.select_once if checks else 0) + self.select_candidate * checks,
            ACCELERATION_CHECK: self.check_candidate * checks + self.check_trial * trials,
            VERIFY: self.trial * trials,
            PID: self.pid,
        }


def cycles_of_trial(style: Style, robots: int, parameters: AvoidParameters) -> int:
    """Cycles in which one candidate is tested against all other robots: Table II."""
    return trial_cycles(robots, units_of(style, robots, parameters), *module_latencies(parameters))


def module_latencies(parameters: AvoidParameters) -> tuple[int, int]:
    """Cycles of one pos_vel_update and of one coll_detect."""
    approaching, ranged = parameters.detection is Detection.APPROACHING, parameters.range is not None
    return (
        module_cycles(UPDATE, parameters.unit),
        module_cycles(DETECT, parameters.unit, parameters.detector, approaching, ranged),
    )


def update_costs(style: Style, robots: int, parameters: AvoidParameters) -> UpdateCosts:
    """The costs of an update in a style."""
    return UpdateCosts(
        # A word for the target, two a robot. Target check: x², y², compare. Acceleration check: cx², cy², compare,
        # and cx / t meanwhile, so a trial takes two cycles more: cy / t, round. PID: three gains on two axes.
        load=2 * robots + 1,
        target_check=3,
        select_once=2 * halvings(parameters) + 1,
        select_candidate=1,
        check_candidate=3,
        check_trial=2,
        trial=cycles_of_trial(style, robots, parameters),
        pid=7,
    )


@dataclass(frozen=True, eq=False)
class UpdateCycles:
    """Cycles of a whole run. ``checks``, ``trials``: int64, of the slowest robot of each update; all others wait."""

    costs: UpdateCosts
    checks: NDArray[np.int64]
    trials: NDArray[np.int64]

    @property
    def each(self) -> NDArray[np.int64]:
        """Cycles of each update, int64."""
        return self.costs.of_robot(self.checks.astype(np.int32), self.trials.astype(np.int32))


def run_cycles(style: Style, plan: Avoidance, parameters: AvoidParameters) -> UpdateCycles:
    """The cycles of every update of a run: each robot has its own FPGA, and the next update begins for all at once."""
    costs = update_costs(style, plan.positions.shape[1], parameters)
    # Section V has "all robots work at the same time", so the update takes as long as its slowest robot.
    slowest = np.argmax(costs.of_robot(plan.checks, plan.trials), axis=1)
    chosen = np.arange(plan.updates), slowest
    return UpdateCycles(costs, plan.checks[chosen].astype(np.int64), plan.trials[chosen].astype(np.int64))


def addresses(phase: str) -> int:
    """Addresses a cycle that the array of velocities is given: one while the selector runs."""
    return int(phase == SELECT)


def registers(circuit: Mapping[str, int]) -> Registers:
    """The variables of the clock of a robot's circuit: its words. A unit more or less is not on the critical path.

    ``circuit``: the parameters of its Verilog, as ``resources.structure`` has them.
    """
    words = {
        "parallel units": circuit["PARALLEL"],
        "cross products": circuit["CROSS_PRODUCT"],
        "a range": circuit["RANGED"],
        "the published detection": not circuit["APPROACHING"],
    }
    options = frozenset(word for word, present in words.items() if present)
    return Registers("units with a register behind each product", circuit["WIDTH"], options=options)


@cache
def placements() -> tuple[Placement, ...]:
    """The circuits of robots that were placed and routed."""
    return tuple(
        Placement(row, registers(row.variables))
        for style in Style
        for row in clock_rows("velocity_obstacle", style.value)
    )


def clock_limit(part: Part, circuit: Mapping[str, int]) -> Figure:
    """The fastest clock, Hz: on the board's family its oscillator, the only published clock. ``circuit``: as above."""
    ram = part.block_ram_clock.interval[1]
    limit = Figure(
        value=min(CLOCK, ram),
        unit="Hz",
        status=Status.PUBLISHED,
        source=f"{PAPER}, section VI: ran at 50 MHz, the oscillator of the board; up to 100 MHz is assumed to work,"
        " a product of 33-bit numbers each cycle",
        low=min(CLOCK, ram),
        high=min(FASTEST_SHOWN, ram),
    )
    return on_family(limit, part, FAMILY, registers=registers(circuit), placements=placements())
