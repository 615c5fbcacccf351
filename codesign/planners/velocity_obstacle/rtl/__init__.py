"""The circuits of the three styles in Verilog-2005: one robot's, from the states of all to its acceleration."""

from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.rtl.robot import RobotCircuit

CIRCUITS = tuple(RobotCircuit(style) for style in Style)

__all__ = ["CIRCUITS", "RobotCircuit"]
