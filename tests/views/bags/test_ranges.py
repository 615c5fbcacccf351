"""The ranges of rays agree with the cells that the sensor of the simulation sees."""

from __future__ import annotations

import math

import numpy as np
import pytest

from codesign.components.kernels import cast, ranges
from codesign.components.sensor import RaySensor


@pytest.mark.parametrize("seed", range(12))
def test_a_range_ends_at_the_side_of_the_first_blocked_cell(seed: int) -> None:
    random = np.random.default_rng(seed)
    free = random.random((14, 17)) >= random.choice([0.0, 0.1, 0.4])
    position = random.uniform(0.0, 13.0, 2)
    free[tuple(np.floor(position + 0.5).astype(int))] = True
    reach = float(random.choice([0.7, 3.0, 30.0]))
    directions = RaySensor(reach, 40).directions
    lengths = ranges(free, position[0], position[1], reach, directions)
    for direction, length in zip(directions, lengths, strict=True):
        blocked = cast(free, position[0], position[1], reach, direction[None])[1]
        if not len(blocked):
            assert math.isinf(length)
            continue
        along = np.where(direction == 0.0, np.inf, direction)
        entries = ((blocked - 0.5 * np.sign(direction) - position) / along).max(axis=1)
        assert length == pytest.approx(max(entries.min(), 0.0), abs=1e-9)
        assert length <= reach
