"""Progress of long work with the remaining time: a bar on a terminal, otherwise lines on standard error."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Protocol

import click

_SECONDS_BETWEEN_LINES = 10.0


@dataclass(frozen=True)
class Advance:
    """The progress of work: ``done`` of ``total``, their description in ``words``, and the seconds left, if known.

    ``total``: None where it is not known. Such work is announced at once, and outside of a terminal only once.
    """

    done: int
    total: int | None
    words: str
    left_s: float | None = None


class Show(Protocol):
    """Shows an advance, at most as often as a person can read it."""

    def __call__(self, advance: Advance) -> None:
        """Show the progress."""


COMPILING = "compiling kernels, once: about 20 s"
"""What is shown while kernels are compiled. Measured: 16 s for harmonic control on two busy cores."""


@contextmanager
def compiling_shown(show: Show) -> Iterator[None]:
    """Show that kernels are compiled, if they are, while the block runs."""
    from codesign.kernel_cache import compiling_reported

    with compiling_reported(lambda compiled: show(Advance(compiled, None, COMPILING))):
        yield


def silent(advance: Advance) -> None:
    """Show nothing."""


@contextmanager
def progress_shown(*, after_s: float = 0.0, quiet: bool = False) -> Iterator[Show]:
    """A display of progress until the end of the block, after the first ``after_s`` seconds; ``quiet``: none."""
    if quiet:
        yield silent
        return
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield PlainLines(after_s)
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    bar = Progress(*columns, console=console)
    task = bar.add_task("", total=None)
    begun = time.monotonic()

    def show(advance: Advance) -> None:
        if advance.total is None or time.monotonic() - begun >= after_s:
            bar.start()
            bar.update(task, total=advance.total, completed=advance.done, description=advance.words)

    try:
        yield show
    finally:
        bar.stop()


class PlainLines:
    """A line on standard error at each tenth of the work, and after ten seconds without one."""

    def __init__(self, after_s: float = 0.0) -> None:
        self.last_tenth = -1
        self.last_time = time.monotonic() + after_s - _SECONDS_BETWEEN_LINES
        self.after = time.monotonic() + after_s

    def __call__(self, advance: Advance) -> None:
        """Write a line if one is due."""
        if advance.total is None:
            if advance.done == 0:
                click.echo(advance.words, err=True)
            return
        now = time.monotonic()
        if now < self.after:
            return
        tenth = 10 * advance.done // max(1, advance.total)
        if tenth > self.last_tenth or now - self.last_time >= _SECONDS_BETWEEN_LINES:
            self.last_tenth, self.last_time = tenth, now
            left = "" if advance.left_s is None else f", {advance.left_s:.0f} s left"
            click.echo(f"{advance.done}/{advance.total} {advance.words}{left}", err=True)
