"""Tasks of harmonic control that are placed by themselves.

- ``decide`` on an FPGA: the decision module of section 5.3 alone, with the field in block RAM beside it.
- ``decide`` on a processor: one direction in compiled code.
- ``lower_bound`` on a processor: a start nowhere above the field, by a sparse direct solution.
- ``detect`` on a processor: the flag of every sweep is received and answered.
"""

from __future__ import annotations

import hashlib
from collections.abc import Generator

from codesign.ground.figures import Figure, Status
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.planners.clock_law import on_family
from codesign.planners.counted import slice_power
from codesign.planners.harmonic import published
from codesign.planners.harmonic.plan.fixed_point import LowerBound, limbs_needed
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.planner import PLANNER
from codesign.planners.harmonic.plan.relax import HarmonicPlan
from codesign.planners.harmonic.plan.warm_start import warm_start
from codesign.planners.harmonic.styles import resources, timing
from codesign.planners.interface import Path, Problem
from codesign.planners.job import Demand, Job, Line, packed
from codesign.planners.styles import HostTask, Step, TaskStyle, one_step


class DecisionModule(TaskStyle):
    """p + 7 cycles a decision: the circuit ``harmonic_decide``, with the field in block RAM beside it.

    ``steps`` returns the path from the position. It begins with the direction. The field is written into the memories
    as it arrives, which is not counted.
    """

    planner = "harmonic"
    task = "decide"
    style = "bit_serial"
    description = "the decision module alone, with the field in block RAM beside it"
    component_type = "fpga"

    def demand(self, job: Job[Problem, RelaxParameters]) -> Demand:
        """The decision module, and p + 1 bits of every cell in five memories of one bit a word.

        On the paper's families its slices are those published, of a module that has no memory of its own.
        """
        (rows, columns), last, part = job.problem.shape, job.parameters.precisions[-1], job.chip
        variables = {"ROWS": rows, "COLUMNS": columns, "LAST_PRECISION": last}
        logic = resources.ALONE.lines(variables, resources.ALONE.family(part.family))["decision"]
        slices = packed(logic)
        if part.family in resources.PAPER_FAMILIES:
            text = f"{published.PAPER}, section 5.4: 3p + 682"
            shown = resources.decision_slices(last)
            slices = Line.item("decision", "slices", shown, Status.PUBLISHED, text)
        rams = resources.field_rams_a_memory(rows, columns, last, part.block_ram_shapes)
        law = f"{last + 1} bits of each of {rows * columns:,} cells, as synthesis counts the RTL of this package"
        memories = resources.FIELD_MEMORIES * rams
        field = Line.item("field", "block_rams", memories, Status.MEASURED, law)
        return Demand(items=(slices, *logic, field))

    def clock_limit(self, job: Job[Problem, RelaxParameters]) -> Figure:
        """The fastest published clock of a design with the module, the clock of the largest block, Hz. Assumed."""
        shown = published.BLOCK.clock
        ram = job.chip.block_ram_clock
        source = f"{published.PAPER}, Table 3: the design that the module is a part of; by itself it may be faster"
        law = Figure(shown, "Hz", Status.ASSUMED, source, shown, ram.value)
        return on_family(ram if ram.value < shown else law, job.chip, *timing.FITTED)

    def steps(self, job: Job[Problem, RelaxParameters]) -> Generator[Step, None, Path]:
        """One decision."""
        plan: HarmonicPlan = job.plan
        yield one_step(self.task, timing.lone_decision_cycles(plan.precision))
        return PLANNER.path_from(job.problem, plan, job.position)

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """The power law of the whole circuit: slices × clock × the part's power a slice and Hz, W."""
        return slice_power(demand, clock, part)


class HostDecision(HostTask):
    """A decision takes one unit for each 64-bit limb of a value."""

    planner = "harmonic"
    task = "decide"
    description = "one direction in compiled code, a unit for each 64 bits of a value"
    kernel = "harmonic_decision"

    def outcome(self, job: Job[Problem, RelaxParameters]) -> tuple[int, Path]:
        """The path from the position. It begins with the direction."""
        plan: HarmonicPlan = job.plan
        return limbs_needed(plan.precision), PLANNER.path_from(job.problem, plan, job.position)


_bounds = Memo(max_bytes=64 * 2**20)


class SparseSolve(HostTask):
    """A unit for each free cell: factors, refinement and certificate together. The growth of factors is left out.

    The bound is at the last precision of the schedule, where relaxing from it is fastest: docs/replanning.md. So one
    stage is run. Its bits are the bits of a restart that runs its schedule to the end. With
    ``stop: first_without_local_maxima`` a restart may end at fewer bits.
    """

    planner = "harmonic"
    task = "lower_bound"
    style = "sparse_solve"
    description = (
        "a start nowhere above the field at the last precision, by sparse factors and exact certificates;"
        " a restart's bits under stop: schedule_end"
    )
    kernel = "sparse_solve_cell"

    def outcome(self, job: Job[Problem, RelaxParameters]) -> tuple[int, LowerBound]:
        """The bound."""
        problem, precision = job.problem, job.parameters.precisions[-1]
        # The same map is bound for many designs, and once for each plan of a drive.
        bound = _bounds.get(
            (hashlib.sha256(problem.free.tobytes()).digest(), problem.shape, problem.goals, precision),
            lambda: warm_start(problem.free, problem.goals, precision),
        )
        return max(1, int(problem.free.sum())), bound


class HostDetection(HostTask):
    """A flag is read, compared and answered: at most the cost of a node update. Assumed. The link is slower."""

    planner = "harmonic"
    task = "detect"
    description = "the flag of every sweep is asked for and answered"
    kernel = "harmonic_node_update"

    def outcome(self, _job: Job[Problem, RelaxParameters], /) -> tuple[int, None]:
        """One unit, and no result besides the answer."""
        return 1, None


TASK_STYLES = (DecisionModule(), HostDecision(), SparseSolve(), HostDetection())
