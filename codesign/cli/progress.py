"""Progress of a command: a bar on a terminal, otherwise now and then a line on standard error."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

import click

from codesign.progress import Advance, Show, silent, span_text

SECONDS_BETWEEN_LINES = 10.0
_BAR_AFTER_S = 1.0

LATER_S = 2.0
"""Phases of a command that are mostly short are shown after this time."""

COMPILE_S = 20.0
"""Measured: 16 s for harmonic control on two busy cores."""

COMPILING = f"compiling kernels, once: about {COMPILE_S:.0f} s"
"""What is shown while kernels are compiled."""


def compiling(compiled: int = 0) -> Advance:
    """Kernels are compiled; so many are."""
    return Advance(compiled, None, COMPILING, expected_s=COMPILE_S)


@contextmanager
def compiling_shown(show: Show) -> Iterator[None]:
    """Show that kernels are compiled, if they are, while the block runs."""
    from codesign.kernel_cache import compiling_reported

    with compiling_reported(lambda compiled: show(compiling(compiled))):
        yield


@contextmanager
def progress_shown(*, after_s: float = 0.0, quiet: bool = False) -> Iterator[Show]:
    """A display of progress until the end of the block; ``quiet``: none.

    ``after_s``: lines begin after so many seconds. A bar appears after a second, and is erased at the end. Nothing may
    be printed on standard output inside the block.
    """
    if quiet:
        yield silent
        return
    from rich.console import Console

    console = Console(stderr=True)
    if not console.is_terminal:
        yield PlainLines(after_s)
        return
    from codesign.cli.bar import Bar

    bar = Bar(console, _BAR_AFTER_S)
    try:
        yield bar
    finally:
        bar.stop()


class PlainLines:
    """A line on standard error at each tenth of the work, and after ten seconds without one.

    What cannot be counted has a line when it begins.
    """

    def __init__(self, after_s: float = 0.0) -> None:
        self.after = time.monotonic() + after_s
        self.last_time = self.after - SECONDS_BETWEEN_LINES
        self.last_tenth = -1
        self.last = Advance(0, None, "")

    def __call__(self, advance: Advance) -> None:
        """Write a line if one is due."""
        if advance.brief:
            return
        now, last, self.last = time.monotonic(), self.last, advance
        if advance.total is None:
            # What is known to take long is announced at once.
            if advance.words != last.words and (now >= self.after or advance.expected_s is not None):
                click.echo(advance.words, err=True)
            return
        if last.total != advance.total or advance.done < last.done:
            self.last_tenth = -1
        if now < self.after:
            return
        tenth = 10 * advance.done // max(1, advance.total)
        if tenth > self.last_tenth or now - self.last_time >= SECONDS_BETWEEN_LINES:
            self.last_tenth, self.last_time = tenth, now
            left = "" if advance.left_s is None else f", {span_text(advance.left_s)} left"
            click.echo(f"{advance.done}/{advance.total} {advance.words}{left}", err=True)
