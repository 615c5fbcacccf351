"""A drive over links that are down, or with a sensor that sees nothing, ends for a stated reason."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from mission_specs import ENDS, OPEN, rectangle

from codesign.system import Result
from codesign.system.results.mission import Mission

Drives = Callable[..., tuple[Result, Mission]]

LINKS = ["pci", "uart"]


def down(link: str, *spans: dict[str, str]) -> dict[str, Any]:
    return {"links": {link: {"outages": list(spans)}}}


@pytest.mark.parametrize("placement", ["breadth-first", "harmonic-decide-on-host", "harmonic-warm"])
@pytest.mark.parametrize("link", LINKS)
@pytest.mark.parametrize("begin", ["0 s", "1500 ms"])
def test_a_link_that_is_down_for_good(drives: Drives, placement: str, link: str, begin: str) -> None:
    result, mission = drives(
        placement, platform=down(link, {"begin": begin}), text=OPEN, **ENDS, known="none", patience="2 s"
    )
    assert result.links is not None
    use = result.links[link]
    if mission.reached:
        # Who has its plan already needs the FPGA no more.
        assert (link, begin) == ("pci", "1500 ms")
        return
    assert f"{link}: message" in mission.ended
    assert "link down" in mission.ended
    assert use.dropped["link down"] > 0
    assert use.in_flight == 0
    assert mission.mission_time_s < 12.0
    if begin == "0 s":
        assert mission.distance_m == 0.0
        assert mission.plans == 0


@pytest.mark.parametrize("link", LINKS)
def test_a_link_that_is_down_for_a_while(drives: Drives, link: str) -> None:
    spans = {"begin": "0 s", "end": "1 s"}, {"begin": "2 s", "end": "4 s"}
    result, mission = drives(platform=down(link, *spans), text=OPEN, **ENDS, known="none")
    assert mission.reached
    assert mission.missed_deadlines > 0 or link == "pci"
    assert mission.mission_time_s > 5.0 or link == "pci"
    assert result.links is not None
    assert result.links[link].queued_s > 0.5


def test_a_link_that_drops_nearly_all(drives: Drives) -> None:
    errors = {"drop": 0.97, "retries": 0, "seed": 1}
    _, mission = drives(
        platform={"links": {"uart": {"errors": errors}}}, text=OPEN, **ENDS, known="none", patience="4 s"
    )
    assert mission.reached or "uart: message" in mission.ended


# The sensor


@pytest.mark.parametrize("kind", ["rays", "radius"])
def test_a_sensor_that_sees_nothing(drives: Drives, kind: str) -> None:
    """In a map that it knows the robot drives; in one that it does not it stands, and says so."""
    blind = {"type": kind, "range": "0 m"} | ({"rays": 8} if kind == "rays" else {})
    platform = {"components": {"robot": {"sensor": {"=": blind}}}}
    _, known = drives(platform=platform, text=OPEN, **ENDS)
    assert known.reached
    _, unknown = drives(platform=platform, text=OPEN, **ENDS, known="none", patience="2 s")
    assert not unknown.reached
    assert "was never seen to be free" in unknown.ended
    assert unknown.distance_m < 0.1
    _, explored = drives(platform=platform, text=OPEN, **ENDS, known="none", purpose="explore")
    assert explored.known_share == 0.0
    assert explored.distance_m == 0.0


def test_a_blind_robot_stands_before_what_it_does_not_know(drives: Drives) -> None:
    platform = {"components": {"robot": {"sensor": {"range": "0 m"}}}}
    _, mission = drives(
        platform=platform, text=OPEN, start=(5, 1), goals=[(5, 10)], hidden=[rectangle(0, 5, 16, 1)], patience="2 s"
    )
    assert not mission.reached
    assert mission.contacts == 1
    assert mission.ended != ""


# Deadlines and watchdogs
