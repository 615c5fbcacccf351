"""Whether a design fits its part at every value of its demand and of its clock limit, at some, or at none."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pydantic import Field

from codesign.figures import Figure
from codesign.results.model import ResultModel
from codesign.results.result import Result


class Fit(ResultModel):
    """Whether a design fits.

    A clock that a platform declares is a choice. What is uncertain is the limit that the law of the style gives.
    """

    fits: Literal["yes", "no", "uncertain"] = Field(
        description="yes: at every value inside the intervals; no: at none; uncertain: at some"
    )
    decides: str = Field(
        default="", description="the resource, the bound or clock that it depends on, or that is short"
    )
    demand: tuple[float, float] | None = Field(
        default=None, description="what it takes of that: least and most"
    )
    limit: tuple[float, float] | None = Field(
        default=None, description="what it may take of that: least and most"
    )
    figure: Figure | None = Field(default=None, description="the figure with the interval")


def fit_verdict(result: Result) -> Fit:
    """Whether the design of a result fits; see ``Fit``. Of several limits the hardest is named."""
    fits = [*_limits(result)]
    order = ("no", "uncertain", "yes")
    return min(fits, key=lambda each: order.index(each.fits), default=Fit(fits="yes"))


def _limits(result: Result) -> Iterator[Fit]:
    for use in result.resources:
        least, most = (sum(item.figure.interval[end] for item in use.items) for end in (0, 1))
        widest = max(
            (item.figure for item in use.items),
            key=lambda figure: figure.interval[1] - figure.interval[0],
            default=None,
        )
        yield _held(use.resource, (least, most), (use.budget, use.budget), widest if least < most else None)
    for reason in result.reasons:
        if reason.kind in {"bound", "mapping"}:
            yield _held(reason.name, (reason.demand, reason.demand), (reason.limit, reason.limit), None)
    if result.clock is not None:
        hz = float(result.clock.hz)
        yield _held("clock", (hz, hz), result.clock.limit.interval, result.clock.limit)


def _held(name: str, demand: tuple[float, float], limit: tuple[float, float], figure: Figure | None) -> Fit:
    if demand[1] <= limit[0]:
        return Fit(fits="yes", decides=name, demand=demand, limit=limit, figure=figure)
    if demand[0] > limit[1]:
        return Fit(fits="no", decides=name, demand=demand, limit=limit, figure=figure)
    return Fit(fits="uncertain", decides=name, demand=demand, limit=limit, figure=figure)
