"""Factors and offsets of laws, fitted to reports by least squares, with an interval and a held-out error."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from more_itertools import map_reduce

from codesign.ground.figures import Figure, Status
from codesign.inputs.calibration_file import LEAST_FACTOR, FittedTerm, Sample, inverse_sizes, leverage

LEAST_MARGIN = 0.1
"""Of a factor from one design: tools differ by as much from seed to seed, and from one size to the next."""

LEAST_SPREAD = 0.01
"""Of a factor from several designs that agree."""

_STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23)
"""Two-sided 95 % quantiles of Student's t, from one degree of freedom; the last one serves for all beyond."""

OFFSET_TERMS = ("slices", "lut4", "flip_flops")
"""Counts that may have an offset."""
LEAST_DESIGNS, LEAST_SPAN = 4, 1.5
"""Designs, and the largest of them over the smallest by the law, from which an offset is fitted."""

EXACT = ("block_rams", "multipliers")
"""Counts of whole macros: where every report agrees with the law, there is nothing to widen."""


@dataclass(frozen=True)
class Errors:
    """Mean relative errors of a term: of the law, of the fit, and on designs held out of the fit."""

    before: float
    after: float
    held_out: float | None


@dataclass(frozen=True)
class Line:
    """Reported = factor × predicted + offset."""

    factor: float
    offset: float = 0.0

    def times(self, predicted: float) -> float:
        """The factor on a law that says ``predicted``."""
        return max(LEAST_FACTOR * self.factor, self.factor + self.offset / predicted)


def factor_of(samples: Sequence[Sample]) -> float:
    """The factor f with the least sum of (log reported - log f predicted)²; each design has the same weight.

    >>> one, two = (Sample(design=d, predicted=100.0, reported=r, report="r") for d, r in (("a", 90.0), ("b", 160.0)))
    >>> round(factor_of([one, two]), 6)
    1.2
    """
    means = [math.fsum(map(_log_ratio, group)) / len(group) for group in _by_design(samples).values()]
    return math.exp(math.fsum(means) / len(means))


def line_of(term: str, samples: Sequence[Sample]) -> Line:
    """Factor and offset of a count, where designs enough of several sizes are there; otherwise a factor alone.

    The offset is what a tool adds to a design of any size. The line has the least sum of squares of reported over
    predicted; each design has the same weight.
    """
    sizes = inverse_sizes(samples)
    spans = max(sizes.values()) / min(sizes.values()) >= LEAST_SPAN
    if term in OFFSET_TERMS and len(sizes) >= LEAST_DESIGNS and spans:
        ratios = _ratios(samples)
        mean, mid = (math.fsum(each.values()) / len(sizes) for each in (ratios, sizes))
        squares = math.fsum((size - mid) ** 2 for size in sizes.values())
        offset = math.fsum((sizes[name] - mid) * (ratios[name] - mean) for name in sizes) / squares
        factor = mean - offset * mid
        if factor > LEAST_FACTOR:
            return Line(factor, offset)
    return Line(factor_of(samples))


def errors_of(term: str, samples: Sequence[Sample]) -> Errors:
    """The errors of laws and fit: the part of the difference between law and reports that the fit explains."""
    designs = _by_design(samples)
    held_out = None
    if len(designs) > 1:
        lines = {
            name: line_of(term, [*chain.from_iterable(designs[other] for other in designs if other != name)])
            for name in designs
        }
        held_out = _mean(_error(sample, lines[name]) for name, group in designs.items() for sample in group)
    line = line_of(term, samples)
    before, after = (_mean(_error(sample, each) for sample in samples) for each in (Line(1.0), line))
    return Errors(before, after, held_out)


def fitted_term(term: str, samples: Sequence[Sample], law: tuple[float, float], explained: str = "") -> FittedTerm:
    """The factor of a term, or its line, with an interval. ``law``: its interval over its value, such as (0.9, 1.2).

    The interval never claims less than the law's own error, nor less than ``LEAST_MARGIN``. From several designs it is
    at least the one in which one more design of the same kind lies with 95 %; with an offset, one of its size. Every
    sample is inside.
    """
    line, designs = line_of(term, samples), _by_design(samples)
    ratios = [sample.reported / sample.predicted for sample in samples]
    low, high = min(law[0], 1 - LEAST_MARGIN), max(law[1], 1 + LEAST_MARGIN)
    margin, how = 0.0, f"one design, {len(samples)} reported"
    if term in EXACT and set(ratios) == {1.0}:
        low = high = 1.0
        how = "every report agrees with the law"
    elif line.offset:
        margin, how = _margin(line, samples), f"factor and offset over {len(designs)} designs"
    else:
        if len(designs) > 1:
            width = _width(line.factor, samples)
            low, high = min(low, math.exp(-width)), max(high, math.exp(width))
            how = f"least squares over {len(designs)} designs, no narrower than the law"
        low = min(low, *(ratio / line.factor for ratio in ratios))
        high = max(high, *(ratio / line.factor for ratio in ratios))
    digits = 9 - math.ceil(math.log10(line.factor))
    value = round(line.factor, digits)
    ends = (round(bound * line.factor, digits) for bound in (low, high))
    figure = Figure(
        value, "1", Status.CALIBRATED, how, *(pick(end, value) for pick, end in zip((min, max), ends, strict=True))
    )
    return FittedTerm(
        factor=figure,
        offset=round(line.offset, 6),
        margin=round(margin, 9),
        explained=explained,
        held_out=errors_of(term, samples).held_out,
        samples=tuple(samples),
    )


def _student(freedom: int) -> float:
    return _STUDENT[freedom - 1] if freedom <= len(_STUDENT) else _STUDENT[-1]


def _width(factor: float, samples: Sequence[Sample]) -> float:
    """Half of the 95 % interval of one more design, of the logarithm of its ratio."""
    means = [math.log(ratio / factor) for ratio in _ratios(samples).values()]
    spread = max(_scatter(means, 1), _scatter([_log_ratio(sample) - math.log(factor) for sample in samples], 1))
    return max(math.log1p(LEAST_SPREAD), _student(len(means) - 1) * spread * math.sqrt(1 + 1 / len(means)))


def _margin(line: Line, samples: Sequence[Sample]) -> float:
    """Student's quantile times the scatter about the line; every sample is inside of the interval that it makes."""
    sizes, ratios = inverse_sizes(samples), _ratios(samples)
    means = [ratios[name] - line.factor - line.offset * sizes[name] for name in sizes]
    single = [each.reported / each.predicted - line.times(each.predicted) for each in samples]
    spread = max(_scatter(means, 2), _scatter(single, 2), LEAST_SPREAD * line.factor / 2)
    fitted = list(sizes.values())
    inside = (
        abs(left) / math.sqrt(1 + leverage(fitted, 1 / sample.predicted))
        for left, sample in zip(single, samples, strict=True)
    )
    return max(_student(len(means) - 2) * spread, *inside)


def _scatter(residuals: Sequence[float], fitted: int) -> float:
    """The standard deviation of what a fit of so many numbers left."""
    return math.sqrt(math.fsum(each**2 for each in residuals) / max(1, len(residuals) - fitted))


def _ratios(samples: Iterable[Sample]) -> dict[str, float]:
    """The mean of reported / predicted of each design."""
    return {
        name: math.fsum(each.reported / each.predicted for each in group) / len(group)
        for name, group in _by_design(samples).items()
    }


def _by_design(samples: Iterable[Sample]) -> Mapping[str, list[Sample]]:
    return map_reduce(samples, lambda sample: sample.design)


def _log_ratio(sample: Sample) -> float:
    return math.log(sample.reported / sample.predicted)


def _error(sample: Sample, line: Line) -> float:
    return abs(line.times(sample.predicted) * sample.predicted / sample.reported - 1.0)


def _mean(errors: Iterable[float]) -> float:
    values = list(errors)
    return math.fsum(values) / len(values)
