"""What a robot pays for planning again when obstacles appear on its way: the policies of harmonic control, in clock
cycles and in wrong cells; and the relaxation in doubles, in sweeps.

Every row is the median of some placements of the new obstacles, drawn from the cells of the way that a robot takes from
the farthest cell that the old plan leads to the goal.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.maps.reach import distance_octile
from codesign.planners.harmonic.plan import HarmonicPlan
from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.harmonic.plan.trajectory import Ascent
from codesign.planners.harmonic.plan.warm_start import warm_start
from codesign.planners.harmonic.styles import ARCHITECTURES
from codesign.planners.harmonic.styles.steps import MOST_SWEEPS
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.plan import PUBLISHED_TOLERANCE, solve

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests" / "support"))

PLACEMENTS = 5
NEW_OBSTACLES = (1, 5, 20)
CASES = (
    ("maze", 64, 63, {"corridor": 10, "wall": 1, "loops": 0.2}),
    *(
        (name, side, last, options)
        for side, room, corridor in ((128, 40, 10), (256, 62, 20))
        for name, options in (
            ("rooms", {"room": (room, room), "door": room // 5, "wall": 2}),
            ("maze", {"corridor": corridor, "wall": 2, "loops": 0.1}),
        )
        for last in (31, 47, 63)
    ),
)
"""Name, side, last precision and options of each map; blocks are a quarter of the side by half of it."""


@dataclass(frozen=True, eq=False)
class Case:
    """A map, what is asked of the circuit, and the plan that it had before the obstacles appeared."""

    problem: Problem
    parameters: RelaxParameters
    plan: HarmonicPlan
    on_the_way: NDArray[np.int64]

    def closed(self, count: int, seed: int) -> Problem:
        """The problem with ``count`` new obstacles of one cell."""
        random = np.random.Generator(np.random.PCG64([count, seed]))
        chosen = self.on_the_way[random.choice(len(self.on_the_way), count, replace=False)]
        free = self.problem.free.copy()
        free[tuple(chosen.T)] = False
        return Problem(free, self.problem.goals, ())


def case_of(name: str, side: int, last: int, options: dict[str, Any]) -> Case:
    free = maps.generate(name, rows=side, columns=side, seed=4, **options).free
    goal = maps.nearest_free(free, (side // 2, side // 2))
    assert goal is not None
    problem = Problem(free, (goal,), ())
    parameters = RelaxParameters(
        block=(side // 4, side // 2), iterations=24, schedule={"first": 7, "step": 8, "last": last}
    )
    _, plan = cost(problem, parameters)
    ascent = Ascent(plan.field, free, [goal])
    far = np.where(ascent.climbs_to_goal() & maps.reachable(free, [goal]), distance_octile(free, [goal]), -1.0)
    start = np.unravel_index(int(np.argmax(far)), far.shape)
    cells = np.unique(np.floor(ascent.follow(start).points + 0.5).astype(np.int64), axis=0)
    return Case(problem, parameters, plan, cells[np.abs(cells - goal).sum(axis=1) > 2])


def cost(problem: Problem, parameters: RelaxParameters, start: Any = None) -> tuple[int, HarmonicPlan]:
    """Cycles of the bit-serial circuit from the map to the first decision, and the plan."""
    work = ARCHITECTURES[0].work(Job(problem, parameters, detail=False, start=start))
    cycles = 0
    while True:
        try:
            cycles += int(next(work).cycles.sum())
        except StopIteration as done:
            return cycles, done.value


def straight(problem: Problem, parameters: RelaxParameters, start: Any) -> int:
    """Cycles of going on from old values at the last precision at once."""
    last = parameters.model_copy(update={"schedule": parameters.precisions[-1:]})
    return cost(problem, last, start)[0]


def placement(case: Case, count: int, seed: int) -> dict[str, float]:
    """What the policies cost and are worth at one placement."""
    problem, parameters = case.closed(count, seed), case.parameters
    last = parameters.precisions[-1]
    zero, anew = cost(problem, parameters)
    bound, same = cost(problem, parameters, warm_start(problem.free, problem.goals, last))
    old, on = cost(problem, parameters, case.plan.field)
    exact = converged_field(problem.free, problem.goals, last)
    assert same.field == exact, "a lower bound changes no bit"
    settled = exact if on.precision == last else converged_field(problem.free, problem.goals, on.precision)
    assert max(stage.sweeps for stage in on.stages) < MOST_SWEEPS
    from reference_harmonic import share_reaching_goal

    return {
        "zero": zero,
        "bound": bound,
        "old": old,
        "straight": straight(problem, parameters, case.plan.field),
        "bits": anew.precision,
        "old_bits": on.precision,
        "wrong": int((on.field.limbs != settled.limbs).any(axis=2).sum()),
        "share": share_reaching_goal(anew.field, problem.free, problem.goals),
        "old_share": share_reaching_goal(on.field, problem.free, problem.goals),
        "faults": bool(on.fault),
    }


def harmonic_rows() -> Iterator[dict[str, str]]:
    for name, side, last, options in CASES:
        case = case_of(name, side, last, options)
        for count in NEW_OBSTACLES:
            found = [placement(case, count, seed) for seed in range(PLACEMENTS)]
            middle = {key: median(each[key] for each in found) for key in found[0]}
            yield {
                "map": f"{name} {side}×{side}",
                "p": str(last),
                "new": str(count),
                "restart": f"{middle['zero']:,.0f}",
                "lower_bound": f"{middle['bound']:,.0f}",
                "continue": f"{middle['old']:,.0f}",
                "at p at once": f"{middle['straight']:,.0f}",
                "bits of restart, continue": f"{middle['bits']:.0f}, {middle['old_bits']:.0f}",
                "wrong cells of continue": f"{middle['wrong']:,.0f}",
                "reach the goal: restart, continue": f"{middle['share']:.2%}, {middle['old_share']:.2%}",
                "faults": str(sum(int(each["faults"]) for each in found)),
            }


def relaxation_rows() -> Iterator[dict[str, str]]:
    """Sweeps of SOR, from nothing and from the old potential, on the maps of 128 × 128 cells."""
    for name, side, last, options in CASES:
        if (side, last) != (128, 63):
            continue
        case = case_of(name, side, last, options)
        sor = partial(solve, method="sor", omega=1.95, tolerance=PUBLISHED_TOLERANCE)
        old = sor(case.problem.free, case.problem.goals).potential
        for count in NEW_OBSTACLES:
            sweeps = []
            for seed in range(PLACEMENTS):
                free = case.closed(count, seed).free
                runs = [sor(free, case.problem.goals, start=start).iterations for start in (None, old)]
                sweeps.append(runs)
            zero, on = (median(column) for column in zip(*sweeps, strict=True))
            yield {
                "map": f"{name} {side}×{side}, sweeps of SOR",
                "p": "double",
                "new": str(count),
                "restart": f"{zero:,.0f}",
                "lower_bound": "",
                "continue": f"{on:,.0f}",
                "at p at once": "",
                "bits of restart, continue": "",
                "wrong cells of continue": "",
                "reach the goal: restart, continue": "",
                "faults": "0",
            }


def run() -> list[dict[str, str]]:
    """All rows."""
    return [*harmonic_rows(), *relaxation_rows()]
