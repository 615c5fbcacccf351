"""A calibration that follows from reports, and its file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import Any

import yaml
from more_itertools import map_reduce, unique_everseen

from codesign.ground.errors import InputError, SpecError, WrittenFloat, choose_hint
from codesign.ground.figures import Figure, label
from codesign.ground.files import date_of_writing
from codesign.hardware.calibrate.design import DesignPoint
from codesign.hardware.calibrate.fit import factor_of, fitted_term
from codesign.hardware.calibrate.reports import Report
from codesign.inputs.calibration_file import (
    LEAST_FACTOR,
    LEAST_SURE,
    MOST_FACTOR,
    MOST_SURE,
    CalibrationFile,
    FittedTerm,
    Sample,
)
from codesign.inputs.faults import validate
from codesign.inputs.yaml_tree import parse_document
from codesign.version import __version__


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
    head = "# Written by hwsw calibrate fpga. Name it in a platform: the key calibration of an FPGA.\n"
    text: str = yaml.dump(dict(tree), Dumper=_Plain, sort_keys=False, allow_unicode=True, width=118)
    return head + text


class _Plain(yaml.SafeDumper):
    """YAML without anchors, which spec files refuse."""

    def ignore_aliases(self, _data: Any) -> bool:
        """Write the same value out each time."""
        return True


_Plain.add_representer(WrittenFloat, lambda dumper, value: dumper.represent_float(float(value)))
