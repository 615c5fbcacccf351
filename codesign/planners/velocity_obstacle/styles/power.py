"""Power: P = P0 + q · √n, with a q for each style, fitted to Table III with 2 and 4 robots, compared with 8.

Six rows fix four numbers. The form is chosen among log₂ n, √n, ∛n and n by its residual on those six rows; the list
of forms was drawn up with the whole table in view. P0 does not depend on style or robots: it is mostly the
part's leakage. It is booked as static power, the rest as dynamic, in proportion to the clock. The interval is twice
the worst miss on the rows held out, and grows with the distance from the rows beyond 8 robots.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from codesign.ground.figures import Figure, Status
from codesign.ground.models import Part
from codesign.planners.velocity_obstacle.published import CLOCK, PAPER, PART, TABLE_III, Style

FITTED_ROBOTS = (2, 4)
FORMS: dict[str, Callable[[float], float]] = {"log2 n": math.log2, "√n": math.sqrt, "∛n": math.cbrt, "n": float}
"""Forms that were tried for the growth with the number of robots."""

DYNAMIC_OF_PART = 0.75e-12
"""W for each slice and Hz of the XC3S500E, by its part file: the reference for other parts."""
OTHER_PART = 2.0
"""Half to twice, on a part that the law was not fitted to."""


@dataclass(frozen=True)
class PowerFit:
    """P = base + slopes[style] · form(n), mW. ``residual``: root of the mean square over the rows fitted to, mW."""

    form: str
    base: float
    slopes: dict[Style, float]
    residual: float

    def power(self, style: Style, robots: int) -> float:
        """Total power at 50 MHz, mW."""
        return self.base + self.slopes[style] * FORMS[self.form](robots)


def rows(robots: tuple[int, ...]) -> list[tuple[Style, int, int]]:
    """(style, robots, mW) of Table III for these numbers of robots."""
    return [(style, n, mw) for style, row in TABLE_III.items() for n, mw in row.items() if n in robots]


@cache
def fit_power(form: str) -> PowerFit:
    """The least-squares fit of one form to the rows with 2 and 4 robots."""
    grow, styles = FORMS[form], list(Style)
    data = rows(FITTED_ROBOTS)
    matrix = np.array([[1.0, *(grow(n) * (style is other) for other in styles)] for style, n, _ in data])
    watts = np.array([mw for *_, mw in data], float)
    solution = np.linalg.lstsq(matrix, watts, rcond=None)[0]
    residual = float(np.sqrt(np.mean((matrix @ solution - watts) ** 2)))
    slopes = {style: float(slope) for style, slope in zip(styles, solution[1:], strict=True)}
    return PowerFit(form, float(solution[0]), slopes, residual)


@cache
def power_fit() -> PowerFit:
    """The fit of the form with the smallest residual."""
    return min((fit_power(form) for form in FORMS), key=lambda fit: fit.residual)


@cache
def power_miss() -> float:
    """The worst relative error on the rows held out: 8 robots."""
    fit = power_fit()
    return max(abs(fit.power(style, n) / mw - 1.0) for style, n, mw in rows((8,)))


def power(style: Style, robots: int, clock: int, part: Part) -> tuple[Figure, Figure]:
    """Static and dynamic power at ``clock`` Hz, W."""
    fit = power_fit()
    margin = 2.0 * power_miss() * max(1.0, math.log2(robots) / 3.0)
    dynamic = fit.slopes[style] * FORMS[fit.form](robots) / 1e3 * clock / CLOCK
    total = fit.power(style, robots) / 1e3
    law = (
        f"{fit.slopes[style]:.1f} mW × {fit.form} × clock / 50 MHz, fitted with {fit.base:.1f} mW of base to"
        f" {PAPER}, Table III, 2 and 4 robots; interval: twice the miss with 8 robots, {power_miss():.1%}, of the total"
    )
    if part.name == PART:
        spread = margin * total
        leak = part.static_power.interval
        static = Figure(
            fit.base / 1e3,
            "W",
            Status.CALIBRATED,
            f"what Table III of {PAPER} leaves for no robots; clock tree included",
            low=min(fit.base / 1e3, leak[0]),
            high=max(fit.base / 1e3, leak[1]),
        )
        low, high = max(0.0, dynamic - spread), dynamic + spread
        return static, Figure(dynamic, "W", Status.CALIBRATED, law, low=low, high=high)
    scale = part.dynamic_power.value / DYNAMIC_OF_PART
    text = f"{law}; times {scale:.2f}, this part's power of a slice over that of {PART}"
    scaled = dynamic * scale
    return part.static_power, Figure(
        scaled, "W", Status.ASSUMED, text, low=scaled / OTHER_PART, high=scaled * OTHER_PART
    )
