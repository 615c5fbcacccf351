"""``hwsw check`` and ``hwsw schema``."""

from __future__ import annotations

import json

import click

from codesign.cli.options import memory_option, set_option, settings_of
from codesign.errors import SpecError, printable

KINDS = (
    "platform",
    "workload",
    "part",
    "host",
    "calibration",
    "result",
    "study",
    "explanation",
    "reproduction",
    "advice",
)


@click.command(short_help="Check platform and workload files.")
@click.argument("files", nargs=-1, required=True)
@set_option
@memory_option
@click.option("--json", "as_json", is_flag=True, help="Print the faults as JSON.")
def check(files: tuple[str, ...], settings: tuple[str, ...], memory: int | None, as_json: bool) -> None:
    """Check FILES (YAML files, or names of shipped platforms and workloads), and report all faults with their places.

    A platform and a workload are checked against each other too, with the map, its goals and each variant. A run that
    would need too much memory is a fault. Without --json, notes report where a design does different work from what its
    parameters suggest.
    """
    from codesign.cli.progress import LATER_S, progress_shown
    from codesign.progress import doing
    from codesign.scenarios import check_files
    from codesign.units import counted

    notes: list[str] = []
    with progress_shown(after_s=LATER_S, quiet=as_json) as show:
        doing(show, f"checking {counted(len(files), 'file')}")
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
    """Print the JSON Schema of a platform, workload, part, host or calibration file, or of the output of --json.

    The output is a result (hwsw run), a study (hwsw explore), an explanation (hwsw explain), an advice (hwsw advise) or
    a reproduction (hwsw reproduce).
    """
    if kind == "study":
        from codesign.exploration import study_schema

        document = study_schema()
    elif kind == "explanation":
        from codesign.explanation import explanation_schema

        document = explanation_schema()
    elif kind == "advice":
        from codesign.advice import advice_schema

        document = advice_schema()
    elif kind == "reproduction":
        from codesign.reproduce import reproduction_schema

        document = reproduction_schema()
    else:
        from codesign.system import schema_of

        document = schema_of(kind)
    click.echo(json.dumps(document, indent=2))
