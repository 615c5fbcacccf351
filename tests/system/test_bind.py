"""Goals and starts that a map shuts in."""

from __future__ import annotations

import pytest
from small_maps import Specs, put_map

import codesign
from codesign.ground.errors import SpecError

WALLED_GOAL = ".@....\n@.....\n......\n......\n"
WALLED_START = "......\n......\n....@.\n...@.@\n....@.\n"


@pytest.mark.parametrize("goals", ["[[0, 0]]\n  reach: 0", "[[3, 5], [0, 0]]"])
def test_a_walled_in_goal_is_told_and_not_praised(specs: Specs, goals: str) -> None:
    """Also where goals in a pocket are asked for, and where another goal is reached from all other cells."""
    put_map(specs, WALLED_GOAL, goals=goals, starts="{count: 4}")
    with pytest.raises(SpecError, match=r"problem\.goals\[[01]\]: goal \(0, 0\) is walled in"):
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))


@pytest.mark.parametrize("corner", [(0, 0), (0, 5), (3, 0), (3, 5)])
def test_a_goal_is_walled_in_by_obstacles_and_by_each_edge_of_the_map(specs: Specs, corner: tuple[int, int]) -> None:
    lines = WALLED_GOAL.splitlines()[:: -1 if corner[0] else 1]
    text = "\n".join(line[:: -1 if corner[1] else 1] for line in lines)
    put_map(specs, text, goals=f"[[2, 2], {list(corner)}]", starts="{count: 4}")
    with pytest.raises(SpecError, match=r"problem\.goals\[1\]: goal \(\d, \d\) is walled in"):
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))


def test_a_walled_in_goal_alone_is_a_pocket(specs: Specs) -> None:
    """The refusal of pockets comes first: it names the share, and a cell to move the goal to."""
    put_map(specs, WALLED_GOAL, starts="{count: 4}")
    with pytest.raises(SpecError, match=r"problem\.goals: a path leads to a goal from 1 of 22 free") as caught:
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    assert "largest part is (1, 1)" in str(caught.value)


def test_a_start_without_a_way_is_told_with_the_nearest_that_has_one(specs: Specs) -> None:
    put_map(specs, WALLED_START, starts="[[4, 0], [3, 4]]")
    with pytest.raises(SpecError) as caught:
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    (fault,) = caught.value.faults
    assert (fault.key, fault.what) == ("problem.starts[1]", "no path leads from start (3, 4) to a goal")
    assert fault.hint is not None
    assert fault.hint.endswith(("(1, 4)", "(2, 3)", "(2, 5)", "(4, 3)"))
