"""A study of a million points: what is feasible, the front of five objectives, reasons, filters; seconds and memory."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from codesign.ground.figures import FIGURES
from codesign.inputs.constraint import constraint_of
from codesign.planners.interface import Quality
from codesign.study.outcomes import Outcomes, State
from codesign.study.pricing.price import PRICED
from codesign.study.study import Study
from codesign.system.results.result import Reason, ResourceUse, Result
from codesign.views.report.study_tables import study_sentence, study_tables
from codesign.views.report.winners_table import winners_table

BLOCKS, ITERATIONS, SCHEDULES, PARTS, CLOCKS, LINKS = 20, 10, 10, 5, 10, 10
OBJECTIVES = ("plan_time_worst_s", "slices", "block_rams", "energy_j", "share_reaching_goal")


def synthetic(seed: int = 0) -> Study:
    """A million made-up points: 10,000 templates, some of which do not fit, and clocks of which some are too fast."""
    axes: dict[str, tuple[Any, ...]] = {
        "relax.block": tuple([rows, 2 * rows] for rows in range(10, 10 + BLOCKS)),
        "relax.iterations": tuple(range(1, 1 + ITERATIONS)),
        "relax.schedule": tuple([7, last] for last in range(15, 15 + SCHEDULES)),
        "fpga.part": tuple(f"part {number}" for number in range(PARTS)),
        "fpga.clock": tuple(f"{50 + 10 * number} MHz" for number in range(CLOCKS)),
        "link.clock": tuple(f"{10 + number} MHz" for number in range(LINKS)),
    }
    chance = np.random.default_rng(seed)
    templates = [
        _template(block, part, chance.random(3))
        for block in range(BLOCKS)
        for _ in range(ITERATIONS * SCHEDULES)
        for part in range(PARTS)
    ]
    prices = CLOCKS * LINKS
    count = len(templates) * prices
    outcomes = Outcomes.empty(count)
    which = np.repeat(np.arange(len(templates), dtype=np.int32), prices)
    clock = np.tile(np.repeat(np.arange(CLOCKS), LINKS), len(templates))
    work = np.repeat(chance.random(len(templates)) + 0.2, prices)
    seconds = work / (50 + 10 * clock) + 1e-3 / (10 + np.tile(np.arange(LINKS), count // LINKS))
    watts = 0.5 + 0.01 * clock + 0.1 * chance.random(count)
    made = {"cycles": np.round(work * 1e6), "power": watts, "energy_j": watts * seconds}
    batch = Outcomes(
        np.full(count, State.DONE, np.int8),
        which,
        {name: made.get(name, seconds) for name in PRICED},
        {name: 0.9 * made.get(name, seconds) for name in PRICED},
        {name: 1.1 * made.get(name, seconds) for name in PRICED},
        np.where(chance.random(count) < 0.1, 0, -1).astype(np.int32),
        templates,
        reasons=[Reason(kind="clock", name="fpga", demand=140e6, limit=120e6, gap=20e6, unit="Hz")],
    )
    outcomes.join(np.arange(count), batch)
    limits = tuple(map(constraint_of, ("plan_time_worst_s < 20 ms", "slices <= 80 %")))
    return Study("bench", "maze", axes, tuple(FIGURES[name] for name in OBJECTIVES), limits, outcomes)


def _template(block: int, part: int, chance: Any) -> Result:
    slices = int(500 * (block + 1) * (1 + chance[0]))
    budget = 4000 * (part + 1)
    gap = max(0, slices - budget)
    uses = (
        ResourceUse(resource="slices", demand=slices, budget=budget, gap=gap, items=()),
        ResourceUse(resource="block_rams", demand=int(100 * chance[1]), budget=200, gap=0, items=()),
    )
    fields: dict[str, Any] = {
        **{"platform": "bench", "workload": "maze", "planner": "harmonic", "style": "bit_serial"},
        **{"component": "fpga", "part": f"part {part}", "places": {"relax": "fpga"}, "resources": uses},
        "parameters": {"relax": {"block": 1, "iterations": 1, "schedule": 1}},
    }
    if gap:
        reason = Reason(kind="resource", name="slices", demand=slices, limit=budget, gap=gap, unit="")
        return Result(**fields, feasible=False, reasons=(reason,))
    quality = Quality(
        **{"reachable_cells": 100, "planned_cells": 100, "local_maxima": 0, "wrong_cells": 0, "starts": 4},
        **{"starts_arrived": 4, "path_length_ratio_mean": 1.0, "path_length_ratio_worst": 1.0},
        **{"clearance_mean": 1.5, "clearance_least": 1.0, "share_reaching_goal": float(chance[2])},
    )
    busy = {"fpga": 0.5, "link": 0.1}
    return Result(**fields, feasible=True, quality=quality, utilisation=busy, precision=7)


def filtered(study: Study) -> int:
    """The feasible points of one part, by rising energy: what a reader asks of a table."""
    part = study.decisions.levels(np.arange(len(study.designs)))["fpga.part"]
    chosen = np.flatnonzero(study.judged.feasible & (part == 2))
    energy = study.judged.figure(FIGURES["energy_j"])[chosen]
    return int(chosen[np.argsort(energy, kind="stable")][0])


STEPS: dict[str, Callable[[Study], object]] = {
    "feasible": lambda study: len(study.feasible),
    "front of five objectives": lambda study: len(study.front),
    "filter and sort": filtered,
    "reasons": lambda study: len(study.reasons),
    "nearest": lambda study: study.nearest(),
    "repr": repr,
    "sensitivity": lambda study: len(study.sensitivity()),
    "sentence": study_sentence,
    "winners": lambda study: len(winners_table(study, axis="fpga.part").rows),  # type: ignore[union-attr]
    "tables": lambda study: len(study_tables(study)),
}


def run() -> list[Any]:
    """The rows of the table."""
    rows = []
    begin = _now()
    study = synthetic()
    rows.append(_row("points made up", len(study.points), begin))
    for name, step in STEPS.items():
        begin = _now()
        rows.append(_row(name, step(study), begin))
    return rows


def _now() -> tuple[float, float]:
    return time.perf_counter(), time.process_time()


def _row(case: str, outcome: object, begin: tuple[float, float]) -> dict[str, str]:
    wall, own = (f"{now - before:.2f}" for now, before in zip(_now(), begin, strict=True))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"case": case, "outcome": str(outcome)[:60], "s": wall, "processor s": own, "peak MiB": f"{peak:,.0f}"}
