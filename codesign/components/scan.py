"""The scan of a display over a memory in closed form: every access has its exact cycle, without an event for a pixel.

A display fetches words from a memory at its own rate and cannot wait. So the memory's other user stalls in the cycles
that the display takes, unless a port is left. All arithmetic is on integers, with two clocks that begin together:
pixel n begins at n / pixel clock, and cycle k of the memory at k / memory clock. The two are compared as fractions:
rounded to picoseconds, two accesses could fall into one cycle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign.components.component import ClockDomain, Component
from codesign.ground.errors import InputError, RunError
from codesign.ground.records import Listener
from codesign.ground.units import PICOSECONDS_PER_SECOND

Cycles = NDArray[np.int64]

LARGEST = 2**61
"""The limit of the arithmetic: of cycles and pixels since time 0, and of the product of two clocks' reduced hertz."""

ROUNDS = 10
"""Iterations before bisection. A display with a share s of the cycles needs about log(cycles) / log(1 / s)."""


@dataclass(frozen=True)
class Scan:
    """The pixels of a display's frame, blanking included, and which of them are fetched from memory.

    - ``columns``, ``rows``: the visible pixels. ``total_columns``, ``total_rows``: with horizontal and vertical
      blanking.
    - ``window``: the (rows, columns) at the upper left corner that are fetched; None: all visible ones. The rest of the
      screen has one colour and needs no memory.
    - ``pixels_a_word``: neighbouring pixels that one word of the memory holds.

                     columns
        +--------+------------+----------+
        | window |            |          |
        +--------+            | blanking |   total_rows
        |   visible (rows)    |          |
        +---------------------+          |
        |           total_columns        |
        +--------------------------------+

    The scan begins at time 0 with the first visible pixel, and requests its word at that edge. A real controller
    requests each word a constant number of pixels earlier. This shift changes no count.

    >>> scan = Scan(640, 480, 800, 525)
    >>> scan.requests_a_frame, scan.requests_before(800 * 525 + 10)
    (307200, 307210)

    Raises:
        InputError: no visible pixel, negative blanking, or a window beyond the visible pixels.
    """

    columns: int
    rows: int
    total_columns: int
    total_rows: int
    window: tuple[int, int] | None = None
    pixels_a_word: int = 1

    def __post_init__(self) -> None:
        window = self.window or (self.rows, self.columns)
        for key, value, least, most in (
            ("columns", self.columns, 1, 2**16),
            ("rows", self.rows, 1, 2**16),
            ("total_columns", self.total_columns, self.columns, 2**17),
            ("total_rows", self.total_rows, self.rows, 2**17),
            ("window", window[0], 1, self.rows),
            ("window", window[1], 1, self.columns),
            ("pixels_a_word", self.pixels_a_word, 1, 2**16),
        ):
            if not least <= value <= most:
                raise InputError(f"{key} of {value}", key, f"give a whole number from {least} to {most}")

    @property
    def fetched(self) -> tuple[int, int]:
        """Rows and columns that are fetched from memory."""
        return self.window or (self.rows, self.columns)

    @property
    def words_a_line(self) -> int:
        """Words fetched for a line."""
        return -(-self.fetched[1] // self.pixels_a_word)

    @property
    def closest_requests(self) -> int:
        """The fewest pixels from the request of one word to the next."""
        lines = 1 if self.fetched[0] > 1 else self.total_rows
        over_the_end = lines * self.total_columns - (self.words_a_line - 1) * self.pixels_a_word
        return min(self.pixels_a_word, over_the_end) if self.words_a_line > 1 else over_the_end

    @property
    def requests_a_frame(self) -> int:
        """Words fetched for a frame."""
        return self.words_a_line * self.fetched[0]

    @property
    def pixels_a_frame(self) -> int:
        """Pixels of a frame, blanking included."""
        return self.total_columns * self.total_rows

    def requests_before(self, pixel: int) -> int:
        """Words requested at the pixel edges 0 to ``pixel`` - 1."""
        return int(self.requests(np.array([pixel], np.int64))[0])

    def requests(self, pixel: Cycles) -> Cycles:
        """``requests_before`` of an array, int64."""
        frame, within = np.divmod(np.maximum(pixel, 0), self.pixels_a_frame)
        line, column = np.divmod(within, self.total_columns)
        begun = np.minimum(-(-column // self.pixels_a_word), self.words_a_line)
        rows = self.fetched[0]
        lines = frame * rows + np.minimum(line, rows)
        return np.asarray(lines * self.words_a_line + np.where(line < rows, begun, 0), np.int64)

    def lines_before(self, pixel: int) -> int:
        """Lines with their last fetched pixel before edge ``pixel``."""
        rows, columns = self.fetched
        frame, within = divmod(max(pixel, 0), self.pixels_a_frame)
        line, column = divmod(within, self.total_columns)
        return frame * rows + min(line + (column >= columns), rows)


def scaled(cycles: Cycles, numerator: int, denominator: int) -> Cycles:
    """floor(cycles × numerator / denominator), int64, without the large product. ``cycles`` may be negative."""
    whole, rest = np.divmod(cycles, denominator)
    return np.asarray(whole * numerator + rest * numerator // denominator, np.int64)


class Claims:
    """The cycles of a memory that a display takes.

    - ``burst`` None, a memory with one word a cycle: each word takes the first cycle that begins at or after its pixel
      edge. Where words are requested faster than the memory's clock, the display buffers lines: it takes words back to
      back from the beginning of the line, as many as arrive before the next line. The rest are missing.
    - ``burst``, cycles: a line at a time, its words back to back from the beginning of the line.

    ``words``: words that arrive in each line. ``scan.words_a_line`` - ``words`` are missing.

    Raises:
        RunError: the display would leave no cycle free, or the common divisor of the clocks is too small.
    """

    def __init__(
        self, scan: Scan, pixel_clock: ClockDomain, clock: ClockDomain, *, burst: int | None = None, words: int = 0
    ) -> None:
        common = math.gcd(pixel_clock.hz, clock.hz)
        self.scan = scan
        self._pixels, self._cycles = pixel_clock.hz // common, clock.hz // common
        if self._pixels * self._cycles > LARGEST:
            raise RunError(
                f"clocks of {clock.hz} and {pixel_clock.hz} Hz have too little in common to be scanned exactly",
                None,
                "give at least one of them in round MHz",
            )
        self.words = scan.words_a_line if burst is None else words
        self._run = burst
        budget = self.line_cycles(scan, pixel_clock, clock)
        if burst is None and scan.closest_requests * self._cycles < self._pixels:
            self.words = self._run = min(self.words, budget)
        elif burst is not None and not 0 <= burst <= budget:
            raise RunError(f"a burst of {burst} cycles is longer than a line", None, "fetch fewer words a line")
        each = self.words if self._run is None else self._run
        self.a_frame = each * scan.fetched[0]
        if self.a_frame * self._pixels >= scan.pixels_a_frame * self._cycles:
            raise RunError(
                "the display takes every cycle of the memory",
                None,
                "raise the memory's clock, hold more pixels a word, or give the display a copy of its own",
            )

    @staticmethod
    def line_cycles(scan: Scan, pixel_clock: ClockDomain, clock: ClockDomain) -> int:
        """Whole cycles of the memory in the time of one line, blanking included."""
        return scan.total_columns * clock.hz // pixel_clock.hz

    def between(self, first: int, last: int) -> int:
        """Cycles from ``first`` to ``last`` - 1 that the display takes."""
        before = self.before(np.array([first, last], np.int64))
        return int(before[1] - before[0])

    def before(self, cycle: Cycles) -> Cycles:
        """Cycles below ``cycle`` that the display takes, int64."""
        pixel = scaled(cycle - 1, self._pixels, self._cycles)
        if self._run is None:
            return self.scan.requests(pixel + 1)
        rows, frame_pixels = self.scan.fetched[0], self.scan.pixels_a_frame
        frame, within = np.divmod(np.maximum(pixel, 0), frame_pixels)
        line = np.minimum(within // self.scan.total_columns, rows - 1)
        begun = frame * frame_pixels + line * self.scan.total_columns
        first = -scaled(-begun, self._cycles, self._pixels)
        of_line = np.clip(cycle - first, 0, self._run)
        return np.asarray(np.where(pixel < 0, 0, (frame * rows + line) * self._run + of_line), np.int64)

    def ends(self, first: int, work: Cycles) -> Cycles:
        """The cycle at which each of ``work`` cycles of the memory's other user is done, when it begins at ``first``.

        ``work``: int64, at least 1 and ascending. An entry w ends at the smallest e with

            (e - before(e)) - (first - before(first)) = w,

        which leaves w of the cycles ``first`` to e - 1 to the other user. Exact: by iteration from below, which
        converges fast where the display takes few cycles, and by bisection otherwise.

        Raises:
            RunError: the work runs beyond 2^61 cycles or pixels.
        """
        if not work.size:
            return work
        free = 1 - self.a_frame * self._pixels / (self.scan.pixels_a_frame * self._cycles)
        frame = self.scan.pixels_a_frame * self._cycles / self._pixels
        # A span of cycles loses at most its share, and the cycles of one frame.
        latest = first + int((float(work[-1]) + self.a_frame + 2) / free * 1.000001) + int(frame) + 2
        if latest * max(1.0, self._pixels / self._cycles) > LARGEST:
            raise RunError("work beside the display runs beyond 2^61 cycles", None, "make the problem smaller")
        goal = work + (first - self.between(0, first))
        low, high = first + work, np.full(work.shape, latest, np.int64)
        for _ in range(ROUNDS):
            later = goal + self.before(low)
            if np.array_equal(later, low):
                return low
            low = later
        while bool((low < high).any()):
            middle = (low + high) // 2
            enough = middle - self.before(middle) >= goal
            high = np.where(enough, middle, high)
            low = np.where(enough, low, middle + 1)
        return low


class ScannedMemory(Component):
    """A memory with a clock that a display may read, beside its other users.

    ``busy`` counts cycles in which a user is served: the work of the other users with the display's cycles in between,
    and the display's cycles while no other user works.
    """

    def __init__(
        self, environment: simpy.Environment, name: str, clock: ClockDomain, listeners: Sequence[Listener] = ()
    ) -> None:
        super().__init__(environment, name, listeners)
        self.clock = clock
        self.claims: Claims | None = None
        self._idle_from: int | None = 0

    def scanned_by(self, scan: Scan, pixel_clock: ClockDomain) -> Claims:
        """Attach a display that reads from time 0. Returns the cycles that it takes.

        Raises:
            RunError: the memory has a display already, time has passed, or the display would take every cycle.
        """
        if self.claims is not None or self.now:
            raise RunError(
                "the display is attached too late" if self.now else "two displays read one memory",
                self.name,
                "attach one display to a memory before the run begins",
            )
        self.claims = self._claims_of(scan, pixel_clock)
        return self.claims

    @property
    def busy(self) -> int:
        """Picoseconds in which a user was served."""
        return super().busy + self._scanned_until(self.clock.cycles_by(self.now))

    def _claims_of(self, scan: Scan, pixel_clock: ClockDomain) -> Claims:
        return Claims(scan, pixel_clock, self.clock)

    def _work_begins(self, cycle: int) -> None:
        """Book the display's cycles since the last work. From here to ``_work_ends`` all time is booked."""
        self._busy += self._scanned_until(cycle)
        self._idle_from = None

    def _work_ends(self, cycle: int) -> None:
        self._idle_from = cycle

    def _scanned_until(self, cycle: int) -> int:
        """Picoseconds of the display's cycles from the end of the last work to ``cycle`` - 1, rounded down."""
        if self.claims is None or self._idle_from is None or cycle <= self._idle_from:
            return 0
        return self.claims.between(self._idle_from, cycle) * PICOSECONDS_PER_SECOND // self.clock.hz
