"""A partition that the map cannot take is refused, not run as another one."""

from __future__ import annotations

import numpy as np
import pytest

from codesign.planners.harmonic.plan.parameters import RelaxParameters
from codesign.planners.harmonic.plan.planner import PLANNER
from codesign.planners.interface import Problem
from codesign.planners.job import Job


def refused(blocks: tuple[int, int], shape: tuple[int, int]) -> tuple[str, str] | None:
    free = np.ones(shape, dtype=np.bool_)
    problem = Problem(free=free, goals=((0, 0),), starts=((0, 1),), resolution=None)
    return PLANNER.check(Job(problem, RelaxParameters(blocks=blocks, iterations=6, schedule=(7,))))


def test_more_blocks_than_equal_blocks_can_make_are_refused_with_what_they_make() -> None:
    """23 blocks down 24 rows need blocks of 2 rows, which make 12."""
    assert refused((23, 31), (24, 32)) == (
        "blocks",
        "23 × 31 equal blocks do not part a map of 24 × 32 cells: blocks of 2 × 2 nodes make 12 × 16, or 192",
    )


@pytest.mark.parametrize(("blocks", "shape"), [((2, 2), (71, 132)), ((24, 32), (24, 32)), ((1, 1), (24, 32))])
def test_blocks_whose_last_ones_are_cut_are_taken(blocks: tuple[int, int], shape: tuple[int, int]) -> None:
    assert refused(blocks, shape) is None
