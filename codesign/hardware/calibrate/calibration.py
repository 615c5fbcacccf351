"""A calibration that follows from reports, and its file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from operator import itemgetter
from pathlib import Path
from typing import Any

import yaml
from more_itertools import map_reduce, unique_everseen

from codesign.ground.errors import InputError, SpecError, WrittenFloat, choose_hint
from codesign.ground.figures import Figure, Status, label
from codesign.ground.files import date_of_writing
from codesign.hardware.calibrate.design import DesignPoint
from codesign.hardware.calibrate.reports import Report
from codesign.inputs.faults import validate
from codesign.inputs.library import (
    LEAST_FACTOR,
    LEAST_SURE,
    MOST_FACTOR,
    MOST_SURE,
    CalibrationFile,
    FittedTerm,
    Sample,
    inverse_sizes,
    leverage,
)
from codesign.inputs.yaml_tree import parse_document
from codesign.version import __version__

# Factors and offsets of laws, fitted to reports by least squares, with an interval and a held-out error.

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


def student(freedom: int) -> float:
    """Half of the 95 % interval of Student's t."""
    return _STUDENT[freedom - 1] if freedom <= len(_STUDENT) else _STUDENT[-1]


def _width(factor: float, samples: Sequence[Sample]) -> float:
    """Half of the 95 % interval of one more design, of the logarithm of its ratio."""
    means = [math.log(ratio / factor) for ratio in _ratios(samples).values()]
    spread = max(_scatter(means, 1), _scatter([_log_ratio(sample) - math.log(factor) for sample in samples], 1))
    return max(math.log1p(LEAST_SPREAD), student(len(means) - 1) * spread * math.sqrt(1 + 1 / len(means)))


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
    return max(student(len(means) - 2) * spread, *inside)


def _scatter(residuals: Sequence[float], fitted: int) -> float:
    """The standard deviation of what a fit of so many numbers left."""
    return math.sqrt(math.fsum(each**2 for each in residuals) / max(1, len(residuals) - fitted))


def _ratios(samples: Iterable[Sample]) -> dict[str, float]:
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


@dataclass(frozen=True)
class Compared:
    """One number of a report beside the number of the law.

    ``report``: tool, file and line. ``line``: of the demand; "" for the design as a whole.
    """

    term: str
    design: str
    predicted: Figure
    reported: float
    report: str
    line: str = ""

    @property
    def ratio(self) -> float | None:
        """Reported over predicted; None where the law says 0."""
        return self.reported / self.predicted.value if self.predicted.value else None


def fit_calibration(
    reports: Sequence[tuple[Report, DesignPoint]],
    rows: Sequence[Compared],
    added_to: CalibrationFile | None,
    name: str,
    explained: Mapping[str, str],
) -> CalibrationFile | None:
    """The calibration that follows from reports, checked as its file is; None where no term has a factor.

    ``reports``: with their design points. ``rows``: their numbers. ``added_to``: its samples are taken too.
    ``explained``: by term, why reports differ from the law by more than a factor of 2.

    Raises:
        InputError: a factor is of another design or part or is not explained, ``added_to`` is of another style, or the
            part cannot be so.
    """
    point = reports[0][1]
    style = point.style
    if added_to is not None:
        of = (added_to.planner, added_to.style, added_to.task, added_to.family)
        here = (style.planner, style.style, point.task, point.part.family)
        if of != here:
            what = f"{added_to.name} is of {_words(of)}, and the reports are of {_words(here)}"
            raise InputError(what, "--with", "name a calibration of the same style and family")
    before = added_to.terms if added_to else {}
    taken = [(term, sample) for term, fitted in before.items() for sample in fitted.samples]
    widths: dict[str, tuple[float, float]] = {}
    for row in rows:
        law = row.predicted
        if law.value and row.reported:
            sample = Sample(design=row.design, predicted=float(law.value), reported=row.reported, report=row.report)
            taken.append((row.term, sample))
            low, high = (bound / law.value for bound in law.interval)
            width = widths.get(row.term, (1.0, 1.0))
            widths[row.term] = min(low, width[0]), max(high, width[1])
    if not taken:
        return None
    for term in before.keys() - widths.keys():
        low, high = (bound / before[term].factor.value for bound in before[term].factor.interval)
        widths[term] = low, high
    reasons = {term: fitted.explained for term, fitted in before.items()} | dict(explained)
    samples = map_reduce(taken, itemgetter(0), itemgetter(1), lambda held: list(unique_everseen(held)))
    terms = _fitted(samples, widths, point, reasons)
    tools = dict.fromkeys([*(added_to.tools if added_to else ()), *(report.made_by for report, _ in reports)])
    files = {**(added_to.reports if added_to else {}), **{each.file: each.digest for each, _ in reports}}
    head = {
        "kind": "calibration",
        "name": name,
        "planner": style.planner,
        "style": style.style,
        **({"task": point.task} if point.task else {}),
        "family": point.part.family,
        "part": point.part.full_name,
        "tools": list(tools),
        "reports": files,
        "codesign": __version__,
        "date": date_of_writing(),
    }
    calibration = _checked(head, terms)
    contradiction = calibration.contradiction(point.part)
    if contradiction is not None:
        raise InputError(f"the calibration {contradiction}", None, "leave that report out, or correct the part file")
    return calibration


def _words(of: Iterable[str]) -> str:
    return " ".join(filter(None, of))


def _fitted(
    samples: Mapping[str, Sequence[Sample]],
    widths: Mapping[str, tuple[float, float]],
    point: DesignPoint,
    reasons: Mapping[str, str],
) -> dict[str, FittedTerm]:
    """The factor of each term. ``widths``: the interval of each law over its value.

    Raises:
        InputError: a factor is of another design or part, or is not explained.
    """
    unknown = next((term for term in reasons if term not in samples), None)
    if unknown is not None:
        hint = choose_hint(unknown, samples)
        raise InputError(f"no report says {unknown}", "--explain", hint)
    terms = {}
    for term, of_term in samples.items():
        factor = factor_of(of_term)
        if not LEAST_FACTOR <= factor <= MOST_FACTOR:
            what = f"{label(term)}: reported are {factor:.3g} times what the law says ({of_term[-1].report})"
            hint = f"{LEAST_FACTOR:g} to {MOST_FACTOR:g} times are accepted; is the report of {point.name}?"
            raise InputError(what, None, hint)
        reason = "" if LEAST_SURE <= factor <= MOST_SURE else reasons.get(term, "")
        if not LEAST_SURE <= factor <= MOST_SURE and not reason:
            what = f"{label(term)}: reported are {factor:.3g} times what the law says ({of_term[-1].report})"
            hint = (
                f"more than a factor of {MOST_SURE:g} is most often a report with more than {point.name} in it: name"
                f" one of it alone or one by hierarchy; where you know why, --explain {term}=REASON"
            )
            raise InputError(what, None, hint)
        terms[term] = fitted_term(term, of_term, widths.get(term, (1.0, 1.0)), reason)
    return terms


def _checked(head: Mapping[str, Any], terms: Mapping[str, FittedTerm]) -> CalibrationFile:
    """The calibration, read as its file is read.

    Raises:
        InputError: a factor is of another design or part.
    """
    text = _text({**head, "terms": {term: _tree(fitted) for term, fitted in terms.items()}})
    document = parse_document(text.encode(), f"{head['name']}.yaml", Path())
    try:
        return validate(CalibrationFile, document).with_document(document)
    except SpecError as error:
        fault = error.faults[0]
        raise InputError(f"{fault.key}: {fault.what}", None, "check that the reports are of this design") from None


def _tree(fitted: FittedTerm) -> dict[str, Any]:
    factor = fitted.factor
    low, high = factor.interval
    figure = {"value": factor.value, "low": low, "high": high, "status": str(factor.status), "source": factor.source}
    held_out = {} if fitted.held_out is None else {"held_out": round(fitted.held_out, 6)}
    line = {"offset": fitted.offset, "margin": fitted.margin} if fitted.offset else {}
    reason = {"explained": fitted.explained} if fitted.explained else {}
    return {
        "factor": figure,
        **line,
        **reason,
        **held_out,
        "samples": [sample.model_dump() for sample in fitted.samples],
    }


def calibration_text(calibration: CalibrationFile) -> str:
    """The calibration as a YAML file."""
    return _text(calibration.document.tree)


def _text(tree: Mapping[str, Any]) -> str:
    return "# Written by hwsw calibrate fpga. Name it in a platform: the key calibration of an FPGA.\n" + plain_yaml(
        tree
    )


def plain_yaml(tree: Mapping[str, Any]) -> str:
    """A tree as a spec file of YAML, without anchors."""
    text: str = yaml.dump(dict(tree), Dumper=_Plain, sort_keys=False, allow_unicode=True, width=118)
    return text


class _Plain(yaml.SafeDumper):
    """YAML without anchors, which spec files refuse."""

    def ignore_aliases(self, _data: Any) -> bool:
        """Write the same value out each time."""
        return True


_Plain.add_representer(WrittenFloat, lambda dumper, value: dumper.represent_float(float(value)))
