"""Arrangements of robots and problems that cannot be planned for."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from codesign.ground.errors import InputError
from codesign.planners.velocity_obstacle.plan import RobotsProblem, RobotsWorkload, generate
from codesign.planners.velocity_obstacle.plan.problem import distances


def test_digest_is_of_all_that_the_problem_is() -> None:
    problem = generate("circle", 3)
    assert problem.digest == generate("circle", 3).digest
    others = [
        generate("circle", 3, radius=4.0),
        generate("circle", 3, speed=5.0),
        generate("circle", 3, acceleration=23.0),
        generate("circle", 3, seed=1),
        generate("circle", 4),
    ]
    assert len({problem.digest, *(other.digest for other in others)}) == 6


@pytest.mark.parametrize("count", [2, 16, 64])
@pytest.mark.parametrize("arrangement", ["circle", "crossing", "random"])
def test_every_arrangement_holds_2_to_64_robots(arrangement: str, count: int) -> None:
    radius = 5.0 if count <= 16 else 2.0
    problem = generate(arrangement, count, radius=radius, seed=3)
    assert problem.count == count
    apart = distances(problem.positions)
    assert apart[np.triu_indices(count, 1)].min() >= 2.0 * radius


GOOD = np.array([[10.0, 10.0], [30.0, 10.0]])
FAR = np.array([[10.0, 200.0], [30.0, 200.0]])


@pytest.mark.parametrize(
    ("changes", "where", "what"),
    [
        ({"positions": [[10.0, 10.0], [13.0, 10.0]]}, "positions", "robots 0 and 1 start in collision"),
        ({"targets": [[10.0, 10.0], [13.0, 10.0]]}, "targets", "would end in collision"),
        ({"positions": [[10.0, 10.0], [301.0, 10.0]]}, "positions", "outside of the arena"),
        ({"positions": [[10.0, 10.0], [math.nan, 10.0]]}, "positions", "outside of the arena"),
        ({"targets": [[10.0, 10.0], [30.0, -0.1]]}, "targets", "outside of the arena"),
        ({"positions": [[10.0, 10.0]]}, "positions", "1 robots"),
        ({"targets": [[10.0, 10.0]]}, "targets", "1 targets for 2 robots"),
        ({"positions": [10.0, 10.0]}, "positions", "names no robots"),
        ({"radius": 0.0}, "radius", "radius 0"),
        ({"acceleration": 0.0}, "acceleration", "acceleration 0"),
        ({"acceleration": math.inf}, "acceleration", "acceleration inf"),
        ({"speed": -1.0}, "speed", "speed -1"),
        ({"arena": (0.0, 300.0)}, "arena", "an arena of 0"),
    ],
)
def test_robots_that_cannot_be_planned_for(changes: dict[str, Any], where: str, what: str) -> None:
    given_values: dict[str, Any] = {
        "positions": GOOD,
        "targets": FAR,
        "radius": 5.0,
        "speed": 6.0,
        "acceleration": 24.0,
        **changes,
    }
    with pytest.raises(InputError) as raised:
        RobotsProblem(**given_values)
    assert raised.value.where == where
    assert what in raised.value.what
    assert raised.value.hint


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("ring", 4), "no arrangement 'ring'"),
        (("circle", 1), "1 robots"),
        (("circle", 65), "65 robots"),
        (("circle", 64), "start in collision"),
    ],
)
def test_arrangements_that_do_not_exist_or_fit(arguments: tuple[str, int], what: str) -> None:
    with pytest.raises(InputError, match=what):
        generate(*arguments, radius=9.0)


def test_robots_that_find_no_place() -> None:
    with pytest.raises(InputError, match="find no place"):
        generate("random", 64, radius=40.0)


@pytest.mark.parametrize(
    ("robots", "what"),
    [
        ({"count": 4}, "neither in one form nor in the other"),
        ({"count": 4, "arrangement": "circle", "positions": [[1, 1], [20, 20]]}, "neither in one form"),
        ({"count": 4, "arrangement": "circle", "radius": 0.0}, "greater than 0"),
        ({"count": 4, "arrangement": "circle", "acceleration": 0.0}, "greater than 0"),
        ({"positions": [[10, 10], [12, 12]], "targets": [[10, 10], [30, 30]]}, "start in collision"),
        ({"positions": [[10, 10], [312, 12]], "targets": [[10, 10], [30, 30]]}, "outside of the arena"),
        ({"count": True, "arrangement": "circle"}, "valid integer"),
    ],
)
def test_robots_of_a_workload_are_checked(robots: dict[str, Any], what: str) -> None:
    with pytest.raises(ValidationError) as raised:
        RobotsWorkload.model_validate({"robots": robots})
    assert what in str(raised.value)


def test_robots_of_a_workload_become_the_problem() -> None:
    drawn = RobotsWorkload.model_validate({"robots": {"count": 4, "arrangement": "crossing", "seed": 7}})
    assert drawn.problem().digest == generate("crossing", 4, seed=7).digest
    named = {"positions": GOOD.tolist(), "targets": FAR.tolist()}
    assert RobotsWorkload.model_validate({"robots": named}).problem().count == 2
