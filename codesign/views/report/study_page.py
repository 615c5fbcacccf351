"""The self-contained page of a study: its points to look into, its tables, its reasons and its sources."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.progress import Show, doing, silent
from codesign.inputs.aggregate import Share
from codesign.inputs.edit import PLATFORM_AXIS
from codesign.study.reasons import relative_gaps
from codesign.system.explanation import AxisEffect
from codesign.views.report.axes import (
    condition_text,
    figure_column,
    figure_label,
    fixed_axes,
    kind_of_row,
    level_texts,
    rules_text,
    short_names,
    spread_table,
    varying_axes,
)
from codesign.views.report.explain_tables import effects_table
from codesign.views.report.page import Columns, rendered, script_json, template_text, write_page
from codesign.views.report.result_tables import sources_table
from codesign.views.report.study_tables import (
    PointWhys,
    best_table,
    front_table,
    nearest_table,
    reasons_table,
    search_picture,
    search_table,
    sourced_results,
    study_counts,
    study_sentence,
    why_out,
)
from codesign.views.report.winners_table import winners_table
from codesign.views.report.wording import ABSENT, Table, number_scales, share_text

if TYPE_CHECKING:
    from codesign.study import Study
    from codesign.views.report.canvas import Picture

# Which axis moves which figure, as a matrix to be looked at.

_STEPS = 10


@dataclass(frozen=True)
class Effect:
    """A cell: the share of the spread of a figure that an axis moves, in all and by itself; how dark it is, 0 to 10."""

    text: str
    alone: str
    shade: int


@dataclass(frozen=True)
class Matrix:
    """Axes by figures. Each row has the name of its axis, and a cell for each figure that varies."""

    figures: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Effect, ...]], ...]


def effects_matrix(study: Study, figures: Sequence[ResultFigure], effects: Sequence[AxisEffect]) -> Matrix:
    """The total share of each axis in the spread of each figure that varies over the feasible designs.

    ``effects``: the effects on the figures (``Study.sensitivity``).
    """
    if not study.feasible:
        return Matrix((), ())
    moving = [
        figure for figure in figures if any(each.figure == figure.name and each.total is not None for each in effects)
    ]
    held = {(each.axis, each.figure): each for each in effects}
    axes = tuple(dict.fromkeys(each.axis for each in effects))
    rows = []
    for axis, name in zip(axes, short_names(axes), strict=True):
        cells = []
        for figure in moving:
            effect = held[axis, figure.name]
            if effect.total is None or effect.main is None:
                cells.append(Effect(ABSENT, ABSENT, 0))
            else:
                shade = round(_STEPS * min(max(effect.total, 0.0), 1.0))
                cells.append(Effect(_percent(effect.total), _percent(effect.main), shade))
        rows.append((name, tuple(cells)))
    return Matrix(tuple(figure_label(study, figure) for figure in moving), tuple(rows) if moving else ())


def _percent(share: float) -> str:
    """A share as whole percent; a little of it is not 0 %."""
    return share_text(round(share, 2)) if share >= 0.01 or share == 0 else "<1 %"


# What the interactive part of a study's page works on: the points as columns, each text once.

MOST_POINTS = 100_000
"""A page shows no more points than this, so that a browser can hold it; the front is kept first."""

MOST_CONDITIONS = 24
"""A page shows no more conditions by themselves than this."""

_MISSES = {"name": "misses a limit by", "key": "misses", "unit": "1", "counted": "part", "maximise": False}
_Indices = NDArray[np.intp]


def chart_figures(study: Study) -> tuple[ResultFigure, ...]:
    """The figures that the page shows first: objectives, then those that constraints speak of.

    Where these are fewer than two, time and slices are added: a plot has two axes.
    """
    named = [*study.objectives, *(limit.figure for limit in study.constraints)]
    if len(set(named)) < 2:
        named += [FIGURES["first_plan_s"], FIGURES["slices"]]
    return tuple(dict.fromkeys(named))


def offered_figures(study: Study) -> tuple[ResultFigure, ...]:
    """The figures that the page offers: first as ``chart_figures``, then all others that differ between designs."""
    first, distinct = chart_figures(study), np.array(study.distinct, np.intp)

    def differs(figure: ResultFigure) -> bool:
        column = study.judged.figure(figure)[distinct]
        held = column[np.isfinite(column)]
        return bool(len(held)) and held.min() < held.max()

    others = dict.fromkeys((*study.figures.values(), *FIGURES.values()))
    return (*first, *(figure for figure in others if figure not in first and differs(figure)))


def chart_data(study: Study, figures: tuple[ResultFigure, ...] = ()) -> dict[str, Any]:
    """The distinct designs as columns, ready for JSON; at most ``MOST_POINTS`` in all conditions together.

    ``figures``: by default all ``offered_figures``.

    - ``axes``: names, texts of their levels, and the level of each point;
    - ``frames``: all conditions together, then each of the first ones by itself; each with the figures and why a
      point is not on the front, as the number of a text in ``whys``; ``main``: how many figures are shown first;
    - ``columns``: the columns, packed; all else names its place there (``Columns``).
    """
    conditions = study.world.each[:MOST_CONDITIONS] if study.conditions else []
    kept = _kept(study, MOST_POINTS // (len(conditions) + 1))
    columns, numbers = Columns(), defaultdict[str, int](count().__next__)
    axes, figures = varying_axes(study), figures or offered_figures(study)
    names = [rules_text(study) if conditions else "", *map(lambda n: condition_text(study, n), range(len(conditions)))]
    frames = [
        {"name": name, **_frame(each, kept, figures, columns, numbers)}
        for name, each in zip(names, (study, *map(study.at, conditions)), strict=True)
    ]
    return {
        "kind": kind_of_row(study),
        "points": columns.add(kept),
        "axes": [
            {"key": name, "name": short, **_axis(study, name, kept, columns)}
            for name, short in zip(axes, short_names(axes), strict=True)
        ],
        "frames": frames,
        "main": len(chart_figures(study)),
        "whys": columns.texts(list(numbers)),
        "left_out": len(study.distinct) - len(kept),
        "scales": number_scales(),
        "columns": columns.packed,
    }


def _kept(study: Study, most: int) -> _Indices:
    total = len(study.distinct)
    if total <= most:
        return np.array(study.distinct, np.intp)
    front = study.front[:most]
    room = most - len(front)
    spread = {study.distinct[number * total // room] for number in range(room)} if room else set()
    return np.array(sorted(spread | set(front)), np.intp)


def _axis(study: Study, name: str, kept: _Indices, columns: Columns) -> dict[str, Any]:
    places = study.decisions.levels(kept)[name]
    values = [*study.axes[name], *([None] if (places < 0).any() else [])]
    texts_of = list(map(level_texts(study, name), values))
    levels = list(dict.fromkeys(texts_of))
    numbers = np.array([levels.index(text) for text in texts_of], np.intp)
    return {"levels": levels, "level": columns.add(numbers[places])}


def _frame(
    study: Study, kept: _Indices, figures: tuple[ResultFigure, ...], columns: Columns, numbers: dict[str, int]
) -> dict[str, Any]:
    if study.conditions:
        whys = [why_out(study, study.designs[index], gaps=True) for index in kept.tolist()]
    else:
        # A design is a point.
        whys = [*map(PointWhys(study, gaps=True).of, kept.tolist())]
    gaps = relative_gaps(study)[study.first_of_same[kept]]
    gaps[gaps == -math.inf] = math.nan
    misses = [] if np.isnan(gaps).all() else [{**_MISSES, "column": columns.add(gaps)}]
    return {
        "feasible": columns.add(study.judged.feasible[kept]),
        "front": columns.add(study.on_front[kept]),
        "why": columns.add(np.array([numbers[why] for why in whys], np.intp)),
        "figures": [*(_figure(study, figure, kept, columns) for figure in figures), *misses],
    }


def _figure(study: Study, figure: ResultFigure, kept: _Indices, columns: Columns) -> dict[str, Any]:
    by_share = isinstance(study.world.rule(figure), Share)
    return {
        "key": figure.name,
        "name": figure_label(study, figure),
        "unit": figure_column(study, figure).unit,
        "counted": "share" if by_share else figure.counted,
        "maximise": study.world.maximise(figure),
        "column": columns.add(study.judged.figure(figure)[kept]),
    }


_PAGE_S_A_POINT = 80e-6
"""Measured: 8 s for the page of 104,000 points."""

_SCRIPTS = (
    *("numbers.js", "columns.js"),
    *(f"study/{name}.js" for name in ("data", "state", "points", "scatter", "panel", "filters", "table", "page")),
)
_PLOTTER = "vendor/uPlot.iife.min.js", "vendor/uPlot.min.css"
"""uPlot 1.6.32 (MIT, the licence beside it): axes, ticks and zoom of the plots."""


def study_page(
    study: Study, path: Path, *, pictures: Sequence[Picture] = (), command: str | None = None, show: Show = silent
) -> None:
    """Write the page of a study: points to look into, tables, reasons, sources, and how to make it again.

    ``pictures`` stand below the plot. ``command``: the line that made the study; by default it is made of its names.
    ``show`` is told what is done.

    Raises:
        RunError: the file cannot be written.
    """
    write_page(path, study_html(study, pictures=pictures, command=command, show=show))


def _platform_word(study: Study) -> str:
    return "" if PLATFORM_AXIS in study.axes else f"{study.platform} "


def study_html(
    study: Study, *, pictures: Sequence[Picture] = (), command: str | None = None, show: Show = silent
) -> str:
    """The page of ``study_page`` as text."""
    doing(show, "making the page", _PAGE_S_A_POINT * len(study.points))
    feasible = bool(study.feasible)
    figures = offered_figures(study)
    effects = study.sensitivity(*figures)
    first = {figure.name for figure in study.objectives}
    return rendered(
        "study.html.j2",
        study.provenance,
        effects=effects_table([each for each in effects if each.figure in first], study.objectives),
        matrix=effects_matrix(study, figures, effects),
        title=f"{study.workload} on {study.platform}",
        counts=study_counts(study),
        fixed=fixed_axes(study),
        feasible=feasible,
        answer=study_sentence(study),
        front=front_table(study),
        spread=spread_table(study) if study.conditions and feasible else None,
        fronts=_fronts_by_condition(study),
        more_conditions=max(0, len(study.world.each) - MOST_CONDITIONS),
        best=best_table(study),
        winners=winners_table(study),
        reasons=reasons_table(study),
        nearest=nearest_table(study),
        sources=sources_table(sourced_results(study)),
        figures=[figure.name for figure in chart_figures(study)],
        data=script_json(chart_data(study, figures)),
        plotter=template_text(_PLOTTER[0]),
        plotter_style=template_text(_PLOTTER[1]),
        page_style=template_text("study/study.css"),
        script="\n".join(template_text(name) for name in _SCRIPTS),
        searched=search_table(study),
        pictures=(*pictures, *([curves] if (curves := search_picture(study)) else [])),
        command=command or f"hwsw explore {_platform_word(study)}{study.workload} --html report.html",
    )


def _fronts_by_condition(study: Study) -> list[tuple[str, Table]]:
    """The front of each condition by itself, of the first conditions."""
    if not study.conditions:
        return []
    return [
        (condition_text(study, number), front_table(study.at(condition)))
        for number, condition in enumerate(study.world.each[:MOST_CONDITIONS])
    ]
