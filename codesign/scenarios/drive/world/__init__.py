"""A robot's mission, apart from hardware: the true map over time, what is believed of it, what is left to explore.

Nothing here knows a spec or a simulation: arrays in, arrays out, times in integer picoseconds. Obstacles are cells; the
robot is a disc, and ``Inflation`` tells what its middle may not enter, of the true map and of the believed one alike.
"""

from codesign.scenarios.drive.world.belief import Belief, Update
from codesign.scenarios.drive.world.frontier import Frontiers
from codesign.scenarios.drive.world.inflation import Inflation
from codesign.scenarios.drive.world.obstacles import Appearing, Moving, random_appearing
from codesign.scenarios.drive.world.true_map import Deferral, World

__all__ = [
    "Appearing",
    "Belief",
    "Deferral",
    "Frontiers",
    "Inflation",
    "Moving",
    "Update",
    "World",
    "random_appearing",
]
