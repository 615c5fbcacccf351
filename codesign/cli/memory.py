"""The option ``--memory``, which several commands have."""

from __future__ import annotations

import click

from codesign.errors import CodesignError, InputError


class _Memory(click.ParamType[int]):
    """An amount of memory with its unit, as bytes."""

    name = "size"

    def convert(self, value: str | int, param: click.Parameter | None, _context: click.Context | None) -> int:
        """Bytes of ``4 GiB``; a bare number is refused, as in a spec."""
        from codesign.units import Dimension, parse_quantity

        if isinstance(value, int):
            return value
        try:
            return int(parse_quantity(value, Dimension.DATA)) // 8
        except CodesignError as fault:
            raise InputError(fault.what, param.opts[0] if param else None, fault.hint) from fault


memory_option = click.option(
    "--memory",
    type=_Memory(),
    metavar="SIZE",
    help="Most memory to take, by estimate, such as 4GiB.  [default: half of what is free]",
)
