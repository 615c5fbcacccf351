"""The comparison of the model with the papers' tables, row by row. Each paper is in the room of its planner.

Nothing is tuned to look right: a row that does not fit stays in the table with its error, and each row says whether a
law was fitted to it. ``codesign.system.catalog.papers`` lists the papers.
"""

from __future__ import annotations

import io
from pathlib import Path

from codesign.ground.errors import InputError
from codesign.ground.files import write_atomically
from codesign.planners.reproduction import Plot, Reproduction

# Plots of a reproduction as SVG, the same bytes at every run.

MARKERS = "osD^vP*X"


def plot_svg(plot: Plot) -> str:
    """The plot as a self-contained SVG document."""
    import matplotlib as mpl
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    # A fixed salt and no date, so that equal data give equal bytes.
    with mpl.rc_context({"svg.hashsalt": plot.name, "svg.fonttype": "path"}):
        figure = Figure(figsize=(6.4, 4.2), layout="constrained")
        FigureCanvasSVG(figure)
        axes = figure.add_subplot()
        for index, series in enumerate(plot.series):
            axes.plot(series.x, series.y, marker=MARKERS[index % len(MARKERS)], markersize=4, label=series.name)
        axes.set(xlabel=plot.x_label, ylabel=plot.y_label, xscale=plot.x_scale, yscale=plot.y_scale)
        for axis, scale in ((axes.xaxis, plot.x_scale), (axes.yaxis, plot.y_scale)):
            if scale == "log":
                axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
                axis.set_major_formatter(FuncFormatter(_grouped))
                axis.set_minor_formatter(NullFormatter())
        axes.set_title(plot.title, fontsize="medium")
        axes.grid(visible=True, alpha=0.3)
        axes.legend(fontsize="small")
        text = io.StringIO()
        figure.savefig(text, format="svg", metadata={"Date": None, "Creator": None})
    return text.getvalue()


def _grouped(value: float, _position: int) -> str:
    return f"{value:,.0f}"


def write_plots(reproduction: Reproduction, folder: Path) -> tuple[Path, ...]:
    """Write every plot into ``folder`` (created if missing) as NAME.svg; returns the files.

    Raises:
        InputError: the folder cannot be created. RunError: a plot cannot be written; no plot is left half written.
    """
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as fault:
        raise InputError(f"cannot write plots: {fault.strerror}", str(folder), "choose another folder") from fault
    for plot in reproduction.figures:
        path = folder / f"{plot.name}.svg"
        write_atomically(path, plot_svg(plot).encode())
        written.append(path)
    return tuple(written)
