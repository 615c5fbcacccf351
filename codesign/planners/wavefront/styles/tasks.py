"""The tracking of the wavefront planner placed by itself: on a processor, as in the paper, or in the fabric."""

from __future__ import annotations

from collections.abc import Generator

from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.planners.breadth_first.styles import resources as memories
from codesign.planners.breadth_first.styles.state_machine import StateMachine
from codesign.planners.clock_law import on_family
from codesign.planners.interface import Path, Problem, cell_of
from codesign.planners.job import Demand, Job, Line
from codesign.planners.styles import HostTask, Step, TaskStyle, one_step
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.planner import PLANNER, value_bits
from codesign.planners.wavefront.styles import timing
from codesign.planners.wavefront.styles.software import MAP_KERNEL, preparation
from codesign.planners.wavefront.styles.timing import TRACK, tracked_steps

LUT4_A_BIT, FLIP_FLOPS_A_BIT = 3, 2
"""Of a bit of potential: a difference to the neighbour, the best so far, a multiplexer; two registers. Assumed."""
LUT4_AN_ADDRESS_BIT, FLIP_FLOPS_AN_ADDRESS_BIT = 2, 2
"""Of a bit of a cell's address: it is moved to a neighbour and back; two registers. Assumed."""
CONTROL_LUT4, CONTROL_FLIP_FLOPS = 30, 12
"""A counter over the neighbours, and the states. Assumed."""


class Tracker(TaskStyle):
    """10 cycles a step, and two before, as in the arrays; the potentials are in block RAM beside it.

    In a drive with a local course the tracker runs at every turn, inside the array or placed by itself.
    """

    planner = "wavefront"
    task = TRACK
    style = "sequential"
    description = "one neighbour a cycle, with the potentials in block RAM beside it"
    component_type = "fpga"

    def demand(self, job: Job[Problem, PropagateParameters]) -> Demand:
        """The potentials of every cell, a comparator and the registers of two cells."""
        problem = job.problem
        width = value_bits(problem, job.parameters)
        address = memories.address_bits(*problem.shape)
        lut4 = LUT4_A_BIT * width + LUT4_AN_ADDRESS_BIT * address + CONTROL_LUT4
        flip_flops = FLIP_FLOPS_A_BIT * width + FLIP_FLOPS_AN_ADDRESS_BIT * address + CONTROL_FLIP_FLOPS
        by_hand = f"{width} bits of potential, {address} of address; counted by hand, not synthesised"
        rams = memories.block_rams(1 << address, width, job.chip)
        return Demand(
            items=(
                Line.item("tracker", "slices", -(-max(lut4, flip_flops) // 2), Status.ASSUMED, by_hand),
                Line.item("tracker", "lut4", lut4, Status.ASSUMED, by_hand),
                Line.item("tracker", "flip_flops", flip_flops, Status.ASSUMED, by_hand),
                Line.item("potentials", "block_rams", rams, Status.ASSUMED, f"{1 << address:,} words of {width} bits"),
            )
        )

    def clock_limit(self, job: Job[Problem, PropagateParameters]) -> Figure:
        """That of its block RAM, Hz, up to the published clock of a state machine around block RAMs. Assumed."""
        shown, ram = timing.TRACK_CLOCK, job.chip.block_ram_clock
        source = "as of a state machine around block RAMs: Vacariu et al. 2008, section 3.2"
        law = Figure(shown, "Hz", Status.ASSUMED, source, shown / 2, shown)
        return on_family(ram if ram.value < shown else law, job.chip, timing.TRACK_FITTED)

    def steps(self, job: Job[Problem, PropagateParameters]) -> Generator[Step, None, Path]:
        """The path from the position; a local course costs its first steps only."""
        yield one_step(TRACK, timing.track_cycles(_steps(job)))
        return PLANNER.path_from(job.problem, job.plan, job.position)

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """The power of a state machine around block RAMs, W."""
        return StateMachine().power(demand, clock, part)


def _steps(job: Job[Problem, PropagateParameters]) -> int:
    """Steps that are tracked from the position of the job; 1 where no path leads from there."""
    cell = cell_of(job.problem, job.position)
    return 1 if cell is None else tracked_steps(job, job.plan, cell)


class HostTracking(HostTask):
    """A unit for each step of the path, as in style ``software``: the step reads eight neighbours. Assumed.

    Once a plan, the cells of the map are prepared too.
    """

    planner = "wavefront"
    task = TRACK
    description = "the path by the rule of Dreyfus, eight neighbours a step"
    kernel = "wavefront_cell"

    def kernels(self, _job: Job[Problem, PropagateParameters]) -> tuple[str, ...]:
        """Those of the steps and of the cells of the map."""
        return self.kernel, MAP_KERNEL

    def outcome(self, job: Job[Problem, PropagateParameters]) -> tuple[int, Path]:
        """The path from the position; a local course costs its first steps only."""
        return _steps(job), PLANNER.path_from(job.problem, job.plan, job.position)

    def steps(self, job: Job[Problem, PropagateParameters]) -> Generator[Step, None, Path]:
        """The cells of the map, then the steps of the path."""
        yield preparation(job)
        path: Path = yield from super().steps(job)
        return path

    def again(self, job: Job[Problem, PropagateParameters]) -> Generator[Step, None, Path]:
        """The steps of the path: the cells are prepared already."""
        return super().steps(job)


TASK_STYLES = (Tracker(), HostTracking())
