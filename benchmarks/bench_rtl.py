"""How fast the bit planes are against simulators of the exported array: same design point, same bits, one run.

Simulators that are not installed are left out. Each runs the bench of ``hwsw rtl`` or, in CXXRTL, its equal.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from codesign.maps.generate import rooms
from codesign.planners.circuits import CircuitStyle
from codesign.planners.harmonic.plan import relax
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
from codesign.planners.harmonic.rtl import CIRCUITS
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.rtl import tools
from codesign.rtl.simulate import BACKENDS, simulate
from codesign.rtl.verify import compared

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


def simulated(
    style: CircuitStyle, job: Job[Problem, RelaxParameters], backend: str
) -> tuple[float, float, int]:
    """Seconds of processor time that a build and a run take, and the differences from the model."""
    circuit, expected = style.circuit(job), style.expected(job)
    first, run = timed(lambda: simulate(circuit, expected, backend))
    again, run = timed(lambda: simulate(circuit, expected, backend))
    verified = compared(circuit, expected, run)
    return max(0.0, first - again), again, verified.differences


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """The processor time of the tools that work starts, s, and its result."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = work()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, result


def run() -> list[dict[str, str]]:
    """One row for each simulator."""
    style, job = design_point()
    problem = job.problem
    plan = partial(relax, problem.free, problem.goals, **SETTINGS)
    plan()
    times = []
    for _ in range(15):
        begin = time.thread_time()
        result = plan()
        times.append(time.thread_time() - begin)
    own, updates = min(times), result.total_iterations * BLOCK[0] * BLOCK[1]
    rows = [_row("bit planes", own, updates, result.total_cycles, "", "")]
    for backend in BACKENDS:
        if tools.command_of(NEEDS[backend]) is None:
            continue
        build, seconds, differences = simulated(style, job, backend)
        ratio = f"{seconds / own:.0f}"
        rows.append(
            _row(
                backend,
                seconds,
                updates,
                result.total_cycles,
                ratio,
                f"build {build:.0f} s, {differences} differences",
            )
        )
    return rows


def _row(name: str, seconds: float, updates: int, cycles: int, ratio: str, note: str) -> dict[str, str]:
    return {
        "12 × 24 nodes, p = 64": name,
        "s": f"{seconds:.4g}",
        "10⁶ node updates/s": f"{updates / seconds / 1e6:.3g}",
        "simulated over processor time at 150 MHz": f"{cycles / CLOCK / seconds:.2g}",
        "times the bit planes": ratio,
        "note": note,
    }
