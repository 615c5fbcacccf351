"""The part of a space that is computed: so many points, or for so long."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sized
from dataclasses import dataclass, field
from typing import TypeVar

from codesign.ground.errors import InputError
from codesign.ground.units import PICOSECONDS_PER_SECOND, counted, format_time

Batch = TypeVar("Batch", bound=Sized)


@dataclass
class Budget:
    """The points that a run may compute; None: all.

    - ``points``: so many, without those that were found in a store. ``seconds``: nothing is begun after them.
    - ``used``: how many points were begun. ``ended``: why the run ended before all points; "" if it did not.

    A point that is begun is finished. So a budget of time may be passed by one batch.
    """

    points: int | None = None
    seconds: float | None = None
    clock: Callable[[], float] = field(default=time.monotonic, repr=False, compare=False)
    used: int = field(default=0, init=False)
    ended: str = field(default="", init=False)

    def __post_init__(self) -> None:
        for name, value in (("points", self.points), ("time", self.seconds)):
            if value is not None and not value > 0:
                raise InputError(f"a budget of {value} is none", name, "give more than 0, or leave it out")
        self._begun = self.clock()

    def filled(self, points: int | None, seconds: float | None) -> Budget:
        """This budget, with these limits where it has none of its own."""
        self.points = points if self.points is None else self.points
        self.seconds = seconds if self.seconds is None else self.seconds
        return self

    def begin(self) -> None:
        """Time counts from now on; by default since the budget was made."""
        self._begun = self.clock()

    @property
    def left(self) -> int | None:
        """The number of points that may still be begun; None: any number."""
        return None if self.points is None else self.points - self.used

    def bounded(self, left_s: float) -> float:
        """The seconds left of works that would take ``left_s``."""
        if self.seconds is None:
            return left_s
        return min(left_s, max(0.0, self.seconds - (self.clock() - self._begun)))

    def spend(self, points: int) -> bool:
        """True if so many points may be begun now; they then count as begun."""
        if self._is_over():
            return False
        if self.left is not None and points > self.left:
            self.ended = self.ended or f"the budget of {counted(self.points or 0, 'point')} was used up"
            return False
        self.used += points
        return True

    def late(self, points: int) -> bool:
        """True if the time is over for so many points that were granted and not begun: they then count as not begun."""
        over = self._is_over()
        self.used -= points * over
        return over

    def _is_over(self) -> bool:
        if self.seconds is None or self.clock() - self._begun < self.seconds:
            return False
        allotted = format_time(round(self.seconds * PICOSECONDS_PER_SECOND))
        self.ended = self.ended or f"the time of {allotted} was over"
        return True

    def within(self, batches: Iterable[Batch]) -> Iterator[Batch]:
        """The batches that may be begun, each drawn when it is asked for, up to the first that may not."""
        for batch in batches:
            if not self.spend(len(batch)):
                return
            yield batch
