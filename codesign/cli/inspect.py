"""``hwsw check`` and ``hwsw schema``."""

from __future__ import annotations

import json

import click

from codesign.cli.progress import LATER_S, progress_shown
from codesign.cli.requests import Check, Schema
from codesign.ground.errors import SpecError, printable
from codesign.ground.late import load
from codesign.ground.progress import doing
from codesign.ground.units import counted
from codesign.system.scenarios import check_files


def check(asked: Check) -> None:
    """Check files, and report all faults with their places."""
    notes: list[str] = []
    with progress_shown(after_s=LATER_S, quiet=asked.as_json) as show:
        doing(show, f"checking {counted(len(asked.files), 'file')}")
        faults = check_files(asked.files, asked.settings, asked.memory, notes.append)
    if asked.as_json:
        click.echo(json.dumps([vars(fault) for fault in faults], indent=2))
    if faults:
        raise click.exceptions.Exit(SpecError.exit_code) if asked.as_json else SpecError(faults)
    if not asked.as_json:
        for note in notes:
            click.echo(f"note: {printable(note, None)}")
        click.echo(f"{len(asked.files)} checked, no fault found")


def schema(asked: Schema) -> None:
    """Print the JSON Schema of a kind of file, or of what a command prints with --json."""
    schema_of = load(_SCHEMAS.get(asked.kind, "codesign.system:schema_of"))
    document = schema_of() if asked.kind in _SCHEMAS else schema_of(asked.kind)
    click.echo(json.dumps(document, indent=2))


_SCHEMAS = {
    "study": "codesign.study:study_schema",
    "explanation": "codesign.system.explanation:explanation_schema",
    "advice": "codesign.study.advice:advice_schema",
    "reproduction": "codesign.hardware.reproduce:reproduction_schema",
}
"""The schemas of answers that stand beside them; all others are schemas of files."""
