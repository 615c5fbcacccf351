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
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, redirect_stderr, redirect_stdout
from io import TextIOWrapper
from typing import Any, NoReturn, TextIO, cast

import click

from codesign.cli.options import DEBUG, is_debug
from codesign.cli.request import command_of
from codesign.cli.requests import COMMANDS
from codesign.ground import interrupts
from codesign.ground.errors import (
    EXIT_DONE,
    EXIT_FAILED,
    EXIT_INTERRUPTED,
    EXIT_TERMINATED,
    CodesignError,
    InputError,
    RunError,
)
from codesign.ground.files import remove_passing
from codesign.version import __version__

# Output that cannot be written: the reader ended, as in hwsw ... | head, or the disk is full.


class UnfailingStream:
    """A text stream that never raises. After the first failure all output is lost.

    ``fault`` is that failure, or None. A reader that ended is no failure: it needs no more output.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.fault: OSError | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write, or lose, ``text``."""
        try:
            return self._stream.write(text)
        except OSError as fault:
            self._lose_the_rest(fault)
            return len(text)

    def flush(self) -> None:
        """Flush, or lose, what was written."""
        try:
            self._stream.flush()
        except OSError as fault:
            self._lose_the_rest(fault)

    def _lose_the_rest(self, fault: OSError) -> None:
        if not isinstance(fault, BrokenPipeError):
            self.fault = self.fault or fault
        # Redirect the descriptor and not the stream: Python flushes the stream's buffer once more at exit.
        null_device = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(null_device, self._stream.fileno())
        finally:
            os.close(null_device)


@contextmanager
def output_may_fail() -> Iterator[UnfailingStream | None]:
    """Let a command complete its work, with its own exit code, even if its output fails.

    Yields standard output, or None without one. A character that the terminal cannot encode becomes "?".
    """
    with ExitStack() as stack:
        for stream in (sys.stdout, sys.stderr):
            if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
                stream.reconfigure(errors="replace")
        out = None if sys.stdout is None else UnfailingStream(sys.stdout)
        if out is not None:
            stack.enter_context(redirect_stdout(cast("TextIO", out)))
        if sys.stderr is not None:
            stack.enter_context(redirect_stderr(cast("TextIO", UnfailingStream(sys.stderr))))
        yield out


class LazyGroup(click.Group):
    """Makes a command of its request when it is asked for, and turns errors into exit codes."""

    def list_commands(self, ctx: click.Context, /) -> list[str]:
        """The commands in the order in which a newcomer needs them."""
        return [*(name for name in COMMANDS if " " not in name), *super().list_commands(ctx)]

    def get_command(self, ctx: click.Context, cmd_name: str, /) -> click.Command | None:
        """The command, whose module is imported when it runs."""
        known = cmd_name in COMMANDS and " " not in cmd_name
        return command_of(cmd_name, COMMANDS) if known else super().get_command(ctx, cmd_name)

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter, /) -> None:
        """List the commands without making any of them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, each.text) for name, each in COMMANDS.items() if " " not in name])

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
                    f"the cache of compiled kernels cannot be used: {fault or type(fault).__name__}", None, _CACHE
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
"""The errors that click reports itself."""

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
    """True if numba failed to read or write its cache. Such an error may be of any type."""
    place = os.path.join("numba", "core", "caching.py")
    return any(frame.f_code.co_filename.endswith(place) for frame, _ in traceback.walk_tb(fault.__traceback__))


def _check_current_folder() -> None:
    try:
        os.getcwd()
    except OSError as fault:
        raise InputError("the current folder does not exist any more", None, "change to another folder") from fault


def _was_lost(out: UnfailingStream | None) -> bool:
    """True if standard output failed. Reports the failure."""
    if out is None:
        return False
    out.flush()
    if out.fault is not None:
        click.echo(f"the output cannot be written: {out.fault.strerror}", err=True)
    return out.fault is not None


main = LazyGroup(
    "main",
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    help="""Co-design robot path planners in hardware and software.

Declare a platform and a workload in YAML. Simulate one design point, or explore many. Compare time, resources,
power and the quality of the plan.

Exit codes: 0 done, 1 failed, 2 a fault in a file or on the command line, 3 the answer is no, 130 interrupted
(Ctrl-C), 143 terminated (SIGTERM).""",
    callback=lambda **_debug: None,
)
click.version_option(__version__, prog_name="hwsw")(main)
main.params += DEBUG.parameters("debug", bool)
