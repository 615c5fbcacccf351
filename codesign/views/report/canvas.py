"""A picture for a page or a paper, the canvas that it is drawn on, and the marks of a mission's events.

No picture goes through pyplot, so nothing global is touched; the same input gives the same bytes.
matplotlib is imported when the first picture is made.
"""

from __future__ import annotations

import io
import itertools
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from codesign.ground.errors import InputError
from codesign.ground.files import write_atomically
from codesign.ground.late import late
from codesign.ground.notebooks import InNotebooks

if TYPE_CHECKING:
    from matplotlib.figure import Figure

matplotlib = late("matplotlib")
backend_agg = late("matplotlib.backends.backend_agg")
mpl_figure = late("matplotlib.figure")
Image = late("PIL.Image")

Format = Literal["png", "svg", "pdf"]
"""PNG for screens, SVG and PDF for papers. PDF embeds its fonts as outlines that stay text (Type 42)."""

MARKS: dict[str, tuple[str, str, str]] = {
    "plan_requested": ("new plan asked for", "o", "#7b3294"),
    "deadline_missed": ("deadline missed", "v", "#e08214"),
    "safety_stop": ("safety stop", "s", "#b35806"),
    "no_way": ("no path", "D", "#000000"),
    "contact": ("contact", "X", "#d7191c"),
    "livelock": ("livelock", "P", "#542788"),
    "goal_reached": ("goal reached", "*", "#1a9850"),
}
"""The mark of an event of a mission: its words, its marker and its colour."""


@dataclass(frozen=True)
class Picture(InNotebooks):
    """A picture for a page: its title, what it shows in words (``alt``), its bytes, and a caption.

    ``drawing``: of matplotlib (``figure``). None where a picture is made of the bytes of another.
    """

    title: str
    alt: str
    format: Format
    data: bytes = field(repr=False)
    caption: str = ""
    drawing: Figure | None = field(default=None, repr=False, compare=False)

    @property
    def figure(self) -> Figure:
        """The figure of matplotlib, to be restyled: ``write`` draws it as it is at that time.

        Raises:
            InputError: the picture was not drawn here.
        """
        if self.drawing is None:
            raise InputError(f"the picture {self.title!r} has no figure", None, "write its data to a file")
        return self.drawing

    def write(self, path: Path | str, width_mm: float | None = None) -> None:
        """Write the figure as PDF, SVG or PNG, by the end of the name.

        ``width_mm``: of the figure, to a few mm, as margins without ink are cut off. Its letters keep their size.

        Raises:
            InputError: the name ends otherwise, or the picture has no figure. RunError: the file cannot be written.
        """
        format = format_of(Path(path))
        if width_mm is not None:
            set_width(self.figure, width_mm)
        write_atomically(Path(path), picture_bytes(self.figure, format))


def format_of(path: Path, where: str | None = None) -> Format:
    """The format that the end of a name asks for.

    ``where``: the option that names the file, for errors.

    Raises:
        InputError: it is neither PDF, SVG nor PNG.
    """
    suffix = path.suffix.lower().removeprefix(".")
    for format in get_args(Format):
        if suffix == format:
            return format  # type: ignore[no-any-return]
    raise InputError(f"{path} is neither PDF, SVG nor PNG", where, "name a file that ends in .pdf, .svg or .png")


def style() -> Any:
    """A context in which pictures look alike and come out byte for byte the same."""
    return matplotlib.rc_context(
        {
            "svg.hashsalt": "codesign",
            # Letters of a PDF stay letters that publishers accept, in place of Type 3 fonts.
            "pdf.fonttype": 42,
            "font.size": 9,
            "axes.spines.top": False,
            "axes.spines.right": False,
            # A name with a dollar sign in it is no formula.
            "text.parse_math": False,
        }
    )


def canvas(size: tuple[float, float]) -> tuple[Any, Any]:
    """A figure of ``size`` inches, and its axes."""
    picture = mpl_figure.Figure(figsize=size, layout="constrained")
    backend_agg.FigureCanvasAgg(picture)
    return picture, picture.add_subplot()


def drawn(figure: Any, format: Format, title: str, alt: str, caption: str = "") -> Picture:
    """The figure as a picture."""
    return Picture(title, alt, format, picture_bytes(figure, format), caption, figure)


_NO_DATE: dict[Format, dict[str, Any]] = {
    "svg": {"Date": None},
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None, "Creator": None},
}


def picture_bytes(figure: Any, format: Format) -> bytes:
    """The figure as the content of a file, with no date in it; margins without ink are cut off."""
    out = io.BytesIO()
    with style():
        figure.savefig(out, format=format, dpi=130, metadata=_NO_DATE[format], bbox_inches="tight", pad_inches=_MARGIN)
    return out.getvalue()


def with_palette(picture: Picture) -> Picture:
    """A PNG with 256 colours, which takes a quarter of the bytes; another picture as it is."""
    if picture.format != "png":
        return picture
    out = io.BytesIO()
    with Image.open(io.BytesIO(picture.data)) as full:
        # Median cut keeps a ramp of colours smooth.
        few = full.convert("RGB").quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    few.save(out, "png", optimize=True)
    return replace(picture, data=out.getvalue())


_MARGIN = 0.08
_MM_AN_INCH = 25.4
_LEAST_HEIGHT = 2.8
"""Inches: a picture of this height gets no lower with its width, as its letters do not get smaller."""

_ENTRY = 1.8
"""Inches for an entry of a legend."""


def set_width(figure: Any, width_mm: float) -> None:
    """Make a figure so wide, its height in proportion but for low ones; letters keep their size."""
    size, width = figure.get_size_inches(), width_mm / _MM_AN_INCH - 2 * _MARGIN
    figure.set_size_inches(width, max(size[1] * width / size[0], min(size[1], _LEAST_HEIGHT)))
    for before in figure.legends:
        # A legend cannot change its columns.
        labels = [text.get_text() for text in before.get_texts()]
        before.remove()
        _legend(figure, before.legend_handles, labels, max(1, int(width / _ENTRY)))


def marker_size(marker: str) -> int:
    """Points across: a star needs more to be seen."""
    return 9 if marker == "*" else 5


def legend(picture: Any) -> None:
    """A legend below the axes; none where there is nothing to name."""
    entries = [axes.get_legend_handles_labels() for axes in picture.axes]
    handles, labels = (list(itertools.chain.from_iterable(each)) for each in zip(*entries, strict=True))
    if labels:
        _legend(picture, handles, labels, 4)


def _legend(figure: Any, handles: list[Any], labels: list[str], columns: int) -> None:
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, frameon=False, fontsize=8)
