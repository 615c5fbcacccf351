"""Factors of laws, fitted to reports: least squares of the logarithms, with an interval and a held-out error."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from codesign.figures import Figure, Status
from codesign.inputs.calibration_file import FittedTerm, Sample

LEAST_MARGIN = 0.1
"""Of a factor from one design: tools differ by as much from seed to seed, and from one size to the next."""

LEAST_SPREAD = 0.01
"""Of a factor from several designs that agree."""

_STUDENT = (12.71, 4.30, 3.18, 2.78, 2.57, 2.45, 2.36, 2.31, 2.26, 2.23)
"""Two-sided 95 % quantiles of Student's t, from one degree of freedom."""

EXACT = ("block_rams", "multipliers")
"""Counts of whole macros: where every report agrees with the law, there is nothing to widen."""


@dataclass(frozen=True)
class Errors:
    """Mean relative errors of a term: of the law, of the law times the factor, and on designs held out of the fit."""

    before: float
    after: float
    held_out: float | None


def factor_of(samples: Sequence[Sample]) -> float:
    """The factor f with the least sum of (log reported - log f predicted)²; each design has the same weight.

    >>> one, two = (Sample(design=d, predicted=100.0, reported=r, report="r") for d, r in (("a", 90.0), ("b", 160.0)))
    >>> round(factor_of([one, two]), 6)
    1.2
    """
    means = [math.fsum(map(_log_ratio, group)) / len(group) for group in _by_design(samples).values()]
    return math.exp(math.fsum(means) / len(means))


def errors_of(samples: Sequence[Sample]) -> Errors:
    """How much of the difference between law and reports a factor explains."""
    designs = _by_design(samples)
    held_out = None
    if len(designs) > 1:
        held_out = _mean(
            _error(
                sample,
                factor_of([*chain.from_iterable(designs[other] for other in designs if other != name)]),
            )
            for name, group in designs.items()
            for sample in group
        )
    factor = factor_of(samples)
    before, after = (_mean(_error(sample, scale) for sample in samples) for scale in (1.0, factor))
    return Errors(before, after, held_out)


def fitted_term(term: str, samples: Sequence[Sample], law: tuple[float, float]) -> FittedTerm:
    """The factor of a term with its interval. ``law``: the interval of the law over its value, such as (0.9, 1.2).

    One design moves the law and leaves its width, at least ``LEAST_MARGIN``. Several designs give an interval for one
    more, 95 %, no wider than that. Every sample is inside.
    """
    factor, designs = factor_of(samples), _by_design(samples)
    ratios = [sample.reported / sample.predicted for sample in samples]
    low, high = factor * min(law[0], 1 - LEAST_MARGIN), factor * max(law[1], 1 + LEAST_MARGIN)
    how = f"one design, {len(samples)} reported"
    if term in EXACT and set(ratios) == {1.0}:
        low = high = 1.0
        how = "every report agrees with the law"
    elif len(designs) > 1:
        residuals = [math.log(ratio / factor) for ratio in ratios]
        freedom = len(designs) - 1
        spread = math.sqrt(math.fsum(residual**2 for residual in residuals) / max(1, len(residuals) - 1))
        student = _STUDENT[freedom - 1] if freedom <= len(_STUDENT) else 2.0
        width = max(math.log1p(LEAST_SPREAD), student * spread * math.sqrt(1 + 1 / len(designs)))
        low, high = max(low, factor * math.exp(-width)), min(high, factor * math.exp(width))
        how = f"least squares over {len(designs)} designs, interval of one more"
    low, high = min(low, *ratios), max(high, *ratios)
    digits = 9 - math.ceil(math.log10(factor))
    value = round(factor, digits)
    figure = Figure(
        value, "1", Status.CALIBRATED, how, min(round(low, digits), value), max(round(high, digits), value)
    )
    return FittedTerm(factor=figure, held_out=errors_of(samples).held_out, samples=tuple(samples))


def _by_design(samples: Iterable[Sample]) -> Mapping[str, list[Sample]]:
    designs: dict[str, list[Sample]] = {}
    for sample in samples:
        designs.setdefault(sample.design, []).append(sample)
    return designs


def _log_ratio(sample: Sample) -> float:
    return math.log(sample.reported / sample.predicted)


def _error(sample: Sample, factor: float) -> float:
    return abs(factor * sample.predicted / sample.reported - 1.0)


def _mean(errors: Iterable[float]) -> float:
    values = list(errors)
    return math.fsum(values) / len(values)
