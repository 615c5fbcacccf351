"""Robots, maps and fields at the edge of what can be driven end for a stated reason."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from mission_specs import ENDS, OPEN, rectangle

from codesign.system import Result
from codesign.system.results.mission import Mission

Drives = Callable[..., tuple[Result, Mission]]


def test_a_robot_that_does_not_fit_through(drives: Drives) -> None:
    """A gap of one cell, which a point passes."""
    gap = "\n".join(["." * 15] * 5 + ["#######.#######"] + ["." * 15] * 5) + "\n"
    ends: dict[str, Any] = {"start": (2, 7), "goals": [(8, 7)], "text": gap, "patience": "2 s"}
    _, point = drives(**ends)
    assert point.reached
    _, wide = drives(**ends, platform={"components": {"robot": {"radius": "0.12 m"}}})
    assert not wide.reached
    assert "no way leads from (2, 7) to a goal" in wide.ended


def test_a_field_too_coarse_to_lead_to_the_goal(drives: Drives) -> None:
    """A corridor to and fro: at 15 bits the potential is flat at its far end."""
    rows = ["." * 16, "#" * 15 + ".", "." * 16, "." + "#" * 15]
    text = "\n".join([*rows * 4, ""])
    mapping = {"relax": {"schedule": {"=": [15]}}}
    _, mission = drives("harmonic", text=text, start=(0, 0), goals=[(14, 15)], mapping=mapping, patience="2 s")
    assert not mission.reached
    assert "the plan's way ends at" in mission.ended
    assert "short of the goal" in mission.ended


def test_an_obstacle_that_would_bury_the_robot_waits(drives: Drives) -> None:
    obstacles = {"appearing": [rectangle(0, 0, 16, 16, at="1 s")]}
    _, mission = drives(text=OPEN, **ENDS, obstacles=obstacles)
    assert mission.reached
    assert mission.contacts == 0


def test_a_tour_over_the_same_cells(drives: Drives) -> None:
    _, mission = drives(text=OPEN, start=(1, 1), goals=[(1, 2)], tour=[[1, 1], [1, 1], [1, 2], [1, 2]])
    assert mission.reached
    assert mission.goals_reached == 5
    # Half a cell from the middle of the first; the cells lie side by side.
    assert mission.shortest_m == pytest.approx(0.05)
    assert mission.distance_ratio is not None
    assert mission.distance_ratio >= 1.0
    assert mission.distance_m == pytest.approx(0.3, abs=0.11)


def test_a_map_of_one_cell(drives: Drives) -> None:
    one: dict[str, Any] = {"text": ".\n", "start": (0, 0), "goals": [(0, 0)]}
    _, reach = drives(**one)
    _, explored = drives(**one, known="none", purpose="explore")
    assert reach.reached
    assert explored.reached
    assert explored.known_share == 1.0


def test_late_messages_stop_the_robot_and_the_limit_ends_it(drives: Drives) -> None:
    """Every second scan or command comes 5 s late: stale authority never moves the robot for longer than a turn."""
    errors = {"late": {"share": 0.5, "delay": "5 s"}}
    result, mission = drives(
        platform={"links": {"uart": {"errors": errors}}}, text=OPEN, **ENDS, known="none", limit="20 s"
    )
    assert result.links is not None
    assert result.links["uart"].late > 0
    assert mission.missed_deadlines > 0
    assert mission.reached or "limit of 20 s" in mission.ended
    assert mission.contacts == 0


def test_tasks_of_a_drive_on_the_fpga(drives: Drives) -> None:
    """Load and command in the fabric: the host does nothing, and messages pass it by two links."""
    mapping = {"load": {"component": "fpga"}, "command": {"component": "fpga"}, "display": {"component": "host"}}
    result, mission = drives(text=OPEN, **ENDS, mapping=mapping)
    assert mission.reached
    assert result.links is not None
    assert result.links["pci"].delivered >= 2 * (mission.turns - 2)
    assert result.utilisation is not None
    assert result.utilisation["host"] == 0.0
