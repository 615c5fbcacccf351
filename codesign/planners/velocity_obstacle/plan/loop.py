"""The closed loop, one update at a time: the robots decide and move by the compiled kernel."""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
from numpy.typing import NDArray

from codesign.planners.velocity_obstacle.plan import kernels
from codesign.planners.velocity_obstacle.plan.arithmetic import Arithmetic, fixed
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance, Departure
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, Detection, Responsibility
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem


class Loop:
    """All robots at rest at their starts; then update after update, each in this order:

    1. ``decide``: every robot chooses, all from the same state. ``checks`` and ``trials`` (int32 n) count the
       candidates that each looked at. The time of its circuit follows from them.
    2. ``hold(steps)``, if the decision takes longer than its time step: the robots drive on for ``steps`` steps with
       their velocities. The state of their PID control does not change.
    3. ``act``: one step, in which PID control drives every robot to its chosen velocity.

    ``run`` does all remaining updates without a hold. The loop is ``over`` once all robots stand at their targets,
    ``parameters.updates`` are done, or a value left its word (``departure``).

    ``position``, ``velocity``: int64 n × 2, the state now; ``arrived``: bool n; ``steps``: time steps up to now.

    Raises:
        InputError: words too narrow for the problem.
    """

    def __init__(self, problem: RobotsProblem, parameters: AvoidParameters) -> None:
        numbers = fixed(problem, parameters)
        assert numbers.formats is not None
        self.formats, self.parameters = numbers.formats, parameters
        count = problem.count
        self.position, self._targets = (
            np.array([[numbers.position(x), numbers.position(y)] for x, y in places.tolist()], np.int64)
            for places in (problem.positions, problem.targets)
        )
        self.velocity, self._sums, self._errors, self._stepped, self._wanted = (
            np.zeros((count, 2), np.int64) for _ in range(5)
        )
        self.arrived = np.zeros(count, np.bool_)
        self.candidates, self.checks, self.trials = (np.zeros(count, np.int32) for _ in range(3))
        # As ``kernels.run`` takes them.
        self._rules = (
            np.array(numbers.velocities, np.int64),
            np.array(numbers.bounds, np.int64),
            *_constants(numbers),
            parameters.detection is Detection.APPROACHING,
            parameters.responsibility is Responsibility.HALF,
        )
        self.updates = self.steps = 0
        self.departure: Departure | None = None
        self._resting = False
        # Chunks of states, of their times and of decisions, each along its first axis.
        self._states = [(self.position[None].copy(), self.velocity[None].copy(), np.zeros(1, np.int64))]
        self._decisions: list[tuple[NDArray[np.int32], ...]] = []
        self._begins: list[NDArray[np.int64]] = []
        self._begin = 0
        self._held: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]] = []

    @property
    def over(self) -> bool:
        """True if no update follows."""
        return self._resting or self.departure is not None or self.updates >= self.parameters.updates

    @property
    def cells(self) -> NDArray[np.float64]:
        """The positions of the robots, (x, y) in cells, float64 n × 2."""
        return np.ldexp(self.position.astype(np.float64), -self.formats.position)

    @property
    def speeds(self) -> NDArray[np.float64]:
        """Their velocities, cells/s, float64 n × 2."""
        return np.ldexp(self.velocity.astype(np.float64), -self.formats.velocity)

    def decide(self) -> None:
        """Every robot chooses from the state now."""
        # step   0        1        2        3        4
        #        |--------|--------|--------|--------|
        #        |<--- hold(2) --->|<-act-->|<-act-->|     ``_begin``: 0, then 3. The states at the end of each hold
        #        decide                     decide         and of each act are kept.
        self._begin, self._held = self.steps, []
        self.candidates, self.checks, self.trials = (np.zeros_like(self.checks) for _ in range(3))
        places = self._targets, self.arrived, self._stepped, self._wanted
        tried = self.candidates, self.checks, self.trials
        outside = kernels.decide(self.position, self.velocity, *places, self._rules, *tried)
        if outside >= 0:
            self.position[outside] = self._stepped[outside]
            self._depart(kernels.POSITION_OVERFLOW, int(outside), 1)

    def hold(self, steps: int) -> None:
        """Drive on for ``steps`` time steps, 1 or more."""
        robot, first = kernels.hold(self.position, self.velocity, steps, self._rules)
        if robot >= 0:
            self._depart(kernels.POSITION_OVERFLOW, int(robot), int(first))
            return
        self.steps += steps
        self._held.append(self._state())

    def act(self) -> None:
        """Take the chosen velocities: one time step."""
        overflow, robot = kernels.act(self.position, self.velocity, self._sums, self._errors, self._wanted, self._rules)
        if overflow:
            self._depart(overflow, int(robot), 1)
            return
        self.steps += 1
        self.updates += 1
        # The states of a hold are kept only now: a run that ends before the act ends with the update before it.
        self._states += [*self._held, self._state()]
        self._held = []
        self._begins.append(np.array([self._begin]))
        self._decisions.append((self.candidates[None], self.checks[None], self.trials[None]))
        self._resting = bool(kernels.at_rest(self.velocity, self.arrived))

    def run(self) -> None:
        """Do all remaining updates, each decided within its time step."""
        left = self.parameters.updates - self.updates
        state = self.position, self.velocity, self._targets, self.arrived, self._sums, self._errors
        ran = kernels.run(*state, self._rules, left)
        done, positions, velocities, candidates, checks, trials, overflow, robot = ran
        # Without a hold every update takes one step, from its begin to the next.
        begins = self.steps + np.arange(done)
        self._begins.append(begins)
        self._states.append((positions[:done], velocities[:done], begins + 1))
        self._decisions.append((candidates[:done], checks[:done], trials[:done]))
        self.updates += done
        self.steps += done
        if overflow:
            self._depart(overflow, int(robot), 1)
        else:
            self._resting = bool(kernels.at_rest(self.velocity, self.arrived))

    def plan(self) -> Avoidance:
        """The run up to the last complete update."""
        positions, velocities, times = (np.concatenate(chunks) for chunks in zip(*self._states, strict=True))
        none = np.zeros((0, len(self.position)), np.int32)
        decisions = [(none, none, none), *self._decisions]
        candidates, checks, trials = (np.concatenate(chunks) for chunks in zip(*decisions, strict=True))
        begins = np.concatenate([np.zeros(0, np.int64), *self._begins])
        return Avoidance(
            self.formats,
            self.parameters,
            positions,
            velocities,
            times,
            begins,
            candidates,
            checks,
            trials,
            self.departure,
        )

    def _state(self) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        return self.position[None].copy(), self.velocity[None].copy(), np.array([self.steps])

    def _depart(self, overflow: int, robot: int, steps: int) -> None:
        what = "position" if overflow == kernels.POSITION_OVERFLOW else "velocity"
        formats = self.formats
        bits = formats.position if what == "position" else formats.velocity
        x, y = self.cells[robot].tolist()
        passed = self.steps + steps
        self.departure = Departure(
            what,
            robot,
            self.updates + 1,
            passed,
            round(passed * self.parameters.step, 12),
            (x, y),
            formats.width,
            math.ldexp(1.0, formats.width - 1 - bits),
        )


def _constants(numbers: Arithmetic) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    formats, shifts = numbers.formats, numbers.shifts
    assert formats is not None
    assert shifts is not None
    constants = [
        numbers.step,
        numbers.half_square,
        numbers.inverse_step,
        numbers.change_squared,
        numbers.brake,
        numbers.acceleration,
        numbers.speed,
        numbers.radius_squared,
        numbers.tolerance_squared,
        *numbers.gains,
        1 << (formats.width - 1),
        kernels.NO_RANGE if numbers.range_squared is None else numbers.range_squared,
        numbers.turns,
    ]
    return np.array(constants, np.int64), np.array(astuple(shifts), np.int64)
