"""The measures of rows.yaml, of Dubey et al. (2013): tables without a simulation, and runs on the 300 × 300 map."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from codesign.ground.models import Part
from codesign.inputs import load_part
from codesign.planners.interface import RobotsQuality
from codesign.planners.papers import Case, Paper, Runs, Words
from codesign.planners.reproduction import Series, Use
from codesign.planners.velocity_obstacle import published, styles
from codesign.planners.velocity_obstacle.paper.agreement import Verdict, compare
from codesign.planners.velocity_obstacle.plan import Avoidance, AvoidParameters, RobotsProblem, avoid, generate, quality
from codesign.planners.velocity_obstacle.plan.arithmetic import fixed
from codesign.planners.velocity_obstacle.plan.parameters import Detection, Detector, Responsibility, Unit
from codesign.planners.velocity_obstacle.plan.problem import ARRANGEMENTS
from codesign.planners.velocity_obstacle.plan.reference import STAY, RobotState
from codesign.planners.velocity_obstacle.published import CLOCK, Style, VelocityObstacleSettings
from codesign.planners.velocity_obstacle.styles import resources, timing
from codesign.planners.velocity_obstacle.styles.resources import DETECT, module_cycles

PARAMETERS = AvoidParameters()
LABELS = {
    Style.SEQUENTIAL: "sequential, 17n - 10",
    Style.PIPELINED: "RC pipelined, 10n + 4",
    Style.HYBRID: "hybrid, 17",
}
ROBOTS = (2, 4, 8)
RUN_STYLES = {2: Style.HYBRID, 4: Style.HYBRID, 8: Style.PIPELINED}
"""The styles that the paper ran: hybrid where it fits."""
PUBLISHED_RULE = AvoidParameters(detection=Detection.PUBLISHED, responsibility=Responsibility.FULL, margin=0.0)
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


class RobotsRuns(Runs[VelocityObstacleSettings]):
    """Single runs, runs over seeds for each rule, and choices in fixed point and in doubles."""

    @cached_property
    def single(self) -> dict[int, Run]:
        """The runs that the rows show, by robots on a circle, each to the opposite point."""
        runs = {}
        for robots in ROBOTS:
            self.progress(f"{robots} robots on the 300 × 300 map")
            problem = generate("circle", robots)
            plan = avoid(problem, AvoidParameters())
            runs[robots] = Run(problem, plan, quality(problem, plan))
        return runs

    @cached_property
    def tallies(self) -> dict[str, Tally]:
        """Runs over seeds and arrangements for each rule, with 2, 4 and 8 robots."""
        tally_of_rule = {}
        for name, parameters in RULES.items():
            self.progress(f"collisions: {name}")
            tally_of_rule[name] = _tally(parameters, self.settings.seeds or (3 if self.quick else 20))
        return tally_of_rule

    @cached_property
    def verdicts(self) -> Counter[Verdict]:
        """Choices in fixed point against doubles along the run of 8 robots."""
        self.progress("fixed point against doubles")
        parameters = AvoidParameters()
        problem = generate("circle", 8)
        plan, numbers = avoid(problem, parameters), fixed(problem, parameters)
        verdicts: Counter[Verdict] = Counter()
        for update in range(0, plan.updates, 20 if self.quick else 2):
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


PAPER = Paper(Path(__file__).with_name("rows.yaml"), published.NUMBERS, RobotsRuns, VelocityObstacleSettings)
measure = PAPER.measure


def chip() -> Part:
    """The part of the paper; its speed grade is not given, and enters no figure here."""
    return load_part(f"{published.PART}-4")


@measure
def module(_runs: RobotsRuns, case: Case) -> int:
    """Cycles of a module with one multiplier."""
    return module_cycles(case.name, Unit.SERIAL)


@measure
def share_of_part(_runs: RobotsRuns, case: Case) -> float:
    """Percent of the part that a style takes for two robots."""
    part = chip()
    need = styles.totals(Style(case.style), 2, PARAMETERS, part)
    return 100.0 * need[case.kind] / part.resources[case.kind].value


@measure
def power_law(_runs: RobotsRuns, case: Case) -> Words:
    """Power of a style by the law, mW."""
    fit, style, fitted = styles.power_fit(), Style(case.style), case.robots in styles.FITTED_ROBOTS
    return {
        "value": fit.power(style, case.robots),
        "base": fit.base,
        "slope": fit.slopes[style],
        "form": fit.form,
        "fitted": Use.FITTED if fitted else Use.HELD_OUT,
        "remark": "one of six rows that fix four numbers" if fitted else "",
    }


@measure
def fits(_runs: RobotsRuns, case: Case) -> Words:
    """True if a hybrid design fits the part."""
    part = chip()
    short = styles.shortages(Style.HYBRID, case.robots, PARAMETERS, part)
    need = styles.totals(Style.HYBRID, case.robots, PARAMETERS, part)
    listed = ", ".join(
        f"{need[kind]:,} of {int(part.resources[kind].value):,} {kind}" for kind in sorted(need)
    ).replace("_", " ")
    lacking = f"; short of {', '.join(sorted(short))}" if short else ""
    return {"value": "does not fit" if short else "fits", "listed": listed + lacking}


@measure
def trial(_runs: RobotsRuns, case: Case) -> Words:
    """Cycles of one trial."""
    style = Style(case.style)
    return {"value": timing.cycles_of_trial(style, case.robots, PARAMETERS), "label": LABELS[style]}


@measure
def full_runs(runs: RobotsRuns, _case: Case) -> list[Words]:
    """The single runs, in the style that the paper ran."""
    return [{"robots": robots, "style": RUN_STYLES[robots], "run": run} for robots, run in runs.single.items()]


@measure
def full_run(_runs: RobotsRuns, case: Case) -> Words:
    """The figures of a run."""
    run: Run = case.run
    cycles = timing.run_cycles(case.style, run.plan, AvoidParameters())
    return {
        "updates": run.quality.updates,
        "collisions": run.quality.collisions,
        "arrived": run.quality.robots_arrived,
        "approach": run.quality.closest_approach,
        "printed": case.updates_a_run * published.TABLE_II[case.style][case.robots] / CLOCK,
        "seconds": int(cycles.each.sum()) / CLOCK,
        "trials": float(np.mean(cycles.trials)),
        "most_trials": int(cycles.trials.max()),
    }


@measure
def same_choice(runs: RobotsRuns, _case: Case) -> Words:
    """The share of equal choices, and those that the bound does not explain."""
    total, same = sum(runs.verdicts.values()), runs.verdicts[Verdict.SAME]
    beyond = runs.verdicts[Verdict.BEYOND_BOUND]
    return {
        "percent": 100.0 * same / total,
        "same": same / total,
        "total": total,
        "beyond": beyond,
        "holds": beyond == 0,
    }


@measure
def cycles_by_robots(_runs: RobotsRuns, _case: Case) -> Iterator[Series]:
    """Cycles of a trial over the number of robots, with circuits that the paper did not build."""
    robots = tuple(range(2, 17))
    lanes = {
        f"{count} lanes": (Style.HYBRID, PARAMETERS.model_copy(update={"update_units": count, "detect_units": count}))
        for count in (2, 4)
    }
    for name, (style, given) in ({LABELS[style]: (style, PARAMETERS) for style in Style} | lanes).items():
        cycles = tuple(float(timing.cycles_of_trial(style, n, given)) for n in robots)
        yield Series(name, tuple(map(float, robots)), cycles)


@measure
def power_by_robots(_runs: RobotsRuns, _case: Case) -> Iterator[Series]:
    """Power over the number of robots: the table and the law."""
    fit, robots = styles.power_fit(), (2, 3, 4, 6, 8)
    for style, listed in published.TABLE_III.items():
        yield Series(f"{style}, Table III", tuple(map(float, listed)), tuple(map(float, listed.values())))
        law = tuple(fit.power(style, n) for n in robots)
        yield Series(f"{style}, law", tuple(map(float, robots)), law)


@measure
def paths(runs: RobotsRuns, _case: Case) -> Iterator[Series]:
    """The paths of eight robots: figure 10."""
    for index, path in enumerate(np.moveaxis(runs.single[8].plan.cells[::8], 1, 0)):
        yield Series(f"robot {index + 1}", tuple(path[:, 0].tolist()), tuple(path[:, 1].tolist()))


@measure
def power_miss(_runs: RobotsRuns, _case: Case) -> Words:
    """The miss of the power law at the rows that it has not seen."""
    fit, miss = styles.power_fit(), styles.power_miss()
    return {"form": fit.form, "base": fit.base, "miss": miss, "holds": miss < 0.05}


@measure
def energy(_runs: RobotsRuns, _case: Case) -> Words:
    """Energy of a trial with four robots."""
    spent = {
        style: published.TABLE_III[style][4] * 1e-3 * published.TABLE_II[style][4] / CLOCK * 1e9 for style in Style
    }
    figures = {f"4 robots, {style}": f"{spent[style]:.0f} nJ" for style in Style}
    return {"figures": figures, "holds": max(spent, key=spent.__getitem__) is Style.SEQUENTIAL}


@measure
def pipelined(_runs: RobotsRuns, _case: Case) -> Words:
    """The pipelined circuit against the sequential one with two robots."""
    cycles = published.TABLE_II[Style.PIPELINED][2]
    return {"cycles": cycles, "holds": cycles == published.TABLE_II[Style.SEQUENTIAL][2]}


@measure
def luts_of_style(_runs: RobotsRuns, case: Case) -> Words:
    """The LUTs of the hybrid style in Table I, against synthesis of one unit more."""
    shares = published.TABLE_I[Style.HYBRID][1] - published.TABLE_I[Style.PIPELINED][1]
    extra = shares / 100 * case.lut4_of_part
    one, two = (
        resources.LAWS.lines(
            resources.structure(Style.HYBRID, 2, PARAMETERS.model_copy(update={"update_units": count})),
            resources.LAWS.family(chip().family),
        )[resources.UPDATES][0].amount
        for count in (1, 2)
    )
    return {"extra": extra, "more": two - one, "holds": extra > 10 * (two - one)}


@measure
def fewer_units(_runs: RobotsRuns, _case: Case) -> Words:
    """The widest hybrid circuit for eight robots that fits the part."""
    lanes = styles.widest_lanes(8, PARAMETERS, chip())
    assert lanes is not None
    cycles, theirs = timing.cycles_of_trial(Style.HYBRID, 8, lanes), published.TABLE_II[Style.PIPELINED][8]
    units = {"update_units": lanes.update_units, "detect_units": lanes.detect_units}
    return {**units, "cycles": cycles, "pipelined": theirs, "holds": cycles < theirs}


@measure
def six_products(_runs: RobotsRuns, case: Case) -> Words:
    """Detection by cross product against the detection of Figure 6."""
    crossed = module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT)
    return {"cycles": crossed, "holds": crossed < case.detect_cycles}


@measure
def rules(runs: RobotsRuns, _case: Case) -> Words:
    """Collisions from the published rule to the default, one change at a time."""
    counted = runs.tallies
    figures = {"runs": str(next(iter(counted.values())).runs)}
    for name, tally in counted.items():
        figures[f"{name}: collisions"] = str(tally.collisions)
        figures[f"{name}: robots that arrived"] = f"{tally.arrived} of {tally.robots}"
        if tally.overflows:
            figures[f"{name}: runs beyond 16 bits"] = str(tally.overflows)
    first, *_, last = counted.values()
    return {"figures": figures, "holds": first.collisions > 0 and last.collisions == 0}


def _cycles_of_8(runs: RobotsRuns) -> timing.UpdateCycles:
    return timing.run_cycles(Style.PIPELINED, runs.single[8].plan, AvoidParameters())


@measure
def candidates(runs: RobotsRuns, _case: Case) -> Words:
    """The candidates that an update tries."""
    cycles = _cycles_of_8(runs)
    verify, trials = int(cycles.trials.sum()) * cycles.costs.trial, float(np.mean(cycles.trials))
    share = verify / int(cycles.each.sum())
    return {"trials": trials, "most_trials": int(cycles.trials.max()), "share": share, "holds": trials > 1}


@measure
def serial_port(runs: RobotsRuns, _case: Case) -> Words:
    """Time to send the coordinates of eight robots, against the time of an update."""
    sent, computed = 8 * 4 / SERIAL_BYTES_A_SECOND, float(_cycles_of_8(runs).each.mean()) / CLOCK
    return {"sent": sent * 1e3, "update": computed * 1e6, "holds": sent > computed}


@measure
def reconfiguration(runs: RobotsRuns, _case: Case) -> Words:
    """Time to configure the part, against the time of an update."""
    reload, computed = CONFIGURATION_BITS / CONFIGURATION_RATE, float(_cycles_of_8(runs).each.mean()) / CLOCK
    return {"whole": reload * 1e3, "updates": reload / computed, "holds": reload > 100 * computed}
