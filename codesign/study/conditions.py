"""The conditions of a study and its rules, and the values of axes as the numbers that columns hold."""

from __future__ import annotations

import itertools
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from codesign.ground.errors import InputError, choose_hint, clip, nearest, show
from codesign.ground.figures import ResultFigure
from codesign.ground.units import PICOSECONDS_PER_SECOND, SCALES, Dimension, parse_quantity
from codesign.inputs.aggregate import Rule, Share, rule_for
from codesign.study.aggregation import Draws

Scalar = float | int | str | bool | None

_PERCENT = re.compile(r"[0-9]+(\.[0-9]+)? *%")

SEED = ".seed"
"""The end of the name of a condition that is drawn: its values stand for all that might have been drawn."""

_SUFFIXES = {
    Dimension.TIME: "s",
    Dimension.FREQUENCY: "hz",
    Dimension.DATA: "bits",
    Dimension.DATA_RATE: "bits_s",
    Dimension.SPEED: "m_s",
    Dimension.ACCELERATION: "m_s2",
    Dimension.TURN_RATE: "rad_s",
}
"""The end of a column's name by dimension, where it is not the base unit in lower case."""


def axis_column(axis: str, values: Sequence[Any]) -> tuple[str, list[Scalar]]:
    """The name of an axis' column, and the entry for each value."""
    for dimension in Dimension:
        numbers = [_quantity(value, dimension) for value in values]
        if numbers and None not in numbers:
            suffix = _SUFFIXES.get(dimension, SCALES[dimension].base.lower())
            return f"{axis}_{suffix}", [*numbers]
    return axis, [
        value if isinstance(value, str | int | float | None) else json.dumps(value, sort_keys=True) for value in values
    ]


def order_of(axis: str, values: Sequence[Any]) -> int:
    """1 where the values of an axis are numbers or quantities that rise, -1 where they fall; else 0.

    >>> order_of("fpga.clock", ["50 MHz", "100 MHz"]), order_of("workload.variant", ["base", "deep"])
    (1, 0)
    """
    entries = axis_column(axis, values)[1]
    numbers = [each for each in entries if isinstance(each, int | float) and not isinstance(each, bool)]
    steps = np.diff(np.array(numbers, np.float64))
    if len(numbers) < len(entries):
        return 0
    return int((steps > 0).all()) - int((steps < 0).all()) if len(steps) else 1


def _quantity(value: Any, dimension: Dimension) -> float | int | None:
    """The number in a quantity's base unit (seconds of a time); None where the value is no such quantity."""
    try:
        exact = parse_quantity(value, dimension) if isinstance(value, str) else None
    except InputError:
        return None
    if exact is None:
        return None
    if dimension is Dimension.TIME:
        return float(Fraction(exact, PICOSECONDS_PER_SECOND))
    return exact if isinstance(exact, int) else float(exact)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _spelt(axis: str, values: Sequence[Any]) -> list[str]:
    """A text for each value of an axis, equal for 1 and 1.0, 0.8 and 80 %, 50 MHz and 0.05 GHz; true is no 1."""
    shares = [
        float(value[:-1]) / 100 if isinstance(value, str) and _PERCENT.fullmatch(value) else value for value in values
    ]
    texts_alone = all(isinstance(each, str) for each in shares)
    entries = axis_column(axis, shares)[1] if texts_alone else shares
    texts = (json.dumps(entry, sort_keys=True) for entry in entries)
    return [repr(json.loads(text, parse_int=Fraction, parse_float=Fraction)) for text in texts]


@dataclass(frozen=True)
class Conditions:
    """The conditions of a study, and the rules by which a figure is made of its values in all of them."""

    axes: Mapping[str, tuple[Any, ...]]
    aggregate: Mapping[str, Rule]

    @cached_property
    def each(self) -> tuple[dict[str, Any], ...]:
        """Every combination of conditions, the last axis moving fastest; one without any where there are none."""
        return tuple(dict(zip(self.axes, values, strict=True)) for values in itertools.product(*self.axes.values()))

    @cached_property
    def draws(self) -> Draws | None:
        """The number of the seed, or combination of seeds, of each condition; None where fewer than two were drawn."""
        places = itertools.product(*(range(len(values)) for values in self.axes.values()))
        drawn = [position for position, name in enumerate(self.axes) if name.endswith(SEED)]
        seeds = [tuple(place[position] for position in drawn) for place in places]
        numbers = {seed: number for number, seed in enumerate(dict.fromkeys(seeds))}
        return np.array([numbers[seed] for seed in seeds], np.intp) if len(numbers) > 1 else None

    def listed(self, name: str, value: Any) -> Any:
        """The value of a condition that is named by itself, in any spelling, or by its number.

        A number is one of the list only where no value of the condition is a number itself.

        Raises:
            InputError: no such condition, or no such value of it.
        """
        if name not in self.axes:
            hint = choose_hint(name, self.axes) if self.axes else "the study has no conditions"
            raise InputError(f"there is no condition {name}", "condition", hint)
        values = self.axes[name]
        *spelt, wanted = _spelt(name, (*values, value))
        if wanted in spelt:
            return values[spelt.index(wanted)]
        numbers = [each for each in values if _is_number(each)]
        if _is_number(value) and not numbers and value in range(len(values)):
            return values[int(value)]
        texts = [clip(str(each) if _is_number(each) else json.dumps(each), 60) for each in values]
        near: str | None = None
        if numbers and _is_number(value):
            near = str(min(numbers, key=lambda each: abs(each - value)))
        elif isinstance(value, str):
            near = nearest(value, [each for each in values if isinstance(each, str)])
        listed = ", ".join(texts if numbers else (f"{number}: {text}" for number, text in enumerate(texts)))
        hint = f"did you mean {near}? accepted: {listed}" if near else f"accepted: {listed}"
        raise InputError(f"{name} has no value {show(value)}", "condition", clip(hint, 400))

    def rule(self, figure: ResultFigure) -> Rule:
        """The rule of a figure."""
        return rule_for(self.aggregate, figure)

    def maximise(self, figure: ResultFigure) -> bool:
        """True if more of the aggregated figure is better: of a share that meets a limit it is, whatever the figure."""
        return figure.maximise or isinstance(self.rule(figure), Share)
