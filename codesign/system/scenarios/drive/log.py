"""The course of a drive: what is counted while it goes on, and why it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

from codesign.ground.records import MissionRecord
from codesign.system.chain import Answer
from codesign.system.results.ledger import Ledger, Spent
from codesign.system.results.mission import LIVELOCK
from codesign.system.scenarios.drive.scene import Scene

# Requests for plans: the scan that asks, why, where the time until the answer goes, and what becomes of each.


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


@dataclass
class Log:
    """The course of a drive.

    - ``first``, ``last``: its first answer and its latest. ``plans``: answers in all. ``latencies``: of replans, ps,
      from the scan to the answer.
    - ``requests``: the closed requests for plans. ``asking``: where the scans that asked spent their time before they
      reached the map; ``planning``: where the rest went. The two add up to the time from scan to end of all requests.
    - ``asked``: requests for plans, those asked again included. ``broken_off``: plans broken off; ``in_a_row``: the
      most of them with no answer between them.
    - ``turns``: the turns of the control loop. ``turns_spent``: where their time went.
    - ``waiting``: ps in which the robot stood and a plan was under way.
    - ``stall``: what last kept the robot from driving on. ``progress``: when a plan was last under way that did not
      fail, ps.
    - ``ended``: why the drive ended; None while it goes on. ``reached``: whether it did all that it was to do.
    """

    scene: Scene
    first: Answer | None = None
    last: Answer | None = None
    plans: int = 0
    latencies: list[int] = field(default_factory=list)
    requests: list[ClosedRequest] = field(default_factory=list)
    planning: Ledger = field(default_factory=Ledger)
    asked: int = 0
    broken_off: int = 0
    in_a_row: int = 0
    turns_spent: Ledger = field(default_factory=Ledger)
    asking: Ledger = field(default_factory=Ledger)
    turns: int = 0
    missed: int = 0
    goals_reached: int = 0
    waiting: int = 0
    stall: str = ""
    progress: int = 0
    ended: str | None = None
    reached: bool = False

    def tell(self, event: str, text: str) -> None:
        """Note something for listeners."""
        machine = self.scene.machine
        if machine.listening:
            machine.tell(MissionRecord(machine.now, self.scene.robot.name, event, text))

    def close(self, request: PlanRequest, fate: Fate) -> None:
        """A request is over now; all of its time is booked."""
        self.requests.append(ClosedRequest(request.sight.at, self.scene.machine.now, fate, request.seen))
        self.asking.add(request.sight.spent)
        self.planning.add(request.spent)

    def break_off(self, request: PlanRequest) -> None:
        """A plan for ``request`` was broken off; the request stays open."""
        request.broken_off += 1
        self.broken_off += 1
        self.in_a_row = max(self.in_a_row, request.broken_off)
        if request.broken_off == LIVELOCK:
            self.tell("livelock", livelock_text(request))

    def end(self, why: str, *, reached: bool = False) -> None:
        """The drive ends here; the first reason counts."""
        if self.ended is None:
            # Contacts up to now are reported before the end is.
            self.scene.advance()
            self.ended, self.reached = why, reached
            self.tell("ended", why)
