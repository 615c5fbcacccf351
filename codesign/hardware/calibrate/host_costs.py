"""The host that this machine is: the time of one unit of each kernel, its cores, its load and its jitter.

Probes time each kernel of a planner, as it is compiled here. Where a planner names plans to be timed (``Timed``), the
costs of their kernels are fitted to plans on several maps (``host_fit``). ``relaxation_node_update`` is a unit of the
vectorised sweeps; a direct solution is counted in another (``codesign.planners.relaxation.styles.host``).
``occupancy_cell`` and ``way_following``, the work of a drive, are measured on compiled twins (``kernels``), because the
simulation does this work in Python over numpy, and a robot's host would not.
"""

from __future__ import annotations

import json
import math
import os
import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from codesign import maps
from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status
from codesign.ground.late import late
from codesign.ground.progress import Show, silent, tracked
from codesign.ground.units import format_frequency
from codesign.hardware.calibrate.host_fit import (
    Disturbance,
    ProgramFit,
    disturbance_of,
    fit_programs,
    plans_on,
    questions,
    time_plans,
)
from codesign.inputs.library import HOSTS, HostFile
from codesign.planners.breadth_first.plan import search
from codesign.planners.plug_in import Probe
from codesign.system import catalog

numba = late("numba")
kernels = late("codesign.hardware.calibrate.kernels")

LEAST_REPEATS = 5
SHARE = 0.2
"""The share of the time that probes take; plans take the rest."""
MOST_SECONDS = 600.0

OCCUPANCY, FOLLOWING = "occupancy_cell", "way_following"
"""The kernels of a drive: one seen cell entered into the map, and one command made from a path."""


@dataclass(frozen=True)
class MeasuredHost:
    """A host as it was measured.

    ``costs``: of each kernel, s a unit. ``fits``: of the kernels that were fitted to plans. ``not_timed``: by program,
    the reason for which it was not.
    """

    machine: str
    cores: int
    clock_hz: int | None
    costs: Mapping[str, Figure]
    disturbance: Disturbance
    fits: tuple[ProgramFit, ...]
    not_timed: Mapping[str, str]


def measure_host(seconds: float = 20.0, show: Show = silent) -> MeasuredHost:
    """This machine as a host.

    The cost of a kernel of a timed plan is fitted; any other is the median of a probe's runs, with their 1st and 99th
    percentile as the interval.

    Args:
        seconds: about how long to measure in all, without compilation. Every kernel is run at least ``LEAST_REPEATS``
            times, every plan at least ``host_fit.LEAST_ROUNDS`` times.
        show: is told how many kernels and plans were measured.

    Raises:
        InputError: ``seconds`` is not above 0, or above ten minutes.
    """
    number = not isinstance(seconds, bool) and isinstance(seconds, int | float)
    if not (number and math.isfinite(seconds) and 0.0 < seconds <= MOST_SECONDS):
        raise InputError(f"{seconds!r:.80} seconds", "seconds", f"give a number above 0, at most {MOST_SECONDS:g}")
    machine, probes = describe_machine(), all_probes()
    makers = tracked(probes.items(), show, "kernels measured", len(probes))
    costs = {name: _measured(make(), SHARE * seconds / len(probes), machine) for name, make in makers}
    plans = [*plans_on([*questions()], [*costs])]
    timings = time_plans(plans, (1 - SHARE) * seconds, show)
    fits = fit_programs(timings, {name: cost.value for name, cost in costs.items()}, machine)
    fitted = {kernel: cost for fit in fits for kernel, cost in fit.costs.items()}
    disturbance = disturbance_of(timings, machine)
    return MeasuredHost(machine, os.cpu_count() or 1, clock_of_machine(), costs | fitted, disturbance, fits, {})


def clock_of_machine() -> int | None:
    """The greatest clock of this processor as Linux says it, Hz; None where it does not."""
    said = Path("/sys/devices/system/cpu/cpu0/cpufreq/cpuinfo_max_freq")
    return 1000 * int(said.read_text()) if said.is_file() else None


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
    low, high = np.quantile(times, (0.01, 0.99)).tolist()
    source = f"median of {len(times)} runs of {probe.units:,} units, 1st to 99th percentile, on one map; {machine}"
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
        grids = believed, obstacles, risks, seen
        return sum(
            int(kernels.enter_scan(*grids, turn, y, x, limit, scans[turn], directions, covers))
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


REFERENCE = "epyc-9004"
"""The host whose costs, times a factor, stand for the kernels that were not measured."""

UNKNOWN_POWER = {key: Figure(value, "W", Status.ASSUMED, "not measured; any computer", *ends) for key, value, ends in (
    ("busy", 5.0, (0.05, 300.0)),
    ("idle", 2.0, (0.0, 200.0)),
)}  # fmt: skip
"""Of a host that is like none with a file."""

HEAD = "# Written by hwsw calibrate host. Name it in a platform: the key host of a processor.\n"


def processor_text(host: MeasuredHost) -> str:
    """The keys of a processor: cores, load, jitter and costs, as YAML."""
    disturbed = host.disturbance
    lines = [
        f"cores: {host.cores}",
        f"load: {_flow(disturbed.load)}",
        "jitter:",
        *(f"  {name}: {_flow(figure)}" for name, figure in (("median", disturbed.median), ("p99", disturbed.p99))),
        "costs:",
        *(f"  {name}: {_flow(cost)}" for name, cost in sorted(host.costs.items())),
    ]
    return "\n".join(lines) + "\n"


def host_text(host: MeasuredHost, name: str, like: str | None) -> str:
    """A host file.

    ``like``: the host that stands for what was not measured: power, clock, and kernels times a factor. None: kernels
    are of ``REFERENCE``, and the power may be any computer's.

    Raises:
        InputError: there is no such host.
    """
    other = HOSTS.find(like or REFERENCE)
    clock, power = other.clock, UNKNOWN_POWER if like is None else dict(other.power)
    if host.clock_hz is not None:
        clock = Figure(host.clock_hz, "Hz", Status.MEASURED, "as the system of the board says")
    lines = [
        "kind: host",
        f"name: {name}",
        f"description: {json.dumps(f'{host.machine}, as hwsw calibrate host measured it')}",
        f"clock: {_flow(clock, '' if host.clock_hz else f'of host {other.name}; ')}",
        processor_text(host) + _costs_of(host, other) + "power:",
        *(f"  {key}: {_flow(figure, f'of host {like}; ' if like else '')}" for key, figure in power.items()),
    ]
    return HEAD + "\n".join(lines) + "\n"


def _costs_of(host: MeasuredHost, other: HostFile) -> str:
    """The kernels that were not measured: those of another host, by the ratios of the kernels that were."""
    base = HOSTS.find(other.costs_of.host) if other.costs_of else other
    # The kernel of a style has most of its time; of others, such as a diagonal, a program on a board may have nothing.
    kernels = {style.kernel for style in catalog.architectures().values()} & host.costs.keys() & base.costs.keys()
    ratios = [1e12 * host.costs[name].value / base.costs[name].value for name in kernels]
    if not ratios or base.costs.keys() <= host.costs.keys():
        return ""
    source = f"{', '.join(sorted(kernels))} over those of {base.name}: the median; half the least, twice the most"
    factor = Figure(median(ratios), "1", Status.ASSUMED, source, min(ratios) / 2, 2 * max(ratios))
    return f"costs_of:\n  host: {base.name}\n  factor: {_flow(factor)}\n"


def host_document(host: MeasuredHost) -> dict[str, Any]:
    """A measured host for programs, with the fits and what each left on every map."""
    return {
        "machine": host.machine,
        "cores": host.cores,
        "clock_hz": host.clock_hz,
        **asdict(host.disturbance),
        "costs": {name: asdict(figure) for name, figure in host.costs.items()},
        "fits": [
            {
                "program": fit.program,
                "kernels": [*fit.costs],
                "maps": [
                    {"map": each.map, "measured_s": each.measured, "predicted_s": each.predicted}
                    | {"held_out_s": each.held_out}
                    for each in fit.residuals
                ],
            }
            for fit in host.fits
        ],
        "not_timed": dict(host.not_timed),
    }


def _flow(figure: Figure, before: str = "") -> str:
    """A figure as a line of YAML. ``before``: put before its source."""
    value, (low, high) = figure.value, figure.interval
    numbers = {"value": value} | ({} if low == high else {"low": low, "high": high})
    text = ", ".join(f"{key}: {_quantity(number, figure.unit)}" for key, number in numbers.items())
    return f"{{{text}, status: {figure.status}, source: {json.dumps(before + figure.source, ensure_ascii=False)}}}"


def _quantity(number: float, unit: str) -> str:
    """A number as platform files write it: of a cost, whole picoseconds."""
    if unit == "s":
        return f"{max(1, round(number * 1e12))} ps"
    return format_frequency(int(number)) if unit == "Hz" else f"{number:.6g}{'' if unit == '1' else f' {unit}'}"
