"""Options that several commands share, and the command line as a text."""

from __future__ import annotations

import shlex
from collections.abc import Iterable

import click
from click.core import ParameterSource

from codesign.errors import CodesignError, InputError


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


memory_option = click.option(
    "--memory",
    type=Quantity("size", "data", scale=8, least=1),
    metavar="SIZE",
    help="The most memory to use, by estimate, such as 4GiB.  [default: half of the free memory]",
)


def settings_of(texts: Iterable[str], option: str = "--set") -> dict[str, object]:
    """The raw value of each axis that the option names.

    Raises:
        InputError: a text is no setting, or an axis is set twice.
    """
    values: dict[str, object] = {}
    for text in texts:
        axis, value = setting(text, option)
        if axis in values:
            raise InputError(f"{axis} is set twice", option, "keep one of the two")
        values[axis] = value
    return values


def setting(text: str, option: str = "--set") -> tuple[str, object]:
    """An axis and its raw value from ``AXIS=VALUE``."""
    from codesign.inputs import parse_value

    axis, separator, value = text.partition("=")
    if not separator or not axis:
        raise InputError(
            f"{text!r} is no setting", option, f"write AXIS=VALUE, as in {option} relax.iterations=16"
        )
    return axis, parse_value(value, f"{option} {axis}")


def command_line() -> str:
    """The current command line, quoted for a shell, for pages that show how to make them again.

    The options are in the order of the help, without defaults. ``--json`` is left out, because it changes only what is
    printed.
    """
    context = click.get_current_context()
    options, arguments = [], []
    for parameter in context.command.params:
        name = parameter.name or ""
        if context.get_parameter_source(name) is not ParameterSource.COMMANDLINE or name == "as_json":
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
    return shlex.join(["hwsw", context.info_name or "", *words])
