"""``hwsw check``, ``hwsw schema`` and ``hwsw map``."""

from __future__ import annotations

import json
from pathlib import Path

import click

from codesign import maps
from codesign.cli.outputs import check_outputs
from codesign.cli.progress import LATER_S, progress_shown
from codesign.cli.requests import Check, Map, Schema
from codesign.ground.errors import Fault, InputError, MapError, SpecError, printable
from codesign.ground.late import load
from codesign.ground.progress import doing
from codesign.ground.units import counted
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.map_spec import FileMap
from codesign.maps import map_files
from codesign.maps.survey import picture, survey
from codesign.system.inspect import map_lines, place_on
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
    "reproduction": "codesign.planners.reproduction:reproduction_schema",
}
"""The schemas of answers that stand beside them; all others are schemas of files."""


def map_(asked: Map) -> None:
    """Show the map in FILE, or a shipped map by its name, as a workload with these steps would plan on it."""
    given = {name: vars(asked)[name] for name in ("unknown", "inflate", "downsample", "crop", "resolution")}
    steps = {name: value for name, value in given.items() if value is not None}
    spec = _spec(asked.file, steps)
    check_outputs({"--png": asked.png}, map_files(spec.path))
    with progress_shown(after_s=LATER_S, quiet=asked.as_json) as show:
        doing(show, "reading and preparing the map")
        try:
            grid = maps.read_prepared(spec.path, spec.steps)
        except MapError as wrong:
            if wrong.where in steps:
                raise InputError(wrong.what, f"--{wrong.where}", wrong.hint) from None
            raise
        doing(show, "measuring the map")
        place = None if asked.at is None else place_on(grid, asked.at, "--at")
        figures = survey(grid, spec.crop, place)
        if asked.png is not None:
            doing(show, "writing the picture of the map")
            maps.write_image(maps.cropped(grid, figures.part), asked.png)
    if asked.as_json:
        nearest = {} if place is None else {"at": place, "nearest_free": maps.nearest_free(grid.free, place)}
        click.echo(json.dumps(figures.as_json() | nearest, indent=2))
        return
    for line in [*map_lines(figures, place), "", *picture(grid, figures.part, place)]:
        click.echo(printable(line, None))
    if asked.png is not None:
        click.echo(f"written: {printable(str(asked.png), None)}")


def _spec(file: Path, steps: dict[str, str | int]) -> FileMap:
    """The map with its steps, checked as the key ``map`` of a workload is."""
    try:
        return validate(FileMap, Document("command line", Path(), {"file": str(file), **steps}))
    except SpecError as wrong:
        raise SpecError(
            Fault("FILE" if fault.key == "file" else f"--{fault.key}", 0, 0, "", fault.what, fault.hint)
            for fault in wrong.faults
        ) from None
