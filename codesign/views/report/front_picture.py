"""The front of a study as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.late import late
from codesign.ground.units import counted
from codesign.study.front import non_dominated
from codesign.views.report.axes import axis_levels, figure_column, figure_label, kind_of_row, varying_axes
from codesign.views.report.canvas import Format, Picture, canvas, drawn, style
from codesign.views.report.wording import Column, axis_text, labelled, prefix, wants_logarithm

if TYPE_CHECKING:
    from codesign.study import Study

ticker = late("matplotlib.ticker")
colours = late("matplotlib.colors")
mpl_cm = late("matplotlib.cm")
matplotlib = late("matplotlib")
collections = late("matplotlib.collections")


_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")


def front_picture(
    study: Study,
    *,
    x: ResultFigure | None = None,
    y: ResultFigure | None = None,
    colour: ResultFigure | None = FIGURES["share_reaching_goal"],
    marker: str | None = None,
    format: Format = "png",
) -> Picture:
    """The feasible designs by two figures, the front's designs outlined, the front in these two joined.

    - ``x`` and ``y``: the first two objectives unless given.
    - ``colour``: a third figure; one colour for all if it is None, or no two points differ in it.
    - ``marker``: the axis that the shape of a marker tells; unless given the part, where it varies.

    Raises:
        InputError: fewer than two objectives and no figures given, or no feasible point has both figures.
    """
    others = iter([figure for figure in study.objectives if figure not in (x, y)])
    x = x or next(others, None)
    y = y or next(others, None)
    if x is None or y is None:
        raise InputError("a front needs two figures", "x, y", "name two objectives, or give x and y")
    positions, values = _figures(study, (x, y))
    if not len(positions):
        raise InputError(f"no feasible point has both {x.label} and {y.label}", "x, y", "choose other figures")
    maximise = study.world.maximise(x), study.world.maximise(y)
    shapes = marker or next((name for name in varying_axes(study) if name.endswith(".part")), None)
    with style():
        picture, axes = canvas((7.6, 5.0))
        scaled = _scaled(values, [figure_column(study, figure) for figure in (x, y)], axes)
        shades, norm = _shades(study, positions, colour)
        _scatter(study, axes, positions, scaled, shades, norm, shapes)
        axes.plot(*_staircase(scaled, maximise), color="0.35", linewidth=1.0, zorder=1.5, label=_FRONT_LINE)
        if norm is not None and colour is not None:
            bar = picture.colorbar(mpl_cm.ScalarMappable(norm, _colours()), ax=axes, pad=0.02)
            bar.set_label(labelled(figure_label(study, colour), figure_column(study, colour).unit))
            if colour.counted == "share":
                bar.formatter = ticker.PercentFormatter(1)
        legend = picture.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
        if shades is not None:
            _in_grey(legend)
        title = f"{figure_label(study, y)} against {figure_label(study, x)}"
        shown = counted(len(positions), f"feasible {kind_of_row(study)}")
        axes.set_title(f"{study.workload} on {study.platform}: {shown}", wrap=True)
    return drawn(picture, format, title=title, alt=f"Scatter plot of {title}, {shown}, front outlined and joined")


_FRONT_LINE = "front in these two figures"


def _figures(study: Study, figures: tuple[ResultFigure, ...]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
    """The feasible points which have all these figures, and the figures: float64, points × figures."""
    feasible = np.array(study.feasible, np.intp)
    values = np.column_stack([study.judged.figure(figure)[feasible] for figure in figures])
    held = ~np.isnan(values).any(axis=1)
    return feasible[held], values[held]


def _scaled(values: NDArray[np.float64], columns: Sequence[Column], axes: Any) -> NDArray[np.float64]:
    """The values in units that suit them; labels and scales of the two axes are set alike."""
    scaled = values.copy()
    for number, (column, axis) in enumerate(zip(columns, (axes.xaxis, axes.yaxis), strict=True)):
        size, unit = prefix(scaled[:, number].tolist(), column.unit)
        scaled[:, number] /= size
        axis.set_label_text(labelled(column.name, unit))
        least, most = scaled[:, number].min(), scaled[:, number].max()
        if wants_logarithm(least, most):
            (axes.set_xscale if number == 0 else axes.set_yscale)("log")
            axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
            axis.set_minor_formatter(ticker.NullFormatter())
            axis.set_major_formatter(_number)
        elif most >= 10_000:
            axis.set_major_formatter(_number)
    axes.grid(True, color="0.9", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    return scaled


def _number(value: float, _place: int | None = None) -> str:
    return f"{value:,.10g}"


def _shades(study: Study, positions: NDArray[np.intp], colour: ResultFigure | None) -> tuple[Any, Any]:
    """The colouring figure of each point (NaN: none) and its norm; None, None where no two differ."""
    if colour is None:
        return None, None
    values = study.judged.figure(colour)[positions]
    if not np.isfinite(values).any():
        return None, None
    least, most = np.nanmin(values), np.nanmax(values)
    # One value in all points is no colour, and a scale of it would have one number at every tick.
    return (values, colours.Normalize(least, most)) if most > least else (None, None)


def _colours() -> Any:
    return matplotlib.colormaps["viridis"]


def _scatter(
    study: Study,
    axes: Any,
    positions: NDArray[np.intp],
    scaled: NDArray[np.float64],
    shades: Any,
    norm: Any,
    shapes: str | None,
) -> None:
    """The points, a marker for each level of the axis ``shapes``; the points of the front larger and outlined."""
    front = np.isin(positions, study.front)
    levels, level_of = [""], np.zeros(len(positions), np.intp)
    if shapes:
        levels = axis_levels(study, shapes)
        texts = [axis_text(shapes, value) for value in study.axes[shapes]]
        numbers = [levels.index(text) if text in levels else -1 for text in texts]
        level_of = np.array([*numbers, -1], np.intp)[study.decisions.levels(positions)[shapes]]
    for number, level in enumerate(levels):
        for on_front in (False, True):
            mask = (front == on_front) & (level_of == number)
            if not mask.any():
                continue
            colour = {"c": "C0"} if shades is None else {"c": shades[mask], "cmap": _colours(), "norm": norm}
            axes.scatter(
                scaled[mask, 0],
                scaled[mask, 1],
                marker=_MARKERS[number % len(_MARKERS)],
                s=58 if on_front else 22,
                edgecolors="black" if on_front else "none",
                linewidths=1.1 if on_front else 0,
                alpha=1 if on_front else 0.65,
                zorder=3 if on_front else 2,
                label=", ".join(filter(None, [level, "front of all objectives" if on_front else "others"])),
                **colour,
            )


def _in_grey(legend: Any) -> None:
    """Leave colour to the colour bar: a marker in the legend would take the colour of some point."""
    for handle in legend.legend_handles:
        if isinstance(handle, collections.PathCollection):
            handle.set_array(None)
            handle.set_facecolor("0.75")


def _staircase(
    scaled: NDArray[np.float64], maximise: tuple[bool, bool]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of the line that bounds what can be had in these two figures."""
    best = np.unique(scaled[non_dominated(scaled, maximise)], axis=0)
    x, y = best[:, 0], best[:, 1]
    if maximise[0]:
        # A smaller x can be had wherever a larger one can: the bound of y runs to the left of its point.
        return np.repeat(x, 2)[:-1], np.repeat(y, 2)[1:]
    return np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]
