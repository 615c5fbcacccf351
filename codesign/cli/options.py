"""The options that several commands share, each a type of fields of requests, and the command line as a text."""

from __future__ import annotations

import math
import platform
import shlex
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import click
from click.core import ParameterSource

from codesign.cli import outputs
from codesign.cli.request import ANSWER, SENTENCE, TABLES, Option, option
from codesign.ground.errors import CodesignError, InputError, printable
from codesign.ground.kernel_cache import kernel_folders
from codesign.ground.late import load
from codesign.ground.units import Dimension, parse_quantity
from codesign.version import __version__


class Quantity(click.ParamType[int]):
    """A quantity with its unit as a whole number, such as picoseconds of ``12 s`` or bytes of ``4 GiB``.

    ``scale``: base units in one unit of the number. ``least``: the least number.
    """

    def __init__(self, dimension: Dimension, scale: int = 1, least: int = 0) -> None:
        self.name = {Dimension.DATA: "size"}.get(dimension, dimension.value)
        self._dimension, self._scale, self._least = dimension, scale, least

    def convert(self, value: str | int, param: click.Parameter | None, _context: click.Context | None) -> int:
        """The number; as in a spec, a bare number is refused."""
        if isinstance(value, int):
            return value
        written = param.opts[0] if param else None
        try:
            number = int(parse_quantity(value, self._dimension)) // self._scale
        except CodesignError as fault:
            raise InputError(fault.what, written, fault.hint) from fault
        if number < self._least:
            raise InputError(f"{value!r} is too small", written, "leave the option out for its default")
        return number


class Number(click.FloatRange):
    """A finite number within bounds: NaN is neither below nor above one."""

    def convert(self, value: Any, param: click.Parameter | None, context: click.Context | None) -> Any:
        """The number."""
        number = super().convert(value, param, context)
        if not math.isfinite(number):
            self.fail(f"{value} is no finite number.", param, context)
        return number


class MapFile(click.Path):
    """A map: a file, or the name of a shipped one, such as ``house``."""

    def convert(self, value: Any, param: click.Parameter | None, context: click.Context | None) -> Any:
        """The path of the file."""
        path = load("codesign.inputs.files:find_map")(str(value))
        if self.exists and not path.exists():
            maps = load("codesign.inputs.files:shipped_maps")()
            hint = f"name a file, or a shipped map: {', '.join(sorted(maps))}"
            raise InputError(f"{value} does not exist", param.human_readable_name if param else None, hint)
        return super().convert(path, param, context)


class Stopwatch:
    """Prints on standard error how long each step of a command took, for ``--debug``."""

    def __init__(self) -> None:
        self._begun = self._last = time.perf_counter()

    def step(self, name: str) -> None:
        """The end of a step."""
        now = time.perf_counter()
        click.echo(f"debug: {now - self._last:8.3f} s  {name} ({now - self._begun:.3f} s in all)", err=True)
        self._last = now


_STOPWATCH = "codesign.stopwatch"


def _begin_debug(context: click.Context, _param: click.Parameter, wanted: bool) -> bool:
    if wanted and not is_debug(context):
        context.meta[_STOPWATCH] = Stopwatch()
        python = f"Python {platform.python_version()} at {sys.executable}"
        click.echo(f"debug: hwsw {__version__}, {python}", err=True)
        for folder in kernel_folders():
            click.echo(f"debug: compiled kernels in {printable(str(folder), None)}", err=True)
    return wanted


def is_debug(context: click.Context) -> bool:
    """True if ``--debug`` was given, to the command or to a command around it."""
    return _STOPWATCH in context.meta


def debug_step(name: str) -> None:
    """The end of a step of the current command: prints its time under ``--debug``."""
    stopwatch = click.get_current_context().meta.get(_STOPWATCH)
    if stopwatch is not None:
        stopwatch.step(name)


def _begin_force(context: click.Context, _param: click.Parameter, wanted: bool) -> bool:
    if wanted:
        context.meta[outputs.FORCE] = True
    return wanted


DEBUG: Any = option(
    "Print the time of each step, and the traceback of an unexpected error.",
    "--debug",
    is_eager=True,
    callback=_begin_debug,
)
FORCE: Any = option("Replace files of another kind too.", "--force", is_eager=True, callback=_begin_force)
"""For every command that writes files: see ``outputs``."""


class Detail(Option):
    """The options ``-q`` and ``-v`` of a field; the last one counts."""

    def parameters(self, name: str, _kind: Any) -> list[click.Parameter]:
        """Two options of click."""
        return [
            click.Option([name, "-q", "--quiet"], flag_value=SENTENCE, default=self.default, help=self.text),
            click.Option([name, "-v", "--verbose"], flag_value=TABLES, help=self.more["verbose"]),
        ]


def printed(quiet: str, verbose: str) -> Any:
    """A field with the amount that a command prints; ``quiet``, ``verbose``: what it prints with -q and with -v."""
    return Detail(f"{quiet} No progress.", default=ANSWER, verbose=verbose)


NOTHING: Mapping[str, object] = MappingProxyType({})


def setting(text: str, flag: str = "--set", metavar: str = "AXIS=VALUE") -> Any:
    """A field with the raw value of each axis that an option sets, which may be repeated."""
    parse = "codesign.cli.specs:settings_of"
    return option(text, flag, metavar=metavar, multiple=True, default=NOTHING, parse=parse)


def axis(text: str, flag: str) -> Any:
    """A field with the values of each axis that an option names, which may be repeated."""
    parse = "codesign.cli.specs:axes_of"
    return option(text, flag, metavar="AXIS=VALUES", multiple=True, default=NOTHING, parse=parse)


def place(text: str) -> Any:
    """A field that is a ``Place``: a cell, or metres of the map's frame."""
    return option(text, parse="codesign.inputs.places:parse_place", metavar="ROW,COLUMN|X,Y")


SETTINGS: Any = setting("Set an axis, e.g. workload.variant=NAME.")
NEEDS: Any = option(
    'Require a limit, such as "time < 100 ms" or "slices < 80 %". May be repeated.', "--need LIMIT", default=()
)
JSON: Any = option("Print as JSON.", "--json")
PAGE: Any = option("Write an HTML page.", "--html")
BAG: Any = option("Write a ROS 2 bag into the new folder DIR.", "--ros2 DIR", type=click.Path(path_type=Path))
MEMORY: Any = option(
    "The most memory to use, by estimate, such as 4GiB.  [default: half of the free memory]",
    "--memory SIZE",
    type=Quantity(Dimension.DATA, scale=8, least=1),
)
REACH: Any = option(
    "Share of the free cells that has to have a path to a goal; 0 takes a goal in a pocket.  [default: 0.1]",
    "--reach SHARE",
    type=Number(0, 1),
)
"""Of ``problem.reach``."""


_PRINTED_ONLY = frozenset({"as_json", "detail", "debug", "force"})
"""Parameters that change only what is printed, or may be replaced."""


def command_line() -> str:
    """The current command line, quoted for a shell, for pages that show how to make them again.

    The options are in the order of the help, without defaults. Those that change only what is printed are left out.
    """
    context = click.get_current_context()
    options, arguments = [], []
    for parameter in context.command.params:
        name = parameter.name or ""
        if context.get_parameter_source(name) is not ParameterSource.COMMANDLINE or name in _PRINTED_ONLY:
            continue
        value = context.params[name]
        values = [str(each) for each in (value if isinstance(value, tuple) else (value,))]
        if isinstance(parameter, click.Argument):
            arguments += values
        elif isinstance(parameter, click.Option) and parameter.is_flag:
            options.append(parameter.opts[0])
        else:
            options += [word for each in values for word in (parameter.opts[0], each)]
    dashed = any(word.startswith("-") for word in arguments)
    words = [*options, "--", *arguments] if dashed else [*arguments, *options]
    names: list[str] = []
    within: click.Context | None = context
    while within is not None and within.parent is not None:
        names.insert(0, within.info_name or "")
        within = within.parent
    return shlex.join(["hwsw", *names, *words])
