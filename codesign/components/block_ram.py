"""An on-chip block RAM: its shape, its allotted words, its two addresses a clock cycle, and its contents.

A display fetches words from a memory at its own rate and cannot wait. So the memory's other user stalls in the cycles
that the display takes, unless a port is left. All arithmetic is on integers, with two clocks that begin together:
pixel n begins at n / pixel clock, and cycle k of the memory at k / memory clock. The two are compared as fractions:
rounded to picoseconds, two accesses could fall into one cycle.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import simpy
from numpy.typing import NDArray

from codesign.components.component import ClockDomain, Component
from codesign.ground.errors import InputError, RunError
from codesign.ground.records import Listener
from codesign.ground.units import PICOSECONDS_PER_SECOND

# The scan of a display over a memory in closed form: every access has its exact cycle, without an event for a pixel.

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
    >>> scan.requests_before(800 * 525 + 10)  # the 640 × 480 of a frame, and 10 of the next
    307210

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
            what = f"clocks of {clock.hz} and {pixel_clock.hz} Hz have too little in common to be scanned exactly"
            raise RunError(what, None, "give at least one of them in round MHz")
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
            what = "the display takes every cycle of the memory"
            hint = "raise the memory's clock, hold more pixels a word, or give the display a copy of its own"
            raise RunError(what, None, hint)

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
            what = "the display is attached too late" if self.now else "two displays read one memory"
            raise RunError(what, self.name, "attach one display to a memory before the run begins")
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


PORTS = 2
DISPLAY_PORT = 1
"""The port that a display reads a block RAM through."""


def choose_shape(shapes: Iterable[tuple[int, int]], width: int) -> tuple[int, int]:
    """The deepest shape (depth, width) of a part's block RAM that is at least ``width`` bits wide.

    >>> choose_shape([(16384, 1), (2048, 9), (1024, 18), (512, 36)], 18)
    (1024, 18)

    Raises:
        RunError: no shape is that wide.
    """
    offered = sorted(shapes)
    wide_enough = [shape for shape in offered if shape[1] >= width]
    if not wide_enough:
        widest = max((shape[1] for shape in offered), default=0)
        what = f"no shape of the block RAM is {width} bits wide"
        raise RunError(what, None, f"the widest has {widest}; use several side by side")
    return wide_enough[-1]


class WriteMode(StrEnum):
    """The output of a port in a cycle in which it writes.

    - ``read_first``: the old word. ``write_first``: the new one. ``no_change``: the output of the previous cycle.

    Published: Xilinx, UG190 (Virtex-5), "Write Modes" and "Conflict Avoidance". Assumed, from memory: UG002 (Virtex-II)
    and UG070 (Virtex-4) say the same.
    """

    READ_FIRST = "read_first"
    WRITE_FIRST = "write_first"
    NO_CHANGE = "no_change"


@dataclass
class Output:
    """The output of a port after a cycle. It is final when the cycle is over.

    ``valid`` is False where the output of the circuit is undefined. ``value`` is then the old word.
    """

    value: int
    valid: bool = True


class BlockRam(ScannedMemory):
    """A dual-port block RAM of ``depth`` words × ``width`` bits.

    Each port takes one address a clock cycle and either reads or writes there. So there are two accesses a cycle of any
    kind, and a third is refused. ``stream`` and ``access`` book accesses without words. With ``contents``, ``read`` and
    ``write`` move words (all 0 at first) and return what the hardware would show: see ``read``.

    A display (``scanned_by``) takes port 1 in the cycles that it claims. A design that drives both ports then stalls as
    a whole, as all its block RAMs are driven alike. A design with one address a cycle is not affected.

    The harmonic node (Girau et al. 2008, section 5.2) reads bit i of its 18 nodes and writes bit i - 2 in every cycle
    (``cntR``, ``cntW``), which takes both ports. Its second read address (``r_cnt``, MSB first, for local maxima) would
    be a third. So a model searches LSB first on the bits that are read anyway, with the published 11 flip-flops, or
    in a pass of its own of p + 2 cycles a block.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        clock: ClockDomain,
        *,
        depth: int,
        width: int,
        contents: bool = False,
        write_modes: tuple[WriteMode, WriteMode] = (WriteMode.WRITE_FIRST, WriteMode.WRITE_FIRST),
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, clock, listeners)
        self.depth = depth
        self.width = width
        self.write_modes = write_modes
        self.collisions = 0
        self.allotted: dict[str, range] = {}
        self._accesses = [0] * PORTS
        self._last_cycle = -1
        self._taken: set[int] = set()
        self._words = [0] * depth if contents else None
        self._unknown: set[int] = set()
        self._shown = [Output(0) for _ in range(PORTS)]
        self._of_cycle: dict[int, _Access] = {}

    @property
    def accesses(self) -> list[int]:
        """Accesses of each port so far. Those of a display count for port 1, up to the last whole cycle."""
        of_display = self.claims.between(0, self.clock.cycles_by(self.now)) if self.claims else 0
        return [number + of_display * (port == DISPLAY_PORT) for port, number in enumerate(self._accesses)]

    @property
    def words_left(self) -> int:
        """Words that are not allotted."""
        return self.depth - sum(len(addresses) for addresses in self.allotted.values())

    def allocate(self, name: str, words: int) -> range:
        """Allot ``words`` words to ``name``. Returns their addresses.

        A bit-serial block of precision p takes p + 1 words, each with one bit of 18 values.

        Raises:
            RunError: fewer words are left, ``words`` is not positive, or ``name`` has words already.
        """
        if words < 1 or name in self.allotted:
            raise RunError(f"{words} words for {name!r}", self.name, "allot a positive number once for each name")
        if words > self.words_left:
            what = f"{name} needs {words} words, {self.words_left} of {self.depth} are left"
            raise RunError(what, self.name, "use fewer blocks, a lower precision, or a part with deeper block RAMs")
        first = self.depth - self.words_left
        self.allotted[name] = range(first, first + words)
        return self.allotted[name]

    def access(self, cycle: int) -> int:
        """Book one access in clock cycle ``cycle``. Returns the port that takes it (0 or 1).

        Raises:
            RunError: both ports are taken in that cycle, or the cycle lies before the last booked cycle.
        """
        self._check(cycle, 1)
        free = self._free(cycle)
        if not free:
            raise self._too_many(cycle, PORTS + 1)
        self._book(cycle, 1, {free[0]})
        return free[0]

    def stream(self, first: int, cycles: int, addresses: int = PORTS) -> None:
        """Book ``addresses`` accesses in each of ``cycles`` clock cycles from ``first``, after they have passed.

        In the cycles that a display takes from a design that drives both ports, nothing else is booked.

        Raises:
            RunError: more addresses than ports, cycles that are booked already, or cycles in the future.
        """
        if cycles < 1 or addresses < 1:
            raise RunError(f"{addresses} accesses in {cycles} cycles", self.name, "give at least one of each")
        self._check(first, cycles)
        taken = self._taken if first == self._last_cycle else set()
        if len(taken) + addresses > PORTS:
            raise self._too_many(first, len(taken) + addresses)
        ports = [port for port in range(PORTS) if port not in taken][:addresses]
        lost = self.claims.between(first, first + cycles) if self.claims is not None and addresses == PORTS else 0
        self._book(first, cycles, set(ports), lost)

    def read(self, port: int, cycle: int, address: int) -> Output:
        """Read a word in clock cycle ``cycle``. The output is final when the cycle is over.

        Where the other port writes the word in the same cycle, the output is the old value if that port is
        ``read_first``. Otherwise it is undefined (``valid`` False, counted in ``collisions``). Both ports have one
        clock.

        Raises:
            RunError: the RAM was made without ``contents``, the word does not exist, or the port is taken.
        """
        self._begin(port, cycle, address)
        words = self._contents()
        output = Output(words[address], address not in self._unknown)
        self._of_cycle[port] = _Access(address, None, output)
        self._resolve_conflict(port)
        return output

    def write(self, port: int, cycle: int, address: int, value: int) -> Output:
        """Write a word in clock cycle ``cycle``. Returns the output of the port, by its write mode.

        If both ports write different values to one word, its contents are undefined (counted in ``collisions``) until
        it is written again.

        Raises:
            RunError: as for ``read``, or the value is wider than a word.
        """
        if not 0 <= value < 1 << self.width:
            what = f"{value} does not fit a word of {self.width} bits"
            raise RunError(what, self.name, "write a smaller value, or take a wider shape")
        self._begin(port, cycle, address)
        mode, old, before = self.write_modes[port], self._contents()[address], self._shown[port]
        output = {
            WriteMode.READ_FIRST: Output(old, address not in self._unknown),
            WriteMode.WRITE_FIRST: Output(value),
            WriteMode.NO_CHANGE: Output(before.value, before.valid),
        }[mode]
        self._of_cycle[port] = _Access(address, value, output)
        self._resolve_conflict(port)
        return output

    def _begin(self, port: int, cycle: int, address: int) -> None:
        self._contents()
        if not 0 <= port < PORTS or not 0 <= address < self.depth:
            raise RunError(f"port {port}, word {address}", self.name, f"ports are 0 and 1, words 0 to {self.depth - 1}")
        self._check(cycle, 1)
        if port not in self._free(cycle):
            what = f"port {port} takes a second address in cycle {cycle}"
            raise RunError(what, self.name, "use the other port, or the next cycle")
        if cycle > self._last_cycle:
            self._settle()
        self._book(cycle, 1, {port})

    def _settle(self) -> None:
        """End a cycle: put the words that were written in it into the contents."""
        words = self._contents()
        written: dict[int, int] = {}
        for port, access in self._of_cycle.items():
            self._shown[port] = access.output
            if access.value is not None:
                clash = written.get(access.address, access.value) != access.value
                written[access.address] = words[access.address] = access.value
                (self._unknown.add if clash else self._unknown.discard)(access.address)
        self._of_cycle = {}

    def _resolve_conflict(self, port: int) -> None:
        """Apply the conflict of two accesses of one word in one cycle. ``port`` came second."""
        here, there = self._of_cycle[port], self._of_cycle.get(1 - port)
        if there is None or here.address != there.address or here.value is there.value is None:
            return
        if here.value is not None and there.value is not None:
            if here.value == there.value:
                return
            here.output.valid = there.output.valid = False
        else:
            writer = port if here.value is not None else 1 - port
            if self.write_modes[writer] is WriteMode.READ_FIRST:
                return
            self._of_cycle[1 - writer].output.valid = False
        self.collisions += 1

    def _contents(self) -> list[int]:
        if self._words is None:
            raise RunError("this block RAM books accesses only", self.name, "make it with contents=True")
        return self._words

    def _check(self, first: int, cycles: int) -> None:
        last = first + cycles - 1
        if first < max(self._last_cycle, 0) or self.clock.edge(last + 1) > self.now:
            raise RunError(
                f"accesses in cycles {first} to {last} are booked out of order or before they happen", self.name
            )

    def _free(self, cycle: int) -> list[int]:
        taken = set(self._taken) if cycle == self._last_cycle else set()
        if self.claims is not None and self.claims.between(cycle, cycle + 1):
            taken.add(DISPLAY_PORT)
        return [port for port in range(PORTS) if port not in taken]

    def _too_many(self, cycle: int, addresses: int) -> RunError:
        return RunError(
            f"{addresses} accesses in cycle {cycle}, the block RAM has {PORTS} ports",
            self.name,
            "spread the accesses over more cycles, or hold the data twice",
        )

    def _book(self, first: int, cycles: int, ports: set[int], lost: int = 0) -> None:
        last = first + cycles - 1
        for port in ports:
            self._accesses[port] += cycles - lost
        shared = first == self._last_cycle
        begin = first + 1 if shared else first
        self._work_begins(begin)
        self._busy += self.clock.edge(last + 1) - self.clock.edge(begin)
        self._work_ends(last + 1)
        # Only the last cycle can be shared with the next booking.
        self._taken = self._taken | ports if shared and cycles == 1 else ports
        self._last_cycle = last


@dataclass
class _Access:
    """The access of a port in the current cycle. ``value`` None: a read."""

    address: int
    value: int | None
    output: Output
