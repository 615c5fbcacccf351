"""Pictures through matplotlib: a front, and a map with what happened on it.

No picture goes through pyplot, so nothing global is touched; the same input gives the same bytes.
matplotlib is imported when the first picture is made.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from codesign.errors import InputError
from codesign.figures import FIGURES, ResultFigure
from codesign.report.axes import axis_levels, varying_axes
from codesign.report.wording import axis_text, labelled, prefix, wants_logarithm
from codesign.units import counted

if TYPE_CHECKING:
    from codesign.exploration import Study

Format = Literal["png", "svg"]

_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
_PATH = "#d1495b"
_GOAL = "#1a9850"
_LARGEST_SIDE = 1200


@dataclass(frozen=True)
class Picture:
    """A picture for a page: its title, what it shows in words (``alt``), its bytes, and a caption."""

    title: str
    alt: str
    format: Format
    data: bytes
    caption: str = ""


def front_picture(
    study: Study,
    *,
    x: ResultFigure | None = None,
    y: ResultFigure | None = None,
    colour: ResultFigure | None = FIGURES["share_reaching_goal"],
    marker: str | None = None,
    format: Format = "png",
) -> Picture:
    """The feasible points by two figures, those of the front outlined, the front in these two joined.

    - ``x`` and ``y``: the first two objectives unless given.
    - ``colour``: a third figure; one colour for all where it is None or no point has it.
    - ``marker``: the axis that the shape of a marker tells; unless given the part, where it varies.

    Raises:
        InputError: fewer than two objectives and no figures given, or no feasible point has both figures.
    """
    chosen = [figure for figure in (x, y) if figure is not None]
    chosen += [figure for figure in study.objectives if figure not in chosen]
    if len(chosen) < 2:
        raise InputError("a front needs two figures", "x, y", "name two objectives, or give x and y")
    x, y = x or chosen[0], y or chosen[1]
    positions, values = _figures(study, (x, y))
    if not positions:
        raise InputError(
            f"no feasible point has both {x.label} and {y.label}",
            "x, y",
            "choose other figures",
        )
    shapes = marker or next((name for name in varying_axes(study) if name.endswith(".part")), None)
    from matplotlib.ticker import PercentFormatter

    with style():
        picture, axes = canvas((7.6, 5.0))
        scaled = _scaled(values, (x, y), axes)
        shades, norm = _shades(study, positions, colour)
        _scatter(study, axes, positions, scaled, shades, norm, shapes)
        axes.plot(*_staircase(scaled, (x, y)), color="0.35", linewidth=1.0, zorder=1.5, label=_FRONT_LINE)
        if norm is not None and colour is not None:
            bar = picture.colorbar(_mappable(norm), ax=axes, pad=0.02)
            bar.set_label(colour.label)
            if colour.counted == "share":
                bar.formatter = PercentFormatter(1)
        legend = picture.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
        if shades is not None:
            _in_grey(legend)
        title = f"{y.label} against {x.label}"
        axes.set_title(f"{study.workload} on {study.platform}: {counted(len(positions), 'feasible point')}")
        data = picture_bytes(picture, format)
    return Picture(
        title=title,
        alt=f"Scatter plot of {title}, {counted(len(positions), 'feasible point')}, front outlined and joined",
        format=format,
        data=data,
    )


def map_picture(
    free: NDArray[np.bool_],
    goals: Sequence[tuple[int, int]],
    *,
    potential: NDArray[np.floating[Any]] | None = None,
    shades: str = "",
    trajectories: Sequence[NDArray[np.float64]] = (),
    title: str = "Map",
    format: Format = "png",
) -> Picture:
    """The map, with the potential (by its logarithm) or another field, the paths to the goal and the goals where given.

    Args:
        free: bool, rows × columns. goals: (row, column) pairs.
        potential: rows × columns, values of 0 and above; cells at 0 stay white.
        shades: what the values are, where they are no potential: they are shown as they are, and finite ones only.
        trajectories: float64, n × 2 each, (row, column) in cells.
    """
    rows, columns = free.shape
    step = max(1, max(rows, columns) // _LARGEST_SIDE)
    extent = (-0.5, columns - 0.5, rows - 0.5, -0.5)
    width = 8.0
    with style():
        picture, axes = canvas((width, min(12.0, max(2.2, width * rows / columns + 0.8))))
        obstacles = np.ma.masked_where(free, np.ones(free.shape))[::step, ::step]
        if potential is not None:
            values = _logarithm(potential, free)
            if shades:
                values = np.ma.masked_where(~(free & np.isfinite(potential)), potential)
            drawn = axes.imshow(
                values[::step, ::step],
                extent=extent,
                cmap="viridis",
                interpolation="nearest",
            )
            picture.colorbar(drawn, ax=axes, pad=0.02, shrink=0.8).set_label(shades or "potential, log₁₀")
        axes.imshow(obstacles, extent=extent, cmap="gray", vmin=-0.35, vmax=4, interpolation="nearest")
        for path in trajectories:
            axes.plot(path[:, 1], path[:, 0], color="white", linewidth=2.2, alpha=0.8)
            axes.plot(path[:, 1], path[:, 0], color=_PATH, linewidth=1.2)
            axes.plot(path[:1, 1], path[:1, 0], "o", color=_PATH, markersize=3.5)
        axes.plot(
            [column for _, column in goals], [row for row, _ in goals], "*", color=_GOAL, markersize=12,
            markeredgecolor="white", linestyle="none",
        )  # fmt: skip
        axes.set(xlabel="column", ylabel="row", xlim=extent[:2], ylim=extent[2:])
        data = picture_bytes(picture, format)
    shown = [f"{rows} by {columns} cells", counted(len(goals), "goal")]
    shown += [f"the {shades or 'potential'} as colour"] if potential is not None else []
    shown += [f"{counted(len(trajectories), 'path')} drawn"] if trajectories else []
    return Picture(title=title, alt=f"Map of {', '.join(shown)}", format=format, data=data)


_FRONT_LINE = "front in these two figures"


def style() -> Any:
    """A context in which pictures look alike and come out byte for byte the same."""
    import matplotlib

    return matplotlib.rc_context(
        {
            "svg.hashsalt": "codesign",
            "font.size": 9,
            "axes.spines.top": False,
            "axes.spines.right": False,
            # A name with a dollar sign in it is no formula.
            "text.parse_math": False,
        }
    )


def canvas(size: tuple[float, float]) -> tuple[Any, Any]:
    """A figure of ``size`` inches, and its axes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    picture = Figure(figsize=size, layout="constrained")
    FigureCanvasAgg(picture)
    return picture, picture.add_subplot()


def picture_bytes(picture: Any, format: Format) -> bytes:
    """The figure as the content of a file, with no date in it."""
    out = io.BytesIO()
    metadata: dict[str, Any] = {"Date": None} if format == "svg" else {"Software": None}
    picture.savefig(out, format=format, dpi=130, metadata=metadata, bbox_inches="tight", pad_inches=0.08)
    return out.getvalue()


def _figures(study: Study, figures: tuple[ResultFigure, ...]) -> tuple[list[int], NDArray[np.float64]]:
    """The feasible points which have all these figures, and the figures: float64, points × figures."""
    positions, rows = [], []
    for position in study.feasible:
        row = [study.points[position].figure(figure) for figure in figures]
        if None not in row:
            positions.append(position)
            rows.append(row)
    return positions, np.array(rows, dtype=np.float64).reshape(len(rows), len(figures))


def _scaled(
    values: NDArray[np.float64], figures: tuple[ResultFigure, ResultFigure], axes: Any
) -> NDArray[np.float64]:
    """The values in units that suit them; labels and scales of the two axes are set alike."""
    from matplotlib.ticker import LogLocator, NullFormatter

    scaled = values.copy()
    for number, (figure, axis) in enumerate(zip(figures, (axes.xaxis, axes.yaxis), strict=True)):
        size, unit = prefix(scaled[:, number].tolist(), figure.unit)
        scaled[:, number] /= size
        axis.set_label_text(labelled(figure.label, unit))
        least, most = scaled[:, number].min(), scaled[:, number].max()
        if wants_logarithm(least, most):
            (axes.set_xscale if number == 0 else axes.set_yscale)("log")
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_minor_formatter(NullFormatter())
            axis.set_major_formatter(_number)
        elif most >= 10_000:
            axis.set_major_formatter(_number)
    axes.grid(True, color="0.9", linewidth=0.6, zorder=0)
    axes.set_axisbelow(True)
    return scaled


def _number(value: float, _place: int | None = None) -> str:
    return f"{value:,.10g}"


def _shades(study: Study, positions: Sequence[int], colour: ResultFigure | None) -> tuple[Any, Any]:
    """The colouring figure of each point (NaN: none) and its norm; None, None where no point has it."""
    from matplotlib.colors import Normalize

    if colour is None:
        return None, None
    of_points = [study.points[position].figure(colour) for position in positions]
    values = np.array([np.nan if value is None else value for value in of_points])
    if not np.isfinite(values).any():
        return None, None
    least, most = np.nanmin(values), np.nanmax(values)
    return values, Normalize(least, most if most > least else least + 1e-9)


def _mappable(norm: Any) -> Any:
    from matplotlib.cm import ScalarMappable

    return ScalarMappable(norm, _colours())


def _colours() -> Any:
    from matplotlib import colormaps

    return colormaps["viridis"]


def _scatter(
    study: Study,
    axes: Any,
    positions: Sequence[int],
    scaled: NDArray[np.float64],
    shades: Any,
    norm: Any,
    shapes: str | None,
) -> None:
    """The points, a marker for each level of the axis ``shapes``; those of the front larger and outlined."""
    front = set(study.front)
    levels = axis_levels(study, shapes) if shapes else [""]
    for number, level in enumerate(levels):
        for on_front in (False, True):
            mask = np.array(
                [
                    (position in front) == on_front
                    and (not shapes or axis_text(shapes, study.points[position].axes.get(shapes)) == level)
                    for position in positions
                ]
            )
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
    """Leave colour to the colour bar: a marker in the legend would take that of some point."""
    from matplotlib.collections import PathCollection

    for handle in legend.legend_handles:
        if isinstance(handle, PathCollection):
            handle.set_array(None)
            handle.set_facecolor("0.75")


def _staircase(
    scaled: NDArray[np.float64], figures: tuple[ResultFigure, ResultFigure]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of the line that bounds what can be had in these two figures."""
    from codesign.exploration.front import non_dominated

    best = np.unique(scaled[non_dominated(scaled, [figure.maximise for figure in figures])], axis=0)
    x, y = best[:, 0], best[:, 1]
    if figures[0].maximise:
        # A smaller x can be had wherever a larger one can: the bound of y runs to the left of its point.
        return np.repeat(x, 2)[:-1], np.repeat(y, 2)[1:]
    return np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]


def _logarithm(potential: NDArray[np.floating[Any]], free: NDArray[np.bool_]) -> Any:
    values = np.asarray(potential, dtype=np.float64)
    shown = free & (values > 0)
    return np.ma.masked_where(~shown, np.log10(np.where(shown, values, 1.0)))
