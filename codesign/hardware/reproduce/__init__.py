"""The comparison of the model with the papers' tables, row by row. Each paper is in the room of its planner.

Nothing is tuned to look right: a row that does not fit stays in the table with its error, and each row says whether a
law was fitted to it. ``codesign.system.catalog.papers`` lists the papers.
"""

from codesign.hardware.reproduce.plots import plot_svg, write_plots
from codesign.planners.reproduction import Finding, Plot, Reproduction, Row, Series, joined, reproduction_schema

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
