"""The command line: parse, call, print. No logic, and nothing heavy imported before a command needs it.

A reader of its output who goes away (``hwsw run ... | head``) changes nothing: the command ends its work and exits
with the code of its outcome. To die of SIGPIPE instead was rejected: it turns "nothing feasible" (3) into 141, and
leaves files unwritten that were asked for.
"""

from __future__ import annotations

import os
import sys
import threading
import traceback
from importlib import import_module
from typing import Any, NoReturn

import click

from codesign import __version__, interrupts
from codesign.cli.pipes import Heedless, output_may_fail
from codesign.errors import (
    EXIT_DONE,
    EXIT_FAILED,
    EXIT_INTERRUPTED,
    EXIT_TERMINATED,
    CodesignError,
    InputError,
    RunError,
)

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
        with output_may_fail() as out:
            try:
                return super().main(*args, **kwargs)
            except SystemExit as leaving:
                struck = interrupts.struck()
                code = leaving.code if struck is None else struck.exit_code
                if code in (EXIT_INTERRUPTED, EXIT_TERMINATED):
                    _leave_at_once(int(code))
                if _was_lost(out) and leaving.code in (None, EXIT_DONE):
                    raise SystemExit(EXIT_FAILED) from None
                raise

    def invoke(self, ctx: click.Context) -> object:
        """Run a command; a user's mistake ends in its message and exit code, never in a traceback."""
        interrupts.keep("")
        try:
            _check_current_folder()
            return super().invoke(ctx)
        except (Exception, KeyboardInterrupt) as fault:
            struck = interrupts.struck(fault)
            if struck is not None:
                click.echo(interrupts.word(struck), err=True)
                raise click.exceptions.Exit(struck.exit_code) from None
            if isinstance(fault, CodesignError):
                told = fault
            elif _is_of_kernel_cache(fault):
                told = RunError(
                    f"the cache of compiled kernels cannot be used: {fault or type(fault).__name__}",
                    None,
                    _CACHE,
                )
            else:
                raise
        click.echo(str(told), err=True)
        raise click.exceptions.Exit(told.exit_code)


def _leave_at_once(code: int) -> NoReturn:
    """End the process with this code.

    Raises:
        SystemExit: where no thread would have to be joined.
    """
    if all(thread.daemon or thread is threading.main_thread() for thread in threading.enumerate()):
        raise SystemExit(code) from None
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    os._exit(code)


_CACHE = "delete the __pycache__ folders of codesign, or set NUMBA_CACHE_DIR to a new folder that can be written to"


def _is_of_kernel_cache(fault: BaseException) -> bool:
    """Whether numba failed at reading or placing its cache: what is then raised may be of any type."""
    place = os.path.join("numba", "core", "caching.py")
    return any(
        frame.f_code.co_filename.endswith(place) for frame, _ in traceback.walk_tb(fault.__traceback__)
    )


def _check_current_folder() -> None:
    try:
        os.getcwd()
    except OSError as fault:
        raise InputError("the current folder is no longer there", None, "change to another") from fault


def _was_lost(out: Heedless | None) -> bool:
    """Whether standard output failed; says so."""
    if out is None:
        return False
    out.flush()
    if out.fault is not None:
        click.echo(f"the output cannot be written: {out.fault.strerror}", err=True)
    return out.fault is not None


@click.group(
    cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110}
)
@click.version_option(__version__, prog_name="hwsw")
def main() -> None:
    """Co-design robot path planners in hardware and software.

    Declare a platform and a workload in YAML, simulate or explore, and compare time, resources, power and the quality
    of the plan.

    Exit codes: 0 done, 1 failed, 2 a fault of a file or of the command line, 3 nothing feasible, 130 interrupted
    (Ctrl-C), 143 terminated (SIGTERM).
    """
