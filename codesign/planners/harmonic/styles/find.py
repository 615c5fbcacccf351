"""The best precision schedule by the cycles that a style charges."""

from __future__ import annotations

from typing import Any

from codesign.ground.memo import Memo
from codesign.planners.harmonic.plan.arguments import Visits
from codesign.planners.harmonic.plan.best_schedule import Schedule, optimise_schedule
from codesign.planners.harmonic.plan.parameters import RelaxParameters, Start
from codesign.planners.harmonic.styles.steps import DETECT, Costs
from codesign.planners.interface import LOWER_BOUND, Problem
from codesign.planners.job import Job
from codesign.planners.styles import Found

BOUND = "cost so far; sweeps and iterations of a stage from a higher precision; slowest decay of one block"
"""The lower bounds that rule stages out; proven in ``plan.stage_costs`` and ``plan.decay``."""

MOST_SHOWN = 24
"""A note names the precisions of a schedule of fewer stages."""

_schedules = Memo(max_bytes=2**24)
"""Searches that were made. Design points that differ in parts, clocks or links ask for the same ones."""

_stages = Memo(max_bytes=2**27)
"""Stages and fields: searches of designs that differ in costs alone share them."""


def find_schedule(style: str, job: Job[Problem, RelaxParameters], costs: Costs, *, fits: bool = True) -> Found:
    """The parameters of a job with the best schedule for its problem, and the proof.

    ``fits``: whether any schedule of the design fits its part; where none does, no stage is simulated.

    Raises:
        InputError: a start that the search cannot be made from.
    """
    parameters, problem = job.parameters, job.problem
    every, last = parameters.precisions, parameters.precisions[-1]
    if parameters.start is Start.LOWER_BOUND and LOWER_BOUND in job.mapped:
        return _found(parameters, (last,), {"reason": "a start at the last precision leaves one stage"})
    if not fits:
        return _found(parameters, every, {"reason": "not searched, as the design does not fit with any schedule"})

    def cost(precision: int, visits: Visits) -> int:
        return int(costs.visits(precision, visits).sum()) + costs.stage_end(precision)

    key = ("schedule", style, problem.map_digest, parameters)
    best = _schedules.get(key, lambda: optimise_schedule(problem, parameters, every[:-1], _stages, cost))
    # A run that stops at an earlier precision on this map may need the last one on another.
    precisions = best.precisions if best.precisions[-1] == last else (*best.precisions, last)
    found = _found(parameters, precisions, _proof(best, parameters))
    if job.does(DETECT):
        return found
    note = "relax.schedule: the search counts the cycles of the relaxation, not the round trips of detect"
    return Found(found.parameters, found.proofs, (*found.notes, note))


def _found(parameters: RelaxParameters, precisions: tuple[int, ...], proof: dict[str, Any]) -> Found:
    text = ", ".join(map(str, precisions)) + ": " if len(precisions) < MOST_SHOWN else ""
    reason = proof.get("reason") or (
        f"the best of {proof['schedules']:,} schedules; of {proof['stages']:,} stages {proof['simulated']:,} were"
        f" simulated to their end, {proof['cut_off']:,} cut off, and {proof['bounded_away']:,} never begun"
    )
    return Found(
        parameters.model_copy(update={"schedule": precisions}),
        {"schedule": {"precisions": precisions, **proof}},
        (f"relax.schedule: {text}{reason}",),
    )


def _proof(best: Schedule, parameters: RelaxParameters) -> dict[str, Any]:
    return {
        "schedules": best.schedules,
        "cycles": best.cost,
        "cycles_through_all": best.series,
        "stages": best.stages,
        "simulated": best.simulated,
        "cut_off": best.cut,
        "bounded_away": best.bounded,
        "bound": BOUND,
        "run_ends_at": best.precisions[-1],
        "stop": parameters.stop.value,
    }
