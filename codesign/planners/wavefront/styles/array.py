"""What the styles on an FPGA have in common: an array of nodes, loaded, run, and tracked."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Generator, Iterator
from dataclasses import replace
from typing import Any

from codesign.figures import Figure, Status, weakest
from codesign.memo import Memo
from codesign.part import Part
from codesign.planners.interface import Problem
from codesign.planners.styles import Architecture, Demand, Line, Memory, Step, is_done
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters
from codesign.planners.wavefront.plan.plan import WavefrontPlan
from codesign.planners.wavefront.plan.wave import longest_distance, register_bits
from codesign.planners.wavefront.styles import levers, resources, timing
from codesign.planners.wavefront.styles.resources import Layout
from codesign.planners.wavefront.styles.steps import LOAD, TRACK, planned, task_step, tracked_steps

QUIET_ACTIVITY = 0.1
"""Dynamic power may be this much of a typical design's: only the nodes of the wave front switch. Assumed."""


class ArrayStyle(Architecture):
    """A node of the array for every node of the map or of a tile."""

    planner = "wavefront"
    style: str
    component_type = "fpga"
    kernel = ""

    @abstractmethod
    def largest_potential(self, problem: Problem, parameters: PropagateParameters) -> int:
        """The largest potential that a register has to hold."""

    @abstractmethod
    def items(self, layout: Layout, problem: Problem, part: Part) -> tuple[Line, ...]:
        """The demand of an array of ``layout``."""

    @abstractmethod
    def wave_steps(
        self, problem: Problem, parameters: PropagateParameters, memo: Memo, detail: bool
    ) -> Iterator[Step]:
        """The waves of the plan on the clock."""

    def array_shape(self, problem: Problem, parameters: PropagateParameters) -> tuple[int, int]:  # noqa: ARG002
        """Rows and columns of the array: those of the map."""
        return problem.rows, problem.columns

    def bits(self, problem: Problem, parameters: PropagateParameters) -> int:
        """Bits of a register: as given, or as many as the problem needs."""
        if parameters.register_bits is not None:
            return parameters.register_bits
        return register_bits(self.largest_potential(problem, parameters))

    def layout(self, problem: Problem, parameters: PropagateParameters) -> Layout:
        """What decides the size of the array."""
        obstacle_bits = 0
        if parameters.paths is Paths.SAFE:
            longest = longest_distance((problem.rows, problem.columns), parameters.delays)
            obstacle_bits = register_bits(longest)
        return Layout(
            self.array_shape(problem, parameters),
            self.bits(problem, parameters),
            obstacle_bits,
            parameters.delays[-1],
            0 if parameters.penalty is None else parameters.penalty.delay,
            parameters.corner_cutting,
        )

    def demand(
        self,
        problem: Problem,
        parameters: PropagateParameters,
        part: Part,
        *,
        inside: frozenset[str] | None = None,  # noqa: ARG002
    ) -> Demand:
        """Nodes, counter and select lines; the register against the largest potential.

        ``inside`` changes nothing: the papers count no circuit that tracks, and the chains that read the potentials out
        are needed to send them, too.
        """
        layout = self.layout(problem, parameters)
        largest = self.largest_potential(problem, parameters)
        needed = register_bits(largest)
        items = self.items(layout, problem, part)
        bounds: tuple[Line, ...] = (levers.register_bound(needed, layout.bits, largest),)
        spare = (layout.bits, needed) if layout.bits > needed else None
        whole = replace(layout, shape=(problem.rows, problem.columns))
        delay_line = resources.array_items(resources.delay_line_node(whole), whole)
        map_shape = problem.rows, problem.columns

        def in_tiles(tile: tuple[int, int]) -> tuple[Line, ...]:
            return resources.tiled_items(layout, map_shape, tile, part)

        other = levers.Alternatives({"delay_line": delay_line}, in_tiles, map_shape, spare)
        return Demand(items, bounds, levers.resource_levers(items, part, other))

    def clock_limit(self, problem: Problem, parameters: PropagateParameters, part: Part) -> Figure:
        """The fastest clock for an array of this size on the part, Hz."""
        rows, columns = self.array_shape(problem, parameters)
        return timing.clock_limit(rows * columns, part)

    def memory(self, problem: Problem, parameters: PropagateParameters) -> Memory | None:  # noqa: ARG002
        """None: potentials stay in the nodes' registers."""
        return None

    def work(
        self,
        problem: Problem,
        parameters: PropagateParameters,
        *,
        memo: Memo | None = None,
        detail: bool = True,
        start: Any = None,  # noqa: ARG002
        inside: frozenset[str] | None = None,
    ) -> Generator[Step, None, WavefrontPlan]:
        """Phases ``load``, ``propagate_obstacles`` (safe paths), ``propagate`` (``exchange``) and ``track``.

        Every wave begins anew: ``start`` changes nothing.
        """
        kept = Memo() if memo is None else memo
        parameters = self.settled(parameters)
        plan = planned(problem, parameters, kept)
        # Safe paths load the map twice: obstacles as sources first (all nodes free), then the free space.
        passes = 2 if plan.obstacle_potentials is not None else 1
        yield task_step(LOAD, passes * timing.load_cycles(problem.free.size))
        yield from self.wave_steps(problem, parameters, kept, detail)
        if is_done(TRACK, inside):
            yield self.tracking(problem, parameters, plan)
        return plan

    def tracking(self, problem: Problem, parameters: PropagateParameters, plan: WavefrontPlan) -> Step:
        """The first steps of the way of the first start, or all of them, once the plan stands."""
        steps = tracked_steps(problem, parameters, plan)
        return task_step(TRACK, timing.track_cycles(steps, parameters.paths))

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static power of the part, and slices × clock × the part's power a slice and Hz, W."""
        scale = demand.total("slices") * clock
        rate = part.dynamic_power
        low, high = rate.interval
        dynamic = Figure(
            value=rate.value * scale,
            unit="W",
            status=weakest(Status.ASSUMED, rate.status),
            source=f"slices × clock × {rate.value * 1e12:.3g} µW a slice and MHz ({rate.source}); down to a tenth of"
            " the lower bound, as only nodes of the wave front switch",
            low=low * scale * QUIET_ACTIVITY,
            high=high * scale,
        )
        return part.static_power, dynamic
