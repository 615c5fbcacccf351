"""The next goal of a drive: goals one after another, or the frontiers of what is known."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from codesign.ground.records import GoalRecord
from codesign.system.scenarios.drive.log import Log
from codesign.system.scenarios.drive.scene import Scene
from codesign.system.scenarios.drive.world.belief import Frontiers

Cell = tuple[int, int]


class Goals(ABC):
    """The goals of the robot; ``done`` counts the goals that are behind it."""

    done: int
    finished: str
    """The reason for the end of a mission that reached all its goals."""

    @property
    @abstractmethod
    def over(self) -> bool:
        """True if nothing is left to be done."""

    @abstractmethod
    def goals(self) -> list[Cell]:
        """The cells to choose from: one of them is to be reached now."""

    @abstractmethod
    def none_left(self) -> str:
        """The reason to give where ``goals`` has none."""

    @abstractmethod
    def arrived(self) -> bool:
        """True if the robot was last seen where it was to go; it goes on from there."""

    @abstractmethod
    def obsolete(self, target: Cell, /) -> bool:
        """True if a path to ``target`` has lost its purpose."""

    @property
    def waiting(self) -> bool:
        """True if the robot waits at a goal, as the next one is not given yet."""
        return False

    def given(self) -> bool:
        """True if the goal that the robot waited for is given now. True ends the wait."""
        return False

    @property
    def since(self) -> int:
        """The time at which the goal under way is given, ps."""
        return 0

    def end_if_over(self, log: Log) -> bool:
        """End the mission where nothing is left to be done; whether it has ended."""
        if self.over:
            log.end(self.finished, reached=True)
        return log.ended is not None


class Tour(Goals):
    """Goals one after another: first any of the problem's, then each of the tour."""

    finished = "all goals are reached"

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        first = scene.machine.system.problem.goals
        self._legs: list[tuple[Cell, ...]] = [first, *((goal,) for goal in scene.scenario.tour)]
        self._times = (0, *(scene.scenario.tour_times or (0,) * len(scene.scenario.tour)))
        self._waiting = False
        self.done = 0
        self._tell()

    @property
    def over(self) -> bool:
        """True if all goals were reached."""
        return self.done == len(self._legs)

    def goals(self) -> list[Cell]:
        """The goals of the leg under way that are not believed blocked; while it waits, where it was to go before."""
        blocked = self._scene.belief.blocked_for_robot
        return [goal for goal in self._legs[self.done - self._waiting] if not blocked[goal]]

    def none_left(self) -> str:
        """The reason to give where ``goals`` has none."""
        named = ", ".join(str(self._scene.named(goal)) for goal in self._legs[self.done][:3])
        near = ", or lies too near to one" if self._scene.robot.radius_cells else ""
        return f"goal {named} is taken by an obstacle{near}"

    def arrived(self) -> bool:
        """True if the robot was last seen at a goal of the leg under way, standing at the last. Goes on if so."""
        look = self._scene.latest_look
        last = self.done == len(self._legs) - 1
        if look.cell not in self._legs[self.done] or (last and look.speed > 0):
            return False
        self.done += 1
        self._waiting = not last and self._scene.machine.now < self._times[self.done]
        if not (last or self._waiting):
            self._tell()
        return True

    @property
    def waiting(self) -> bool:
        """True if the time of the next goal has not come."""
        return self._waiting

    def given(self) -> bool:
        """True if the time of the next goal has come."""
        if not self._waiting or self._scene.machine.now < self._times[self.done]:
            return False
        self._waiting = False
        self._tell()
        return True

    @property
    def since(self) -> int:
        """The time at which the goal under way is given, at the earliest, ps."""
        return 0 if self.over else self._times[self.done]

    def _tell(self) -> None:
        _tell_goals(self._scene, self._legs[self.done])

    def obsolete(self, _target: Cell, /) -> bool:
        """A goal stays one."""
        return False


def _tell_goals(scene: Scene, cells: tuple[Cell, ...]) -> None:
    """Tell listeners where the robot is to go from now on."""
    if scene.machine.listening:
        goals = np.array(cells, np.int32).reshape(-1, 2)
        scene.machine.tell(GoalRecord(scene.machine.now, scene.robot.name, goals))


class FrontierGoals(Goals):
    """The frontiers of what is known, until none can be reached."""

    finished = "all that can be reached is explored"

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._frontiers = Frontiers(scene.belief)
        self.done = 0
        _tell_goals(scene, ())

    @property
    def over(self) -> bool:
        """True if all that can be reached is known."""
        return not self.goals()

    def goals(self) -> list[Cell]:
        """The frontier cells that can be reached, the robot's own cell left out."""
        here = self._scene.latest_look.cell
        return [goal for goal in self._frontiers.goals(here) if goal != here]

    def none_left(self) -> str:
        """The reason to give where ``goals`` has none."""
        return "no frontier can be reached"

    def arrived(self) -> bool:
        """True if the robot looked from a frontier cell that it stands in."""
        look = self._scene.latest_look
        if look.speed > 0 or not self._frontiers.mask(look.cell)[look.cell]:
            return False
        self._frontiers.looked(look.cell)
        self.done += 1
        return True

    def obsolete(self, target: Cell) -> bool:
        """True if what lies beyond ``target`` was seen meanwhile."""
        return not self._frontiers.mask(self._scene.latest_look.cell)[target]
