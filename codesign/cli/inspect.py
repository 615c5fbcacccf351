"""``hwsw check``, ``schema``, ``list`` and ``init``."""

from __future__ import annotations

import json
from pathlib import Path

import click

from codesign.cli.memory import memory_option
from codesign.errors import InputError, SpecError, printable

KINDS = ("platform", "workload", "part", "result", "study", "reproduction")


@click.command(short_help="Check platform and workload files.")
@click.argument("files", nargs=-1, required=True)
@click.option(
    "--set", "settings", multiple=True, metavar="AXIS=VALUE", help="Override, e.g. workload.variant=NAME"
)
@memory_option
@click.option("--json", "as_json", is_flag=True, help="Print the faults as JSON.")
def check(files: tuple[str, ...], settings: tuple[str, ...], memory: int | None, as_json: bool) -> None:
    """Check FILES (YAML files, or names of shipped platforms and workloads): every fault at once, with its place.

    Where a platform and a workload are given, they are checked against each other too, the map and its goals included,
    and each variant of the workload. A run that would need too much memory is a fault too. Notes, printed without
    --json, say where a design does other work than its parameters let one expect.
    """
    from codesign.cli.run import settings_of
    from codesign.scenarios import check_files

    notes: list[str] = []
    faults = check_files(files, settings_of(settings), memory, notes.append)
    if as_json:
        click.echo(json.dumps([vars(fault) for fault in faults], indent=2))
    if faults:
        raise click.exceptions.Exit(SpecError.exit_code) if as_json else SpecError(faults)
    if not as_json:
        for note in notes:
            click.echo(f"note: {printable(note, None)}")
        click.echo(f"{len(files)} checked, no fault found")


@click.command(short_help="Print a JSON Schema.")
@click.argument("kind", type=click.Choice(KINDS))
def schema(kind: str) -> None:
    """Print the JSON Schema of a platform, workload or part file, or of what --json prints.

    That is a result (run), a study (explore) or a reproduction (reproduce).
    """
    if kind == "study":
        from codesign.exploration import study_schema

        found = study_schema()
    elif kind == "reproduction":
        from codesign.reproduce import reproduction_schema

        found = reproduction_schema()
    else:
        from codesign.system import schema_of

        found = schema_of(kind)
    click.echo(json.dumps(found, indent=2))


@click.command("list", short_help="List what is at hand.")
@click.option("--json", "as_json", is_flag=True, help="Print as JSON.")
def list_(as_json: bool) -> None:
    """List the shipped platforms, parts and workloads, and the installed planners and styles."""
    from codesign.system import at_hand

    found = at_hand()
    if as_json:
        click.echo(json.dumps(found, indent=2))
        return
    for kind, entries in found.items():
        click.echo(f"{kind}:")
        width = max(map(len, entries), default=0)
        for name, text in entries.items():
            click.echo(f"  {name:<{width}}  {text}".rstrip())


@click.command(short_help="Write a platform and a workload to start from.")
@click.argument("folder", type=click.Path(file_okay=False, path_type=Path), default=Path())
def init(folder: Path) -> None:
    """Write my-platform.yaml and my-workload.yaml into FOLDER, to be run and changed."""
    from codesign.files import write_atomically
    from codesign.inputs import starting_files

    texts = starting_files()
    existing = [folder / name for name in texts if (folder / name).exists()]
    if existing:
        raise InputError(f"{existing[0]} is there already", hint="choose another folder, or remove it first")
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
        # One without the other is no start, and would stand in the way of the next try.
        for path in written:
            path.unlink(missing_ok=True)
        raise
    for name in texts:
        click.echo(f"written: {printable(str(folder / name), None)}")
    click.echo(f"next: hwsw run {' '.join(printable(str(folder / name), None) for name in texts)}")
