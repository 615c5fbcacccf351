"""The ledger of time: what a chain of work and messages spent computing, waiting and on the wire, and where."""

from __future__ import annotations

from collections import Counter
from enum import StrEnum
from typing import NamedTuple


class Spent(StrEnum):
    """The kinds of use of time.

    - ``compute``, ``wait``, ``transfer``: of work and messages that came to their end.
    - ``behind``: a request for a plan waited while another plan was copied. ``broken_off``: in plans that were broken
      off. ``failed``: in plans that failed, and the pause after. ``unfinished``: in the plan cut by the mission's end.
    """

    COMPUTE = "compute"
    WAIT = "wait"
    TRANSFER = "transfer"
    BEHIND = "behind"
    BROKEN_OFF = "broken_off"
    FAILED = "failed"
    UNFINISHED = "unfinished"


SPENT = {
    Spent.COMPUTE: "compute",
    Spent.WAIT: "wait",
    Spent.TRANSFER: "transfer",
    Spent.BEHIND: "wait behind another plan",
    Spent.BROKEN_OFF: "in plans that were broken off",
    Spent.FAILED: "in plans that failed, and the pause after",
    Spent.UNFINISHED: "in the plan cut by the mission's end",
}
"""The same in words."""


class Work(NamedTuple):
    """A kind of work, whatever it costs.

    - ``where``: the component or link. ``what``: the phase, or the message.
    - ``unit``: what is counted: ``CYCLES`` of an FPGA, ``BEGINS`` of its work, a kernel of a processor, or messages of
      this many bits. ``RETRIES`` are messages that were sent again.
    """

    where: str
    what: str
    unit: str | int

    @property
    def bits(self) -> int | None:
        """Bits of a message; None of other work."""
        return self.unit if isinstance(self.unit, int) else None


CYCLES, BEGINS, RETRIES = "cycles", "begins", "retries"


class Ledger:
    """Picoseconds by what they were spent on, and by the component or link where.

    ``work``: the same in units, in the order in which each kind of work was first done.
    """

    def __init__(self) -> None:
        self.spent: Counter[tuple[Spent, str]] = Counter()
        self.work: dict[Work, int] = {}

    def count(self, where: str, what: str, unit: str | int, amount: int) -> None:
        """Add work."""
        work = Work(where, what, unit)
        self.work[work] = self.work.get(work, 0) + amount

    def book(self, what: Spent, where: str, picoseconds: int) -> None:
        """Add a span; one of no time leaves no entry."""
        if picoseconds:
            self.spent[what, where] += picoseconds

    def add(self, other: Ledger) -> None:
        """Add the time that another ledger holds."""
        self.spent.update(other.spent)

    def copy(self) -> Ledger:
        """A ledger with the same times. A change of one leaves the other as it is."""
        copied = Ledger()
        copied.add(self)
        return copied

    @property
    def total(self) -> int:
        """Picoseconds in all."""
        return self.spent.total()
