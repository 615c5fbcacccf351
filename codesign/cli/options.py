"""Options that several commands share, and the command line as a text."""

from __future__ import annotations

import platform
import shlex
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

import click
from click.core import ParameterSource

from codesign.cli.replacing import FORCE
from codesign.errors import CodesignError, InputError, clip, printable

REACH = (
    "Share of the free cells that has to have a path to a goal; 0 takes a goal in a pocket.  [default: 0.1]"
)
"""The help of the option of ``problem.reach``."""


class Quantity(click.ParamType[int]):
    """A quantity with its unit as a whole number, such as picoseconds of ``12 s`` or bytes of ``4 GiB``.

    ``dimension``: the value of a ``units.Dimension``. ``scale``: base units in one unit of the number. ``least``: the
    least number.
    """

    def __init__(self, name: str, dimension: str, scale: int = 1, least: int = 0) -> None:
        self.name = name
        self._dimension, self._scale, self._least = dimension, scale, least

    def convert(self, value: str | int, param: click.Parameter | None, _context: click.Context | None) -> int:
        """The number; as in a spec, a bare number is refused."""
        from codesign.units import Dimension, parse_quantity

        if isinstance(value, int):
            return value
        option = param.opts[0] if param else None
        try:
            number = int(parse_quantity(value, Dimension(self._dimension))) // self._scale
        except CodesignError as fault:
            raise InputError(fault.what, option, fault.hint) from fault
        if number < self._least:
            raise InputError(f"{value!r} is too small", option, "leave the option out for its default")
        return number


class MapFile(click.Path):
    """A map: a file, or the name of a shipped one, such as ``house``."""

    def convert(self, value: Any, param: click.Parameter | None, context: click.Context | None) -> Any:
        """The path of the file."""
        from codesign.inputs.files import find_map, shipped_maps

        path = find_map(str(value))
        if self.exists and not path.exists():
            hint = f"name a file, or a shipped map: {', '.join(sorted(shipped_maps()))}"
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


def _begin_debug(context: click.Context, _param: click.Parameter, wanted: bool) -> None:
    if not wanted or is_debug(context):
        return
    from codesign.kernel_cache import kernel_folders
    from codesign.version import __version__

    context.meta[_STOPWATCH] = Stopwatch()
    python = f"Python {platform.python_version()} at {sys.executable}"
    click.echo(f"debug: hwsw {__version__}, {python}", err=True)
    for folder in kernel_folders():
        click.echo(f"debug: compiled kernels in {printable(str(folder), None)}", err=True)


def is_debug(context: click.Context) -> bool:
    """Whether ``--debug`` was given, to the command or to a command around it."""
    return _STOPWATCH in context.meta


def debug_step(name: str) -> None:
    """The end of a step of the current command: prints its time under ``--debug``."""
    stopwatch = click.get_current_context().meta.get(_STOPWATCH)
    if stopwatch is not None:
        stopwatch.step(name)


debug_option = click.option(
    "--debug",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_begin_debug,
    help="Print the time of each step, and the traceback of an unexpected error.",
)

SENTENCE, ANSWER, TABLES = "sentence", "answer", "tables"
"""How much a command prints: one sentence (``-q``), the answer, or the answer and all tables (``-v``)."""

_Command = TypeVar("_Command", bound=Callable[..., object])


def output_options(quiet: str, verbose: str) -> Callable[[_Command], _Command]:
    """The options ``-q``, ``-v`` and ``--debug``. The command gets ``detail``: of ``-q`` and ``-v``, the last one.

    ``quiet``, ``verbose``: what the command prints with them, for its help.
    """

    def decorate(command: _Command) -> _Command:
        command = debug_option(command)
        command = click.option("-v", "--verbose", "detail", flag_value=TABLES, help=verbose)(command)
        return click.option(
            "-q", "--quiet", "detail", flag_value=SENTENCE, default=ANSWER, help=f"{quiet} No progress."
        )(command)

    return decorate


_PRINTED_ONLY = frozenset({"as_json", "detail", "debug", "force"})
"""Parameters that change only what is printed, or may be replaced."""


def _begin_force(context: click.Context, _param: click.Parameter, wanted: bool) -> None:
    if wanted:
        context.meta[FORCE] = True


force_option = click.option(
    "--force",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_begin_force,
    help="Replace files of another kind too.",
)
"""For every command that writes files: see ``replacing``."""

backend_option = click.option(
    "--backend",
    type=click.Choice(("auto", "cxxrtl", "icarus", "verilator")),
    default="auto",
    show_default=True,
    help="The simulator. auto: CXXRTL, and Verilator for a large array where it is installed.",
)
"""What runs circuits."""

memory_option = click.option(
    "--memory",
    type=Quantity("size", "data", scale=8, least=1),
    metavar="SIZE",
    help="The most memory to use, by estimate, such as 4GiB.  [default: half of the free memory]",
)


def budget_options(command: _Command) -> _Command:
    """The options ``--points`` and ``--time``. The command gets ``points``, or None, and ``time_ms``, or None."""
    command = click.option(
        "--time",
        "time_ms",
        type=Quantity("time", "time", scale=10**9, least=1),
        metavar="TIME",
        help="Begin no point after this time, such as 10min.",
    )(command)
    return click.option(
        "--points", type=click.IntRange(min=1), metavar="N", help="Compute no more than N points."
    )(command)


set_option = click.option(
    "--set", "settings", multiple=True, metavar="AXIS=VALUE", help="Set an axis, e.g. workload.variant=NAME."
)

ros2_option = click.option(
    "--ros2",
    "bag",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Write a ROS 2 bag into the new folder DIR.",
)

need_option = click.option(
    "--need",
    "needs",
    multiple=True,
    metavar="LIMIT",
    help='Require a limit, such as "time < 100 ms" or "slices < 80 %". May be repeated.',
)


def settings_of(texts: Iterable[str], option: str = "--set") -> dict[str, object]:
    """The raw value of each axis that the option names.

    Raises:
        InputError: a text is no setting, or an axis is set twice.
    """
    from codesign.inputs import parse_value

    texts_by_axis = _by_axis(texts, option)
    return {axis: parse_value(value, f"{option} {axis}") for axis, value in texts_by_axis.items()}


def axes_of(texts: Iterable[str], option: str) -> dict[str, dict[str, Any]]:
    """Each axis that the option names, from lists and ranges: its ``values``, and what it depends on, ``when``.

    Raises:
        InputError: a text is no list of values of an axis, or an axis is set twice.
    """
    from codesign.inputs.axis_values import axis_form

    texts_by_axis = _by_axis(texts, option)
    return {axis: axis_form(values, f"{option} {axis}") for axis, values in texts_by_axis.items()}


def _by_axis(texts: Iterable[str], option: str) -> dict[str, str]:
    """The text behind each ``AXIS=``."""
    values: dict[str, str] = {}
    for text in texts:
        axis, separator, value = text.partition("=")
        if not separator or not axis:
            hint = f"write AXIS=VALUE, as in {option} relax.iterations=16"
            raise InputError(f"{clip(text)!r} is no setting", option, hint)
        if axis in values:
            raise InputError(f"{axis} is set twice", option, "keep one of the two")
        values[axis] = value
    return values


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


def cell_of(option: str, text: str) -> tuple[int, int]:
    """The cell of an option, (row, column).

    Raises:
        InputError: the text is no cell.
    """
    numbers = text.split(",")
    if len(numbers) != 2 or not all(number.strip().isdecimal() for number in numbers):
        raise InputError(f"{text!r} is no cell", option, "write ROW,COLUMN from 0,0, as in 3,128")
    return int(numbers[0]), int(numbers[1])
