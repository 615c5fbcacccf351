"""Robots in the closed loop: the compiled kernel against the plain reference, and against the time it stands for."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

from codesign.planners.velocity_obstacle.plan import AvoidParameters, RobotsProblem, avoid, generate
from codesign.planners.velocity_obstacle.plan.arithmetic import double, fixed

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests" / "support"))

PARAMETERS = AvoidParameters(updates=500)
REPEATS = 7
MOST_SECONDS = 0.5
"""What 8 robots × 500 updates may take."""


def best(call: Callable[[], Any], repeats: int) -> float:
    """The shortest of several times, s."""
    times = []
    for _ in range(repeats):
        begin = perf_counter()
        call()
        times.append(perf_counter() - begin)
    return min(times)


def row(problem: RobotsProblem) -> dict[str, Any]:
    import reference_robots

    done = avoid(problem, PARAMETERS)
    compiled = best(partial(avoid, problem, PARAMETERS), REPEATS)
    plain, doubles = (
        best(partial(reference_robots.run, numbers(problem, PARAMETERS), problem, PARAMETERS), 1)
        for numbers in (fixed, double)
    )
    return {
        "robots": problem.count,
        "updates": done.updates,
        "trials": int(done.trials.sum()),
        "compiled, ms": f"{compiled * 1e3:.2f}",
        "share of 0.5 s": f"{compiled / MOST_SECONDS:.2%}",
        "reference / compiled": f"{plain / compiled:.0f}",
        "doubles / compiled": f"{doubles / compiled:.0f}",
        "simulated / wall": f"{done.updates * PARAMETERS.step / compiled:,.0f}",
    }


def run() -> list[dict[str, Any]]:
    """Runs as in the paper, and two of slow robots, which are under way in all 500 updates."""
    paper = [generate("circle", robots) for robots in (2, 4, 8)]
    slow = [generate("circle", 8, speed=5.0), generate("circle", 32, speed=5.0, radius=3.0)]
    return [row(problem) for problem in (*paper, *slow)]
