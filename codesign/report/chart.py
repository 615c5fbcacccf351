"""What the interactive part of a study's page works on: the points as data, and empty plots for it to fill.

The data stands in the page once; the script of the page hands it to the plot and to the table.
"""

from __future__ import annotations

import math
from itertools import permutations
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from codesign.figures import FIGURES, ResultFigure
from codesign.report.aggregated import aggregated_cell, figure_column, figure_label
from codesign.report.axes import level_texts, short_names, varying_axes
from codesign.report.study_tables import why_out
from codesign.report.wording import labelled, prefix, wants_logarithm

if TYPE_CHECKING:
    from codesign.exploration import Study

MOST_POINTS = 20_000
"""A page shows no more points than this, so that a browser can hold it; the front is kept first."""

Scale = Literal["linear", "log"]
_LOGARITHMIC_TICKS = [float(f"{digit}e{power}") for power in range(-12, 13) for digit in (1, 2, 5)]
SCALES: tuple[Scale, ...] = ("linear", "log")


def chart_figures(study: Study) -> tuple[ResultFigure, ...]:
    """The figures that the page offers as axes and columns: objectives, then those that constraints speak of.

    Where these are fewer than two, time and slices are added: a plot has two axes.
    """
    named = [*study.objectives, *(limit.figure for limit in study.constraints)]
    if len(set(named)) < 2:
        named += [FIGURES["first_plan_s"], FIGURES["slices"]]
    return tuple(dict.fromkeys(named))


def chart_data(study: Study, most: int | None = None) -> dict[str, Any]:
    """The distinct designs as columns, ready for JSON; at most so many, by default ``MOST_POINTS``.

    - ``axes``: names, texts of their levels, and the level of each point;
    - ``figures``: label, and of each point the value (scaled to the unit in the label, six digits, None where
      there is none) and the text;
    - ``fronts``: for each ordered pair of figures ("0,1") the points that bound them, by rising first figure,
      as places among the points kept here.
    """
    kept = _kept(study, MOST_POINTS if most is None else most)
    points = [study.designs[position] for position in kept]
    feasible, front = study.judged.feasible[kept], study.on_front[kept]
    whys = [why_out(study, design) for design in points]
    distinct = list(dict.fromkeys(whys))
    numbers = {why: number for number, why in enumerate(distinct)}
    axes, figures = varying_axes(study), chart_figures(study)
    return {
        "points": [point.index for point in points],
        "feasible": feasible.astype(int).tolist(),
        "front": front.astype(int).tolist(),
        "why": [numbers[why] for why in whys],
        "whys": distinct,
        "axes": [
            _axis_data(study, name, short, kept) for name, short in zip(axes, short_names(axes), strict=True)
        ],
        "figures": [_figure_data(study, figure, kept) for figure in figures],
        "fronts": _fronts(study, figures, kept),
        "left_out": len(study.distinct) - len(kept),
    }


def chart_plots(study: Study) -> dict[str, Any]:
    """An empty Bokeh plot as JSON for each pair of scales of its axes ("linear,log"), with like names."""
    return {f"{x},{y}": _plot(study, x, y) for x in SCALES for y in SCALES}


def bokeh_script() -> str:
    """Bokeh's own script, to stand in the page."""
    from bokeh.resources import Resources

    scripts = Resources(mode="inline", components=["bokeh"], log_level="error").js_raw
    # A closing tag in a text of the script would end it early, an opened comment would hide its end.
    return "\n".join(scripts).replace("</script", "<\\/script").replace("<!--", "<\\!--")


def _kept(study: Study, most: int) -> list[int]:
    total = len(study.distinct)
    if total <= most:
        return list(study.distinct)
    front = study.front[:most]
    room = most - len(front)
    spread = {study.distinct[number * total // room] for number in range(room)} if room else set()
    return sorted(spread | set(front))


def _axis_data(study: Study, name: str, short: str, kept: list[int]) -> dict[str, Any]:
    places = study.decisions.levels(np.array(kept, np.intp))[name]
    values = [*study.axes[name], *([None] if (places < 0).any() else [])]
    texts_of = list(map(level_texts(study, name), values))
    levels = list(dict.fromkeys(texts_of))
    numbers = [levels.index(text) for text in texts_of]
    return {"name": short, "levels": levels, "level": [numbers[place] for place in places.tolist()]}


def _figure_data(study: Study, figure: ResultFigure, kept: list[int]) -> dict[str, Any]:
    column = study.judged.figure(figure)[kept]
    values = [None if math.isnan(value) else value for value in column.tolist()]
    # Points that are not feasible have figures too, but are not plotted.
    finite = column[study.judged.feasible[kept] & np.isfinite(column)].tolist()
    size, unit = prefix(finite, figure_column(study, figure).unit)
    return {
        "name": figure_label(study, figure),
        "label": labelled(figure_label(study, figure), unit),
        "maximise": study.world.maximise(figure),
        "logarithm": bool(finite) and wants_logarithm(min(finite), max(finite)),
        "values": [_rounded(value, size) for value in values],
        "texts": [aggregated_cell(study, study.designs[position], figure).text for position in kept],
    }


def _rounded(value: float | None, size: float) -> float | None:
    return None if value is None or not math.isfinite(value) else float(f"{value / size:.6g}")


def _fronts(study: Study, figures: tuple[ResultFigure, ...], kept: list[int]) -> dict[str, list[int]]:
    from codesign.exploration.front import non_dominated

    feasible = study.judged.feasible[kept]
    rows = [np.where(feasible, study.judged.figure(figure)[kept], math.nan) for figure in figures]
    fronts = {}
    for x, y in permutations(range(len(figures)), 2):
        chosen = non_dominated(
            np.column_stack([rows[x], rows[y]]), [study.world.maximise(figures[axis]) for axis in (x, y)]
        )
        places = np.flatnonzero(chosen)
        fronts[f"{x},{y}"] = places[np.argsort(rows[x][places], kind="stable")].tolist()
    return fronts


def _plot(study: Study, x_scale: Scale, y_scale: Scale) -> Any:
    from bokeh.embed import json_item
    from bokeh.models import BasicTickFormatter, ColumnDataSource, FixedTicker, HoverTool
    from bokeh.plotting import figure

    names = ["x", "y", "colour", "size", "edge", "alpha", "point"]
    lines = [("point", "@point")]
    for number, axis in enumerate(short_names(varying_axes(study))):
        names.append(f"axis{number}")
        lines.append((axis, f"@axis{number}"))
    for number, chosen in enumerate(chart_figures(study)):
        names.append(f"figure{number}")
        lines.append((chosen.label, f"@figure{number}"))
    source = ColumnDataSource({name: [] for name in names}, name="points")
    bound = ColumnDataSource({"x": [], "y": []}, name="bound")
    plot: Any = figure(
        name="plot",
        height=480,
        sizing_mode="stretch_width",
        x_axis_type=x_scale,
        y_axis_type=y_scale,
        tools="pan,box_zoom,wheel_zoom,box_select,tap,reset,save",
        active_drag="box_select",
        toolbar_location="above",
        background_fill_alpha=0,
        border_fill_alpha=0,
    )
    plot.toolbar.logo = None
    plot.step(x="x", y="y", source=bound, line_width=1.5, line_dash="dashed", name="bound_line")
    for line, scale in ((plot.xaxis, x_scale), (plot.yaxis, y_scale)):
        line.formatter = BasicTickFormatter(power_limit_high=7)
        if scale == "log":
            # Bokeh's own ticks bunch at the far end of an axis of less than two decades.
            line.ticker = FixedTicker(ticks=_LOGARITHMIC_TICKS)
    scatter = plot.scatter(
        x="x", y="y", size="size", fill_color="colour", fill_alpha="alpha", line_color="edge", line_width=1.4,
        source=source, name="scatter",
    )  # fmt: skip
    plot.add_tools(HoverTool(tooltips=lines, renderers=[scatter], attachment="horizontal"))
    return json_item(plot)
