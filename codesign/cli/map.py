"""``hwsw map``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from codesign.cli.options import MapFile, force_option
from codesign.errors import InputError, MapError, printable

if TYPE_CHECKING:
    from codesign.inputs.map_spec import FileMap


@click.command("map", short_help="Show a map: its size, free cells, components, and what cropping saves.")
@click.argument("file", type=MapFile(path_type=Path))
@click.option(
    "--unknown", metavar="blocked|free", help="What a cell counts as that the map says nothing about."
)
@click.option(
    "--inflate", metavar="RADIUS", help="Block cells this near to an obstacle: '0.3 m' or '6 cells'."
)
@click.option("--downsample", type=int, metavar="N", help="Join N × N cells to one.")
@click.option("--crop", metavar="none|free|reachable", help="The part of the map that is shown.")
@click.option("--resolution", metavar="LENGTH", help="Metres a cell, where the map does not say so: '5 cm'.")
@click.option(
    "--at", metavar="ROW,COLUMN|X,Y", help="Find the nearest free cell: 40,60 is a cell, 12.5,3.0 are metres."
)
@click.option(
    "--png", type=click.Path(dir_okay=False, path_type=Path), help="Write the part shown as an image."
)
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON.")
@force_option
def map_(
    file: Path,
    at: str | None,
    png: Path | None,
    as_json: bool,
    **steps: str | int | None,
) -> None:
    """Show the map in FILE, or a shipped map by its name, as a workload with these steps would plan on it.

    Rows are counted from 0 at the top, columns from 0 at the left. Metres are those of map_server: x to the right, y
    up. Cropping keeps both.
    """
    from codesign import maps
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.inputs.places import parse_place
    from codesign.maps import map_files
    from codesign.maps.survey import picture, survey
    from codesign.progress import doing
    from codesign.system.map_text import map_lines, place_on

    spec = _spec(file, {name: value for name, value in steps.items() if value is not None})
    check_outputs({"--png": png}, map_files(spec.path))
    with progress_shown(after_s=LATER_S, quiet=as_json) as show:
        doing(show, "reading and preparing the map")
        try:
            grid = maps.read_prepared(spec.path, spec.steps)
        except MapError as wrong:
            if wrong.where in steps:
                raise InputError(wrong.what, f"--{wrong.where}", wrong.hint) from None
            raise
        doing(show, "measuring the map")
        place = None if at is None else place_on(grid, parse_place(at, "--at"), "--at")
        figures = survey(grid, spec.crop, place)
        if png is not None:
            doing(show, "writing the picture of the map")
            maps.write_image(maps.cropped(grid, figures.part), png)
    if as_json:
        nearest = {} if place is None else {"at": place, "nearest_free": maps.nearest_free(grid.free, place)}
        click.echo(json.dumps(figures.as_json() | nearest, indent=2))
        return
    for line in [*map_lines(figures, place), "", *picture(grid, figures.part, place)]:
        click.echo(printable(line, None))
    if png is not None:
        click.echo(f"written: {printable(str(png), None)}")


def _spec(file: Path, steps: dict[str, str | int]) -> FileMap:
    """The map with its steps, checked as the key ``map`` of a workload is."""
    from codesign.errors import Fault, SpecError
    from codesign.inputs.document import Document
    from codesign.inputs.faults import validate
    from codesign.inputs.map_spec import FileMap

    try:
        return validate(FileMap, Document("command line", Path(), {"file": str(file), **steps}))
    except SpecError as wrong:
        raise SpecError(
            Fault("FILE" if fault.key == "file" else f"--{fault.key}", 0, 0, "", fault.what, fault.hint)
            for fault in wrong.faults
        ) from None
