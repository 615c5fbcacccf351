"""The run that holds the model against the papers' tables, row by row; each paper stands in its planner's room.

Nothing is tuned to look right: a row that does not fit stays in the table with its error, and each row says whether a
law was fitted to it. ``codesign.system.catalog.papers`` lists what can be reproduced.
"""

from codesign.planners.reproduction import (
    Finding,
    Plot,
    Reproduction,
    Row,
    Series,
    joined,
    reproduction_schema,
)
from codesign.reproduce.plots import plot_svg, write_plots

__all__ = [
    "Finding",
    "Plot",
    "Reproduction",
    "Row",
    "Series",
    "joined",
    "plot_svg",
    "reproduction_schema",
    "write_plots",
]
