"""``hwsw list``, ``show`` and ``init``: what ships, and first files of one's own."""

from __future__ import annotations

import json
import shlex
import sys
from pathlib import Path

import click

from codesign.cli.options import MapFile, cell_of
from codesign.errors import InputError, printable


@click.command("list", short_help="List platforms, parts, hosts, workloads, planners and styles.")
@click.argument("planner", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def list_(planner: str | None, as_json: bool) -> None:
    """List the shipped platforms, parts, hosts and workloads, and the installed planners and styles.

    With PLANNER, list the parameters of that planner: task, name, accepted values, default and meaning; its styles, and
    its policies for planning again.
    """
    from codesign.report import planner_tables, render_text
    from codesign.system import at_hand, planner_facts

    if planner is not None:
        facts = planner_facts(planner)
        if as_json:
            click.echo(json.dumps(facts.as_dict(), indent=2))
            return
        click.echo(f"{facts.name}: {facts.description}\n")
        for table in planner_tables(facts):
            click.echo(render_text(table))
        return
    available = at_hand()
    if as_json:
        click.echo(json.dumps(available, indent=2))
        return
    for kind, entries in available.items():
        click.echo(f"{kind}:")
        width = max(map(len, entries), default=0)
        for name, text in entries.items():
            click.echo(f"  {name:<{width}}  {text}".rstrip())


@click.command(short_help="Print a shipped file.")
@click.argument("name")
@click.option("--path", "path_only", is_flag=True, help="Print the path of the file alone.")
def show(name: str, path_only: bool) -> None:
    """Print the shipped platform, part, workload or map NAME. Its path is a comment on standard error.

    Where files of several kinds have one name, write platform:NAME, part:NAME, workload:NAME or map:NAME.
    """
    from codesign.inputs.files import find_shipped, shown

    path = find_shipped(name)
    if path_only:
        click.echo(shown(path))
        return
    content = path.read_bytes()
    if b"\0" in content and sys.stdout.isatty():
        hint = "add --path for its path, or send the output to a file"
        raise InputError(f"{shown(path)} is an image, which a terminal cannot show", name, hint)
    click.echo(f"# {shown(path)}", err=True)
    click.echo(content, nl=False)


@click.command(short_help="Write a first platform and workload.")
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path), default=Path())
@click.option("--board", metavar="PLATFORM", help="Begin with this shipped platform.")
@click.option("--planner", help="Plan with this planner.")
@click.option(
    "--map",
    "map_file",
    type=MapFile(exists=True, dir_okay=False, path_type=Path),
    help="Plan on this map: a file, or the name of a shipped one.",
)
@click.option("--goal", metavar="ROW,COLUMN", help="The goal on the map.")
def init(
    folder: Path, board: str | None, planner: str | None, map_file: Path | None, goal: str | None
) -> None:
    """Write my-platform.yaml and my-workload.yaml into FOLDER, ready to run and to edit.

    Without options: harmonic control of a labyrinth on virtex4-pci. With an option, the workload has the first style
    and parameters of the planner that fit the board and the map. Without --goal, the goal is the free cell nearest to
    the middle of the map, in its largest connected area. No file is overwritten.
    """
    from codesign.inputs import starting_files
    from codesign.scenarios import begin

    for name in (begin.PLATFORM_FILE, begin.WORKLOAD_FILE):
        if (folder / name).exists():
            hint = "choose another folder, or remove the file first"
            raise InputError(f"{folder / name} exists already", hint=hint)
    choices: tuple[str, ...] = ()
    if (board, planner, map_file, goal) == (None, None, None, None):
        texts = starting_files()
    else:
        cell = None if goal is None else cell_of("--goal", goal)
        chosen = begin.beginning(board or begin.BOARD, planner or begin.PLANNER, map_file, cell, folder)
        texts, choices = chosen.texts, chosen.choices
    _write(folder, texts)
    for name in texts:
        click.echo(f"written: {printable(str(folder / name), None)}")
    for choice in choices:
        click.echo(printable(choice, None))
    click.echo(f"next: hwsw run {printable(shlex.join(str(folder / name) for name in texts), None)}")


def _write(folder: Path, texts: dict[str, str]) -> None:
    """Write all files into the folder, or none."""
    from codesign.files import write_atomically

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot write into {folder}: {fault.strerror}") from fault
    written: list[Path] = []
    try:
        for name, text in texts.items():
            write_atomically(folder / name, text.encode())
            written.append(folder / name)
    except BaseException:
        # One file without the other is useless, and the next attempt would refuse to overwrite it.
        for path in written:
            path.unlink(missing_ok=True)
        raise
