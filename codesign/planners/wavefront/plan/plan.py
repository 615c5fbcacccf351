"""The plan: potentials on a problem under the parameters of a mapping."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError
from codesign.ground.memo import Memo
from codesign.ground.models import Task
from codesign.planners.interface import Cell, Problem
from codesign.planners.wavefront.plan.grid import WaveMap, check_cells, check_map
from codesign.planners.wavefront.plan.parameters import Paths, PropagateParameters, WaveEnd
from codesign.planners.wavefront.plan.tracking import Tracker
from codesign.planners.wavefront.plan.wave import near_obstacles, obstacle_potentials, run_wave

_plans = Memo(max_bytes=128 * 2**20)


@dataclass(frozen=True, eq=False)
class WavefrontPlan:
    """The result of a wave.

    - ``potentials``: int32 H×W, ``UNREACHED`` where the wave did not come.
    - ``obstacle_potentials``: int32 H×W, p^d, for safe paths; else None.
    - ``stop_potential``: the potential of the start that the wave waited for, at which it ended; None where it ran to
      its end.
    - ``wave_map``: the map of the wave.
    """

    potentials: NDArray[np.int32]
    obstacle_potentials: NDArray[np.int32] | None
    stop_potential: int | None
    wave_map: WaveMap

    @property
    def largest_potential(self) -> int:
        """The largest potential of any reached cell."""
        return int(self.potentials.max())

    @property
    def reached_cells(self) -> int:
        """Cells that the wave reached, sources included."""
        return int((self.potentials >= 0).sum())

    @cached_property
    def tracker(self) -> Tracker:
        """Tracks paths over these potentials, by the rule of the parameters."""
        return Tracker(self.wave_map, self.potentials, self.obstacle_potentials)

    @cached_property
    def digest(self) -> str:
        """SHA-256 over everything that a path depends on."""
        delays, steps = self.wave_map.neighbours.delays, self.wave_map.neighbours.beside.shape
        hasher = hashlib.sha256(f"{self.potentials.shape}{delays.tolist()}{steps}".encode())
        for values in (self.potentials, self.obstacle_potentials, self.wave_map.extra):
            hasher.update(b"none" if values is None else np.ascontiguousarray(values).tobytes())
        return hasher.hexdigest()


def problem_map(problem: Problem, parameters: PropagateParameters) -> WaveMap:
    """The map of a problem with the delays of its parameters."""
    penalty = parameters.penalty
    extra = None if penalty is None else near_obstacles(problem.free, penalty.distance, penalty.delay)
    return check_map(problem.free, parameters.delays, parameters.corner_cutting, extra)


def waits(problem: Problem, parameters: PropagateParameters) -> bool:
    """True if the wave waits for a start. A field is a wave to its own end, whatever the parameters say."""
    return parameters.stop is WaveEnd.STARTS and problem.task is not Task.FIELD and bool(problem.starts)


def stops_of(problem: Problem, parameters: PropagateParameters) -> tuple[Cell, ...]:
    """The cells that the wave is to reach: the first start, or none where it runs to its end."""
    return problem.starts[:1] if waits(problem, parameters) else ()


def stop_cells(problem: Problem, stops: tuple[Cell, ...]) -> NDArray[np.int64]:
    """The stops as an array, n × 2.

    Raises:
        MapError: a start outside of the map or on an obstacle.
    """
    return check_cells(stops, problem.free, "starts") if stops else np.zeros((0, 2), np.int64)


def compute_plan(
    problem: Problem, parameters: PropagateParameters, stops: tuple[Cell, ...] | None = None
) -> WavefrontPlan:
    """Run the wave without a clock, until it has reached ``stops``: by default ``stops_of``.

    Raises:
        MapError: a goal or start that cannot be used, or a start that no path joins to a goal while the wave
            waits for it.
    """
    wave_map = problem_map(problem, parameters)
    ends = stop_cells(problem, stops_of(problem, parameters) if stops is None else stops)
    sources = check_cells(problem.goals, problem.free, "goals")
    potentials, _ = run_wave(wave_map, sources, ends)
    distances = None
    if parameters.paths is Paths.SAFE:
        distances = obstacle_potentials(problem.free, delays=parameters.delays)
    last = int(potentials[tuple(ends.T)].max()) if len(ends) else None
    return WavefrontPlan(potentials, distances, last, wave_map)


def plan_key(
    problem: Problem, parameters: PropagateParameters, stops: tuple[Cell, ...] | None = None
) -> tuple[object, ...]:
    """Everything that a plan depends on. Widths of registers and shapes of tiles do not change a plan."""
    chosen = parameters.model_dump(include={"paths", "corner_cutting", "delays", "penalty"})
    stops = stops_of(problem, parameters) if stops is None else stops
    return "wavefront", problem.map_digest, tuple(sorted(stops)), repr(sorted(chosen.items()))


def cached_plan(
    problem: Problem, parameters: PropagateParameters, stops: tuple[Cell, ...] | None = None
) -> WavefrontPlan:
    """``compute_plan``, kept in this process: laws of resources ask for it before anything runs."""
    key = plan_key(problem, parameters, stops)
    return _plans.get(key, lambda: compute_plan(problem, parameters, stops))


def sizing_stops(problem: Problem, parameters: PropagateParameters) -> tuple[Cell, ...]:
    """The stops for laws of size: every start that the wave may wait for; none where it cannot reach one of them.

    ``Wavefront.check`` refuses such a plan. But a drive may begin in this state, and its design still has a size.
    """
    stops = problem.starts if waits(problem, parameters) else ()
    try:
        cached_plan(problem, parameters, stops)
    except MapError:
        return ()
    return stops


def sizing_plan(problem: Problem, parameters: PropagateParameters) -> WavefrontPlan:
    """The plan with the largest potential that a design is sized for: a wave to the farthest start, or to its end.

    Of a replan both maps count, and the plan belongs to the map with the larger potential.
    """
    plans = [
        cached_plan(each, parameters, sizing_stops(each, parameters))
        for each in dict.fromkeys((problem, problem.changed))
    ]
    return max(plans, key=lambda plan: plan.largest_potential)


def from_farthest(problem: Problem, parameters: PropagateParameters) -> Problem:
    """The problem asked from its farthest start, whose wave is the longest; as it is where it has none."""
    if not problem.starts:
        return problem
    potentials = cached_plan(problem, parameters, ()).potentials
    return problem.asked_from(max(problem.starts, key=lambda start: potentials[start]))
