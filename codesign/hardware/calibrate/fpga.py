"""Predicted against reported, term by term, and the calibration that follows from it."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from codesign.ground.errors import InputError, choose_hint
from codesign.ground.figures import Figure, Status, label
from codesign.ground.units import counted
from codesign.hardware.calibrate.calibration import Compared, Errors, errors_of, fit_calibration
from codesign.hardware.calibrate.design import DesignPoint, check_design, exported_point, find_manifest
from codesign.hardware.calibrate.reports import ClockReading, Reading, Report, Stage, read_report
from codesign.hardware.calibrate.reports.engine import added
from codesign.inputs.library import CLOCK, DYNAMIC, STATIC, CalibrationFile

# The lines of a demand beside a report that has a hierarchy: which part of the law is off.

REST = "all else"
"""The name of all that no line of the demand counts."""

NOT_COUNTED = Figure(0, "1", Status.CALIBRATED, "no line of the demand counts it")

_COPY = re.compile(r"(__\w+)?(_\d+)?")
"""The ending that Vivado adds to the name of a module: the number of its parameters, and of its copy."""


def alone(report: Report, top: str | None) -> tuple[Report, list[str]]:
    """A report of a design that stands inside of another one, as the report of that design alone; with a note.

    ``top``: the top module of the design. A report of nothing else, or without a hierarchy, stays as it is.

    Raises:
        InputError: the design stands in it more than once.
    """
    if top is None or report.top == top or not report.hierarchy:
        return report, []
    known = {top: top}
    names = {
        place.modules[: i + 1]
        for place in report.hierarchy
        for i, module in enumerate(place.modules)
        if module_name(module, known) == top
    }
    if not names:
        return report, []
    if len(names) > 1:
        what = f"has {len(names)} copies of {top}, and a report by module does not part them"
        raise InputError(what, report.file, "report a design with one of them")
    (path,) = names
    inside = [place for place in report.hierarchy if place.modules[: len(path)] == path]
    used: dict[str, Reading] = {}
    for place in inside:
        used = added(used, place.used)
    hierarchy = tuple(replace(place, modules=place.modules[len(path) :]) for place in inside)
    note = f"{report.file}: counts are those of module {top}, inside of {report.top or 'the whole design'}"
    return replace(report, top=top, used=used, hierarchy=hierarchy), [note]


def compared_lines(report: Report, point: DesignPoint) -> Iterator[Compared]:
    """Each line of the demand, in each resource that the report has by module, beside the law.

    None where the report has no hierarchy, or its top is not the circuit of the design point: the modules of another
    design are not known. A module that no line names counts with the module that contains it.
    """
    circuit = point.circuit
    if not report.hierarchy or circuit is None or report.top != point.top:
        return
    line_of = {module: line for line, modules in circuit.pieces.items() for module in modules}
    reported: dict[str, dict[str, Reading]] = {}
    for place in report.hierarchy:
        lines = (line_of.get(module_name(name, line_of)) for name in reversed(place.modules))
        line = next(filter(None, lines), REST)
        reported[line] = added(reported.get(line, {}), place.used)
    nothing = Reading(0.0, min(reading.line for reading in report.used.values()))
    predicted = _predicted(point)
    for line in dict.fromkeys((*(line for line, _ in predicted), *reported)):
        for resource in report.used:
            law = predicted.get((line, resource), NOT_COUNTED)
            reading = reported.get(line, {}).get(resource, nothing)
            if law.value or reading.value:
                cited = report.cited(reading)
                yield Compared(resource, point.name, law, reading.value, cited, line)


def _predicted(point: DesignPoint) -> dict[tuple[str, str], Figure]:
    """By line and resource: a line may stand in the demand more than once."""
    predicted: dict[tuple[str, str], Figure] = {}
    for item in point.demand.items:
        key, figure = (item.name, item.resource), item.figure
        before = predicted.get(key)
        low, high = (
            end + more for end, more in zip(before.interval if before else (0, 0), figure.interval, strict=True)
        )
        value = item.amount + (before.value if before else 0)
        predicted[key] = Figure(value, "1", figure.status, figure.source, min(low, value), max(high, value))
    return predicted


def module_name(written: str, known: Mapping[str, str]) -> str:
    """The name of a module in its source, of one that a tool wrote.

    >>> module_name("node__parameterized3_12", {"node": "nodes"}), module_name("node_12", {"node": "nodes"})
    ('node', 'node')
    >>> module_name("node_control", {"node": "nodes"})
    'node_control'
    """
    names = sorted((name for name in known if written.startswith(name)), key=len, reverse=True)
    return next((name for name in names if _COPY.fullmatch(written[len(name) :])), written)


MOST_REPORTS = 1000


@dataclass(frozen=True, repr=False)
class Comparison:
    """The comparison of reports with the laws of one style.

    - ``rows``: every number that both have. ``lines``: the same for each line of the demand, where a report has the
      hierarchy of a design that is recognised. ``errors``: of each term that was fitted.
    - ``calibration``: the factors; None if no term could be fitted. ``notes``: what a reader must know.
    """

    rows: tuple[Compared, ...]
    lines: tuple[Compared, ...]
    errors: Mapping[str, Errors]
    calibration: CalibrationFile | None
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        fitted = counted(len(self.errors), "fitted term")
        return f"Comparison({counted(len(self.rows), 'number')} compared, {fitted})"


@dataclass(frozen=True)
class _Told:
    """A number of a report, for a design point."""

    term: str
    point: DesignPoint
    reading: Reading
    report: Report
    clock: float = 0.0

    def compared(self) -> Compared:
        """The number beside the number of the law."""
        of_clock = self.term == DYNAMIC
        law = self.point.dynamic_power(self.clock) if of_clock else self.point.predicted(self.term)
        scale = self.point.counted_a_slice if self.term == "slices" else 1
        cited = self.report.cited(self.reading)
        return Compared(self.term, self.point.name, law, self.reading.value * scale, cited)


def compare_reports(
    paths: Sequence[Path],
    point: DesignPoint | None,
    *,
    clock: str | None = None,
    added_to: CalibrationFile | None = None,
    name: str = "calibration",
    explained: Mapping[str, str] | None = None,
) -> Comparison:
    """Read reports, hold them against the laws of their designs, and fit a factor to each term.

    Args:
        paths: the report files.
        point: the design that all of them are of; None: each is recognised by the manifest beside it.
        clock: the clock domain of the design, where a report has several.
        added_to: a calibration; its samples are taken too.
        name: of the new calibration.
        explained: by term, why its reports differ from the law by more than a factor of 2.

    Raises:
        SpecError: a report is none, is cut off or in another language; or the calibration contradicts the part.
        InputError: a report is of another design or part, names no design, or has several clocks.
    """
    if len(paths) > MOST_REPORTS:
        raise InputError(f"{len(paths)} reports", "--report", f"give at most {MOST_REPORTS:,}")
    points: dict[Path, DesignPoint] = {}
    reports: list[tuple[Report, DesignPoint]] = []
    notes: list[str] = []
    for path in paths:
        of, expected = _point_of(path, point, points)
        report, wrapped = alone(read_report(path), expected)
        notes += wrapped
        note = check_design(report, of, expected)
        notes += [*([note] if note else []), *(f"{report.file}: {text}" for text in report.notes)]
        reports.append((report, of))
    _check_one_style(reports)
    told, more = _latest([*_terms(reports, clock)])
    rows = tuple(each.compared() for each in told)
    notes += more + [_bound(each) for each in told if each.term == CLOCK and _clock(each.report, clock).met]
    notes += [
        f"{row.term} of {row.design}: the law says 0, and {row.report} says {row.reported:g}; no factor follows"
        for row in rows
        if row.ratio is None and row.reported
    ]
    calibration = fit_calibration(reports, rows, added_to, name, explained or {})
    terms = {} if calibration is None else calibration.terms
    errors = {term: errors_of(term, fitted.samples) for term, fitted in terms.items()}
    notes += [_no_help(term, error) for term, error in errors.items() if (error.held_out or 0.0) > error.before]
    lines = tuple(itertools.chain.from_iterable(compared_lines(report, of) for report, of in reports))
    return Comparison(rows, lines, errors, calibration, tuple(dict.fromkeys(notes)))


def _point_of(path: Path, point: DesignPoint | None, points: dict[Path, DesignPoint]) -> tuple[DesignPoint, str | None]:
    """The design point of a report, and the top module that its name has to be; None where it has no circuit."""
    manifest = find_manifest(path)
    if point is not None:
        return point, point.top
    if manifest is None:
        hint = "name PLATFORM WORKLOAD before --report, or keep manifest.json of hwsw rtl beside the report or above it"
        raise InputError("names no design", str(path), hint)
    if manifest not in points:
        points[manifest] = exported_point(manifest)
    return points[manifest], points[manifest].name


def _check_one_style(reports: Iterable[tuple[Report, DesignPoint]]) -> None:
    """A calibration is of one style on one family."""
    first: tuple[str, ...] | None = None
    for report, point in reports:
        of = (point.style.planner, point.style.style, *filter(None, (point.task,)), point.part.family)
        first = first or of
        if of != first:
            what = f"is of {' '.join(of)}, and the first report is of {' '.join(first)}"
            raise InputError(what, report.file, "calibrate each style on each family by itself")


def _terms(reports: Sequence[tuple[Report, DesignPoint]], clock: str | None) -> Iterator[_Told]:
    """Every number of the reports that a law has too."""
    constraints = {
        point.name: reading.constraint
        for report, point in reports
        for reading in ([_clock(report, clock)] if report.clocks else [])
        if reading.constraint is not None
    }
    for report, point in reports:
        _check_counts(report, point)
        for resource, reading in report.used.items():
            yield _Told(resource, point, reading, report)
        if report.clocks:
            yield _Told(CLOCK, point, _clock(report, clock).fmax, report)
        if report.static is not None:
            yield _Told(STATIC, point, report.static, report)
        if report.dynamic is not None:
            at = report.power_clock or constraints.get(point.name)
            if at is None:
                hint = "name the timing report of the same run too, or a power report that has the clock"
                raise InputError("does not say at which clock its power is", report.file, hint)
            yield _Told(DYNAMIC, point, report.dynamic, report, at)


def _clock(report: Report, wanted: str | None) -> ClockReading:
    """The clock of the design in a report.

    Raises:
        InputError: the report has several, or none of that name.
    """
    names = [reading.name for reading in report.clocks]
    if wanted is None and len(names) > 1:
        raise InputError(f"has {len(names)} clocks", report.file, f"--clock NAME, one of {', '.join(names[:12])}")
    found = [reading for reading in report.clocks if wanted in (None, reading.name)]
    if not found:
        raise InputError(f"has no clock {wanted!r}", report.file, choose_hint(wanted or "", names))
    return found[0]


def _check_counts(report: Report, point: DesignPoint) -> None:
    """Refuse counts that the part cannot have.

    Raises:
        SpecError: more than the part has, or more LUT than its slices hold.
    """
    used, part = report.used, point.part
    for resource, reading in used.items():
        scale = point.counted_a_slice if resource == "slices" else 1
        most = part.resources[resource].interval[1]
        if reading.value * scale > most:
            what = f"{reading.value * scale:,.0f} {resource} are more than {part.name} has, {most:,.0f}"
            raise _contradiction(report, reading.line, what)
    slices, lut4 = used.get("slices"), used.get("lut4")
    if slices is not None and lut4 is not None:
        held = 2 * point.counted_a_slice * slices.value
        if lut4.value > held:
            what = f"{lut4.value:,.0f} LUT do not fit in {slices.value:,.0f} slices, which hold {held:,.0f}"
            raise _contradiction(report, lut4.line, what)


def _contradiction(report: Report, line: int, what: str) -> InputError:
    return InputError(what, f"{report.file}:{line}:1", "it is the report of another part, or was edited")


def _latest(told: Sequence[_Told]) -> tuple[list[_Told], list[str]]:
    """The numbers of the latest stage of each term of each design, and notes on those that are left out."""
    latest: dict[tuple[str, str], Stage] = {}
    for each in told:
        key = each.term, each.point.name
        latest[key] = max(latest.get(key, each.report.stage), each.report.stage)
    kept, notes = [], []
    for each in told:
        stage = latest[each.term, each.point.name]
        if each.term == CLOCK and each.report.stage != Stage.ROUTED:
            notes.append(f"{each.report.file}: its clock is of no routed design, and is left out")
        elif each.report.stage != stage:
            notes.append(f"{each.report.file}: another report has its numbers {stage.word}, which are taken")
        else:
            kept.append(each)
    return kept, notes


def _bound(told: _Told) -> str:
    return (
        f"{told.report.file}: the constraint was met, so the tool did not go on: {told.reading.value / 1e6:.1f} MHz is"
        " a lower bound. A tighter constraint says more"
    )


def _no_help(term: str, error: Errors) -> str:
    return (
        f"{label(term)}: the factor does not carry over to other designs: {error.held_out:.1%} on those held out,"
        f" {error.before:.1%} by the law alone. Calibrate the design that you build by itself"
    )
