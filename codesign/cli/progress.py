"""Progress of a command: a bar on a terminal, otherwise now and then a line on standard error."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import click

from codesign.ground import kernel_cache
from codesign.ground.late import load
from codesign.ground.progress import Advance, Show, silent, span_text

SECONDS_BETWEEN_LINES = 10.0
_BAR_AFTER_S = 1.0

LATER_S = 2.0
"""Phases of a command that are mostly short are shown after this time."""

COMPILE_S = 20.0
"""Measured: 16 s for harmonic control on two busy cores."""

COMPILING = f"compiling kernels, once: about {COMPILE_S:.0f} s"
"""The words that are shown while kernels are compiled."""


def compiling(compiled: int = 0) -> Advance:
    """Kernels are compiled; so many are."""
    return Advance(compiled, None, COMPILING, expected_s=COMPILE_S)


@contextmanager
def compiling_shown(show: Show) -> Iterator[None]:
    """Show that kernels are compiled, if they are, while the block runs."""
    with kernel_cache.compiling_reported(lambda compiled: show(compiling(compiled))):
        yield


@contextmanager
def progress_shown(*, after_s: float = LATER_S, quiet: bool = False) -> Iterator[Show]:
    """A display of progress until the end of the block; ``quiet``: none.

    ``after_s``: lines begin after so many seconds (``PlainLines``). A bar appears after a second, and is erased at the
    end. Nothing may be printed on standard output inside the block.
    """
    if quiet:
        yield silent
        return
    console = load("rich.console:Console")(stderr=True)
    if not console.is_terminal:
        context = click.get_current_context(silent=True)
        announced = None if context is None else context.find_root().meta.setdefault(__name__, set())
        yield PlainLines(after_s, announced)
        return
    bar = load("codesign.cli.bar:Bar")(console, _BAR_AFTER_S)
    try:
        yield bar
    finally:
        bar.stop()


class PlainLines:
    """At most a line each ten seconds on standard error, the first one after ``after_s``.

    What is known to take long is announced at once, and once in a command: ``announced`` are the words so far.
    """

    def __init__(self, after_s: float = 0.0, announced: set[str] | None = None) -> None:
        self._due = time.monotonic() + after_s
        self._announced = set() if announced is None else announced

    def __call__(self, advance: Advance) -> None:
        """Write a line if one is due."""
        now = time.monotonic()
        fresh = advance.expected_s is not None and not advance.brief and advance.words not in self._announced
        if not fresh and (advance.brief or now < self._due or advance.words in self._announced):
            return
        if fresh:
            self._announced.add(advance.words)
        self._due = now + SECONDS_BETWEEN_LINES
        count = "" if advance.total is None else f"{advance.done}/{advance.total} "
        left = "" if advance.left_s is None else f", {span_text(advance.left_s)} left"
        click.echo(f"{count}{advance.words}{left}", err=True)
