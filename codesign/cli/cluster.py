"""The option ``--cluster``: the workers of a cluster compute in the place of processes of this machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from codesign.errors import InputError, printable
from codesign.units import counted

if TYPE_CHECKING:
    from codesign.exploration import ClusterExecutor

cluster_option = click.option(
    "--cluster",
    metavar="ADDRESS",
    help="Compute with the workers of a dask cluster: tcp://HOST:PORT, tls://HOST:PORT, or the scheduler's file.",
)


@contextmanager
def cluster_of(address: str | None, *, quiet: bool) -> Iterator[ClusterExecutor | None]:
    """The cluster at an address until the end of the block; None where the workers are those of this machine.

    Raises:
        InputError: ``--workers`` is given too, the address is none, or dask is not installed.
        RunError: nothing answers.
    """
    if address is None:
        yield None
        return
    if click.get_current_context().get_parameter_source("workers") is ParameterSource.COMMANDLINE:
        raise InputError(
            "--workers is given too",
            "--cluster",
            "keep one of the two: --workers are processes of this machine, and a cluster has its own",
        )
    from codesign.exploration.cluster import ClusterExecutor

    with ClusterExecutor(address) as executor:
        if not quiet:
            click.echo(f"cluster {printable(address)}: {executor.words}", err=True)
        yield executor
        if executor.died and not quiet:
            died = counted(executor.died, "worker")
            click.echo(
                f"cluster {printable(address)}: {died} died, and what was under way was computed again",
                err=True,
            )
