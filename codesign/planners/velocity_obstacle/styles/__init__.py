"""Velocity obstacles: the three circuits of Dubey et al. (2013), on an FPGA that each robot carries.

- ``sequential``: one datapath, update and detection in turn.
- ``pipelined``: one unit of each kind side by side (resource-constrained, RC).
- ``hybrid``: a unit for each update, and one for each detection.

Cycles are the length of a schedule of units (``schedule``), so ``update_units`` and ``detect_units`` of a mapping
give circuits in between. The differences of the paper from these laws are in docs/velocity_obstacle.md.
"""

from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.styles import Circuit

ARCHITECTURES = tuple(Circuit(style) for style in Style)

__all__ = ["ARCHITECTURES", "Circuit", "Style"]
