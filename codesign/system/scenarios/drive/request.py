"""Requests for plans: the scan that asks, why, where the time until the answer goes, and what becomes of each."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from codesign.system.results.ledger import Ledger, Spent
from codesign.system.results.mission import LIVELOCK


class Fate(StrEnum):
    """The end of a request.

    - ``answered``: by a plan that the robot follows. ``refused``: no plan could be made.
    - ``merged``: it broke off a plan under way; the request for that plan goes on for both.
    - ``open``: the mission ended first.
    """

    ANSWERED = "answered"
    REFUSED = "refused"
    MERGED = "merged"
    OPEN = "open"


@dataclass(frozen=True)
class Sight:
    """A scan at ``at`` (ps) that asks for something, and where its time went until it reached the map."""

    at: int
    spent: Ledger


@dataclass(eq=False)
class PlanRequest:
    """A plan that is asked for: by which scan, ``why``, and whether something ``seen`` is why.

    ``spent``: where the time went after the scan had reached the map. ``broken_off``: its plans that were broken off.
    """

    sight: Sight
    why: str
    seen: bool
    spent: Ledger = field(default_factory=Ledger)
    broken_off: int = 0

    def book_rest(self, what: Spent, where: str, now: int) -> None:
        """Book all the time up to ``now`` (ps) that is not booked yet."""
        self.spent.book(what, where, now - self.sight.at - self.sight.spent.total - self.spent.total)


def livelock_text(request: PlanRequest | None) -> str:
    """That plans for a request are broken off again and again, and what ends that; "" where they are not."""
    if request is None or request.broken_off < LIVELOCK:
        return ""
    return broken_off_text(request.broken_off)


def broken_off_text(in_a_row: int) -> str:
    """A sentence on a livelock, and on what ends it."""
    return (
        f"{in_a_row} plans in a row were broken off before their answer, as something new is seen sooner than a plan is"
        " made (replan.when_busy: restart; with finish, each plan is brought to its end)"
    )


@dataclass(frozen=True)
class ClosedRequest:
    """A request that is over: from its ``scan`` until it ``ended`` (ps)."""

    scan: int
    ended: int
    fate: Fate
    seen: bool
