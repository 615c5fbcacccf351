"""A run of several robots: every decision, every state, and the value that ended it."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.planners.velocity_obstacle.plan.arithmetic import Formats
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters


@dataclass(frozen=True)
class Departure:
    """A value that left its word, which ends a run.

    ``what``: position or velocity. ``robot``: its number. ``update``: counted from 1. ``steps``: time steps from the
    begin of the run to the end of the step in question; ``seconds``: the same time. ``place``: the position of the
    robot after that step, (x, y) in cells. ``reach``: the greatest value that the words hold, in cells or cells/s.
    """

    what: str
    robot: int
    update: int
    steps: int
    seconds: float
    place: tuple[float, float]
    width: int
    reach: float

    def __str__(self) -> str:
        unit = "cells" if self.what == "position" else "cells/s"
        x, y = self.place
        return (
            f"the {self.what} of robot {self.robot} left its words of {self.width} bits, which reach to"
            f" {self.reach:g} {unit}, in update {self.update} after {self.seconds:g} s, near ({x:.0f}, {y:.0f})"
        )


@dataclass(frozen=True, eq=False)
class Avoidance:
    """A run of n robots over u updates in fixed point: m + 1 states, the start first, and m legs between them.

    An update that is decided within its time step is one leg. An update that takes longer is two legs: the robots drive
    straight on while they decide, and then take their new velocity in one time step.

    - ``positions``, ``velocities``: int64 (m + 1) × n × 2, (x, y) in units of ``formats``.
    - ``times``: int64 m + 1, the time of each state, in time steps from the start.
    - ``begins``: int64 u, the time at which each update begins, in the same unit.
    - ``candidates``: int32 u × n, speed level × directions + direction, or BRAKE (-1) or STAY (-2).
    - ``checks``: int32 u × n, candidates tested against the acceleration; ``trials``: those that pass, which are then
      tested against all other robots.
    - ``departure``: the value that left its word in the next update and ended the run, or None.
    """

    formats: Formats
    parameters: AvoidParameters
    positions: NDArray[np.int64]
    velocities: NDArray[np.int64]
    times: NDArray[np.int64]
    begins: NDArray[np.int64]
    candidates: NDArray[np.int32]
    checks: NDArray[np.int32]
    trials: NDArray[np.int32]
    departure: Departure | None = None

    @property
    def updates(self) -> int:
        """Updates done."""
        return len(self.candidates)

    @property
    def step(self) -> float:
        """The time step, s."""
        return self.parameters.step

    @property
    def in_step(self) -> bool:
        """True if every update was decided within its time step."""
        return len(self.times) == self.updates + 1

    @cached_property
    def cells(self) -> NDArray[np.float64]:
        """Positions in cells, float64 (m + 1) × n × 2, exact."""
        return np.ldexp(self.positions.astype(np.float64), -self.formats.position)

    @cached_property
    def speeds(self) -> NDArray[np.float64]:
        """Velocities in cells/s, float64 (m + 1) × n × 2, exact."""
        return np.ldexp(self.velocities.astype(np.float64), -self.formats.velocity)

    @cached_property
    def digest(self) -> str:
        """SHA-256 over every state of the run, and over its times where some update was late."""
        text = f"{self.formats}{self.positions.shape}"
        content = self.positions.astype("<i8").tobytes() + self.velocities.astype("<i8").tobytes()
        late = b"" if self.in_step else self.times.astype("<i8").tobytes()
        return hashlib.sha256(text.encode() + content + late).hexdigest()
