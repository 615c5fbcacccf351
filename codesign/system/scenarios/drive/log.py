"""What is noted while a drive goes on, and why it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from codesign.records import MissionRecord
from codesign.system.chain import Answer
from codesign.system.ledger import Ledger

if TYPE_CHECKING:
    from codesign.system.scenarios.drive.scene import Scene


@dataclass
class Log:
    """The course of a drive.

    - ``first``, ``last``: its first answer and its latest. ``plans``: answers in all. ``latencies``: of replans, ps,
      from the scan to the answer. ``planning``: where the time of all plans went. ``turns``: those of the control loop.
    - ``turns_spent``: where the time of control turns went; ``asking``: that of the scans among it that plans were
      asked for by. ``waiting``: ps in which the robot stood and a plan was
      under way.
    - ``stall``: what last kept the robot from driving on. ``progress``: when a plan was last under way, ps.
    - ``ended``: why the drive ended; None while it goes on. ``reached``: whether it did all that it was to do.
    """

    scene: Scene
    first: Answer | None = None
    last: Answer | None = None
    plans: int = 0
    latencies: list[int] = field(default_factory=list)
    planning: Ledger = field(default_factory=Ledger)
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

    def end(self, why: str, *, reached: bool = False) -> None:
        """The drive ends here; the first reason counts."""
        if self.ended is None:
            # What the robot ran against until now is told before the end is.
            self.scene.advance()
            self.ended, self.reached = why, reached
            self.tell("ended", why)
