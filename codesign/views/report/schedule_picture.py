"""The stages of harmonic control over time: the precision of each, and the local maxima that it left."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from codesign.ground.activity import spans_of
from codesign.ground.records import Record
from codesign.ground.units import PICOSECONDS_PER_SECOND, counted, format_count, format_time
from codesign.views.report.canvas import Format, Picture, canvas, drawn, legend, style
from codesign.views.report.wording import prefix

_MOST_STAGES = 2000


def schedule_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """A bar for each stage, as wide as its time and as high as its precision; None without a stage.

    A line joins the local maxima that the stages left. Of a long mission the first 2,000 stages are drawn.
    """
    every = [span for span in spans_of(records) if span.kind == "stage"]
    stages = every[:_MOST_STAGES]
    if not stages:
        return None
    size, unit = prefix([stages[-1].end / PICOSECONDS_PER_SECOND], "s")
    scale = size * PICOSECONDS_PER_SECOND
    begins = np.array([stage.begin for stage in stages]) / scale
    ends = np.array([stage.end for stage in stages]) / scale
    with style():
        figure, axes = canvas((8.0, 3.4))
        axes.bar(
            begins, [stage.details["precision"] for stage in stages], ends - begins, align="edge", color="#a6c8e4",
            edgecolor="#2166ac", linewidth=0.6, label="stage",
        )  # fmt: skip
        axes.set(xlabel=f"time ({unit})", ylabel="precision (bits)", xlim=(0, ends[-1]))
        beside = axes.twinx()
        beside.spines["right"].set_visible(True)
        beside.plot(
            ends, [stage.details["local_maxima"] for stage in stages], "o-", color="#d1495b", markersize=3.5,
            linewidth=1.0, clip_on=False, label="local maxima left",
        )  # fmt: skip
        beside.set_yscale("symlog", linthresh=1)
        beside.yaxis.set_major_formatter(_whole)
        beside.set(ylabel="local maxima", ylim=(0, None))
        legend(figure)
    last = stages[-1]
    facts = f"{counted(len(stages), 'stage')} of at most {max(stage.details['precision'] for stage in stages)} bits"
    left = f"{format_count(int(last.details['local_maxima']))} local maxima after the last"
    more = f"; {format_count(len(every) - len(stages))} later stages are not drawn" * (len(every) > len(stages))
    title = "The stages of the relaxation"
    alt = f"{facts} over {format_time(last.end)}, {left}"
    return drawn(figure, format, title, alt, f"{title}: {alt}{more}")


def _whole(value: float, _place: int | None = None) -> str:
    return f"{value:,.0f}"
