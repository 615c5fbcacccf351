"""The plan: potentials on a problem under the parameters of a mapping."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.errors import MapError
from codesign.memo import Memo
from codesign.planners.interface import Problem
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
    - ``stop_potential``: the potential of the farthest stop, at which the wave ended; None where it ran to its end.
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
        import hashlib

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


def stop_cells(problem: Problem, parameters: PropagateParameters) -> NDArray[np.int64]:
    """The cells that the wave is to reach, n × 2; none where it runs to its end.

    Raises:
        MapError: a start outside of the map or on an obstacle.
    """
    if parameters.stop is WaveEnd.WHOLE_MAP or not problem.starts:
        return np.zeros((0, 2), np.int64)
    return check_cells(problem.starts, problem.free, "starts")


def compute_plan(problem: Problem, parameters: PropagateParameters) -> WavefrontPlan:
    """Run the wave without a clock.

    Raises:
        MapError: a goal or start that cannot be used, or a start that no path joins to a goal while the wave
            waits for it.
    """
    wave_map = problem_map(problem, parameters)
    stops = stop_cells(problem, parameters)
    sources = check_cells(problem.goals, problem.free, "goals")
    potentials, _ = run_wave(wave_map, sources, stops)
    distances = None
    if parameters.paths is Paths.SAFE:
        distances = obstacle_potentials(problem.free, delays=parameters.delays)
    last = int(potentials[tuple(stops.T)].max()) if len(stops) else None
    return WavefrontPlan(potentials, distances, last, wave_map)


def plan_key(problem: Problem, parameters: PropagateParameters) -> tuple[object, ...]:
    """Everything that a plan depends on. Widths of registers and shapes of tiles do not change a plan."""
    chosen = parameters.model_dump(include={"stop", "paths", "corner_cutting", "delays", "penalty"})
    return "wavefront", problem.digest, repr(sorted(chosen.items()))


def cached_plan(problem: Problem, parameters: PropagateParameters) -> WavefrontPlan:
    """``compute_plan``, kept in this process: laws of resources ask for it before anything runs."""
    return _plans.get(plan_key(problem, parameters), lambda: compute_plan(problem, parameters))


def sizing_parameters(problem: Problem, parameters: PropagateParameters) -> PropagateParameters:
    """The parameters for laws of size: without a stop where the wave cannot reach a start.

    ``Wavefront.check`` refuses such a plan. But a drive may begin in this state, and its design still has a size.
    """
    try:
        cached_plan(problem, parameters)
    except MapError:
        return parameters.model_copy(update={"stop": WaveEnd.WHOLE_MAP})
    return parameters
