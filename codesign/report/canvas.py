"""A picture for a page, the canvas that it is drawn on, and the marks of a mission's events.

No picture goes through pyplot, so nothing global is touched; the same input gives the same bytes.
matplotlib is imported when the first picture is made.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any, Literal

Format = Literal["png", "svg"]

MARKS: dict[str, tuple[str, str, str]] = {
    "plan_requested": ("new plan asked for", "o", "#7b3294"),
    "deadline_missed": ("deadline missed", "v", "#e08214"),
    "safety_stop": ("safety stop", "s", "#b35806"),
    "no_way": ("no path", "D", "#000000"),
    "contact": ("contact", "X", "#d7191c"),
    "livelock": ("livelock", "P", "#542788"),
    "goal_reached": ("goal reached", "*", "#1a9850"),
}
"""How an event of a mission is marked: its words, its marker and its colour."""


@dataclass(frozen=True)
class Picture:
    """A picture for a page: its title, what it shows in words (``alt``), its bytes, and a caption."""

    title: str
    alt: str
    format: Format
    data: bytes
    caption: str = ""


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


def marker_size(marker: str) -> int:
    """Points across: a star needs more to be seen."""
    return 9 if marker == "*" else 5


def legend(picture: Any) -> None:
    """A legend below the axes; none where there is nothing to name."""
    if any(axes.get_legend_handles_labels()[1] for axes in picture.axes):
        picture.legend(loc="outside lower center", ncols=4, frameon=False, fontsize=8)
