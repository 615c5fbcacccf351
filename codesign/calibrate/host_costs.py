"""What this machine needs for one unit of each kernel: the costs of a processor, measured.

The kernels are those of the planners, as they are compiled here: a platform with these costs predicts this package on
this machine. Costs of other hosts stand in ``platforms/`` with their sources. ``relaxation_node_update`` is that of the
vectorised sweeps; a direct solution is counted in another (``codesign.planners.relaxation.styles.costs``).
``occupancy_cell`` and ``way_following``, a drive's own work, are those of compiled twins (``host_kernels``): the
simulation does that work in Python over numpy, which no robot's host would run.
"""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles
from typing import Any

from codesign.errors import InputError
from codesign.figures import Figure, Status

LEAST_REPEATS = 5
MOST_SECONDS = 600.0

OCCUPANCY, FOLLOWING = "occupancy_cell", "way_following"
"""The kernels of a drive: a cell that was seen, put into the map; and one command made from a way."""

_SHORT, _LONG = 10, 300
"""Iterations of the two relaxations whose difference is timed."""


@dataclass(frozen=True)
class Probe:
    """A way to time a kernel: ``run`` computes ``units`` units of it; ``without`` does all that goes beside them."""

    units: int
    run: Callable[[], object]
    without: Callable[[], object] | None = None

    def seconds(self) -> float:
        """Seconds a unit, measured once."""
        spent = _timed(self.run) - (0.0 if self.without is None else _timed(self.without))
        return spent / self.units


def measure_host(seconds: float = 2.0) -> dict[str, Figure]:
    """The cost of each kernel on this machine, s: the median of repeated runs, with their quartiles as the interval.

    Args:
        seconds: about how long to measure in all, compilation left out; every kernel is run ``LEAST_REPEATS`` times at
            the least.

    Raises:
        InputError: ``seconds`` is not above 0, or above ten minutes.
    """
    number = not isinstance(seconds, bool) and isinstance(seconds, int | float)
    if not (number and math.isfinite(seconds) and 0.0 < seconds <= MOST_SECONDS):
        raise InputError(
            f"{seconds!r:.80} seconds", "seconds", f"give a number above 0, at most {MOST_SECONDS:g}"
        )
    machine = describe_machine()
    return {name: _measured(make(), seconds / len(PROBES), machine) for name, make in PROBES.items()}


def describe_machine() -> str:
    """The processor and what the kernels are compiled with, in a line."""
    import numba

    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        lines = info.read_text(encoding="utf-8", errors="replace").splitlines()
        processor = next(
            (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), processor
        )
    return f"{processor}, one core, Python {platform.python_version()}, numba {numba.__version__}"


def _measured(probe: Probe, seconds: float, machine: str) -> Figure:
    probe.seconds()  # compiles
    found: list[float] = []
    end = time.perf_counter() + seconds
    while len(found) < LEAST_REPEATS or time.perf_counter() < end:
        found.append(probe.seconds())
    low, _, high = quantiles(found, n=4)
    source = f"median of {len(found)} runs of {probe.units:,} units on {machine}"
    return Figure(median(found), "s", Status.MEASURED, source, low, high)


def _timed(run: Callable[[], object]) -> float:
    """Seconds of this thread on a core: what it takes on an idle one, however many others want the core now."""
    begin = time.thread_time()
    run()
    return time.thread_time() - begin


def _harmonic() -> Probe:
    """Iterations over a maze as one block, at one precision, from zero until nothing changes."""
    from codesign import maps
    from codesign.planners.harmonic.plan import Relaxation, relax

    free = maps.maze(72, 132, corridor=6, seed=1).free

    def run() -> Relaxation:
        return relax(
            free, [(3, 3)], block=free.shape, iterations=1 << 20, schedule=(31,), record_visits=False
        )

    return Probe(run().total_iterations * free.size, run)


def _harmonic_decision() -> Probe:
    """Directions at all free cells of a map of rooms, at 62 bits."""
    from codesign import maps
    from codesign.planners.harmonic.plan import relax
    from codesign.planners.harmonic.plan.decision import directions

    free = maps.rooms(128, 128, room=(40, 40), door=8, wall=2, seed=4).free
    field = relax(
        free, [(64, 64)], block=free.shape, iterations=64, schedule=(62,), record_visits=False
    ).field
    return Probe(int(free.sum()), lambda: directions(field, free))


def _sparse_solve() -> Probe:
    """A start nowhere above the field at 63 bits: factors, refinement, certificate."""
    from codesign import maps
    from codesign.planners.harmonic.plan.warm_start import warm_start

    free = maps.rooms(128, 128, room=(40, 40), door=8, wall=2, seed=4).free
    return Probe(int(free.sum()), lambda: warm_start(free, [(64, 64)], 63))


def _relaxation() -> Probe:
    """Sweeps of SOR over rooms of the size of Saudi and Sulaiman's area."""
    from codesign import maps
    from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, solve

    free = maps.rooms(270, 330, room=(64, 80), door=12, wall=3, seed=1).free

    def sweeps(count: int) -> Callable[[], object]:
        # To a tolerance, so that no look for cells without a descent is timed.
        return lambda: solve(
            free,
            [(10, 10)],
            method="sor",
            omega=1.95,
            tolerance=PUBLISHED_TOLERANCE,
            boundary="low_goal",
            max_iterations=count,
        )

    return Probe((_LONG - _SHORT) * free.size, sweeps(_LONG), sweeps(_SHORT))


def _relaxation_direct() -> Probe:
    """A direct solution over rooms of a quarter of that area, shared out over the units of its law."""
    from codesign import maps
    from codesign.planners.relaxation.plan import Solution, solve
    from codesign.planners.relaxation.styles.costs import direct_units

    free = maps.rooms(135, 165, room=(32, 40), door=6, wall=2, seed=1).free

    def run() -> Solution:
        return solve(free, [(10, 10)], method="direct")

    return Probe(direct_units(run().updates), run)


def _breadth_first() -> Probe:
    """A search that pops every cell of a map without obstacles."""
    import numpy as np

    from codesign.planners.breadth_first.plan import search

    free = np.ones((500, 500), np.bool_)
    return Probe(free.size, lambda: search(free, (0, 0), (499, 499)))


def _wavefront() -> Probe:
    """A wave over all of a map without obstacles."""
    import numpy as np

    from codesign.planners.wavefront.plan import propagate

    free = np.ones((256, 256), np.bool_)
    return Probe(free.size, lambda: propagate(free, [(0, 0)]))


def _occupancy() -> Probe:
    """Scans of 180 rays of 20 cells on the way through rooms that are not known, ranges traced into the map.

    The robot covers 5 cells. A unit is a cell seen, however many rays pass it.
    """
    import numpy as np

    from codesign.calibrate import kernels as host_kernels

    free, points, directions = _mission_map()
    limit, covers = 20.0, np.array([(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)], np.int64)
    scans = [host_kernels.measure_ranges(free, y, x, limit, directions) for y, x in points]

    def run() -> int:
        believed, seen = np.zeros(free.shape, np.int8), np.full(free.shape, -1, np.int32)
        obstacles, risks = np.zeros(free.shape, np.int32), np.full(free.shape, len(covers), np.int32)
        return sum(
            int(
                host_kernels.enter_scan(
                    believed, obstacles, risks, seen, turn, y, x, limit, scans[turn], directions, covers
                )
            )
            for turn, (y, x) in enumerate(points)
        )

    return Probe(run(), run)


def _following() -> Probe:
    """Commands along a way through rooms, cell by cell: found on all of the way, and 10 cells ahead looked at."""
    import numpy as np

    from codesign.calibrate import kernels as host_kernels

    free, points, _ = _mission_map()
    risks = (~free).astype(np.int32)
    return Probe(len(points), lambda: host_kernels.follow(points, risks, 10.0))


def _mission_map() -> tuple[Any, Any, Any]:
    """Rooms of 64 × 96 cells, a way through them as float64 n × 2, and the unit vectors of 180 rays."""
    import numpy as np

    from codesign import maps
    from codesign.planners.breadth_first.plan import search

    free = maps.rooms(64, 96, room=(15, 15), door=4, wall=1, seed=1).free
    (top, left), *_, (bottom, right) = np.argwhere(free).tolist()
    path = search(free, (top, left), (bottom, right)).path.astype(np.float64)
    angles = np.arange(180) * (np.pi / 90.0) + 0.001
    return free, path, np.column_stack((np.sin(angles), np.cos(angles)))


PROBES: Mapping[str, Callable[[], Probe]] = {
    "harmonic_node_update": _harmonic,
    "harmonic_decision": _harmonic_decision,
    "sparse_solve_cell": _sparse_solve,
    "relaxation_node_update": _relaxation,
    "relaxation_direct_cell": _relaxation_direct,
    "breadth_first_cell": _breadth_first,
    "wavefront_cell": _wavefront,
    OCCUPANCY: _occupancy,
    FOLLOWING: _following,
}
"""How each kernel is timed, by the name that platforms give its cost."""
