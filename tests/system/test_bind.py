"""Goals and starts that a map shuts in."""

from __future__ import annotations

import pytest
from small_maps import Specs, put_map

import codesign
from codesign.errors import SpecError

WALLED_GOAL = ".@....\n@.....\n......\n......\n"
WALLED_START = "......\n......\n....@.\n...@.@\n....@.\n"


def test_a_walled_in_goal_is_told_and_not_praised(specs: Specs) -> None:
    put_map(specs, WALLED_GOAL, starts="{count: 4}")
    with pytest.raises(SpecError, match=r"problem\.goals\[0\]: goal \(0, 0\) is walled in"):
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))


def test_a_start_without_a_way_is_told_with_the_nearest_that_has_one(specs: Specs) -> None:
    put_map(specs, WALLED_START, starts="[[4, 0], [3, 4]]")
    with pytest.raises(SpecError) as caught:
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    (fault,) = caught.value.faults
    assert (fault.key, fault.what) == ("problem.starts[1]", "no path leads from start (3, 4) to a goal")
    assert fault.hint is not None
    assert fault.hint.endswith(("(1, 4)", "(2, 3)", "(2, 5)", "(4, 3)"))
