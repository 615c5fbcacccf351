"""Ways on a small map, maps, and robots with every kind of drive."""

from __future__ import annotations

import math

import numpy as np
import simpy
from hypothesis import strategies as st

from codesign.components import MobileRobot
from codesign.components.path import Polyline
from codesign.components.robot import DifferentialDrive, Kinematics, OmnidirectionalDrive, PointDrive

SIDE = 12


# Quarters of a cell: points on borders and on corners are as frequent as others.
quarters = st.integers(-1, 4 * SIDE - 3).map(lambda number: number / 4)
anywhere = st.floats(-0.4, SIDE - 0.6)
points = st.tuples(quarters, quarters) | st.tuples(anywhere, anywhere)
ways = st.lists(points, min_size=1, max_size=7).map(Polyline)

maps = st.tuples(st.integers(0, 2**32), st.sampled_from([0.0, 0.1, 0.3])).map(
    lambda drawn: np.random.default_rng(drawn[0]).random((SIDE, SIDE)) >= drawn[1]
)


kinematics = st.sampled_from(
    [PointDrive(0.5), OmnidirectionalDrive(0.5, 0.3), OmnidirectionalDrive(1.5, 4.0), DifferentialDrive(0.5, 0.4, 1.5)]
)


def a_robot(limits: Kinematics, position: tuple[float, float], resolution: float = 1.0) -> MobileRobot:
    return MobileRobot(simpy.Environment(), "robot", kinematics=limits, resolution=resolution, position=position)


OPEN = np.zeros((SIDE, SIDE), np.bool_)


def circle(count: int, radius: float) -> Polyline:
    """Twice around, ``count`` points a turn."""
    angle = np.arange(2 * count) * (2 * math.pi / count)
    return Polyline(radius * np.column_stack((np.sin(angle), np.cos(angle))))
