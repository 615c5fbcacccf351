"""The options of ``hwsw explore`` that search a space."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import click

from codesign.errors import InputError

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
        " or bound, which proves the front. --points N limits each.",
    )(command)


def check_search_options(search: str | None, seed: int | None) -> None:
    """Refuse a search that does not exist, before any file is read.

    Raises:
        InputError: no such search, no such seed, or a seed of no search.
    """
    from codesign.exploration.searches import check_search

    if search is not None:
        check_search(search, seed or 0)
    elif seed is not None:
        raise InputError(f"a seed of {seed} is of no search", "--seed", "name one: --search nsga2")
