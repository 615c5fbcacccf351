"""Collision avoidance with acceleration velocity obstacles (Dubey, Pradhan, Krishna and Roy Chowdhury 2013).

Each of n robots samples velocities, the one towards its target first, and takes the first that its acceleration
allows and that is on no collision course with any other robot (equation 4). ``avoid`` runs all of them in the
closed loop in fixed point; ``reference`` holds the same in plain lines, in fixed point and in doubles.

Where the paper is silent, and what was taken here:

- Equation 4 does not ask whether two robots come closer or part, so robots that have passed each other go on
  avoiding. ``detection: approaching`` asks for r·V < 0 as well: the sign of a product that is there anyway.
- The paper takes the other robots as passive, each for itself. ``responsibility: half`` tests 2v' - v in place of
  v' (reciprocal velocity obstacles, van den Berg et al. 2008): no product more.
- Order of the array of velocities: all directions at the greatest speed, rotating both ways, then the next speed.
- No safe velocity: the robot brakes, each axis by itself. Having arrived, it brakes too, and rests.
- A decision that takes longer than its time step: the robots drive on with the velocities that they have, and take
  the new ones in the step after it (``Loop.hold``).
"""

from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, RobotsSpec, RobotsWorkload
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem, generate
from codesign.planners.velocity_obstacle.plan.quality import quality

__all__ = [
    "AvoidParameters",
    "Avoidance",
    "RobotsProblem",
    "RobotsSpec",
    "RobotsWorkload",
    "avoid",
    "generate",
    "quality",
]
