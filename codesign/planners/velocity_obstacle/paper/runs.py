"""Whole runs of 2, 4 and 8 robots on the 300 × 300 map, counted against section VI."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from codesign.figures import Status
from codesign.planners.quality import RobotsQuality
from codesign.planners.reproduction import Finding, Plot, Progress, Row, Series, Use, row
from codesign.planners.velocity_obstacle import published
from codesign.planners.velocity_obstacle.paper.agreement import Verdict, compare
from codesign.planners.velocity_obstacle.plan import (
    Avoidance,
    AvoidParameters,
    RobotsProblem,
    avoid,
    generate,
    quality,
)
from codesign.planners.velocity_obstacle.plan.arithmetic import fixed
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Responsibility
from codesign.planners.velocity_obstacle.plan.problem import ARRANGEMENTS
from codesign.planners.velocity_obstacle.plan.reference import STAY, RobotState
from codesign.planners.velocity_obstacle.published import CLOCK, Style
from codesign.planners.velocity_obstacle.styles import timing

ROBOTS = (2, 4, 8)
RUN_STYLES = {2: Style.HYBRID, 4: Style.HYBRID, 8: Style.PIPELINED}
"""The styles that the paper ran: hybrid where it fits."""
PUBLISHED_RULE = AvoidParameters(
    detection=Detection.PUBLISHED, responsibility=Responsibility.FULL, margin=0.0
)
RULES = {
    "equation 4 alone, others passive": PUBLISHED_RULE,
    "and only robots that approach": AvoidParameters(responsibility=Responsibility.FULL, margin=0.0),
    "and each takes half": AvoidParameters(margin=0.0),
    "and a margin of one cell": AvoidParameters(),
}
"""From the rule of the paper to the default, one change at a time."""

SERIAL_BYTES_A_SECOND = 11_520
"""115,200 baud, ten bits a byte: assumed for the board's serial port."""
CONFIGURATION_BITS = 2_270_208
CONFIGURATION_RATE = 8 * 50_000_000
"""Bits of an XC3S500E's configuration (DS312, from memory: assumed) and bits/s, a byte a cycle at 50 MHz."""


@dataclass(frozen=True)
class Run:
    """One run with its figures."""

    problem: RobotsProblem
    plan: Avoidance
    quality: RobotsQuality


@dataclass(frozen=True)
class Tally:
    """Sums over runs under one rule: collisions, robots, arrivals, and runs that left the number range."""

    runs: int
    robots: int
    arrived: int
    collisions: int
    overflows: int


def single_runs(progress: Progress | None) -> dict[int, Run]:
    """The runs that the rows show: robots on a circle, each to the opposite point."""
    runs = {}
    for robots in ROBOTS:
        if progress is not None:
            progress(f"{robots} robots on the 300 × 300 map")
        problem = generate("circle", robots)
        plan = avoid(problem, AvoidParameters())
        runs[robots] = Run(problem, plan, quality(problem, plan))
    return runs


def tallies(quick: bool, progress: Progress | None, seeds: int | None = None) -> dict[str, Tally]:
    """Runs over seeds and arrangements for each rule, with 2, 4 and 8 robots."""
    tally_of_rule = {}
    for name, parameters in RULES.items():
        if progress is not None:
            progress(f"collisions: {name}")
        tally_of_rule[name] = _tally(parameters, seeds or (3 if quick else 20))
    return tally_of_rule


def _tally(parameters: AvoidParameters, seeds: int) -> Tally:
    count: Counter[str] = Counter()
    for arrangement in ARRANGEMENTS:
        for robots in ROBOTS:
            for seed in range(seeds):
                problem = generate(arrangement, robots, seed=seed)
                count["runs"] += 1
                count["robots"] += robots
                plan = avoid(problem, parameters)
                count["overflows"] += plan.departure is not None
                result = quality(problem, plan)
                count["arrived"] += result.robots_arrived
                count["collisions"] += result.collisions
    return Tally(**{name: count[name] for name in ("runs", "robots", "arrived", "collisions", "overflows")})


def agreement(quick: bool, progress: Progress | None) -> Counter[Verdict]:
    """Choices in fixed point against doubles along the run of 8 robots."""
    if progress is not None:
        progress("fixed point against doubles")
    parameters = AvoidParameters()
    problem = generate("circle", 8)
    plan, numbers = avoid(problem, parameters), fixed(problem, parameters)
    verdicts: Counter[Verdict] = Counter()
    for update in range(0, plan.updates, 20 if quick else 2):
        robots = [
            RobotState(
                tuple(plan.positions[update, robot].tolist()),
                (numbers.position(target[0]), numbers.position(target[1])),
                tuple(plan.velocities[update, robot].tolist()),
            )
            for robot, target in enumerate(problem.targets.tolist())
        ]
        for robot in range(problem.count):
            if plan.candidates[update, robot] != STAY:
                verdicts[compare(problem, parameters, robots, robot)[0]] += 1
    return verdicts


def run_rows(runs: dict[int, Run], verdicts: Counter[Verdict]) -> tuple[Row, ...]:
    """The figures of a run, row by row."""
    rows: list[Row] = []
    for robots, run in runs.items():
        rows += _rows_of_run(robots, run)
    total = sum(verdicts.values())
    rows.append(
        row(
            "Section IV",
            "same velocity chosen in fixed point and in doubles",
            None,
            100.0 * verdicts[Verdict.SAME] / total,
            unit="%",
            status=Status.MEASURED,
            source=f"{total:,} choices along the run of 8 robots, 16 bits",
            use=Use.NOTHING,
            note=f"the others within the bound of a threshold; {verdicts[Verdict.BEYOND_BOUND]} beyond it",
        )
    )
    return tuple(rows)


def _rows_of_run(robots: int, run: Run) -> list[Row]:
    style = RUN_STYLES[robots]
    cycles = timing.run_cycles(style, run.plan, AvoidParameters())
    source = "robots on a circle to the opposite points; radius, speed and acceleration are assumed"
    total = int(cycles.each.sum())
    head = f"{robots} robots, full run"
    listed = (
        (
            "updates",
            "nearly 500",
            run.quality.updates,
            "1",
            "speed and size of the robots were chosen with this in view",
            Use.KNOWN,
        ),
        (
            "collisions",
            "none shown",
            run.quality.collisions,
            "1",
            "pairs that touched at or between updates",
            Use.HELD_OUT,
        ),
        ("robots that arrived", robots, run.quality.robots_arrived, "1", "", Use.HELD_OUT),
        ("closest approach, edge to edge", None, run.quality.closest_approach, "cells", "", Use.NOTHING),
        (
            f"time in the circuit, {style}",
            published.UPDATES_A_RUN * published.TABLE_II[style][robots] / CLOCK,
            total / CLOCK,
            "s",
            "published: 500 updates of one trial; modelled: all trials, and all other modules (assumed)",
            Use.HELD_OUT,
        ),
        (
            "trials an update, slowest robot",
            1,
            float(np.mean(cycles.trials)),
            "1",
            f"Table II counts one; up to {int(cycles.trials.max())}",
            Use.HELD_OUT,
        ),
    )
    return [
        row(
            "Section VI",
            f"{head}: {name}",
            printed,
            modelled,
            unit=unit,
            status=Status.ASSUMED if unit == "s" else Status.MEASURED,
            source=source,
            use=use,
            note=note,
        )
        for name, printed, modelled, unit, note, use in listed
    ]


def paths_plot(run: Run) -> Plot:
    """The paths of the robots: figure 10."""
    series = tuple(
        Series(f"robot {index + 1}", tuple(path[:, 0].tolist()), tuple(path[:, 1].tolist()))
        for index, path in enumerate(np.moveaxis(run.plan.cells[::8], 1, 0))
    )
    return Plot(
        "dubey2013-ways",
        f"{run.problem.count} robots on the 300 × 300 map, every eighth update",
        "Figure 10: four snapshots of 8 robots",
        "x, cells",
        "y, cells",
        series,
    )


def run_findings(
    runs: dict[int, Run], counted: dict[str, Tally], verdicts: Counter[Verdict]
) -> tuple[Finding, ...]:
    """The conclusions from the runs."""
    total = sum(verdicts.values())
    run = runs[8]
    cycles = timing.run_cycles(Style.PIPELINED, run.plan, AvoidParameters())
    verify = int(cycles.trials.sum()) * cycles.costs.trial
    share = verify / int(cycles.each.sum())
    sent = 8 * 4 / SERIAL_BYTES_A_SECOND
    computed = float(cycles.each.mean()) / CLOCK
    reload = CONFIGURATION_BITS / CONFIGURATION_RATE
    return (
        _rules_finding(counted),
        Finding(
            "Table II is the cost of one candidate, and an update tries several.",
            {
                "candidates, mean": f"{float(np.mean(cycles.trials)):.1f}",
                "candidates, most": str(int(cycles.trials.max())),
                "share of update and detection": f"{share:.0%}",
            },
            float(np.mean(cycles.trials)) > 1,
        ),
        Finding(
            "The serial port limits the experiment, not the circuit.",
            {"coordinates of 8 robots": f"{sent * 1e3:.1f} ms", "update": f"{computed * 1e6:.1f} µs"},
            sent > computed,
        ),
        Finding(
            "Reconfiguring the part between steps takes far longer than a step.",
            {"whole part": f"{reload * 1e3:.1f} ms", "in updates": f"{reload / computed:,.0f}"},
            reload > 100 * computed,
        ),
        Finding(
            "Where 16 bits choose another velocity than doubles, a threshold is within the stated bound.",
            {
                "same choice": f"{verdicts[Verdict.SAME] / total:.1%}",
                "choices": f"{total:,}",
                "beyond the bound": str(verdicts[Verdict.BEYOND_BOUND]),
            },
            verdicts[Verdict.BEYOND_BOUND] == 0,
        ),
    )


def _rules_finding(counted: dict[str, Tally]) -> Finding:
    """Collisions from the published rule to the default, one change at a time."""
    figures = {"runs": str(next(iter(counted.values())).runs)}
    for name, tally in counted.items():
        figures[f"{name}: collisions"] = str(tally.collisions)
        figures[f"{name}: robots that arrived"] = f"{tally.arrived} of {tally.robots}"
        if tally.overflows:
            figures[f"{name}: runs beyond 16 bits"] = str(tally.overflows)
    first, *_, last = counted.values()
    return Finding(
        "Equation 4 alone lets robots collide; three changes prevent it.",
        figures,
        first.collisions > 0 and last.collisions == 0,
    )
