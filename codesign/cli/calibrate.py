"""``hwsw calibrate``: costs measured on this machine, and laws fitted to the reports of an FPGA tool."""

from __future__ import annotations

import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import force_option, settings_of
from codesign.errors import InputError, printable
from codesign.models import NAME_PATTERN

if TYPE_CHECKING:
    from codesign.calibrate.design import DesignPoint
    from codesign.inputs.calibration_file import CalibrationFile


@click.group(short_help="Fit costs and laws to your machine and your FPGA tool.")
def calibrate() -> None:
    """Fit costs to this machine, or laws to the reports of your FPGA tool, for platform files."""


@calibrate.command(short_help="Measure the cost of each kernel on this machine.")
@click.option(
    "--seconds", type=float, default=2.0, show_default=True, help="The approximate time to measure."
)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def host(seconds: float, as_json: bool) -> None:
    """Time the planners' kernels on this machine, and print them as the key costs of a processor in a platform file."""
    from codesign.calibrate.host_costs import measure_host
    from codesign.cli.progress import LATER_S, compiling_shown, progress_shown

    with progress_shown(after_s=LATER_S, quiet=as_json) as show, compiling_shown(show):
        measured = measure_host(seconds, show)
    if as_json:
        click.echo(json.dumps({name: asdict(figure) for name, figure in measured.items()}, indent=2))
        return
    click.echo("costs:")
    for name, figure in measured.items():
        low, high = figure.interval
        value = {"value": f"{_ps(figure.value)} ps", "low": f"{_ps(low)} ps", "high": f"{_ps(high)} ps"}
        text = ", ".join(f"{key}: {quantity}" for key, quantity in value.items())
        click.echo(f"  {name}: {{{text}, status: measured, source: {json.dumps(figure.source)}}}")


def _ps(seconds: float) -> int:
    return max(1, round(seconds * 1e12))


@calibrate.command(short_help="Fit the laws of a style to reports of your FPGA tool.")
@click.argument("specs", nargs=-1, metavar="[PLATFORM WORKLOAD]")
@click.option(
    "--report",
    "reports",
    multiple=True,
    required=True,
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="A report of utilisation, timing or power. May be repeated.",
)
@click.option(
    "--set", "settings", multiple=True, metavar="AXIS=VALUE", help="Set an axis of the design point."
)
@click.option("--clock", metavar="NAME", help="The clock of the design, where a report has several.")
@click.option(
    "--with",
    "added_to",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="A calibration; its samples are taken too.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="FILE",
    help="Write the calibration, such as calibrations/mine.yaml.",
)
@click.option(
    "--explain",
    "reasons",
    multiple=True,
    metavar="TERM=REASON",
    help="Accept reports of TERM, such as lut4, that differ from the law by more than a factor of 2. May be repeated.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
@force_option
def fpga(
    specs: tuple[str, ...],
    reports: tuple[Path, ...],
    settings: tuple[str, ...],
    clock: str | None,
    added_to: Path | None,
    output: Path | None,
    reasons: tuple[str, ...],
    as_json: bool,
) -> None:
    """Show what reports of your FPGA tool say beside what the laws predict, and fit a factor to each term.

    The reports are those of Vivado, ISE, Quartus, Diamond, Radiant, Gowin EDA, Yosys and nextpnr, as text or JSON. All
    are of the design point PLATFORM WORKLOAD (names or YAML files). Without these, each report is of the design whose
    manifest.json, by hwsw rtl, stands in its folder or above.

    With -o, the factors are written as a calibration. Name it in your platform, with the key calibration of the FPGA:
    results then say the calibrated numbers, and cite it.
    """
    from codesign.calibrate.calibration import calibration_text
    from codesign.calibrate.fpga import compare_reports
    from codesign.cli.outputs import check_outputs
    from codesign.files import write_atomically
    from codesign.report import render_text
    from codesign.report.calibration_tables import calibration_document, calibration_tables

    check_outputs({"-o": output}, (*reports, *specs, added_to), kind="calibration")
    name = "calibration" if output is None else _name_of(output)
    compared = compare_reports(
        reports,
        _named_point(specs, settings),
        clock=clock,
        added_to=None if added_to is None else _loaded(added_to),
        name=name,
        explained=dict(_explained(reason) for reason in reasons),
    )
    if as_json:
        click.echo(json.dumps(calibration_document(compared), indent=2))
    else:
        for table in calibration_tables(compared):
            click.echo(render_text(table))
        for note in compared.notes:
            click.echo(f"note: {printable(note, None)}")
    if output is None:
        return
    if compared.calibration is None:
        raise InputError(
            "no term has a factor, so there is nothing to write", "-o", "name reports of the design"
        )
    write_atomically(output, calibration_text(compared.calibration).encode())
    click.echo(f"written: {printable(str(output), None)}", err=as_json)


def _named_point(specs: tuple[str, ...], settings: tuple[str, ...]) -> DesignPoint | None:
    """The design point of the command line; None where it names none."""
    from codesign.calibrate.design import design_point
    from codesign.inputs import load_platform
    from codesign.system import catalog

    if not specs:
        if settings:
            raise InputError("a setting without a design point", "--set", "name PLATFORM WORKLOAD")
        return None
    if len(specs) != 2:
        raise InputError(
            f"{len(specs)} names", "PLATFORM WORKLOAD", "name a platform and a workload, or none"
        )
    platform, workload = load_platform(specs[0]), catalog.load_workload(specs[1])
    name = " ".join((platform.name, workload.name, *settings))
    return design_point(platform, workload, settings_of(settings), name[:200])


def _explained(option: str) -> tuple[str, str]:
    """The term and the reason of an option."""
    from codesign.inputs.calibration_file import TERMS

    term, _, reason = option.partition("=")
    if term not in TERMS or not reason.strip():
        hint = f"write TERM=REASON; a term is one of {', '.join(TERMS)}"
        raise InputError(f"{printable(option)} gives no reason for a term", "--explain", hint)
    return term, reason.strip()[:512]


def _loaded(path: Path) -> CalibrationFile:
    from codesign.inputs.calibration_file import CALIBRATIONS

    return CALIBRATIONS.load(path)


def _name_of(output: Path) -> str:
    """The name of a calibration is that of its file."""
    if output.suffix != ".yaml" or not re.match(NAME_PATTERN, output.stem) or len(output.stem) > 64:
        what = f"{output.name} is no name of a calibration"
        raise InputError(what, "-o", "letters, digits, _ and -, and .yaml: calibrations/mine.yaml")
    return output.stem
