"""``hwsw trace layout``: what a viewer shows of a trace, and where."""

from __future__ import annotations

from pathlib import Path

import click

from codesign.cli.options import force_option
from codesign.errors import printable

_VIEWERS = ("foxglove", "ros2", "rerun")


@click.command(short_help="Write the layout of a viewer for a trace.")
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    help="The file to write.  [default: FILE with the ending .json, or .rbl for Rerun]",
)
@click.option(
    "--viewer",
    type=click.Choice(_VIEWERS),
    default=_VIEWERS[0],
    show_default=True,
    help="A layout for Foxglove and Lichtblick, of the trace or of its ROS 2 bag; a blueprint for Rerun.",
)
@force_option
def layout(file: Path, output: Path | None, viewer: str) -> None:
    """Write a layout for the trace FILE: the topics that it has, in panels, seen from above, with plots and events."""
    from codesign.cli.outputs import check_outputs
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.exports.blueprint import write_blueprint
    from codesign.exports.layouts import bag_layout, foxglove_layout
    from codesign.files import write_atomically, written_atomically
    from codesign.trace import open_trace

    output = output or file.with_suffix(".rbl" if viewer == "rerun" else ".json")
    check_outputs({"--output": output}, [file], kind="blueprint" if viewer == "rerun" else "layout")
    with progress_shown(after_s=LATER_S) as show:
        opened = open_trace(file, show)
        if viewer == "rerun":
            with written_atomically(output) as passing:
                write_blueprint(opened, passing)
        else:
            text = bag_layout(opened) if viewer == "ros2" else foxglove_layout(opened)
            write_atomically(output, text.encode())
    click.echo(f"written: {printable(str(output), None)}")
    if opened.fault is not None:
        click.echo(f"the file is not complete: {printable(opened.fault)}", err=True)
