"""``hwsw calibrate`` and ``measured``: costs measured here, reports of an FPGA tool, and a plan timed on a board."""

from __future__ import annotations

import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, compiling_shown, progress_shown
from codesign.cli.requests import CalibrateFpga, CalibrateHost, Measured
from codesign.cli.specs import settings_of
from codesign.ground.errors import EXIT_NO, InputError, printable
from codesign.ground.files import write_atomically
from codesign.ground.models import NAME_PATTERN
from codesign.hardware.calibrate.board import read_board, script
from codesign.hardware.calibrate.calibration import calibration_text
from codesign.hardware.calibrate.design import design_point
from codesign.hardware.calibrate.fpga import compare_reports
from codesign.hardware.calibrate.host_costs import host_document, host_text, measure_host, processor_text
from codesign.hardware.calibrate.measured import compare_measured
from codesign.inputs import load_platform
from codesign.inputs.library import CALIBRATIONS, HOSTS, TERMS
from codesign.system import catalog
from codesign.views.report import render_text
from codesign.views.report.hardware_tables import calibration_document, calibration_tables
from codesign.views.report.wording import Ends, interval_text, quantity_text, with_ends

if TYPE_CHECKING:
    from codesign.ground.figures import Figure
    from codesign.hardware.calibrate.design import DesignPoint
    from codesign.hardware.calibrate.measured import Compared


def host(asked: CalibrateHost) -> None:
    """Time the planners' kernels on this machine, and print them as keys of a processor, or write a host file."""
    if asked.script:
        given = {"--from": asked.board, "--write": asked.write, "--like": asked.like, "--json": asked.as_json or None}
        if other := [option for option, value in given.items() if value is not None]:
            raise InputError(
                f"a script, and {' and '.join(other)}", "--script", "run it on the board, then give --from"
            )
        click.echo(script(asked.seconds), nl=False)
        return
    check_outputs({"--write": asked.write}, (asked.board,), kind="host")
    name = None if asked.write is None else _name_of("--write", asked.write, "hosts/mine.yaml")
    if asked.like is not None:
        HOSTS.find(asked.like)
    with progress_shown(after_s=LATER_S, quiet=asked.as_json) as show, compiling_shown(show):
        measured = measure_host(asked.seconds, show) if asked.board is None else read_board(asked.board)
    for program, why in measured.not_timed.items():
        click.echo(f"note: {printable(program, None)} was not timed: {printable(why, None)}", err=True)
    if asked.as_json or asked.write is None:
        text = json.dumps(host_document(measured), indent=2) + "\n" if asked.as_json else processor_text(measured)
        click.echo(text, nl=False)
    if asked.write is not None and name is not None:
        write_atomically(asked.write, host_text(measured, name, asked.like).encode())
        click.echo(f"written: {printable(str(asked.write), None)}", err=asked.as_json)


def fpga(asked: CalibrateFpga) -> None:
    """Show what reports of your FPGA tool say beside what the laws predict, and fit a factor to each term."""
    check_outputs({"-o": asked.output}, (*asked.reports, *asked.specs, asked.added_to), kind="calibration")
    name = "calibration" if asked.output is None else _name_of("-o", asked.output, "calibrations/mine.yaml")
    compared = compare_reports(
        asked.reports,
        _named_point(asked.specs, asked.settings),
        clock=asked.clock,
        added_to=None if asked.added_to is None else CALIBRATIONS.load(asked.added_to),
        name=name,
        explained=dict(_explained(reason) for reason in asked.reasons),
    )
    if asked.as_json:
        click.echo(json.dumps(calibration_document(compared), indent=2))
    else:
        for table in calibration_tables(compared):
            click.echo(render_text(table))
        for note in compared.notes:
            click.echo(f"note: {printable(note, None)}")
    if asked.output is None:
        return
    if compared.calibration is None:
        raise InputError("no term has a factor, so there is nothing to write", "-o", "name reports of the design")
    write_atomically(asked.output, calibration_text(compared.calibration).encode())
    click.echo(f"written: {printable(str(asked.output), None)}", err=asked.as_json)


def _named_point(specs: tuple[str, ...], settings: tuple[str, ...]) -> DesignPoint | None:
    """The design point of the command line; None where it names none."""
    if not specs:
        if settings:
            raise InputError("a setting without a design point", "--set", "name PLATFORM WORKLOAD")
        return None
    if len(specs) != 2:
        raise InputError(f"{len(specs)} names", "PLATFORM WORKLOAD", "name a platform and a workload, or none")
    platform, workload = load_platform(specs[0]), catalog.load_workload(specs[1])
    name = " ".join((platform.name, workload.name, *settings))
    return design_point(platform, workload, settings_of(settings), name[:200])


def _explained(option: str) -> tuple[str, str]:
    """The term and the reason of an option."""
    term, _, reason = option.partition("=")
    if term not in TERMS or not reason.strip():
        hint = f"write TERM=REASON; a term is one of {', '.join(TERMS)}"
        raise InputError(f"{printable(option)} gives no reason for a term", "--explain", hint)
    return term, reason.strip()[:512]


def _name_of(option: str, output: Path, example: str) -> str:
    """The name of a calibration or a host, which is the name of its file."""
    if output.suffix != ".yaml" or not re.match(NAME_PATTERN, output.stem) or len(output.stem) > 64:
        what = f"{output.name} is no name of a {example.partition('s/')[0]}"
        raise InputError(what, option, f"letters, digits, _ and -, and .yaml: {example}")
    return output.stem


def measured(asked: Measured) -> None:
    """Hold a plan that was measured on the real board against the model, and solve for the figures that decide it."""
    check_outputs({"--write": asked.write}, (asked.file,), kind="measured")
    compared = compare_measured(asked.file, Path() if asked.write is None else asked.write.parent)
    click.echo(json.dumps(_document(compared), indent=2) if asked.as_json else _text(compared))
    if asked.write is not None:
        write_atomically(asked.write, compared.text.encode())
        click.echo(f"written: {printable(str(asked.write), None)}", err=asked.as_json)
    if compared.off != 1.0:
        raise click.exceptions.Exit(EXIT_NO)


def _text(compared: Compared) -> str:
    """The comparison for people."""
    of, times = compared.measured, compared.measured.time_of_a_plan
    place = "inside"
    if compared.off != 1.0:
        end = "the greatest" if compared.off > 1 else "the least"
        place = f"outside, {compared.off:.3g} times {end}: another program, machine or design than the model's?"
    model = with_ends(quantity_text(compared.value, "s"), _span(*compared.interval), Ends.INTERVAL)
    lines = [
        f"{of.platform}, {of.workload}: a plan took {quantity_text(times.median, 'ps')} (median of {of.runs:,}),"
        f" {quantity_text(times.p99, 'ps')} at the 99th percentile, on {of.date}.",
        f"The model says {model}: {place}.",
        *(
            f"{name}: {_figure(figure)}, measured; before {_figure(compared.before[name])}"
            for name, figure in compared.figures.items()
        ),
        f"With {'these' if len(compared.figures) > 1 else 'this'} the model says {_span(*compared.narrowed)}.",
    ]
    return "\n".join(printable(line, None) for line in lines)


def _figure(figure: Figure) -> str:
    low, high = figure.interval
    value = quantity_text(figure.value, figure.unit)
    return value if low == high else with_ends(value, interval_text(low, high, figure.unit), Ends.INTERVAL)


def _span(low: float, high: float) -> str:
    return f"{quantity_text(low, 's')} to {quantity_text(high, 's')}"


def _document(compared: Compared) -> dict[str, object]:
    """The comparison for programs."""
    return {
        "measured": compared.measured.model_dump(mode="json"),
        "model_s": compared.value,
        "interval_s": compared.interval,
        "inside": compared.off == 1.0,
        "off": compared.off,
        "figures": {name: asdict(figure) for name, figure in compared.figures.items()},
        "before": {name: asdict(figure) for name, figure in compared.before.items()},
        "narrowed_s": compared.narrowed,
    }
