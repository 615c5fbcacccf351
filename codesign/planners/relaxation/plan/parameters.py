"""The parameters of the relaxation, as a workload's mapping gives them, and the parameters of each method."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Any, Literal, TypeVar

from pydantic import Field, model_validator

from codesign.ground.errors import InputError, choose_hint
from codesign.ground.models import RefusalError, TaskParameters

E = TypeVar("E", bound=StrEnum)

PUBLISHED_TOLERANCE = 1e-15
"""Section V: "a very small error tolerance"."""

SCALE = 2.0**1000
"""Depth of a deep goal. A power of two, so that no bit of a value changes but its exponent; 2^24 are left above it."""

DEFAULT_MAX_ITERATIONS = 1_000_000
MOST_ITERATIONS = 1_000_000_000


class Method(StrEnum):
    """The method that solves the system of equations."""

    GS = "gs"
    SOR = "sor"
    AM = "am"
    MAM = "mam"
    RED_BLACK = "red_black"
    JACOBI = "jacobi"
    HALF_SWEEP_AM = "half_sweep_am"
    DIRECT = "direct"


DEFAULT_METHOD = Method.AM
"""With sweeps forwards and backwards, a field crosses a map in any direction in few iterations."""


class Boundary(StrEnum):
    """The fixed values on obstacles and on goals.

    The potential of ``deep_goal`` is the potential of ``low_goal`` times 2^1000. It has 600 decades before a value
    becomes 0, where ``low_goal`` has 300.
    """

    DEEP_GOAL = "deep_goal"
    LOW_GOAL = "low_goal"
    HIGH_WALLS = "high_walls"
    HIGH_GOAL = "high_goal"

    @property
    def values(self) -> tuple[float, float]:
        """The values of an obstacle and of a goal.

        >>> Boundary.LOW_GOAL.values
        (0.0, -1.0)
        """
        return _VALUES[self]

    @property
    def scale(self) -> float:
        """The difference of the values of a goal and an obstacle: changes and tolerances are shares of it."""
        wall, goal = self.values
        return abs(goal - wall)

    @property
    def upwards(self) -> bool:
        """True if the path to a goal goes up."""
        return self is Boundary.HIGH_GOAL


DEFAULT_BOUNDARY = Boundary.DEEP_GOAL

_VALUES = {
    Boundary.DEEP_GOAL: (0.0, -SCALE),
    Boundary.LOW_GOAL: (0.0, -1.0),
    Boundary.HIGH_WALLS: (1.0, 0.0),
    Boundary.HIGH_GOAL: (0.0, 1.0),
}

ACCELERATION: dict[Method, tuple[float | None, float | None]] = {
    Method.GS: (None, None),
    Method.SOR: (1.0, None),
    Method.AM: (1.0, None),
    Method.MAM: (1.0, 1.0),
    Method.RED_BLACK: (1.0, None),
    Method.JACOBI: (None, None),
    Method.HALF_SWEEP_AM: (1.0, None),
    Method.DIRECT: (None, None),
}
"""The default ω and r of each method; None where it takes none.

No method over-relaxes by default. The best ω differs from map to map, and over-relaxation carries the rounding
errors of cells near the goal into far rooms. The values there are smaller than these errors (docs/relaxation.md).
"""


def settle(method: Method, omega: Any, r: Any) -> tuple[float | None, float | None]:
    """ω and r of a run: those given, or the method's own; None where the method has none.

    Raises:
        InputError: a value outside of (0, 2), or one that the method does not take (``where`` names it).
    """
    settled: list[float | None] = []
    for index, (name, given) in enumerate((("omega", omega), ("r", r))):
        default = ACCELERATION[method][index]
        if given is None:
            settled.append(default)
            continue
        if default is None:
            takers = [str(other) for other, pair in ACCELERATION.items() if pair[index] is not None]
            hint = f"leave it out (--set relax.{name}=null), or choose a method that has one: {', '.join(takers)}"
            raise InputError(f"{method} takes no {name}, but {given!r:.80} is given", name, hint)
        if isinstance(given, bool) or not isinstance(given, int | float):
            raise InputError(f"{given!r:.80} is not a number", name, "give a number between 0 and 2")
        if not (math.isfinite(given) and 0.0 < given < 2.0):
            hint = "the sweeps converge for 0 < value < 2 only; 1.9 to 1.98 is usual"
            raise InputError(f"{given} is outside of (0, 2)", name, hint)
        settled.append(float(given))
    return settled[0], settled[1]


def named(kind: type[E], value: Any, name: str) -> E:
    """The member of an enumeration. Raises InputError, with ``name`` of the argument, where there is none."""
    try:
        return kind(value)
    except ValueError:
        raise InputError(f"{name} {value!r:.80} is unknown", name, choose_hint(str(value), list(kind))) from None


class RelaxParameters(TaskParameters):
    """The computation of the potential, and the search over it."""

    method: Method = Field(
        default=DEFAULT_METHOD, description="gs, sor, am, mam, red_black, jacobi, half_sweep_am or direct"
    )
    omega: float | None = Field(
        default=None,
        description="over-relaxation of sor, red_black, am, mam, half_sweep_am, between 0 and 2; left out: 1",
    )
    r: float | None = Field(
        default=None, description="over-relaxation of mam's second level, between 0 and 2; left out: 1"
    )
    tolerance: float | None = Field(
        default=None,
        gt=0,
        le=1,
        description="a run ends once no value changes by this share of the goal's in one iteration; left out: once"
        " every cell that can reach a goal has a lower neighbour",
    )
    boundary: Boundary = Field(
        default=DEFAULT_BOUNDARY,
        description="values of obstacles and goals; deep_goal: 0 and -2^1000; low_goal: 0 and -1; high_walls: 1"
        " and 0; high_goal: 0 and 1",
    )
    max_iterations: int = Field(
        default=DEFAULT_MAX_ITERATIONS, ge=1, le=MOST_ITERATIONS, description="most iterations of a run"
    )
    neighbours: Literal[4, 8] = Field(default=8, description="cells that a step of the search chooses from")

    @model_validator(mode="after")
    def _acceleration(self) -> RelaxParameters:
        try:
            settle(self.method, self.omega, self.r)
        except InputError as wrong:
            raise RefusalError(wrong.what, wrong.hint, (str(wrong.where),)) from None
        return self


class SearchParameters(TaskParameters):
    """The gradient descent search has no parameters of its own."""
