"""Whatever goes wrong, a drive ends for a stated reason, soon, and its trace is whole up to there."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result as Invoked
from mission_specs import ENDS, IDEAL, OPEN, POINT, SECOND, Ground, rectangle

import codesign
from codesign.records import MissionRecord, PoseRecord, SummaryRecord
from codesign.results.mission import Mission
from codesign.system import Result
from codesign.verdicts import RunDocument

WALLED = "\n".join(
    ["." * 16, ".####...........", *[".#..#..........."] * 2, ".####...........", *["." * 16] * 11, ""]
)

Hwsw = Callable[..., Invoked]
Drives = Callable[..., tuple[Result, Mission]]


@pytest.fixture(autouse=True)
def bounded() -> Iterator[None]:
    """No case takes longer than a minute of wall time: none hangs."""

    def give_up(*_: object) -> None:
        raise TimeoutError("the drive hangs")

    before = signal.signal(signal.SIGALRM, give_up)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture
def drives(tmp_path: Path, hwsw: Hwsw) -> Drives:
    """Run a drive from the command line, look into its trace, and give its result."""

    def run(placement: str = "breadth-first", **settings: Any) -> tuple[Result, Mission]:
        files = Ground(tmp_path).files(placement, **settings)
        trace = tmp_path / "drive.mcap"
        done = hwsw("run", *files, "--trace", trace, "--json")
        assert done.exit_code == 0, done.output[:500]
        result = RunDocument.model_validate(json.loads(done.stdout))
        mission = result.mission
        assert mission is not None
        assert mission.ended
        opened = codesign.open_trace(trace)
        assert opened.complete
        records = list(opened.records())
        (summary,) = [record for record in records if isinstance(record, SummaryRecord)]
        beside = {"provenance", "intervals", "fit"}
        printed = {key: value for key, value in result.model_dump(mode="json").items() if key not in beside}
        assert {key: value for key, value in summary.result.items() if key not in beside} == printed
        end = round(mission.mission_time_s * SECOND)
        assert summary.time == max(record.time for record in records) == end
        last = [record for record in records if isinstance(record, MissionRecord)][-1]
        assert (last.time, last.event, last.text) == (end, "ended", mission.ended)
        poses = [record for record in records if isinstance(record, PoseRecord)]
        assert len(poses) in {mission.turns, mission.turns + 1}
        return result, mission

    return run


# No way


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
        platform=platform,
        text=OPEN,
        start=(5, 1),
        goals=[(5, 10)],
        hidden=[rectangle(0, 5, 16, 1)],
        patience="2 s",
    )
    assert not mission.reached
    assert mission.contacts == 1
    assert mission.ended != ""


# Deadlines and watchdogs


def test_a_deadline_of_zero_with_links_that_take_no_time(drives: Drives) -> None:
    _, mission = drives(platform=[IDEAL, POINT], text=OPEN, **ENDS, deadline="0 s")
    assert mission.reached
    assert mission.missed_deadlines == 0


def test_a_deadline_of_zero_with_links_as_they_are(drives: Drives) -> None:
    """Every turn is late: the robot brakes at each, and creeps on with each late command, or says why it stands."""
    _, mission = drives(text=OPEN, **ENDS, deadline="0 s", limit="30 s", patience="5 s")
    assert mission.missed_deadlines >= mission.turns - 2
    assert mission.reached or "no answer within 0 s" in mission.ended


def test_the_limit_on_simulated_time(drives: Drives) -> None:
    _, mission = drives(text=OPEN, **ENDS, limit="1234567 us")
    assert mission.mission_time_s == 1.234567
    assert "limit of 1.23457 s of simulated time" in mission.ended


def test_a_limit_of_zero(drives: Drives) -> None:
    _, mission = drives(text=OPEN, **ENDS, limit="0 s")
    assert mission.mission_time_s == 0.0
    assert not mission.reached
    assert "limit" in mission.ended


@pytest.mark.parametrize("events", [1, 7, 200])
def test_the_limit_on_events(drives: Drives, events: int) -> None:
    _, mission = drives(text=OPEN, **ENDS, events=events)
    assert f"limit of {events} events" in mission.ended
    assert not mission.reached


def test_patience_of_zero(drives: Drives) -> None:
    _, mission = drives(text=OPEN, **ENDS, patience="0 s")
    assert not mission.reached
    assert "stood for 0 s" in mission.ended


def test_patience_is_not_spent_while_a_plan_is_under_way(drives: Drives) -> None:
    """A plan may take longer than the patience of a robot that has no way."""
    _, mission = drives(
        platform={"components": {"fpga": {"clock": "100 Hz"}}},
        text=OPEN,
        **ENDS,
        patience="1 s",
        limit="5 min",
    )
    assert mission.reached, mission.ended
    assert mission.waiting_s > 2.0


def test_a_plan_that_outlasts_the_mission(drives: Drives) -> None:
    result, mission = drives(
        "harmonic", platform={"components": {"fpga": {"clock": "10 Hz"}}}, text=OPEN, **ENDS, limit="20 s"
    )
    assert mission.mission_time_s == 20.0
    assert mission.plans == 0
    assert result.time is None
    assert mission.waiting_s == pytest.approx(20.0, abs=0.1)
    assert mission.bottleneck is not None
    assert mission.bottleneck.name == "fpga"
    assert mission.account["fpga"].compute_s == pytest.approx(20.0, abs=0.2)


@pytest.mark.parametrize("period", ["1 us", "10 ms", "100 s"])
def test_periods_far_off(drives: Drives, period: str) -> None:
    """Turns that are longer than their period, or the mission."""
    _, mission = drives(
        platform=IDEAL,
        text=OPEN,
        **ENDS,
        control_period=period,
        limit="300 s",
        patience="250 s",
        events=2_000 if period == "1 us" else 100_000,
    )
    assert mission.reached or "events" in mission.ended
    assert mission.reached or period == "1 us"


# Odd, and well


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
    _, mission = drives(
        "harmonic", text=text, start=(0, 0), goals=[(14, 15)], mapping=mapping, patience="2 s"
    )
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
    mapping = {
        "load": {"component": "fpga"},
        "command": {"component": "fpga"},
        "display": {"component": "host"},
    }
    result, mission = drives(text=OPEN, **ENDS, mapping=mapping)
    assert mission.reached
    assert result.links is not None
    assert result.links["pci"].delivered >= 2 * (mission.turns - 2)
    assert result.utilisation is not None
    assert result.utilisation["host"] == 0.0
