"""Law over measured by term and family, on one axis."""

from __future__ import annotations

from more_itertools import map_reduce

from codesign.ground.figures import label
from codesign.ground.late import late
from codesign.hardware.fidelity import WORST, Fidelity, spread
from codesign.hardware.fidelity.points import TOTAL, Point
from codesign.views.report.canvas import canvas, legend, picture_bytes, style
from codesign.views.report.fidelity_page import FAMILY_NAMES

ticker = late("matplotlib.ticker")

MARKERS = {
    "xc2v": ("o", "#1b9e77"),
    "xc2vp": ("s", "#66a61e"),
    "xc3se": ("D", "#a6761d"),
    "xc4v": ("^", "#e6ab02"),
    "xc7": ("v", "#d95f02"),
    "ecp5": ("P", "#7570b3"),
    "gowin": ("X", "#e7298a"),
    "ice40": ("*", "#666666"),
}
LEAST, MOST = 0.25, 4.0
"""The ends of the axis; a ratio beyond stands at its end."""


def fidelity_picture(result: Fidelity) -> bytes:
    """The picture as SVG: a line for each style and resource, a mark for each family, its bar from least to most."""
    terms = _terms(result.points)
    with style():
        picture, axes = canvas((8.2, 1.4 + 0.3 * len(terms)))
        axes.axvspan(1 - WORST, 1 + WORST, color="#2c7fb8", alpha=0.12, linewidth=0, label=f"±{WORST:.0%}")
        axes.axvline(1, color="#444444", linewidth=0.8)
        seen: set[str] = set()
        for line, (_, families) in enumerate(terms):
            for place, (family, group) in enumerate(families.items()):
                errors = spread(group)
                if errors.least is None or errors.middle is None or errors.most is None:
                    continue
                low, middle, high = (_within(each) for each in (errors.least, errors.middle, errors.most))
                marker, colour = MARKERS[family]
                y = line + 0.64 * ((place + 0.5) / len(families) - 0.5)
                axes.plot([low, high], [y, y], color=colour, linewidth=1.2)
                name = "" if family in seen else FAMILY_NAMES[family]
                axes.plot(
                    [middle], [y], marker, color=colour, markersize=4.5, label=name, linestyle="none", clip_on=False
                )
                seen.add(family)
        axes.set(xscale="log", xlim=(LEAST, MOST), ylim=(len(terms) - 0.4, -0.6))
        axes.set_yticks(range(len(terms)), [name for name, _ in terms])
        axes.set_xticks([0.25, 0.5, 0.8, 1, 1.25, 2, 4])
        axes.xaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))
        axes.xaxis.set_minor_formatter(ticker.NullFormatter())
        axes.xaxis.set_minor_locator(ticker.NullLocator())
        axes.grid(visible=True, axis="x", alpha=0.3)
        axes.set_xlabel("law / measured (synthesised, or placed); bar: least to most, mark: middle row")
        legend(picture)
        return picture_bytes(picture, "svg")


def _within(ratio: float) -> float:
    return min(MOST, max(LEAST, ratio))


def _terms(points: tuple[Point, ...]) -> list[tuple[str, dict[str, list[Point]]]]:
    """Planner, style and quantity in words, and its points by family."""
    shown = [point for point in points if point.line == TOTAL or point.quantity == "clock"]
    terms = map_reduce(
        shown,
        lambda point: f"{point.planner} {point.style}, {label(point.quantity)}".replace("_", " "),
        reducefunc=lambda group: dict(map_reduce(group, lambda point: point.family)),
    )
    return list(terms.items())
