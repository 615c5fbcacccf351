"""An on-chip block RAM: its shape, what is allotted in it, and the two addresses it takes a clock cycle."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import simpy

from codesign.components.clock import ClockDomain
from codesign.components.component import Component
from codesign.errors import RunError
from codesign.records import Listener

PORTS = 2


def choose_shape(shapes: Iterable[tuple[int, int]], width: int) -> tuple[int, int]:
    """The deepest (depth, width) of a part's block RAM that is at least ``width`` bits wide.

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


class BlockRam(Component):
    """A dual-port block RAM of ``depth`` words × ``width`` bits.

    Each port takes one address a clock cycle, and either reads or writes there: two accesses a cycle,
    whatever their kind. A third is refused. What a read returns of a word that is written in the same cycle
    is not modelled.

    The budget of the harmonic node (Girau et al. 2008, section 5.2): in every cycle of an iteration the
    update reads bit i of all 18 nodes of the cluster (LSB first, counter ``cntR``) and writes bit i - 2 of
    the results (division by four; counter ``cntW``): two addresses, both ports taken. The text also sends a
    second read address (MSB first, ``r_cnt``) to the ports, to look for local maxima on the way. That is a
    third address, and a Virtex port has one for reading and writing, so the text as it stands does not fit a
    dual-port RAM. Looking for maxima LSB first on the bits that are read anyway fits (and gives the published
    11 flip-flops); MSB first needs a pass of its own, p + 2 cycles a block, with nothing written. A model of
    the architecture has to choose one of these two.
    """

    def __init__(
        self,
        environment: simpy.Environment,
        name: str,
        clock: ClockDomain,
        *,
        depth: int,
        width: int,
        listeners: Sequence[Listener] = (),
    ) -> None:
        super().__init__(environment, name, listeners)
        self.clock = clock
        self.depth = depth
        self.width = width
        self.accesses = [0] * PORTS
        self.allotted: dict[str, range] = {}
        self._last_cycle = -1
        self._ports_taken = 0

    @property
    def words_left(self) -> int:
        """Words not allotted yet."""
        return self.depth - sum(len(addresses) for addresses in self.allotted.values())

    def allocate(self, name: str, words: int) -> range:
        """Allot ``words`` words to ``name``; returns their addresses.

        A bit-serial block of precision p takes p + 1 words, each with one bit of 18 values.

        Raises:
            RunError: fewer are left, ``words`` is not positive, or ``name`` has words already.
        """
        if words < 1 or name in self.allotted:
            raise RunError(
                f"{words} words for {name!r}", self.name, "allot a positive number once for each name"
            )
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
        """Book one access in clock cycle ``cycle``; returns the port that takes it (0 or 1).

        Raises:
            RunError: both ports are taken in that cycle, or the cycle lies before the last one booked.
        """
        taken = self._ports_taken if cycle == self._last_cycle else 0
        return self._take(cycle, 1, 1, taken)

    def stream(self, first: int, cycles: int, addresses: int = PORTS) -> None:
        """Book ``addresses`` accesses in each of ``cycles`` clock cycles from ``first`` on, once they have
        passed.

        Raises:
            RunError: more addresses than ports, cycles booked before, or cycles still to come.
        """
        taken = self._ports_taken if first == self._last_cycle else 0
        if cycles < 1 or addresses < 1:
            raise RunError(f"{addresses} accesses in {cycles} cycles", self.name, "give at least one of each")
        self._take(first, cycles, addresses, taken)

    def _take(self, first: int, cycles: int, addresses: int, taken: int) -> int:
        last = first + cycles - 1
        if first < self._last_cycle or self.clock.edge(last + 1) > self.now:
            raise RunError(
                f"accesses in cycles {first} to {last} are booked out of order or before they happen",
                self.name,
            )
        if taken + addresses > PORTS:
            raise RunError(
                f"{taken + addresses} accesses in cycle {first}, the block RAM has {PORTS} ports",
                self.name,
                "spread the accesses over more cycles, or hold the data twice",
            )
        for port in range(taken, taken + addresses):
            self.accesses[port] += cycles
        begin = first + 1 if taken else first
        self._busy += self.clock.edge(last + 1) - self.clock.edge(begin)
        # Only the last cycle can be shared with what comes next.
        self._ports_taken = addresses if cycles > 1 else taken + addresses
        self._last_cycle = last
        return taken
