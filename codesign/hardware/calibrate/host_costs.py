"""The measured costs of a processor: the time of one unit of each kernel on this machine.

The kernels are the planners' kernels, as they are compiled here. So a platform with these costs predicts this package
on this machine. Costs of other hosts are in ``platforms/``, with their sources. ``relaxation_node_update`` is a unit of
the vectorised sweeps; a direct solution is counted in another unit (``codesign.planners.relaxation.styles.costs``).
``occupancy_cell`` and ``way_following`` are the work of a drive. They are measured on compiled twins (``kernels``),
because the simulation does this work in Python over numpy, and a robot's host would not.
"""

from __future__ import annotations

import math
import platform
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from statistics import median, quantiles
from typing import Any

import numpy as np

from codesign import maps
from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status
from codesign.ground.late import late
from codesign.ground.progress import Show, silent, tracked
from codesign.planners.breadth_first.plan import search
from codesign.planners.plug_in import Probe
from codesign.system import catalog

numba = late("numba")
kernels = late("codesign.hardware.calibrate.kernels")

LEAST_REPEATS = 5
MOST_SECONDS = 600.0

OCCUPANCY, FOLLOWING = "occupancy_cell", "way_following"
"""The kernels of a drive: one seen cell entered into the map, and one command made from a path."""


def measure_host(seconds: float = 2.0, show: Show = silent) -> dict[str, Figure]:
    """The cost of each kernel on this machine, s: the median of repeated runs, with their quartiles as the interval.

    Args:
        seconds: about how long to measure in all, without compilation. Every kernel is run at least ``LEAST_REPEATS``
            times.
        show: is told how many kernels were measured.

    Raises:
        InputError: ``seconds`` is not above 0, or above ten minutes.
    """
    number = not isinstance(seconds, bool) and isinstance(seconds, int | float)
    if not (number and math.isfinite(seconds) and 0.0 < seconds <= MOST_SECONDS):
        raise InputError(f"{seconds!r:.80} seconds", "seconds", f"give a number above 0, at most {MOST_SECONDS:g}")
    machine, probes = describe_machine(), all_probes()
    makers = tracked(probes.items(), show, "kernels measured", len(probes))
    return {name: _measured(make(), seconds / len(probes), machine) for name, make in makers}


def all_probes() -> dict[str, Callable[[], Probe]]:
    """The probes of all planners and of drives, by the name of the cost in platform files."""
    probes = {name: make for plug_in in catalog.plug_ins() for name, make in plug_in.probes.items()}
    return {**probes, **DRIVE_PROBES}


def describe_machine() -> str:
    """The processor and the compiler of the kernels, in a line."""
    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        lines = info.read_text(encoding="utf-8", errors="replace").splitlines()
        processor = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), processor)
    return f"{processor}, one core, Python {platform.python_version()}, numba {numba.__version__}"


def _measured(probe: Probe, seconds: float, machine: str) -> Figure:
    probe.seconds()  # compiles
    times: list[float] = []
    end = time.perf_counter() + seconds
    while len(times) < LEAST_REPEATS or time.perf_counter() < end:
        times.append(probe.seconds())
    low, _, high = quantiles(times, n=4)
    source = f"median of {len(times)} runs of {probe.units:,} units on {machine}"
    return Figure(median(times), "s", Status.MEASURED, source, low, high)


def _occupancy() -> Probe:
    """Scans of 180 rays of 20 cells on a path through unknown rooms, entered into the map.

    The robot covers 5 cells. A unit is one seen cell, for any number of rays through it.
    """
    free, points, directions = _mission_map()
    limit, covers = 20.0, np.array([(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)], np.int64)
    scans = [kernels.measure_ranges(free, y, x, limit, directions) for y, x in points]

    def run() -> int:
        believed, seen = np.zeros(free.shape, np.int8), np.full(free.shape, -1, np.int32)
        obstacles, risks = np.zeros(free.shape, np.int32), np.full(free.shape, len(covers), np.int32)
        return sum(
            int(
                kernels.enter_scan(believed, obstacles, risks, seen, turn, y, x, limit, scans[turn], directions, covers)
            )
            for turn, (y, x) in enumerate(points)
        )

    return Probe(run(), run)


def _following() -> Probe:
    """Commands along a path through rooms, cell by cell. Each searches the whole path, and checks 10 cells ahead."""
    free, points, _ = _mission_map()
    risks = (~free).astype(np.int32)
    return Probe(len(points), lambda: kernels.follow(points, risks, 10.0))


def _mission_map() -> tuple[Any, Any, Any]:
    """Rooms of 64 × 96 cells, a path through them as float64 n × 2, and the unit vectors of 180 rays."""
    free = maps.rooms(64, 96, room=(15, 15), door=4, wall=1, seed=1).free
    (top, left), *_, (bottom, right) = np.argwhere(free).tolist()
    path = search(free, (top, left), (bottom, right)).path.astype(np.float64)
    angles = np.arange(180) * (np.pi / 90.0) + 0.001
    return free, path, np.column_stack((np.sin(angles), np.cos(angles)))


DRIVE_PROBES: Mapping[str, Callable[[], Probe]] = {OCCUPANCY: _occupancy, FOLLOWING: _following}
"""The probes of the kernels of a drive, by name."""
