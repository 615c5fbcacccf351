"""A bar of progress on a terminal, by rich. Imported where standard error is a terminal."""

from __future__ import annotations

import threading
import time

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TextColumn
from rich.text import Text

from codesign.ground import interrupts
from codesign.ground.progress import Advance, span_text

_UPDATES_A_SECOND = 5
_CLEAN = b"\r\x1b[2K\x1b[?25h"
"""Erases the line of the bar, and shows the cursor again."""


class Bar:
    """Shows what is done, how much of it, and the time left, until it is stopped; then it is erased.

    It appears ``after_s`` seconds after it is made, even while the work reports nothing: a shorter command shows none.
    """

    def __init__(self, console: Console, after_s: float) -> None:
        columns = (TextColumn("{task.description}"), BarColumn(), _Count(), _TimeLeft())
        # Standard output may be a file or a pipe: rich would send it to the terminal.
        self._bar = Progress(
            *columns, console=console, transient=True, redirect_stdout=False, refresh_per_second=_UPDATES_A_SECOND
        )
        self._task = self._bar.add_task("", total=None)
        self._words, self._expected = "", 0.0
        self._due = time.monotonic() + after_s
        self._timer: threading.Timer | None = None
        self._stopped = False

    def __call__(self, advance: Advance) -> None:
        """Show an advance, at once or as soon as the bar appears."""
        if self._stopped:
            return
        now = time.monotonic()
        ends = None if advance.left_s is None else now + advance.left_s
        if advance.expected_s is not None:
            if advance.words != self._words:
                self._expected = now + advance.expected_s
            ends = self._expected
        self._words = advance.words
        self._bar.update(self._task, total=advance.total, completed=advance.done, description=advance.words, ends=ends)
        if self._timer is None:
            self._timer = threading.Timer(max(0.0, self._due - now), self._appear)
            self._timer.daemon = True
            self._timer.start()

    def _appear(self) -> None:
        interrupts.clean_terminal_by(_CLEAN)
        self._bar.start()

    def stop(self) -> None:
        """Erase the bar; what is shown from now on is not."""
        self._stopped = True
        if self._timer is not None:
            self._timer.cancel()
            self._timer.join()
        if self._bar.live.is_started:
            self._bar.stop()
        interrupts.clean_terminal_by(b"")


class _Count(ProgressColumn):
    """The number that is done, and of how many; nothing if it is not counted."""

    def render(self, task: Task) -> Text:
        """The text of the column."""
        if task.total is None:
            return Text("")
        return Text(f"{int(task.completed):,}/{int(task.total):,}", style="progress.download")


class _TimeLeft(ProgressColumn):
    """The time left, counted down between two advances; the time spent where it is not known, or was wrong."""

    max_refresh = 0.5

    def render(self, task: Task) -> Text:
        """The text of the column."""
        ends = task.fields.get("ends")
        # What takes longer than was said has no time left that could be believed.
        if ends is None or (ends < time.monotonic() and not task.finished):
            return Text(f"{span_text(task.elapsed or 0.0)} so far", style="progress.elapsed")
        return Text(f"{span_text(max(0.0, ends - time.monotonic()))} left", style="progress.remaining")
