"""The parameters of the relaxation, as a workload's mapping gives them, and what each method takes."""

from __future__ import annotations

import math
from enum import StrEnum
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from codesign.errors import InputError, choose_hint
from codesign.spec import RefusalError, SpecModel

DEFAULT_TOLERANCE = 1e-15
"""Section V: "a very small error tolerance"."""

DEFAULT_MAX_ITERATIONS = 1_000_000
MOST_ITERATIONS = 1_000_000_000


class Method(StrEnum):
    """How the system of equations is solved."""

    GS = "gs"
    SOR = "sor"
    AM = "am"
    MAM = "mam"
    RED_BLACK = "red_black"
    JACOBI = "jacobi"
    HALF_SWEEP_AM = "half_sweep_am"
    DIRECT = "direct"


class Boundary(StrEnum):
    """What is fixed on obstacles and on goals."""

    LOW_GOAL = "low_goal"
    HIGH_WALLS = "high_walls"
    HIGH_GOAL = "high_goal"

    @property
    def values(self) -> tuple[float, float]:
        """The value of an obstacle and that of a goal.

        >>> Boundary.LOW_GOAL.values
        (0.0, -1.0)
        """
        return _VALUES[self]

    @property
    def upwards(self) -> bool:
        """Whether the way to a goal goes up."""
        return self is Boundary.HIGH_GOAL


_VALUES = {
    Boundary.LOW_GOAL: (0.0, -1.0),
    Boundary.HIGH_WALLS: (1.0, 0.0),
    Boundary.HIGH_GOAL: (0.0, 1.0),
}

ACCELERATION: dict[Method, tuple[float | None, float | None]] = {
    Method.GS: (None, None),
    Method.SOR: (1.95, None),
    Method.AM: (1.97, None),
    Method.MAM: (1.975, 1.92),
    Method.RED_BLACK: (1.95, None),
    Method.JACOBI: (None, None),
    Method.HALF_SWEEP_AM: (1.97, None),
    Method.DIRECT: (None, None),
}
"""ω and r that each method takes where none is given, None where it takes none.

AM and MAM: the fewest iterations of Tables I and II. SOR and red-black: near the best on the shipped floor plan.
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


def check_method(method: Any) -> Method:
    """The method of that name. Raises InputError where there is none."""
    try:
        return Method(method)
    except ValueError:
        raise InputError(
            f"method {method!r:.80} is unknown", "method", choose_hint(str(method), list(Method))
        ) from None


class RelaxParameters(SpecModel):
    """How the potential is computed and followed."""

    method: Annotated[
        Method, Field(description="gs, sor, am, mam, red_black, jacobi, half_sweep_am or direct")
    ]
    omega: Annotated[
        float | None,
        Field(description="over-relaxation of sor, red_black, am, mam, half_sweep_am, between 0 and 2"),
    ] = None
    r: Annotated[
        float | None, Field(description="over-relaxation of mam's second level, between 0 and 2")
    ] = None
    tolerance: Annotated[
        float, Field(gt=0, le=1, description="a run ends once no value changes by as much in one iteration")
    ] = DEFAULT_TOLERANCE
    boundary: Annotated[
        Boundary,
        Field(
            description="low_goal: obstacles 0, goals -1; high_walls: obstacles 1, goals 0; high_goal: 0 and 1"
        ),
    ] = Boundary.LOW_GOAL
    max_iterations: Annotated[
        int, Field(ge=1, le=MOST_ITERATIONS, description="a run ends there at the latest")
    ] = DEFAULT_MAX_ITERATIONS
    neighbours: Annotated[
        Literal[4, 8], Field(description="cells that a step of the search chooses from")
    ] = 8

    @model_validator(mode="after")
    def _acceleration(self) -> RelaxParameters:
        try:
            settle(self.method, self.omega, self.r)
        except InputError as wrong:
            raise RefusalError(wrong.what, wrong.hint, (str(wrong.where),)) from None
        return self


class SearchParameters(SpecModel):
    """The gradient descent search has nothing of its own to choose."""


class LoadParameters(SpecModel):
    """The task that brings the map to the planner has nothing to choose."""
