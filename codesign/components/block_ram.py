"""An on-chip block RAM: its shape, its allotted words, its two addresses a clock cycle, and its contents."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

import simpy

from codesign.components.component import ClockDomain
from codesign.components.scan import ScannedMemory
from codesign.ground.errors import RunError
from codesign.ground.records import Listener

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
        raise RunError(
            f"no shape of the block RAM is {width} bits wide",
            None,
            f"the widest has {widest}; use several side by side",
        )
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

    The budget of the harmonic node (Girau et al. 2008, section 5.2). In every cycle of an iteration the update reads
    bit i of all 18 nodes of the cluster (LSB first, counter ``cntR``) and writes bit i - 2 of the results (division by
    four, counter ``cntW``). These two addresses take both ports. The text also sends a second read address (MSB first,
    ``r_cnt``) to the ports, to search for local maxima in the same pass. That is a third address. A Virtex port has one
    address for reading and writing, so the text as it stands does not fit a dual-port RAM. Two designs fit:

    - Search LSB first on the bits that are read anyway. This gives the published 11 flip-flops.
    - Search MSB first in a separate pass of p + 2 cycles a block, in which nothing is written.

    A model of the architecture has to choose one of the two.
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
            raise RunError(
                f"{name} needs {words} words, {self.words_left} of {self.depth} are left",
                self.name,
                "use fewer blocks, a lower precision, or a part with deeper block RAMs",
            )
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
        self._book(first, cycles, set(ports), self._lost(first, first + cycles, addresses))

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
            raise RunError(
                f"{value} does not fit a word of {self.width} bits",
                self.name,
                "write a smaller value, or take a wider shape",
            )
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
            raise RunError(
                f"port {port} takes a second address in cycle {cycle}",
                self.name,
                "use the other port, or the next cycle",
            )
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

    def _lost(self, first: int, last: int, addresses: int) -> int:
        """Cycles that a display takes from a design with ``addresses`` addresses a cycle."""
        return self.claims.between(first, last) if self.claims is not None and addresses == PORTS else 0

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
