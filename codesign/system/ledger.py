"""Where time went: what a chain of work and messages spent computing, waiting and on the wire, and where."""

from __future__ import annotations

from collections import Counter
from enum import StrEnum


class Spent(StrEnum):
    """What time was spent on."""

    COMPUTE = "compute"
    WAIT = "wait"
    TRANSFER = "transfer"


class Ledger:
    """Picoseconds by what they were spent on, and by the component or link where."""

    def __init__(self) -> None:
        self.spent: Counter[tuple[Spent, str]] = Counter()

    def book(self, what: Spent, where: str, picoseconds: int) -> None:
        """Add a span; one of no time leaves no entry."""
        if picoseconds:
            self.spent[what, where] += picoseconds

    def add(self, other: Ledger) -> None:
        """Add all that another ledger holds."""
        self.spent.update(other.spent)

    def copy(self) -> Ledger:
        """A ledger that holds the same, and goes its own way."""
        made = Ledger()
        made.add(self)
        return made

    @property
    def total(self) -> int:
        """Picoseconds in all."""
        return self.spent.total()
