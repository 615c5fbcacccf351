"""A result as JSON has it: with the intervals of its figures, whether it fits at every value, and the date."""

from __future__ import annotations

from pydantic import Field

from codesign.ground.figures import FIGURES
from codesign.inputs.constraint import FigureName
from codesign.system.results.result import Result
from codesign.system.verdicts.fits import Fit, fit_verdict


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
