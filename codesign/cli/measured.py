"""``hwsw measured``: a plan that was measured on the real board, against the model and back into its figures."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.outputs import check_outputs
from codesign.cli.requests import Measured
from codesign.ground.errors import EXIT_NO, printable
from codesign.ground.files import write_atomically
from codesign.hardware.calibrate.measured import compare_measured
from codesign.views.report.wording import Ends, interval_text, quantity_text, with_ends

if TYPE_CHECKING:
    from codesign.ground.figures import Figure
    from codesign.hardware.calibrate.measured import Compared


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
