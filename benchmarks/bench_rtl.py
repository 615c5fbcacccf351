"""How fast the bit planes are against simulators of the exported array: same design point, same bits, one run.

Simulators that are not installed are left out. Each runs the bench of ``hwsw rtl`` or, in CXXRTL, its equal.
"""

from __future__ import annotations

import os
import resource
import sys
import time
from collections.abc import Iterator
from functools import partial
from tempfile import TemporaryDirectory
from typing import Any
from unittest.mock import patch

import numpy as np

from codesign.hardware.rtl import bench_runs, tools
from codesign.hardware.rtl.verify import compared, simulate
from codesign.maps.generate import rooms
from codesign.planners.circuits import CircuitStyle
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
from codesign.planners.harmonic.rtl import CIRCUITS
from codesign.planners.interface import Problem
from codesign.planners.job import Job

BLOCK = (12, 24)
SETTINGS: dict[str, Any] = {"block": BLOCK, "iterations": 64, "schedule": tuple(range(8, 65, 8))}
GOAL = (2, 3)
NEEDS = {"cxxrtl": "pyosys", "icarus": "iverilog", "verilator": "verilator"}
"""The tool of each simulator."""

TARGET = 300
"""Times as fast as Verilator."""

CLOCK = 150e6
ALL_IN_ONE = frozenset({"relax", "detect", "decide"})


def design_point() -> tuple[CircuitStyle, Job[Problem, RelaxParameters]]:
    """The array of 12 × 24 nodes at 64 bits, on a map with two rooms."""
    free = rooms(*BLOCK, room=(12, 11), door=2, seed=1).free
    start = tuple(int(side) for side in np.argwhere(free)[-1])
    parameters = RelaxParameters(**SETTINGS, stop=Stop.SCHEDULE_END)
    problem = Problem(free, (GOAL,), ((start[0], start[1]),))
    job = Job(problem, parameters, inside=ALL_IN_ONE, position=(float(start[0]), float(start[1])))
    return CIRCUITS[0], job


def simulated(style: CircuitStyle, job: Job[Problem, RelaxParameters], backend: str) -> tuple[float, float, int]:
    """Seconds of processor time that the build and the run take, and the differences from the model.

    Every program is built anew, to run fast: the cache is a temporary folder.
    """
    circuit, expected = style.circuit(job), style.expected(job)
    marks = []

    def mark(words: str, _cycles: int, expected_cycles: int) -> None:
        if not expected_cycles:
            print(f"{words}: {sum(expected.cycles.values()):,} cycles", file=sys.stderr, flush=True)
            marks.append(of_children())

    fast = patch.object(bench_runs, "LONG", 0)
    with TemporaryDirectory() as cache, patch.dict(os.environ, {"CODESIGN_CACHE_DIR": cache}), fast:
        result = simulate(circuit, expected, backend, None, mark)
    built, begun, ended = (*marks, of_children())
    return begun - built, ended - begun, compared(circuit, expected, result).differences


def of_children() -> float:
    """The processor time of all tools that have ended, s."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def run() -> Iterator[dict[str, str]]:
    """One row for each simulator, as soon as it is measured."""
    style, job = design_point()
    problem = job.problem
    plan = partial(relax, problem.free, problem.goals, **SETTINGS)
    plan()
    times = []
    for _ in range(15):
        begin = time.thread_time()
        result = plan()
        times.append(time.thread_time() - begin)
    own, updates, cycles = min(times), result.total_iterations * BLOCK[0] * BLOCK[1], result.total_cycles
    yield _row("bit planes", own, updates, cycles, "", "")
    for backend in ("verilator", "cxxrtl", "icarus"):
        if tools.command_of(NEEDS[backend]) is None:
            continue
        build, seconds, differences = simulated(style, job, backend)
        note = f"build {build:.1f} s, {differences} differences"
        yield _row(backend, seconds, updates, cycles, f"{seconds / own:,.0f}", note)


def _row(name: str, seconds: float, updates: int, cycles: int, ratio: str, note: str) -> dict[str, str]:
    return {
        "12 × 24 nodes, p = 64": name,
        "s": f"{seconds:.4g}",
        "10⁶ node updates/s": f"{updates / seconds / 1e6:.3g}",
        "simulated over processor time at 150 MHz": f"{cycles / CLOCK / seconds:.2g}",
        "times that of the bit planes": ratio,
        "note": note,
    }
