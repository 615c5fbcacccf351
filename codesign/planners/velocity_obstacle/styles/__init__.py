"""Velocity obstacles: the three circuits of Dubey et al. (2013), on an FPGA that each robot carries.

- ``sequential``: one datapath, update and detection in turn.
- ``pipelined``: one unit of each kind side by side (resource-constrained, RC).
- ``hybrid``: a unit for each update, and one for each detection.

Cycles are the length of a schedule of units (``resources``), so ``update_units`` and ``detect_units`` of a mapping
give circuits in between. The differences of the paper from these laws are in docs/velocity_obstacle.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status
from codesign.ground.late import late
from codesign.ground.models import Part
from codesign.planners.job import Demand, Job, Lever, Line, part_lever, short_resources, sum_by_resource
from codesign.planners.styles import Architecture, Memory, Step, task_record
from codesign.planners.velocity_obstacle.plan.arithmetic import fixed
from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem
from codesign.planners.velocity_obstacle.published import CLOCK, PAPER, PART, TABLE_III, Style
from codesign.planners.velocity_obstacle.styles import resources, timing
from codesign.planners.velocity_obstacle.styles.resources import items
from codesign.planners.velocity_obstacle.styles.timing import cycles_of_trial

if TYPE_CHECKING:
    from codesign.planners.velocity_obstacle.styles import updates
else:
    updates = late("codesign.planners.velocity_obstacle.styles.updates")

__all__ = ["ARCHITECTURES", "Circuit", "Style"]


def totals(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> dict[str, int]:
    """Demand by resource."""
    return sum_by_resource(items(style, robots, parameters, part))


def shortages(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> dict[str, int]:
    """The demand for each resource that the part lacks."""
    return short_resources(items(style, robots, parameters, part), part)


def widest_lanes(robots: int, parameters: AvoidParameters, part: Part) -> AvoidParameters | None:
    """The numbers of units that fit the part and take the fewest cycles; None: not even one of each kind fits."""
    best: tuple[int, int, AvoidParameters] | None = None
    for update in range(1, robots + 1):
        for detect in range(1, robots):
            tried = parameters.model_copy(update={"update_units": update, "detect_units": detect})
            if shortages(Style.HYBRID, robots, tried, part):
                break
            cycles = cycles_of_trial(Style.HYBRID, robots, tried)
            if best is None or (cycles, update + detect) < best[:2]:
                best = cycles, update + detect, tried
    return None if best is None else best[2]


def resource_levers(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> dict[str, tuple[Lever, ...]]:
    """For each resource that the part lacks: the units, style, robots and part that remedy it."""
    missing = shortages(style, robots, parameters, part)
    if not missing:
        return {}
    shared = [*_unit_levers(style, robots, parameters, part), *_style_levers(style, robots, parameters, part)]
    most = max((n for n in range(2, robots) if not shortages(style, n, parameters, part)), default=None)
    if most is not None:
        shared.append(Lever("problem.robots", f"at most {most} fit {part.name} in style {style}"))
    return {kind: (*shared, part_lever(kind, need)) for kind, need in missing.items()}


def array_bound(parameters: AvoidParameters, part: Part) -> Line:
    """Speeds × directions ≤ words of a block RAM, one array for each component."""
    words = parameters.speeds * parameters.directions
    _, depth = resources.array_rams(parameters, part)
    most = depth // parameters.directions
    narrower = Lever("avoid.speeds", f"at most {most} with these directions", axes={"avoid.speeds": most})
    return Line.bound(
        name="velocities of the array",
        demand=words,
        limit=depth,
        unit="words",
        status=Status.ASSUMED,
        source=f"block RAM of {part.name}, the shape that is deep enough",
        levers=() if words <= depth else (narrower,),
    )


def unit_bounds(style: Style, parameters: AvoidParameters) -> tuple[Line, ...]:
    """One unit of each kind where one datapath does all: a larger given number would change nothing."""
    if style is not Style.SEQUENTIAL:
        return ()
    counts = {"update_units": parameters.update_units, "detect_units": parameters.detect_units}
    return tuple(
        Line.bound(
            name=f"{name} of the sequential style",
            demand=count,
            limit=1,
            unit="units",
            status=Status.PUBLISHED,
            source=f"{PAPER}, section III: one datapath does the work of either unit in turn",
            levers=(
                Lever(f"avoid.{name}", "1, or left out", axes={f"avoid.{name}": 1}),
                Lever(
                    "avoid.style",
                    f"{Style.PIPELINED} or {Style.HYBRID} can have more",
                    axes={"avoid.style": str(Style.PIPELINED)},
                ),
            ),
        )
        for name, count in counts.items()
        if count is not None and count > 1
    )


def _unit_levers(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> list[Lever]:
    if style is not Style.HYBRID:
        return []
    lanes = widest_lanes(robots, parameters, part)
    if lanes is None:
        return []
    cycles = cycles_of_trial(style, robots, lanes)
    fits = f"fit {part.name}, {cycles} cycles a trial in place of {cycles_of_trial(style, robots, parameters)}"
    text = f"{lanes.update_units}, with {lanes.detect_units} detect_units, {fits}"
    axes = {"avoid.update_units": lanes.update_units, "avoid.detect_units": lanes.detect_units}
    return [Lever("avoid.update_units", text, axes=axes)]


def _style_levers(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> list[Lever]:
    plain = parameters.model_copy(update={"update_units": None, "detect_units": None})
    style_levers = []
    for other in (Style.PIPELINED, Style.SEQUENTIAL):
        if other is not style and not shortages(other, robots, plain, part):
            cycles = cycles_of_trial(other, robots, plain)
            text = f"{other} fits {part.name}, {cycles} cycles a trial"
            style_levers.append(Lever("avoid.style", text, axes={"avoid.style": str(other)}))
    return style_levers


# Power: P = P0 + q · √n, with a q for each style, fitted to Table III with 2 and 4 robots, compared with 8.
#
# Six rows fix four numbers. The form is chosen among log₂ n, √n, ∛n and n by its residual on those six rows; the list
# of forms was drawn up with the whole table in view. P0 does not depend on style or robots: it is mostly the
# part's leakage. It is booked as static power, the rest as dynamic, in proportion to the clock. The interval is twice
# the worst miss on the rows held out, and grows with the distance from the rows beyond 8 robots.

FITTED_ROBOTS = (2, 4)
FORMS: dict[str, Callable[[float], float]] = {"log2 n": math.log2, "√n": math.sqrt, "∛n": math.cbrt, "n": float}
"""Forms that were tried for the growth with the number of robots."""

DYNAMIC_OF_PART = 0.75e-12
"""W for each slice and Hz of the XC3S500E, by its part file: the reference for other parts."""
OTHER_PART = 2.0
"""Half to twice, on a part that the law was not fitted to."""


@dataclass(frozen=True)
class PowerFit:
    """P = base + slopes[style] · form(n), mW. ``residual``: root of the mean square over the rows fitted to, mW."""

    form: str
    base: float
    slopes: dict[Style, float]
    residual: float

    def power(self, style: Style, robots: int) -> float:
        """Total power at 50 MHz, mW."""
        return self.base + self.slopes[style] * FORMS[self.form](robots)


def rows(robots: tuple[int, ...]) -> list[tuple[Style, int, int]]:
    """(style, robots, mW) of Table III for these numbers of robots."""
    return [(style, n, mw) for style, row in TABLE_III.items() for n, mw in row.items() if n in robots]


@cache
def fit_power(form: str) -> PowerFit:
    """The least-squares fit of one form to the rows with 2 and 4 robots."""
    grow, styles = FORMS[form], list(Style)
    data = rows(FITTED_ROBOTS)
    matrix = np.array([[1.0, *(grow(n) * (style is other) for other in styles)] for style, n, _ in data])
    watts = np.array([mw for *_, mw in data], float)
    solution = np.linalg.lstsq(matrix, watts, rcond=None)[0]
    residual = float(np.sqrt(np.mean((matrix @ solution - watts) ** 2)))
    slopes = {style: float(slope) for style, slope in zip(styles, solution[1:], strict=True)}
    return PowerFit(form, float(solution[0]), slopes, residual)


@cache
def power_fit() -> PowerFit:
    """The fit of the form with the smallest residual."""
    return min((fit_power(form) for form in FORMS), key=lambda fit: fit.residual)


@cache
def power_miss() -> float:
    """The worst relative error on the rows held out: 8 robots."""
    fit = power_fit()
    return max(abs(fit.power(style, n) / mw - 1.0) for style, n, mw in rows((8,)))


def power(style: Style, robots: int, clock: int, part: Part) -> tuple[Figure, Figure]:
    """Static and dynamic power at ``clock`` Hz, W."""
    fit = power_fit()
    margin = 2.0 * power_miss() * max(1.0, math.log2(robots) / 3.0)
    dynamic = fit.slopes[style] * FORMS[fit.form](robots) / 1e3 * clock / CLOCK
    total = fit.power(style, robots) / 1e3
    law = (
        f"{fit.slopes[style]:.1f} mW × {fit.form} × clock / 50 MHz, fitted with {fit.base:.1f} mW of base to"
        f" {PAPER}, Table III, 2 and 4 robots; interval: twice the miss with 8 robots, {power_miss():.1%}, of the total"
    )
    if part.name == PART:
        spread = margin * total
        leak = part.static_power.interval
        static = Figure(
            fit.base / 1e3,
            "W",
            Status.CALIBRATED,
            f"what Table III of {PAPER} leaves for no robots; clock tree included",
            low=min(fit.base / 1e3, leak[0]),
            high=max(fit.base / 1e3, leak[1]),
        )
        low, high = max(0.0, dynamic - spread), dynamic + spread
        return static, Figure(dynamic, "W", Status.CALIBRATED, law, low=low, high=high)
    scale = part.dynamic_power.value / DYNAMIC_OF_PART
    text = f"{law}; times {scale:.2f}, this part's power of a slice over that of {PART}"
    scaled = dynamic * scale
    return part.static_power, Figure(
        scaled, "W", Status.ASSUMED, text, low=scaled / OTHER_PART, high=scaled * OTHER_PART
    )


@dataclass(frozen=True)
class CircuitDemand(Demand):
    """A demand with the values that its power depends on: the style that gives its rest, and the robots."""

    style: Style = Style.SEQUENTIAL
    robots: int = 2


class Circuit(Architecture):
    """One of the three styles: units, scheduled by ``schedule``; laws in ``resources``, ``power``, ``timing``.

    The memory of an exploration keeps whole runs: units and styles change cycles, never a choice.
    """

    planner = "velocity_obstacle"
    component_type = "fpga"
    description = "update and detection units on a schedule: one of each, pipelined, or one for each robot"

    def __init__(self, style: Style) -> None:
        self.style = style.value
        self._style = style

    def demand(self, job: Job[RobotsProblem, AvoidParameters]) -> CircuitDemand:
        """Resources by unit, and the words of the array of velocities. Nothing is placed apart from ``avoid``."""
        parameters, part = job.parameters, job.chip
        robots = job.problem.count
        units = resources.units_of(self._style, robots, parameters)
        return CircuitDemand(
            items=resources.items(self._style, robots, parameters, part, constants(job)),
            bounds=(array_bound(parameters, part), *unit_bounds(self._style, parameters)),
            levers=resource_levers(self._style, robots, parameters, part),
            style=resources.rest_style(self._style, units),
            robots=robots,
        )

    def clock_limit(self, job: Job[RobotsProblem, AvoidParameters]) -> Figure:
        """The fastest published clock, Hz."""
        circuit = resources.structure(self._style, job.problem.count, job.parameters)
        return timing.clock_limit(job.chip, circuit)

    def memory(self, job: Job[RobotsProblem, AvoidParameters]) -> Memory:
        """One component of each velocity of the array; a deep array is cut over several block RAMs."""
        parameters = job.parameters
        words = parameters.speeds * parameters.directions
        return Memory(min(parameters.width, resources.ram_width(words)), {"velocities": words})

    def work(self, job: Job[RobotsProblem, AvoidParameters]) -> Generator[Step, None, Avoidance]:
        """Phases of ``timing.PHASES``: with ``detail`` once for each update, without it each phase of the run at once.

        No task of it is placed by itself, and every run begins at the starts: ``start`` and ``inside`` change nothing.
        An update takes as long as its slowest robot. A unit of ``verify`` is a trial.
        """
        plan = avoid(job.problem, job.parameters) if job.detail else _whole(job)
        cycles = timing.run_cycles(self._style, plan, job.parameters)
        if job.detail:
            for checks, trials in zip(cycles.checks.tolist(), cycles.trials.tolist(), strict=True):
                yield from _steps(cycles.costs, checks, trials)
            return plan
        sums = dict.fromkeys(timing.PHASES, 0)
        for checks, trials in zip(cycles.checks.tolist(), cycles.trials.tolist(), strict=True):
            for phase, amount in cycles.costs.phases(checks, trials).items():
                sums[phase] += amount
        for phase, amount in sums.items():
            if amount:
                yield Step(phase, np.array([amount], np.int64), ram_addresses=timing.addresses(phase))
        return plan

    def updates(self, job: Job[RobotsProblem, AvoidParameters]) -> updates.Updates:
        """The closed loop with the cycles of every robot's own circuit, update by update: for scenario ``fleet``."""
        problem, parameters = job.problem, job.parameters
        return updates.Updates(problem, parameters, timing.update_costs(self._style, problem.count, parameters))

    def power(self, demand: Demand, clock: int, part: Part) -> tuple[Figure, Figure]:
        """Static and dynamic power at ``clock`` Hz, W, of one robot's circuit."""
        assert isinstance(demand, CircuitDemand), "power follows from a demand of this style"
        return power(demand.style, demand.robots, clock, part)


def constants(job: Job[RobotsProblem, AvoidParameters]) -> dict[str, int]:
    """The constant factors of the circuit's products, by their names in the Verilog; none that words cannot hold."""
    try:
        numbers = fixed(job.problem, job.parameters)
    except InputError:
        # The planner refuses the width, with its fault.
        return {}
    return {"RADIUS": math.isqrt(numbers.radius_squared), "STEP": numbers.step, "HALF_SQUARE": numbers.half_square}


def _whole(job: Job[RobotsProblem, AvoidParameters]) -> Avoidance:
    """The run from the memory of an exploration: units do not change it."""
    units = {"detector", "unit", "update_units", "detect_units"}
    key = ("velocity_obstacle", job.problem.digest, job.parameters.model_dump_json(exclude=units))
    return job.shared(key, lambda: avoid(job.problem, job.parameters))


def _steps(costs: timing.UpdateCosts, checks: int, trials: int) -> Generator[Step, None, None]:
    for phase, amount in costs.phases(checks, trials).items():
        if not amount:
            continue
        cycles = np.full(trials, costs.trial, np.int64) if phase == timing.VERIFY else np.array([amount], np.int64)
        yield Step(phase, cycles, task_record(phase, amount), timing.addresses(phase))


ARCHITECTURES = tuple(Circuit(style) for style in Style)
