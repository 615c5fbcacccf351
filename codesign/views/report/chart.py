"""What the interactive part of a study's page works on: the points as columns, each text once.

The script of the page hands them to the plot, the filters and the table, and writes every number with the same digits
and units as the tables do (``templates/numbers.js`` does what ``wording.figure_cell`` does).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.figures import FIGURES, ResultFigure
from codesign.inputs.aggregate import Share
from codesign.study.reasons import relative_gaps
from codesign.views.report.aggregated import condition_text, figure_column, figure_label, kind_of_row, rules_text
from codesign.views.report.axes import level_texts, short_names, varying_axes
from codesign.views.report.columns import Columns
from codesign.views.report.study_tables import PointWhys, why_out
from codesign.views.report.wording import number_scales

if TYPE_CHECKING:
    from codesign.study import Study

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
    """The figures that the page offers: those of ``chart_figures``, then all others that differ between designs."""
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
    columns, numbers = Columns(), dict[str, int]()
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
        "why": columns.add(np.array([numbers.setdefault(why, len(numbers)) for why in whys], np.intp)),
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
