"""The common part of the styles on an FPGA: an array of nodes, loaded, run, and tracked."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from codesign.ground.figures import Figure, Status
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.planners.counted import counted_activity, slice_power
from codesign.planners.interface import Problem
from codesign.planners.job import Demand, Job, Lever, Line, part_lever, short_resources
from codesign.planners.styles import Architecture, Designs, Family, Step, one_step
from codesign.planners.wavefront.plan.grid import check_cells
from codesign.planners.wavefront.plan.parameters import (
    MAX_ELEMENT_CELLS,
    Course,
    Paths,
    PropagateParameters,
    ReadOut,
    WaveEnd,
)
from codesign.planners.wavefront.plan.plan import WavefrontPlan, plan_key, problem_map, sizing_plan, waits
from codesign.planners.wavefront.plan.wave import longest_distance, obstacle_map, register_bits
from codesign.planners.wavefront.styles import resources, timing
from codesign.planners.wavefront.styles.designs import BEYOND, DESIGNS, exact_families
from codesign.planners.wavefront.styles.resources import ArrayLayout
from codesign.planners.wavefront.styles.tile import tiled_items
from codesign.planners.wavefront.styles.timing import (
    LOAD,
    OBSTACLES,
    PROPAGATE,
    TRACK,
    planned,
    read_out_steps,
    tracked_steps,
    updates,
)

Shape = tuple[int, int]
ItemsOf = Callable[[Shape], tuple[Line, ...]]


def largest_tile(items_of: ItemsOf, map_shape: Shape, part: Part) -> Shape | None:
    """The largest square, cut to the map, with an array that fits the part; None: not even one node fits.

    The nodes' demand grows with the side, but the memories' demand falls by steps, so every side is tried from the
    largest down, in steps of an eighth above 128.
    """
    side = max(map_shape)
    while side >= 1:
        shape = min(side, map_shape[0]), min(side, map_shape[1])
        if not short_resources(items_of(shape), part):
            return shape
        side = side - 1 if side <= 128 else side * 7 // 8
    return None


@dataclass(frozen=True)
class Alternatives:
    """Other designs for the same problem: whole-map arrays by style, tiled arrays by tile, a narrower register.

    ``spare_bits``: bits of the register, and the smaller number that is enough; or None.
    """

    whole: Mapping[str, tuple[Line, ...]]
    tiled: ItemsOf
    map_shape: Shape
    spare_bits: tuple[int, int] | None


def resource_levers(items: tuple[Line, ...], part: Part, other: Alternatives) -> dict[str, tuple[Lever, ...]]:
    """For each resource that the part lacks: a style or a tile that fits it, a narrower register, another part."""
    short = short_resources(items, part)
    if not short:
        return {}
    shared = [
        Lever("propagate.style", f"{style} fits {part.name}", axes={"propagate.style": style})
        for style, array in other.whole.items()
        if not short_resources(array, part)
    ]
    tile = largest_tile(other.tiled, other.map_shape, part)
    if tile is not None:
        axes = {"propagate.style": "tiled", "propagate.tile": list(tile)}
        text = f"style tiled with [{tile[0]}, {tile[1]}] fits {part.name}"
        shared.append(Lever("propagate.tile", text, axes=axes))
    if not shared:
        shared.append(Lever("propagate.style", f"no style and no tile fits {part.name}"))
    if other.spare_bits is not None:
        asked, enough = other.spare_bits
        axis, text = "propagate.register_bits", f"{enough} are enough, {asked} are asked for"
        shared.append(Lever(axis, text, axes={axis: enough}))
    return {kind: (*shared, part_lever(kind, need)) for kind, need in short.items()}


def register_bound(needed: int, given: int, largest: int) -> Line:
    """Registers hold potentials up to the largest, and infinity."""
    levers: tuple[Lever, ...] = ()
    if given < needed:
        levers = (
            Lever(
                "propagate.register_bits",
                f"at least {needed} bits hold {largest} and infinity, {largest + 1}",
                axes={"propagate.register_bits": needed},
            ),
            Lever("problem", f"a map whose largest potential is at most {2**given - 2}"),
        )
    return Line.bound(
        name="register",
        demand=needed,
        limit=given,
        unit="bits",
        status=Status.MEASURED,
        source=f"the largest potential of this problem is {largest}; one value more is infinity",
        levers=levers,
    )


QUIET_ACTIVITY = 0.1
"""A larger array may switch this much of a typical design: only the nodes of the wave front do. Assumed."""


class ArrayStyle(Architecture):
    """A node of the array for every node of the map or of a tile."""

    planner = "wavefront"
    style: str
    component_type = "fpga"
    beyond = BEYOND

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
        bounds: tuple[Line, ...] = (register_bound(needed, layout.bits, largest),)
        spare = (layout.bits, needed) if layout.bits > needed else None
        delay_line = resources.array_items(replace(layout, shape=map_shape, adders=False), part)

        def in_tiles(tile: tuple[int, int]) -> tuple[Line, ...]:
            return tiled_items(layout, map_shape, tile, part)

        other = Alternatives({"delay_line": delay_line}, in_tiles, map_shape, spare)
        return Demand(items, bounds, resource_levers(items, part, other))

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


# Style ``adder_comparator``: eight adders and eight comparators a node (Hassoun and Sanghvi 1990).
#
# The paper compares its node with this one (reference [4]). All nodes update their potentials by equation 3 in every
# cycle, until none changes. The array cannot stop at a stop node, as a smaller potential may still come by more steps.

_waves = Memo(max_bytes=2**20)


class AdderComparator(ArrayStyle):
    """An update a cycle: as many as the longest shortest path has steps, and one before and after them."""

    style = "adder_comparator"
    description = "a node with adders and comparators for every cell (Hassoun and Sanghvi)"

    def settled(self, parameters: PropagateParameters) -> PropagateParameters:
        """With ``stop: whole_map``: the potential of a start is final only when no potential changes any more.

        Nodes are not shared.
        """
        return parameters.model_copy(update={"stop": WaveEnd.WHOLE_MAP, "element_cells": 1})

    def designs(self, _job: Job[Problem, Any]) -> Designs:
        """One: it cannot wait for a start."""
        return DESIGNS[-1:]

    def notes(self, job: Job[Problem, PropagateParameters]) -> tuple[str, ...]:
        """A note where the parameters ask for a stop at the starts, which this style cannot do."""
        if job.parameters.stop is WaveEnd.WHOLE_MAP or not job.problem.starts:
            return ()
        return (
            f"propagate.stop: style {self.style} runs as with whole_map, as it cannot stop at a start: a smaller"
            " potential may still come by a path of more steps",
        )

    def largest_potential(self, job: Job[Problem, PropagateParameters]) -> int:
        """The largest potential of the whole map: nothing stops the updates before. Of a replan both maps count."""
        maps = dict.fromkeys((job.problem, job.problem.changed))
        largest = max(self._whole(replace(job, problem=each))[0] for each in maps)
        # One register for both: p^d of safe paths is computed by the same adders.
        if job.parameters.paths is Paths.SAFE:
            largest = max(largest, longest_distance(job.problem.shape, job.parameters.delays))
        return largest

    def items(self, job: Job[Problem, PropagateParameters]) -> tuple[Line, ...]:
        """Nodes, read-out, tracker and control, with the tree that detects a changed potential."""
        return resources.array_items(replace(self.layout(job), adders=True), job.chip)

    def wave_steps(self, job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
        """Updates until no potential changes; for safe paths, p^d first."""
        problem, parameters = job.problem, job.parameters
        if parameters.paths is Paths.SAFE:
            key = ("wavefront obstacle updates", problem.map_digest, parameters.delays)
            count = job.shared(key, lambda: obstacle_updates(problem, parameters))
            yield one_step(OBSTACLES, timing.adder_cycles(count))
            yield from read_out_steps(job)
        yield one_step(PROPAGATE, timing.adder_cycles(self._whole(job)[1]))
        yield from read_out_steps(job)

    def clock_limit(self, job: Job[Problem, PropagateParameters]) -> Figure:
        """The fastest clock: five operations over R bits are chained in a cycle."""
        return timing.clock_limit(replace(self.outline(job), adders=True, bits=self.bits(job)), job.chip)

    def _whole(self, job: Job[Problem, PropagateParameters]) -> tuple[int, int]:
        problem, parameters = job.problem, job.parameters
        key = ("whole", *plan_key(problem, parameters, ()))

        def compute() -> tuple[int, int]:
            sources = check_cells(problem.goals, problem.free, "goals")
            return updates(problem_map(problem, parameters), sources)

        return _waves.get(key, compute)


def obstacle_updates(problem: Problem, parameters: PropagateParameters) -> int:
    """Updates until p^d is final; 0 on a map without obstacles."""
    wave_map, obstacles = obstacle_map(problem.free, parameters.delays)
    return updates(wave_map, obstacles)[1] if len(obstacles) else 0


class DelayLine(ArrayStyle):
    """Figure 2. The wave is the computation: D_stop + 1 cycles, and fewer nodes reached where it stops early."""

    style = "delay_line"
    description = "a node of delay lines for every cell: the wave is the computation"

    def largest_potential(self, job: Job[Problem, PropagateParameters]) -> int:
        """D_stop of the farthest start, or the largest potential of the map where the wave runs to its end."""
        largest = sizing_plan(job.problem, job.parameters).largest_potential
        return max(largest, self.chained_distance(job))

    def variants(self, job: Job[Problem, Any], design: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """Each read-out, and elements of up to a column: more cells take more cycles and no fewer elements."""
        for variant in super().variants(job, design):
            for power in range(min(MAX_ELEMENT_CELLS, job.problem.rows - 1).bit_length() + 1):
                yield {**variant, "element_cells": 1 << power}

    def items(self, job: Job[Problem, PropagateParameters]) -> tuple[Line, ...]:
        """Nodes or elements, their memories, read-out, tracker and control."""
        return resources.array_items(self.layout(job), job.chip)

    def wave_steps(self, job: Job[Problem, PropagateParameters]) -> Iterator[Step]:
        """D + 1 steps: of the stop, or of the farthest cell; for p^d, of the longest distance of the map."""
        plan, cells = planned(job), job.parameters.element_cells
        if plan.obstacle_potentials is not None:
            longest = longest_distance(job.problem.shape, job.parameters.delays)
            yield one_step(OBSTACLES, timing.wave_cycles(longest, cells))
            yield from read_out_steps(job)
        yield one_step(PROPAGATE, timing.wave_cycles(plan.largest_potential, cells))
        yield from read_out_steps(job)
