"""The common part of the styles on an FPGA: an array of nodes, loaded, run, and tracked."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Generator, Iterator, Mapping
from dataclasses import replace
from typing import Any

from codesign.ground.figures import Figure, Status
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.planners.counted import counted_activity, slice_power
from codesign.planners.interface import Problem
from codesign.planners.job import Demand, Job, Line
from codesign.planners.styles import Architecture, Designs, Family, Step, one_step
from codesign.planners.wavefront.plan.parameters import Course, Paths, PropagateParameters, ReadOut
from codesign.planners.wavefront.plan.plan import WavefrontPlan, waits
from codesign.planners.wavefront.plan.wave import longest_distance, register_bits
from codesign.planners.wavefront.styles import levers, resources, timing
from codesign.planners.wavefront.styles.designs import DESIGNS, exact_families
from codesign.planners.wavefront.styles.layout import ArrayLayout
from codesign.planners.wavefront.styles.steps import LOAD, TRACK, planned, tracked_steps
from codesign.planners.wavefront.styles.tile import tiled_items

QUIET_ACTIVITY = 0.1
"""A larger array may switch this much of a typical design: only the nodes of the wave front do. Assumed."""


class ArrayStyle(Architecture):
    """A node of the array for every node of the map or of a tile."""

    planner = "wavefront"
    style: str
    component_type = "fpga"

    @abstractmethod
    def largest_potential(self, job: Job[Problem, PropagateParameters]) -> int:
        """The largest potential that a register must hold."""

    @abstractmethod
    def items(self, job: Job[Problem, PropagateParameters]) -> tuple[Line, ...]:
        """The demand of the array."""

    @abstractmethod
    def wave_steps(self, job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
        """The waves of the plan on the clock."""

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """The array of the whole map, for the starts and for the whole map."""
        return DESIGNS

    def families(self, job: Job[Problem, Any]) -> Iterator[Family]:
        """Both read-outs of the array of the whole map, and cells that share an element, each with its exact cycles."""
        designs = (design for chain in self.designs(job) for design in chain)
        yield from exact_families(self, job, (each for design in designs for each in self.variants(job, design)))

    def variants(self, _job: Job[Problem, Any], design: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """The designs that follow from one: with each read-out."""
        for read_out in ReadOut:
            yield {**design, "read_out": str(read_out)}

    def array_shape(self, job: Job[Problem, PropagateParameters]) -> tuple[int, int]:
        """Rows and columns of the array, which are the map's."""
        return job.problem.shape

    def load_cycles(self, job: Job[Problem, PropagateParameters]) -> int:
        """Cycles to load the map."""
        return timing.load_cycles(job.problem.shape, job.parameters.element_cells)

    def chained_distance(self, job: Job[Problem, PropagateParameters]) -> int:
        """The largest p^d that the register of a chain must hold; 0 where p^d has a register of its own or none."""
        parameters = job.parameters
        if parameters.paths is not Paths.SAFE or parameters.read_out is not ReadOut.CHAIN:
            return 0
        return longest_distance(job.problem.shape, parameters.delays)

    def bits(self, job: Job[Problem, PropagateParameters]) -> int:
        """Bits of a register: as given, or as many as the problem needs."""
        given = job.parameters.register_bits
        return register_bits(self.largest_potential(job)) if given is None else given

    def layout(self, job: Job[Problem, PropagateParameters]) -> ArrayLayout:
        """The sizes that decide the demand of the array."""
        problem, parameters, obstacle_bits = job.problem, self.settled(job.parameters), 0
        if parameters.paths is Paths.SAFE and parameters.read_out is ReadOut.ADDRESSED:
            longest = longest_distance(problem.shape, parameters.delays)
            obstacle_bits = register_bits(longest)
        return replace(self.outline(job), bits=self.bits(job), obstacle_bits=obstacle_bits)

    def outline(self, job: Job[Problem, PropagateParameters]) -> ArrayLayout:
        """The layout without the widths of its registers, which follow from a plan."""
        problem, parameters = job.problem, self.settled(job.parameters)
        return ArrayLayout(
            self.array_shape(job),
            0,
            0,
            parameters.delays[-1],
            0 if parameters.penalty is None else parameters.penalty.delay,
            parameters.corner_cutting,
            element_cells=parameters.element_cells,
            safe=parameters.paths is Paths.SAFE,
            chain=parameters.read_out is ReadOut.CHAIN,
            waits=waits(problem, parameters),
            tracked=job.does(TRACK),
            local=parameters.course is Course.LOCAL,
        )

    def demand(self, job: Job[Problem, PropagateParameters]) -> Demand:
        """Nodes, memories, read-out, tracker and control; the register against the largest potential.

        Where the path is tracked elsewhere, the array has no tracker; its read-out remains, as it sends the potentials.
        """
        map_shape, part = job.problem.shape, job.chip
        layout = self.layout(job)
        largest = self.largest_potential(job)
        needed = register_bits(largest)
        items = self.items(job)
        bounds: tuple[Line, ...] = (levers.register_bound(needed, layout.bits, largest),)
        spare = (layout.bits, needed) if layout.bits > needed else None
        delay_line = resources.array_items(replace(layout, shape=map_shape, adders=False), part)

        def in_tiles(tile: tuple[int, int]) -> tuple[Line, ...]:
            return tiled_items(layout, map_shape, tile, part)

        other = levers.Alternatives({"delay_line": delay_line}, in_tiles, map_shape, spare)
        return Demand(items, bounds, levers.resource_levers(items, part, other))

    def clock_limit(self, job: Job[Problem, PropagateParameters]) -> Figure:
        """The fastest clock for an array of this size on the part, Hz."""
        return timing.clock_limit(self.outline(job), job.chip)

    def work(self, job: Job[Problem, PropagateParameters]) -> Generator[Step, None, WavefrontPlan]:
        """Phases ``load``, ``propagate_obstacles`` (safe paths), ``propagate`` (``exchange``), ``read_out`` of a chain,
        and ``track``.

        Every wave begins anew: ``start`` changes nothing.
        """
        job = replace(job, parameters=self.settled(job.parameters), memo=Memo() if job.memo is None else job.memo)
        plan = planned(job)
        # Safe paths load the map once: in the wave from the obstacles every node takes its F for Z, and is free.
        yield one_step(LOAD, self.load_cycles(job))
        yield from self.wave_steps(job)
        if job.does(TRACK):
            yield self.tracking(job, plan)
        return plan

    def tracking(self, job: Job[Problem, PropagateParameters], plan: WavefrontPlan) -> Step:
        """The first steps of the path of the first start, or all of them, after the plan."""
        return one_step(TRACK, timing.track_cycles(tracked_steps(job, plan)))

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static power of the part, and slices × clock × the part's power a slice and Hz × the counted activity, W."""
        activity = counted_activity(self.planner, self.style)
        if activity is not None:
            activity = replace(activity, low=min(activity.interval[0], QUIET_ACTIVITY))
        return slice_power(demand, clock, part, activity, Status.ASSUMED)
