"""The command line: parse, call, print. No logic, and nothing heavy imported before a command needs it.

A reader of its output who goes away (``hwsw run ... | head``) changes nothing: the command ends its work and exits
with the code of its outcome. To die of SIGPIPE instead was rejected: it turns "nothing feasible" (3) into 141, and
leaves files unwritten that were asked for.
"""

from __future__ import annotations

import os
import sys
import threading
from importlib import import_module
from typing import Any

import click

from codesign import __version__
from codesign.cli.pipes import readers_may_leave
from codesign.errors import EXIT_INTERRUPTED, CodesignError

COMMANDS = {
    "run": (
        "codesign.cli.run:run",
        "Simulate one design point: its time, resources, power and quality of plan.",
    ),
    "explore": (
        "codesign.cli.explore:explore",
        "Evaluate every point of a workload's exploration; find the front.",
    ),
    "compare": (
        "codesign.cli.compare:compare",
        "Hold designs, of any planner, against each other on one map.",
    ),
    "report": ("codesign.cli.explore:report", "Make the tables and the HTML page of an exploration again."),
    "trace": ("codesign.cli.trace:trace", "Look into the trace of a run."),
    "reproduce": (
        "codesign.cli.reproduce:reproduce",
        "Hold the model against the published tables, row by row.",
    ),
    "calibrate": (
        "codesign.cli.calibrate:calibrate",
        "Measure what this machine needs for the planners' kernels.",
    ),
    "check": ("codesign.cli.inspect:check", "Check platform and workload files; report all faults at once."),
    "schema": (
        "codesign.cli.inspect:schema",
        "Print a JSON Schema, for editors and for readers of our JSON.",
    ),
    "list": (
        "codesign.cli.inspect:list_",
        "List the platforms, parts, workloads, planners and styles at hand.",
    ),
    "init": ("codesign.cli.inspect:init", "Write a platform and a workload to start from."),
}


class LazyGroup(click.Group):
    """Loads a command's module when that command runs, and turns our errors into exit codes."""

    def list_commands(self, ctx: click.Context) -> list[str]:  # noqa: ARG002 - click's signature
        """The commands in the order a newcomer needs them."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:  # noqa: ARG002
        """The command, imported now."""
        if cmd_name not in COMMANDS:
            return None
        module, name = COMMANDS[cmd_name][0].split(":")
        command: click.Command = getattr(import_module(module), name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:  # noqa: ARG002
        """List the commands without importing any of them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run, and leave at once when interrupted.

        The threads of a pool whose workers were just killed may wait for ever to be joined at exit.
        """
        try:
            return super().main(*args, **kwargs)
        except SystemExit as leaving:
            if leaving.code == EXIT_INTERRUPTED and threading.active_count() > 1:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(EXIT_INTERRUPTED)
            raise

    def invoke(self, ctx: click.Context) -> object:
        """Run a command; a user's mistake ends in its message and exit code, never in a traceback."""
        with readers_may_leave():
            try:
                return super().invoke(ctx)
            except CodesignError as fault:
                click.echo(str(fault), err=True)
                ctx.exit(fault.exit_code)
            except KeyboardInterrupt:
                click.echo("interrupted; what was finished is kept", err=True)
                ctx.exit(EXIT_INTERRUPTED)


@click.group(
    cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}
)
@click.version_option(__version__, prog_name="hwsw")
def main() -> None:
    """Co-design robot path planners in hardware and software.

    Declare a platform and a workload in YAML, simulate or explore, and compare time, resources, power and the quality
    of the plan.
    """
