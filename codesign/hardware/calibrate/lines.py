"""The lines of a demand beside a report that has a hierarchy: which part of the law is off."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

from codesign.ground.errors import InputError
from codesign.ground.figures import Figure, Status
from codesign.hardware.calibrate.calibration import Compared
from codesign.hardware.calibrate.design import DesignPoint
from codesign.hardware.calibrate.reports import Report
from codesign.hardware.calibrate.reports.record import Reading, added

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
