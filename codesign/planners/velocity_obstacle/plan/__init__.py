"""Collision avoidance with acceleration velocity obstacles (Dubey, Pradhan, Krishna and Roy Chowdhury 2013).

Each of n robots samples velocities, the one towards its target first, and takes the first that its acceleration
allows and that is on no collision course with any other robot (equation 4). ``avoid`` runs all of them in the
closed loop in fixed point; ``reference`` holds the choice of a robot in plain lines, in fixed point and in doubles.

Choices where the paper is silent:

- Equation 4 holds whether two robots come closer or part, so robots that have passed each other still avoid each
  other. ``detection: approaching`` also requires r·V < 0: the sign of a product that the equation already forms.
- In the paper each robot takes the others as passive. ``responsibility: half`` tests 2v' - v in place of v'
  (reciprocal velocity obstacles, van den Berg et al. 2008), with no additional product.
- Order of the array of velocities: all directions at the greatest speed, rotating in both directions, then the next
  speed.
- A robot without a safe velocity brakes, each axis by itself. A robot that has arrived brakes too, and rests.
- During a decision that takes longer than its time step, the robots drive on with their velocities. They take the new
  velocities in the step after it (``Loop.hold``).
"""

from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.avoidance import Avoidance
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, RobotsSpec, RobotsWorkload
from codesign.planners.velocity_obstacle.plan.planner import quality
from codesign.planners.velocity_obstacle.plan.problem import RobotsProblem, generate

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
