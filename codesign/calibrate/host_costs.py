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
from pathlib import Path
from statistics import median, quantiles
from typing import Any

from codesign.errors import InputError
from codesign.figures import Figure, Status
from codesign.planners.plug_in import Probe
from codesign.system import catalog

LEAST_REPEATS = 5
MOST_SECONDS = 600.0

OCCUPANCY, FOLLOWING = "occupancy_cell", "way_following"
"""The kernels of a drive: a cell that was seen, put into the map; and one command made from a way."""


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
    machine, probes = describe_machine(), all_probes()
    return {name: _measured(make(), seconds / len(probes), machine) for name, make in probes.items()}


def all_probes() -> dict[str, Callable[[], Probe]]:
    """How each kernel is timed, by the name that platforms give its cost: those of all planners, and of drives."""
    found = {name: make for plug_in in catalog.plug_ins() for name, make in plug_in.probes.items()}
    return {**found, **DRIVE_PROBES}


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


DRIVE_PROBES: Mapping[str, Callable[[], Probe]] = {OCCUPANCY: _occupancy, FOLLOWING: _following}
"""How the kernels of a drive's own work are timed, by name."""
