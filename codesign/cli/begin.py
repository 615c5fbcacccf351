"""``hwsw list``, ``show`` and ``init``: what ships, and first files of one's own."""

from __future__ import annotations

import json
import shlex
import sys
from pathlib import Path

import click

from codesign import system
from codesign.cli.requests import Init, List, Show
from codesign.ground.errors import InputError, printable
from codesign.ground.files import write_atomically
from codesign.ground.late import late
from codesign.inputs import starting_files
from codesign.inputs.files import find_shipped, shown
from codesign.views import report

begin = late("codesign.system.scenarios.begin")


def list_(asked: List) -> None:
    """List the shipped platforms, parts, hosts and workloads, and the installed planners and styles."""
    if asked.planner is not None:
        facts = system.planner_facts(asked.planner)
        if asked.as_json:
            click.echo(json.dumps(facts.as_dict(), indent=2))
            return
        click.echo(f"{facts.name}: {facts.description}\n")
        for table in report.planner_tables(facts):
            click.echo(report.render_text(table))
        return
    available = system.at_hand()
    if asked.as_json:
        click.echo(json.dumps(available, indent=2))
        return
    for kind, entries in available.items():
        click.echo(f"{kind}:")
        width = max(map(len, entries), default=0)
        for name, text in entries.items():
            click.echo(f"  {name:<{width}}  {text}".rstrip())


def show(asked: Show) -> None:
    """Print the shipped platform, part, workload or map NAME. Its path is a comment on standard error."""
    path = find_shipped(asked.name)
    if asked.path_only:
        click.echo(shown(path))
        return
    content = path.read_bytes()
    if b"\0" in content and sys.stdout.isatty():
        hint = "add --path for its path, or send the output to a file"
        raise InputError(f"{shown(path)} is an image, which a terminal cannot show", asked.name, hint)
    click.echo(f"# {shown(path)}", err=True)
    click.echo(content, nl=False)


def init(asked: Init) -> None:
    """Write my-platform.yaml and my-workload.yaml into FOLDER, ready to run and to edit."""
    for name in (begin.PLATFORM_FILE, begin.WORKLOAD_FILE):
        if (asked.folder / name).exists():
            hint = "choose another folder, or remove the file first"
            raise InputError(f"{asked.folder / name} exists already", hint=hint)
    choices: tuple[str, ...] = ()
    if (asked.board, asked.planner, asked.map_file, asked.goal) == (None, None, None, None):
        texts = starting_files()
    else:
        chosen = begin.beginning(
            asked.board or begin.BOARD, asked.planner or begin.PLANNER, asked.map_file, asked.goal, asked.folder
        )
        texts, choices = chosen.texts, chosen.choices
    _write(asked.folder, texts)
    for name in texts:
        click.echo(f"written: {printable(str(asked.folder / name), None)}")
    for choice in choices:
        click.echo(printable(choice, None))
    click.echo(f"next: hwsw run {printable(shlex.join(str(asked.folder / name) for name in texts), None)}")


def _write(folder: Path, texts: dict[str, str]) -> None:
    """Write all files into the folder, or none."""
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
