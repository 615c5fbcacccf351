"""The options of ``hwsw explore`` that search a space."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import click

_Command = TypeVar("_Command", bound=Callable[..., object])


def search_options(command: _Command) -> _Command:
    """The options ``--search`` and ``--seed``. The command gets ``search`` and ``seed``, or None."""
    command = click.option(
        "--seed", type=int, metavar="S", help="The seed of --search: the same seed, the same designs."
    )(command)
    return click.option(
        "--search",
        metavar="NAME",
        help="Compute what a search asks for, and as many random points beside it: nsga2, tpe (extra search), random,"
        " or bound, which proves the front; all: no search. --points N limits each. All points of a small space are"
        " computed instead, where they take few simulations: exact, and cheaper than bound."
        "  [default: explore.search of the workload]",
    )(command)


def check_search_options(search: str | None, seed: int | None) -> None:
    """Refuse a search that does not exist, before any file is read.

    Raises:
        InputError: no such search, or no such seed.
    """
    from codesign.inputs.searching import ALL, check_search

    check_search(search or ALL, seed or 0)
