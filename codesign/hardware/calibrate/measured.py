"""A plan measured on the real board: held against the model, and fed back into the platform's figures.

A file says what was measured; ``compare_measured`` simulates the same design, says if the time lies in the interval of
the model, and solves for the figures that decide it. For a processor these are the costs of its kernels, moved together
by one factor: one time decides no more than one number. Otherwise it is the figure of the platform that moves the time
most. The platform with these figures, with status ``measured``, answers the next question.
"""

from __future__ import annotations

import datetime
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import yaml
from pydantic import Field, model_validator

from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES, Figure, Status
from codesign.ground.models import RefusalError, SpecModel
from codesign.hardware.calibrate.calibration import plain_yaml
from codesign.inputs import Platform, design_point, load_platform
from codesign.inputs.base import Spec, fault
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.fields import Duration
from codesign.inputs.files import shown
from codesign.inputs.yaml_tree import read_document
from codesign.laws import Monomial
from codesign.system import catalog
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate

TIME = FIGURES["plan_time_worst_s"]
Plans = tuple[tuple[Monomial, ...], ...]
_UNITS = {"s": (1e12, "ps"), "Hz": (1.0, "Hz")}
"""Units of inputs that are solved for, and how platform files write them."""
MOST_FACTOR = 1e4
"""Beyond it, or below one over it, a factor is of another program or another machine."""

HEAD = "# Written by hwsw measured: the figures that were solved for stand in place of their own.\n"


class MeasuredTime(SpecModel):
    """The time of a plan on the board, from the request to the answer, over the runs from the worst start."""

    median: Duration = Field(description="Median over the runs.")
    p99: Duration = Field(description="99th percentile.")

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if not 0 < self.median <= self.p99:
            hint = "give a median above 0, and a 99th percentile that is no less"
            raise RefusalError("the 99th percentile is below the median, or the median is 0", hint, ("p99",))
        return self


class MeasuredFile(Spec):
    """What was measured of one design on one board."""

    kind: Literal["measured"] = Field(description="This file is a measurement.")
    platform: str = Field(description="The platform that was simulated: a shipped name, or a file from here.")
    workload: str = Field(description="The workload that ran: a shipped name, or a file from here.")
    settings: Mapping[str, Any] = Field(default={}, description="Axes of the design, as --set gives them.")
    date: datetime.date = Field(description="The day of the measurement, such as 2026-11-20.")
    runs: Annotated[int, Field(ge=1)] = Field(description="How many plans were timed.")
    time_of_a_plan: MeasuredTime = Field(description="Their time, of the worst start.")


@dataclass(frozen=True)
class Compared:
    """A measurement beside the model.

    ``result``: of the design by the model, ``interval`` its worst time, s. ``figures``: by axis of the platform, what
    was solved for. ``narrowed``: the interval with these. ``text``: the platform with these, as YAML.
    """

    measured: MeasuredFile
    result: Result
    value: float
    interval: tuple[float, float]
    figures: Mapping[str, Figure]
    narrowed: tuple[float, float]
    text: str

    @property
    def before(self) -> dict[str, Figure]:
        """The figures as they were declared."""
        assert self.result.terms is not None, "they were solved for"
        return {name: self.result.terms.inputs[name] for name in self.figures}

    @property
    def off(self) -> float:
        """The median over the nearest end of the interval; 1 inside of it."""
        low, high = self.interval
        median = self.measured.time_of_a_plan.median * 1e-12
        return median / low if median < low else median / high if median > high else 1.0


def compare_measured(path: Path, beside: Path) -> Compared:
    """A measurement against the model, and the platform that follows from it.

    ``beside``: the folder in which that platform will stand: parts and hosts of its own are looked for there.

    Raises:
        SpecError: every fault of the file; the design does not belong together, has no time, or no figure of the
            platform explains what was measured.
    """
    document = read_document(path, shown(path))
    measured = validate(MeasuredFile, document).with_document(document)
    specs = (_named(measured.platform, path), _named(measured.workload, path))
    platform, workload = load_platform(specs[0]), catalog.load_workload(specs[1])
    point = design_point(platform, workload, measured.settings, by=f"{shown(path)}: settings: ")
    result = simulate(*point)
    interval, value = result.interval(TIME), result.figure(TIME)
    if interval is None or value is None or result.terms is None:
        reason = "" if result.terms is None else result.terms.open.get(TIME.name, "")
        raise SpecError(
            [fault(measured, ("workload",), reason or "this design has no time of a plan", "hwsw run says more")]
        )
    figures = _solved(measured, result, path)
    axes = {name: _written(figure) for name, figure in figures.items()}
    narrowed = design_point(platform, workload, axes, by="measured: ")[0]
    ends = simulate(*design_point(narrowed, workload, measured.settings)).interval(TIME)
    assert ends is not None, "the same design has terms"
    text = HEAD + plain_yaml(narrowed.document.tree)
    _load_beside(text, beside)
    return Compared(measured, result, float(value), interval, figures, ends, text)


def _named(name: str, path: Path) -> str:
    """A file beside the measurement, where there is one; else the name of a shipped file."""
    return str(path.parent / name) if (path.parent / name).is_file() else name


def _load_beside(text: str, folder: Path) -> None:
    """Refuse a platform that names a part or host which its new folder lacks."""
    tree = yaml.safe_load(text)
    validate(Platform, Document("the platform that is written", folder, tree))


def _solved(measured: MeasuredFile, result: Result, path: Path) -> dict[str, Figure]:
    """The figures that explain a measured time: their value the median, their slow end the 99th percentile.

    Load and jitter stay declared: what is solved for is a time without them.
    """
    assert result.terms is not None, "asked of a result with terms"
    inputs, plans, times = result.terms.inputs, result.terms.plans(TIME.name), measured.time_of_a_plan
    moved = _moved(plans, inputs)
    if not moved:
        what = "every figure of the platform that this time rests on is exact, and nothing is solved for"
        raise SpecError([fault(measured, ("platform",), what, "hwsw explain shows what the time is made of")])
    slowest = {name: each.interval[0] / each.value for name, each in inputs.items() if name.endswith(".pace")}

    def at(own: Mapping[str, float], factor: float) -> float:
        return _time(plans, inputs, {**own, **dict.fromkeys(moved, factor)})

    middle = _factor(partial(at, {}), times.median * 1e-12)
    late = _factor(partial(at, slowest), times.p99 * 1e-12)
    if middle is None:
        what = f"no value of {' and '.join(moved)} explains {times.median * 1e-9:.4g} ms"
        hint = "the rest of the plan takes longer, or another design was measured"
        raise SpecError([fault(measured, ("time_of_a_plan", "median"), what, hint)])
    rises = at({}, 2.0) > at({}, 1.0)
    slow = middle if late is None else (max if rises else min)(middle, late)
    source = (
        f"solved for by hwsw measured from {path.name} of {measured.date}: {measured.runs:,} plans of"
        f" {measured.workload}, median {times.median * 1e-9:.6g} ms, 99th percentile {times.p99 * 1e-9:.6g} ms"
    )
    return {
        name: Figure(
            each.value * middle, each.unit, Status.MEASURED, source, *sorted((each.value * middle, each.value * slow))
        )
        for name, each in ((name, inputs[name]) for name in moved)
    }


def _moved(plans: Plans, inputs: Mapping[str, Figure]) -> list[str]:
    """The axes that are solved for: the open one that moves the time most; where it is a cost, all of its host."""
    used = {name for plan in plans for each in plan for name in each.inputs if inputs[name].unit in _UNITS}
    keys = sorted(name for name in used if " " not in name)
    swings = {
        name: abs(_time(plans, inputs, {name: high / each.value}) - _time(plans, inputs, {name: low / each.value}))
        for name in keys
        for each in (inputs[name],)
        for low, high in (each.interval,)
        if low < high
    }
    if not swings:
        return []
    widest = max(swings, key=swings.__getitem__)
    component, _, key = widest.partition(".")
    return [name for name in keys if name.startswith(f"{component}.costs.")] if key.startswith("costs.") else [widest]


def _written(figure: Figure) -> dict[str, Any]:
    """A figure as a platform file writes it: whole picoseconds or hertz."""
    scale, unit = _UNITS[figure.unit]
    low, high = figure.interval
    ends = {
        key: f"{max(1, round(end * scale))} {unit}"
        for key, end in (("value", figure.value), ("low", low), ("high", high))
    }
    return {**ends, "status": str(figure.status), "source": figure.source}


def _time(plans: Plans, inputs: Mapping[str, Figure], times: Mapping[str, float]) -> float:
    """The greatest plan, s, at the values of the inputs, some of them times a factor."""
    values = {name: each.value * times.get(name, 1.0) for name, each in inputs.items()}
    return float(max(sum(each.at(values) for each in plan) for plan in plans))


def _factor(time: Callable[[float], float], target: float) -> float | None:
    """The factor at which a time that rises or falls with it is ``target``; None where it never is."""
    low, high = 1 / MOST_FACTOR, MOST_FACTOR
    rises = time(high) > time(low)
    if not min(time(low), time(high)) <= target <= max(time(low), time(high)):
        return None
    for _ in range(200):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if (time(middle) > target) == rises else (middle, high)
    return high
