"""A drive without a way or a goal ends for a stated reason, soon, and its trace is whole up to there."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from mission_specs import ENDS, OPEN, rectangle

from codesign.system import Result
from codesign.system.results.mission import Mission

Drives = Callable[..., tuple[Result, Mission]]

WALLED = "\n".join(["." * 16, ".####...........", *[".#..#..........."] * 2, ".####...........", *["." * 16] * 11, ""])


@pytest.mark.parametrize("placement", ["breadth-first", "harmonic", "harmonic-warm", "relaxation"])
def test_a_robot_that_is_walled_in(drives: Drives, placement: str) -> None:
    _, mission = drives(placement, text=WALLED, start=(2, 2), goals=[(0, 0)], patience="2 s")
    assert not mission.reached
    assert "no way leads from (2, 2) to a goal" in mission.ended
    assert mission.distance_m == 0.0
    assert mission.mission_time_s == pytest.approx(2.0, abs=0.2)
    assert mission.plans == 0


@pytest.mark.parametrize("placement", ["wavefront", "wavefront-tiled-track-on-host"])
@pytest.mark.parametrize("stop", ["starts", "whole_map"])
def test_a_wave_that_cannot_come_to_a_walled_in_robot(drives: Drives, placement: str, stop: str) -> None:
    """Whether it would wait for the robot or not: the drive begins, and says why it ends."""
    mapping = {"propagate": {"stop": stop}}
    _, mission = drives(placement, mapping=mapping, text=WALLED, start=(2, 2), goals=[(0, 0)], patience="2 s")
    assert not mission.reached
    assert "no way leads from (2, 2) to a goal" in mission.ended


def test_a_robot_that_does_not_know_that_it_is_walled_in(drives: Drives) -> None:
    """It finds out."""
    _, mission = drives(text=WALLED, start=(2, 2), goals=[(0, 0)], known="none", patience="2 s")
    assert not mission.reached
    assert "no way leads from" in mission.ended
    assert mission.shortest_m is None


def test_an_exploration_of_a_cell_with_walls_ends_well(drives: Drives) -> None:
    _, mission = drives(text=WALLED, start=(2, 2), goals=[(0, 0)], known="none", purpose="explore")
    assert mission.reached
    assert "explored" in mission.ended
    assert mission.known_share < 0.5


def test_a_goal_under_an_obstacle_from_the_start(drives: Drives) -> None:
    _, mission = drives(text=OPEN, **ENDS, hidden=[rectangle(10, 10)], patience="3 s")
    assert not mission.reached
    assert "goal (10, 10) is taken by an obstacle" in mission.ended
    assert mission.distance_m > 0.8, "it drives up to where it can see it"


def test_a_goal_that_is_taken_later(drives: Drives) -> None:
    obstacles = {"appearing": [rectangle(10, 10, at="2 s")]}
    _, mission = drives(text=OPEN, **ENDS, obstacles=obstacles, patience="3 s")
    assert not mission.reached
    assert "goal (10, 10) is taken by an obstacle" in mission.ended
    assert mission.contacts == 0


@pytest.mark.parametrize("placement", ["breadth-first", "harmonic", "wavefront", "relaxation"])
def test_a_goal_that_is_free_again_is_reached(drives: Drives, placement: str) -> None:
    obstacles = {"appearing": [rectangle(9, 9, 3, 3, at="1 s", until="12 s")]}
    _, mission = drives(placement, text=OPEN, **ENDS, obstacles=obstacles, patience="20 s")
    assert mission.reached, mission.ended
    assert mission.mission_time_s > 12.0


def test_of_two_goals_the_free_one_is_reached(drives: Drives) -> None:
    _, mission = drives(text=OPEN, goals=[(2, 8), (10, 10)], start=(1, 1), hidden=[rectangle(2, 8)])
    assert mission.reached


def test_a_tour_whose_second_goal_is_taken(drives: Drives) -> None:
    _, mission = drives(
        text=OPEN, goals=[(1, 6)], start=(1, 1), tour=[(10, 10)], hidden=[rectangle(10, 10)], patience="2 s"
    )
    assert (mission.reached, mission.goals_reached) == (False, 1)
    assert "goal (10, 10) is taken" in mission.ended


def test_the_start_is_the_goal(drives: Drives) -> None:
    _, mission = drives(text=OPEN, start=(1, 1), goals=[(1, 1)])
    assert mission.reached
    assert mission.distance_m == 0.0
    assert mission.mission_time_s < 1.0


# Links
