"""Power on an FPGA: static by part, and dynamic = toggles a cycle × energy of a toggle × clock.

The energy is the part's own, whose figure a slice holds at the activity that tools take where nobody says otherwise.
The toggles of a style were counted in simulations of its circuit (``ActivityRow``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from codesign.ground.figures import Figure, Status, weakest
from codesign.ground.models import Part
from codesign.planners.job import Demand
from codesign.planners.measured import ActivityRow, activity_rows

TYPICAL = 0.125
"""Toggles a net and edge of the clock that tools take by default: of such a design is the power of a part's slice."""

LEAST_MARGIN = 0.05
"""The least interval of a counted activity."""


@dataclass(frozen=True)
class PowerReport:
    """A public report: ``dynamic`` power of the fabric in W at ``clock`` Hz, on LUT, flip-flops and slices."""

    dynamic: float
    clock: float
    luts: int
    flip_flops: int
    slices: int

    @property
    def toggle_energy(self) -> float:
        """J a toggle of an output of a LUT or a flip-flop, wires and clock tree with it."""
        return self.dynamic / (self.clock * TYPICAL * (self.luts + self.flip_flops))


REPORTS = (PowerReport(0.070, 100e6, 12_403, 18_391, 7_847), PowerReport(0.084, 100e6, 17_372, 25_373, 9_709))
"""Mucha and Scechura 2023, two sizes of an A* array on the XC7Z020-1, by Vivado."""


@cache
def counted_activity(room: str, style: str) -> Figure | None:
    """Toggles a net and cycle of a style over ``TYPICAL``, by the rows of its room; None where it has none."""
    return activity_by(activity_rows(room, style))


def activity_by(rows: Sequence[ActivityRow]) -> Figure | None:
    """Toggles a net and cycle over ``TYPICAL``, by counts on designs of one style; None without rows.

    The value is the mean of the rows. The interval is the largest error of a row that the mean of all others predicts,
    and a quarter more.
    """
    if not rows:
        return None
    rates = [row.rate for row in rows]
    mean = sum(rates) / len(rates)
    others = [(sum(rates) - rate) / (len(rates) - 1) for rate in rates] if len(rates) > 1 else rates
    worst = max(abs(rate / other - 1) for rate, other in zip(rates, others, strict=True))
    margin = max(LEAST_MARGIN, 1.25 * worst)
    source = (
        f"{mean:.3f} toggles a net and cycle, counted on {len(rows)} designs ({min(rates):.3f} to {max(rates):.3f});"
        f" {TYPICAL} in a typical design"
    )
    value = mean / TYPICAL
    return Figure(value, "1", Status.MEASURED, source, value * max(0.0, 1 - margin), value * (1 + margin))


def slice_power(
    demand: Demand, clock: int, part: Part, activity: Figure | None = None, status: Status = Status.CALIBRATED
) -> tuple[Figure, Figure]:
    """Static power of ``part``; and slices × ``clock`` (Hz) × the part's power a slice and Hz × ``activity``, W.

    Block RAMs and the clock tree are in the figure for a slice of a typical design; pins are not counted. ``activity``:
    over the activity of a typical design; None: as typical.
    """
    scale = demand.total("slices") * clock
    rate = part.dynamic_power
    low, high = rate.interval
    value, least, most = (1.0, 1.0, 1.0) if activity is None else (activity.value, *activity.interval)
    counted = "" if activity is None else f" × {value:.3g} ({activity.source})"
    dynamic = Figure(
        value=rate.value * scale * value,
        unit="W",
        status=weakest(status, rate.status),
        source=f"slices × clock × {rate.value * 1e12:.3g} µW a slice and MHz ({rate.source}){counted}",
        low=low * scale * least,
        high=high * scale * most,
    )
    return part.static_power, dynamic
