"""The papers' tables as data, and the run that holds the model against them, row by row.

``PAPERS`` maps a paper's short name to the function that reproduces it. Nothing is tuned to look right: a
row that does not fit stays in the table with its error, and each row says whether a law was fitted to it.
"""

from codesign.planners.breadth_first.paper.reproduce import breadth_first
from codesign.planners.harmonic.paper.reproduce import harmonic
from codesign.planners.relaxation.paper.reproduce import relaxation
from codesign.planners.reproduction import Plot, Reproduction, Row, Series, joined, reproduction_schema
from codesign.planners.velocity_obstacle.paper.reproduce import velocity_obstacle
from codesign.planners.wavefront.paper.reproduce import wavefront
from codesign.reproduce.plots import plot_svg, write_plots

PAPERS = {
    "harmonic": harmonic,
    "breadth_first": breadth_first,
    "wavefront": wavefront,
    "velocity_obstacle": velocity_obstacle,
    "relaxation": relaxation,
}

__all__ = [
    "PAPERS",
    "Plot",
    "Reproduction",
    "Row",
    "Series",
    "breadth_first",
    "harmonic",
    "joined",
    "plot_svg",
    "relaxation",
    "reproduction_schema",
    "velocity_obstacle",
    "wavefront",
    "write_plots",
]
