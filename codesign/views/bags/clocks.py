"""The clocks of a bag: when a message was recorded, and the stamp in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError

SAME_CLOCK_S = 1.0
"""Stamps that are this near to the time of the bag, in the middle, are of the same clock."""

BACKWARDS_S = 0.1
"""Stamps of one topic that go back by less are put in order. More is a clock that was set."""

GAP_S, LONGEST_GAP_S = 5.0, 3600.0
"""A gap of the stamps that is remarked, and one that is a clock that was set."""


def common_clock(pairs: Sequence[tuple[float, float]], begin: int) -> float:
    """How far the stamps are behind the times of the bag, s: their median, or 0 where both have one clock.

    ``pairs``: (time since ``begin``, stamp), s. Static transforms, and messages without a stamp, do not count.
    """
    late = [time + begin * 1e-9 - stamp for time, stamp in pairs if stamp > 0.0 and math.isfinite(stamp)]
    if not late:
        return 0.0
    middle = float(np.median(late))
    return middle if abs(middle) > SAME_CLOCK_S else 0.0


def checked_clock(
    rows: Sequence[tuple[float, ...]], begin: int, shift: float, where: str, name: str, remark: Callable[[str], None]
) -> NDArray[np.float64]:
    """The rows (time, stamp, ...) as (time by the clock of the bag since ``begin``, ...), in order of time.

    A row without a stamp has the time of its recording. A static transform has its own.

    Raises:
        InputError: the clock goes back, or ahead by more than ``LONGEST_GAP_S``.
    """
    if not rows:
        return np.zeros((0, 1))
    table = np.array(rows, np.float64)
    stamps = table[:, 1]
    stamped = np.isfinite(stamps) & (stamps > 0.0)
    times = np.where(stamped, stamps + (shift - begin * 1e-9), table[:, 0])
    if not np.isfinite(stamps).all():
        times = table[:, 0]
    steps = np.diff(times)
    if len(steps):
        back, ahead = int(steps.argmin()), int(steps.argmax())
        if steps[back] < -BACKWARDS_S:
            what = f"the clock of {name} goes back by {-steps[back]:,.3f} s after {times[back]:,.3f} s"
            hint = "cut the bag there, so that each part has one clock, and give one part"
            raise InputError(what, where, hint)
        if steps[ahead] > LONGEST_GAP_S:
            what = f"the clock of {name} jumps ahead by {steps[ahead]:,.0f} s after {times[ahead]:,.3f} s"
            hint = "cut the bag there, so that each part has one clock, and give one part"
            raise InputError(what, where, hint)
        if steps[ahead] > GAP_S and np.isfinite(stamps).all():
            remark(f"{name} has a gap of {steps[ahead]:.1f} s after {times[ahead]:.1f} s")
    order = np.argsort(times, kind="stable")
    return np.column_stack([times, table[:, 2:]])[order]
