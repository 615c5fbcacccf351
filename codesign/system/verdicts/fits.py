"""The fit of a design on its part, and the document of a result: with intervals, fit and date."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

from pydantic import Field

from codesign.ground.figures import FIGURES, Figure, Status, label
from codesign.inputs.constraint import FigureName
from codesign.system.results.model import ResultModel
from codesign.system.results.result import BoundUse, Clock, ResourceUse, Result


class Fit(ResultModel):
    """The verdict about the fit of a design.

    A clock that a platform declares is a choice. What is uncertain is the limit that the law of the style gives.
    """

    fits: Literal["yes", "no", "uncertain"] = Field(
        description="yes: at every value inside the intervals; no: at none; uncertain: at some"
    )
    decides: str = Field(
        default="", description="the resource, the bound or clock that it depends on, or that is short"
    )
    demand: tuple[float, float] | None = Field(default=None, description="what it takes of that: least and most")
    limit: tuple[float, float] | None = Field(default=None, description="what it may take of that: least and most")
    figure: Figure | None = Field(default=None, description="the figure with the interval")
    flips_at: float | None = Field(
        default=None,
        description="the value of that figure at which it changes, all others at their own; null: not in its interval",
    )


def fit_verdict(result: Result) -> Fit:
    """True if the design of a result fits; see ``Fit``. Of several limits the hardest is named."""
    fits = [*limit_verdicts(result.resources, result.bounds, result.clock)]
    # A combination that is refused; and a bound of a result that was written without its bounds.
    known = {bound.name for bound in result.bounds}
    fits += [
        Fit(fits="no", decides=reason.name, demand=(reason.demand,) * 2, limit=(reason.limit,) * 2)
        for reason in result.reasons
        if reason.kind == "mapping" or (reason.kind == "bound" and reason.name not in known)
    ]
    order = ("no", "uncertain", "yes")
    return min(fits, key=lambda each: order.index(each.fits), default=Fit(fits="yes"))


def limit_verdicts(resources: Sequence[ResourceUse], bounds: Sequence[BoundUse], clock: Clock | None) -> Iterator[Fit]:
    """True if each limit of a design is kept at every value inside the intervals."""
    for use in resources:
        budget = Figure(use.budget, "1", Status.PUBLISHED, "the part")
        yield _held(use.resource, [item.figure for item in use.items], budget)
    for bound in bounds:
        yield _held(bound.name, [bound.figure], bound.limit)
    if clock is not None:
        yield _held("clock", [Figure(clock.hz, "Hz", Status.ASSUMED, "chosen")], clock.limit)


def _held(name: str, demands: Sequence[Figure], limit: Figure) -> Fit:
    """The sum of some demands against a limit. The figure with the widest interval decides."""
    least, most = (sum(float(each.interval[end]) for each in demands) for end in (0, 1))
    low, high = map(float, limit.interval)
    fits: Literal["yes", "no", "uncertain"] = "yes" if most <= low else "no" if least > high else "uncertain"
    margin = limit.value - sum(each.value for each in demands)
    widest = max((*demands, limit), key=lambda each: each.interval[1] - each.interval[0])
    flip = widest.value + (-margin if widest is limit else margin)
    known = widest.interval[0] == widest.interval[1]
    return Fit(
        fits=fits,
        decides=name,
        demand=(least, most),
        limit=(low, high),
        figure=None if known else widest,
        flips_at=flip if fits == "uncertain" and widest.interval[0] <= flip <= widest.interval[1] else None,
    )


def ends_text(fit: Fit) -> str:
    """The demand of a design, its limit, and the point where the verdict changes: ``slices, 90 to 120 against 100``."""
    assert fit.demand is not None, "asked of a limit"
    assert fit.limit is not None, "asked of a limit"
    unit = "" if fit.figure is None or fit.figure.unit == "1" else f" {fit.figure.unit}"
    spans = [{_number(low): None, _number(high): None} for low, high in (fit.demand, fit.limit)]
    text = f"{label(fit.decides)}, " + " against ".join(f"{' to '.join(span)}{unit}" for span in spans)
    if fit.figure is None or fit.flips_at is None:
        return text
    whole = fit.figure.interval in (fit.demand, fit.limit)
    stands = f"{_number(fit.flips_at)}{unit} ({fit.figure.status} {_number(fit.figure.value)})"
    return f"{text}; it changes {'at' if whole else 'where one item of it takes'} {stands}"


def _number(value: float) -> str:
    return f"{value:,.0f}" if value >= 1e4 else f"{value:,.6g}"


class RunDocument(Result):
    """All the figures of one design point, with what the intervals of others leave open of them."""

    intervals: dict[FigureName, tuple[float, float]] = Field(
        description="least and greatest value of each figure that rests on figures with intervals, in its unit"
    )
    fit: Fit | None = Field(
        description="whether it fits at every value of its demand and its limits; null without a part or a limit"
    )


def run_document(result: Result) -> RunDocument:
    """The document of a result, with the date of today."""
    intervals = {figure: result.interval(figure) for figure in FIGURES.values()}
    fields = dict(result) | {
        "provenance": None if result.provenance is None else result.provenance.stamped(),
        "intervals": {figure: ends for figure, ends in intervals.items() if ends is not None},
        "fit": None if result.part is None and not result.bounds else fit_verdict(result),
    }
    # Every field is of a result that was checked when it was made.
    return RunDocument.model_construct(**fields)
