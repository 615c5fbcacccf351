"""The world of a drive, apart from hardware: the true map over time, what is believed of it, what is left to explore.

Nothing here knows a spec or a simulation: arrays in, arrays out, times in integer picoseconds. Obstacles are cells and
the robot is a disc. ``Inflation`` has the cells that its middle may not enter, on the true map and the believed one.
"""

from codesign.system.scenarios.drive.world.belief import Belief, Frontiers, Update
from codesign.system.scenarios.drive.world.inflation import Inflation
from codesign.system.scenarios.drive.world.obstacles import Appearing, Moving, random_appearing
from codesign.system.scenarios.drive.world.true_map import Deferral, World

__all__ = ["Appearing", "Belief", "Deferral", "Frontiers", "Inflation", "Moving", "Update", "World", "random_appearing"]
