"""The progress of long work: the code that computes reports it, and its caller shows it.

Work that may take over two seconds takes a ``Show``, and calls it with an ``Advance``. It does not know whether
anything is shown. ``codesign.cli.progress`` shows it on a terminal.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Protocol, TypeVar

Item = TypeVar("Item")

_SECONDS_BETWEEN = 0.1
_SAMPLES = 64
_SECONDS_BETWEEN_SAMPLES = 0.25


@dataclass(frozen=True)
class Advance:
    """The progress of work.

    - ``done``: of ``total``. ``total`` is None where it is not known.
    - ``words``: what is counted, or what is done, in words.
    - ``left_s``: the seconds left, by an estimate; None where nothing but a bound is known. ``expected_s``: what work
      that is not counted takes in all, by experience.
    - ``brief``: it is mostly over at once, so that only a terminal shows it.
    """

    done: int
    total: int | None
    words: str
    left_s: float | None = None
    expected_s: float | None = None
    brief: bool = False


class Show(Protocol):
    """Shows an advance, at most as often as a person can read it."""

    def __call__(self, advance: Advance) -> None:
        """Show how far the work is."""


def silent(advance: Advance) -> None:
    """Show nothing."""


def doing(show: Show, words: str, expected_s: float | None = None) -> None:
    """Show what is begun, where it cannot be counted and is mostly over at once."""
    show(Advance(0, None, words, expected_s=expected_s, brief=True))


class Pace:
    """The time left of pieces of work that take about the same time each, judged by the recent ones."""

    def __init__(self, total: int, clock: Callable[[], float] = time.monotonic) -> None:
        self.total, self._clock = total, clock
        self._samples: deque[tuple[float, int]] = deque([(clock(), 0)], _SAMPLES)

    def left_s(self, done: int) -> float | None:
        """The seconds left once so many pieces are done; None before the first one."""
        now = self._clock()
        since, before = self._samples[0]
        if done > self._samples[-1][1] and now - self._samples[-1][0] >= _SECONDS_BETWEEN_SAMPLES:
            self._samples.append((now, done))
        if done <= before:
            return None
        return (now - since) / (done - before) * (self.total - done)


class Track:
    """Reports how many pieces of work are done, of ``total``.

    ``bound``: it is an upper bound of their number, so that no time left follows from it.
    """

    def __init__(
        self, show: Show, words: str, total: int, clock: Callable[[], float] = time.monotonic, *, bound: bool = False
    ) -> None:
        self._show, self._words, self._clock, self._bound = show, words, clock, bound
        self._pace = Pace(total, clock)
        self._done, self._shown = 0, clock()
        show(Advance(0, total, words))

    def step(self, size: int = 1) -> None:
        """So many more pieces are done."""
        self._done += size
        if self._clock() - self._shown >= _SECONDS_BETWEEN:
            self._shown = self._clock()
            left = None if self._bound else self._pace.left_s(self._done)
            self._show(Advance(self._done, self._pace.total, self._words, left))

    def end(self) -> None:
        """No more is to be done."""
        self._show(Advance(self._done, self._pace.total, self._words, 0.0))


def tracked(
    items: Iterable[Item],
    show: Show,
    words: str,
    total: int,
    *,
    size: Callable[[Item], int] = lambda _: 1,
    clock: Callable[[], float] = time.monotonic,
) -> Iterator[Item]:
    """The items, while ``show`` is told how many were taken, ``size`` counting each.

    An item counts once the next one is asked for.
    """
    track = Track(show, words, total, clock)
    for item in items:
        yield item
        track.step(size(item))
    track.end()


_plans: ContextVar[Show] = ContextVar("plans", default=silent)


@contextmanager
def plans_shown(show: Show) -> Iterator[None]:
    """Show how far each plan is that is computed in the block.

    Who asks for a plan and who computes it lie far apart, and most who ask want to see more than one plan: an
    exploration shows its points. So this is no argument of all that lies between.
    """
    token = _plans.set(show)
    try:
        yield
    finally:
        _plans.reset(token)


def plan_track(words: str, total: int) -> Track:
    """The progress of a plan, for planners. It may end before ``total``."""
    return Track(_plans.get(), words, total, bound=True)


def span_text(seconds: float) -> str:
    """A span of time as a person says it, to two digits or so.

    >>> span_text(7.4), span_text(100), span_text(4000), span_text(200_000)
    ('7 s', '1 min 40 s', '1 h 6 min', '2 d 7 h')
    """
    whole = round(seconds)
    for unit, name, smaller, its in ((86400, "d", 3600, "h"), (3600, "h", 60, "min"), (60, "min", 1, "s")):
        if whole >= unit:
            return f"{whole // unit} {name} {whole % unit // smaller} {its}"
    return f"{whole} s"
