"""The command line: parse, call, print. It has no logic, and imports no heavy module before a command needs it.

Where the reader of the output ends early (``hwsw run ... | head``), the command still completes its work and exits with
its own code. Rejected: to end by SIGPIPE. That would turn "nothing feasible" (3) into 141, and leave requested files
unwritten.
"""

from __future__ import annotations

import os
import sys
import threading
import traceback
from importlib import import_module
from typing import Any, NoReturn

import click

from codesign import interrupts
from codesign.cli.options import debug_option, is_debug
from codesign.cli.pipes import UnfailingStream, output_may_fail
from codesign.errors import (
    EXIT_DONE,
    EXIT_FAILED,
    EXIT_INTERRUPTED,
    EXIT_TERMINATED,
    CodesignError,
    InputError,
    RunError,
)
from codesign.files import remove_passing
from codesign.version import __version__

COMMANDS = {
    "run": (
        "codesign.cli.run:run",
        "Simulate one design point: its time, resources, power and quality of the plan.",
    ),
    "advise": (
        "codesign.cli.advise:advise",
        "Answer which board suffices for a map at a rate, and why no cheaper one does.",
    ),
    "explore": (
        "codesign.cli.explore:explore",
        "Evaluate every point of a workload's exploration, and find the front.",
    ),
    "explain": (
        "codesign.cli.explain:explain",
        "Say why a design of an exploration, or a run, is as it is.",
    ),
    "compare": (
        "codesign.cli.compare:compare",
        "Compare designs of any planner on one map.",
    ),
    "report": ("codesign.cli.explore:report", "Write the tables and the HTML page of a stored exploration."),
    "plot": (
        "codesign.cli.plot:plot",
        "Draw a front, a map, a time line or a schedule as PDF, SVG or PNG.",
    ),
    "verify-front": (
        "codesign.cli.verify_front:verify_front",
        "Check the certificate of a front. Nothing is simulated.",
    ),
    "trace": ("codesign.cli.trace:trace", "Read the trace of a run."),
    "workload": ("codesign.cli.workload:workload", "Make a workload of a recorded ROS 2 bag."),
    "reproduce": (
        "codesign.cli.reproduce:reproduce",
        "Compare the model with the published tables, row by row.",
    ),
    "calibrate": (
        "codesign.cli.calibrate:calibrate",
        "Fit costs to this machine, or laws to the reports of your FPGA tool.",
    ),
    "rtl": (
        "codesign.cli.rtl:rtl",
        "Write the Verilog of a design point, with its test bench and memory images.",
    ),
    "verify": (
        "codesign.cli.rtl:verify",
        "Compare circuits in Verilog with the model, cycle for cycle.",
    ),
    "synth": (
        "codesign.cli.synth:synth",
        "Synthesise a circuit with open tools, place and route it, and compare it with the laws.",
    ),
    "fidelity": (
        "codesign.cli.fidelity:fidelity",
        "Hold all laws against circuits that were simulated, synthesised and placed, and against papers.",
    ),
    "check": (
        "codesign.cli.inspect:check",
        "Check platform and workload files, and report all faults at once.",
    ),
    "map": (
        "codesign.cli.map:map_",
        "Show a map: its size, free cells, components, and what cropping saves.",
    ),
    "schema": (
        "codesign.cli.inspect:schema",
        "Print a JSON Schema, for editors and for programs that read the JSON output.",
    ),
    "list": (
        "codesign.cli.begin:list_",
        "List platforms, parts, hosts, workloads, planners and styles, or the parameters of a planner.",
    ),
    "show": ("codesign.cli.begin:show", "Print a shipped platform, part, workload or map."),
    "init": (
        "codesign.cli.begin:init",
        "Write a first platform and workload, for a board, a planner and a map.",
    ),
}


class LazyGroup(click.Group):
    """Loads the module of a command when the command runs, and turns errors into exit codes."""

    def list_commands(self, _ctx: click.Context, /) -> list[str]:
        """The commands in the order in which a newcomer needs them."""
        return list(COMMANDS)

    def get_command(self, _ctx: click.Context, cmd_name: str, /) -> click.Command | None:
        """Import and return the command."""
        if cmd_name not in COMMANDS:
            return None
        module, name = COMMANDS[cmd_name][0].split(":")
        command: click.Command = getattr(import_module(module), name)
        return command

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter, /) -> None:
        """List the commands without importing any of them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, text) for name, (_, text) in COMMANDS.items()])

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run the command. After an interrupt, exit at once.

        At a normal exit Python joins all threads. Those of a pool with killed workers may never end.
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
        """Run a command. Every error ends with a message and an exit code; ``--debug`` adds an unexpected traceback."""
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
                error = fault
            elif _is_of_kernel_cache(fault):
                error = RunError(
                    f"the cache of compiled kernels cannot be used: {fault or type(fault).__name__}",
                    None,
                    _CACHE,
                )
            elif isinstance(fault, _OF_CLICK):
                raise
            else:
                if is_debug(ctx):
                    click.echo(traceback.format_exc(), err=True, nl=False)
                error = RunError(f"{_UNEXPECTED}: {type(fault).__name__}: {fault}", None, _REPORT)
        click.echo(str(error), err=True)
        raise click.exceptions.Exit(error.exit_code)


_OF_CLICK = (click.ClickException, click.Abort, click.exceptions.Exit, BrokenPipeError)
"""What click reports itself."""

_UNEXPECTED = "unexpected error, a fault of hwsw"
_REPORT = "hwsw --debug COMMAND ... prints the traceback; please report it with the files"


def _leave_at_once(code: int) -> NoReturn:
    """End the process with this code, and remove its temporary files.

    A signal may strike after such a file is made, and before the block begins that would remove it.

    Raises:
        SystemExit: no thread has to be joined.
    """
    remove_passing()
    if all(thread.daemon or thread is threading.main_thread() for thread in threading.enumerate()):
        raise SystemExit(code) from None
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    os._exit(code)


_CACHE = "delete the __pycache__ folders of codesign, or set NUMBA_CACHE_DIR to a new writable folder"


def _is_of_kernel_cache(fault: BaseException) -> bool:
    """Whether numba failed to read or write its cache. Such an error may be of any type."""
    place = os.path.join("numba", "core", "caching.py")
    return any(
        frame.f_code.co_filename.endswith(place) for frame, _ in traceback.walk_tb(fault.__traceback__)
    )


def _check_current_folder() -> None:
    try:
        os.getcwd()
    except OSError as fault:
        raise InputError(
            "the current folder does not exist any more", None, "change to another folder"
        ) from fault


def _was_lost(out: UnfailingStream | None) -> bool:
    """Whether standard output failed. Reports the failure."""
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
@debug_option
def main() -> None:
    """Co-design robot path planners in hardware and software.

    Declare a platform and a workload in YAML. Simulate one design point, or explore many. Compare time, resources,
    power and the quality of the plan.

    Exit codes: 0 done, 1 failed, 2 a fault in a file or on the command line, 3 the answer is no, 130 interrupted
    (Ctrl-C), 143 terminated (SIGTERM).
    """
