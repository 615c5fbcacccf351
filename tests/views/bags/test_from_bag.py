"""Recorded bags as workloads: independent bags, made with the library's own types, and bags of runs."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bag_missions import cells_of, messages_of, write_mission, yard
from click.testing import Result

pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'hwsw-codesign[ros2]'")

from recorded_bags import CRATE, CRATE_TIMES, GOALS, ORIGIN, SIDE, Hall, hall, record

import codesign
from codesign.ground.records import GoalRecord
from codesign.maps import read_map
from codesign.views.bags import BagFacts, Choices, Rule, Topics, facts_of, read_bag
from codesign.views.bags.obstacles import Appeared
from codesign.views.bags.recording import Series, poses
from codesign.views.trace import MemoryListener

SHORT = Hall(seconds=90.0, rays=180)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("bags") / "hall", SHORT)


@pytest.fixture(scope="module")
def facts(bag: Path) -> BagFacts:
    return facts_of(read_bag(bag, Topics()), Choices())


def covered(obstacles: tuple[Appeared, ...], time: float) -> set[tuple[int, int]]:
    """The cells that are obstacles at a time."""
    return {
        (row, column)
        for each in obstacles
        if each.at <= time and (each.until is None or time < each.until)
        for row in range(each.row, each.row + each.rows)
        for column in range(each.column, each.column + each.columns)
    }


def test_goals_have_their_cells_and_times(facts: BagFacts) -> None:
    frame = facts.map.frame
    assert facts.begin == pytest.approx(1.0)
    assert [each.cell for each in facts.goals[:6]] == [frame.cell(*goal) for goal in GOALS]
    assert facts.start == frame.cell(0.0, 0.0)
    for each in facts.goals:
        assert each.answered is not None
        assert each.answered - each.time == pytest.approx(0.12, abs=1e-6)
        assert each.plans == 1
    first = facts.goals[0]
    assert first.reached == pytest.approx(0.2 + (2.5 - 0.3) / 0.5, abs=0.11)


def test_figures_are_those_of_the_topics(facts: BagFacts) -> None:
    assert facts.reach.value == pytest.approx(3.5)
    assert facts.rays.value == 180
    assert facts.view.value == pytest.approx(2 * math.pi, abs=1e-5)
    assert facts.period.value == pytest.approx(0.05, abs=1e-6)
    assert facts.speed.value == pytest.approx(0.5)
    assert "/cmd_vel" in facts.period.source
    assert facts.remarks == ()


def test_the_crate_is_the_only_obstacle_while_it_stands(facts: BagFacts) -> None:
    """The laser is turned by half a turn, and map, odometry and robot have frames of their own."""
    frame = facts.map.frame
    rim = set()
    for x in np.arange(CRATE[0], CRATE[2], SIDE) + SIDE / 2:
        rim |= {frame.cell(x, CRATE[1] + 0.01), frame.cell(x, CRATE[3] - 0.01)}
    for y in np.arange(CRATE[1], CRATE[3], SIDE) + SIDE / 2:
        rim |= {frame.cell(CRATE[0] + 0.01, y), frame.cell(CRATE[2] - 0.01, y)}
    stands = covered(facts.obstacles.obstacles, 55.0)
    assert len(stands & rim) >= 0.7 * len(rim)
    near = {(row + down, column + right) for row, column in rim for down in (-1, 0, 1) for right in (-1, 0, 1)}
    assert stands <= near
    assert covered(facts.obstacles.obstacles, CRATE_TIMES[0] - facts.begin - 1.0) == set()
    assert covered(facts.obstacles.obstacles, 88.0) == set()


def test_a_longer_margin_and_more_hits_leave_obstacles_out(bag: Path) -> None:
    recording = read_bag(bag, Topics())
    none = facts_of(recording, Choices(rule=Rule(least=10**6)))
    assert none.obstacles.obstacles == ()
    assert none.obstacles.hits > 0
    far = facts_of(recording, Choices(rule=Rule(margin=5.0)))
    assert far.obstacles.hits == 0
    gone = facts_of(recording, Choices(rule=Rule(stay=2.0)))
    assert all(each.until is not None for each in gone.obstacles.obstacles)


def test_the_command_writes_files_that_run(hwsw: Callable[..., Result], bag: Path) -> None:
    done = hwsw("workload", "from-bag", bag, "-o", "made", "--on", "virtex2pro")
    assert done.exit_code == 0, done.output
    assert "virtex2pro answers" in done.output
    made = Path("made")
    assert sorted(path.name for path in made.iterdir()) == [
        "hall-goals.csv", "hall-map.pgm", "hall-map.yaml", "hall.yaml",
    ]  # fmt: skip
    grid = read_map(made / "hall-map.yaml")
    assert grid.unknown is not None
    values = np.where(grid.free, 0, np.where(grid.unknown, -1, 100))
    np.testing.assert_array_equal(values, hall()[::-1])
    assert grid.origin == (*ORIGIN, 0.0)
    assert grid.resolution == SIDE
    text = (made / "hall.yaml").read_text()
    for source in ("/goal_pose", "/tf and /odom", "/cmd_vel", "/scan", "/odom", "as in workload warehouse"):
        assert source in text
    rows = list(csv.DictReader((made / "hall-goals.csv").read_text().splitlines()))
    assert [row["answered_after_s"] for row in rows] == ["0.120000"] * len(rows)
    checked = hwsw("check", "virtex2pro", made / "hall.yaml")
    assert checked.exit_code == 0, checked.output
    again = hwsw("workload", "from-bag", bag, "-o", "made")
    assert again.exit_code == 2
    assert "exists already" in again.output


def test_a_run_exported_and_made_a_workload_reaches_the_same_goals(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    platform, workload = write_mission(tmp_path)
    done = hwsw("run", platform, workload, "--no-levers", "--ros2", "first")
    assert done.exit_code == 0, done.output
    done = hwsw("workload", "from-bag", "first", "-o", "made", "--like", workload)
    assert done.exit_code == 0, done.output
    done = hwsw("run", platform, "made/first.yaml", "--no-levers", "--ros2", "second")
    assert done.exit_code == 0, done.output
    assert "all goals" in done.output
    maps = [cells_of(messages_of(Path(name), ["/map"])["/map"][0][1]) for name in ("first", "second")]
    np.testing.assert_array_equal(*maps)
    np.testing.assert_array_equal(maps[0], yard())
    goals = [
        [(goal.pose.position.x, goal.pose.position.y) for _, goal in messages_of(Path(name))["/goal_pose"]]
        for name in ("first", "second")
    ]
    assert len(goals[0]) == 3
    np.testing.assert_allclose(*goals)
    # The obstacle that the robot did not know is found again.
    truth = cells_of(messages_of(Path("second"), ["/true_map"])["/true_map"][0][1])
    assert (truth[15:18, 20] == 100).any()
    records = MemoryListener()
    result = codesign.simulate(platform, "made/first.yaml", listeners=[records])
    assert result.mission is not None
    assert result.mission.reached
    assert [each.cells.tolist() for each in records.of(GoalRecord)] == [[[3, 26]], [[16, 26]], [[16, 3]]]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_storages_give_the_same(storage: str, tmp_path: Path, facts: BagFacts) -> None:
    other = facts_of(read_bag(record(tmp_path / "hall", SHORT, storage), Topics()), Choices())
    assert (other.goals, other.obstacles, other.start) == (facts.goals, facts.obstacles, facts.start)
    file = next(path for path in (tmp_path / "hall").iterdir() if path.suffix in (".mcap", ".db3"))
    alone = facts_of(read_bag(file, Topics()), Choices())
    assert (alone.goals, alone.obstacles) == (facts.goals, facts.obstacles)


def test_stamps_of_another_clock_are_put_on_that_of_the_bag(tmp_path: Path, facts: BagFacts) -> None:
    late = facts_of(read_bag(record(tmp_path / "hall", replace(SHORT, late=1.6e9)), Topics()), Choices())
    assert [each.cell for each in late.goals] == [each.cell for each in facts.goals]
    assert any("from that of the bag" in remark for remark in late.remarks)
    # The stamps have 0.2 us at this distance.
    assert len(late.obstacles.obstacles) == pytest.approx(len(facts.obstacles.obstacles), abs=4)


@pytest.mark.parametrize(
    ("skip", "source", "remark"),
    [
        ({"/odom"}, "steps of /tf", None),
        ({"/tf"}, "/odom", "no transform leads from map"),
        ({"/goal_pose"}, "/odom", "the last points of /plan are the goals"),
        ({"/goal_pose", "/plan"}, "/odom", "the last place of the robot is the goal"),
        ({"/cmd_vel"}, "/odom", None),
        ({"/scan"}, "/odom", None),
    ],
    ids=lambda value: "+".join(sorted(value)).replace("/", "") if isinstance(value, set) else "",
)
def test_a_bag_without_a_topic_gives_what_it_can(
    tmp_path: Path, skip: set[str], source: str, remark: str | None
) -> None:
    made = facts_of(read_bag(record(tmp_path / "hall", replace(SHORT, skip=frozenset(skip))), Topics()), Choices())
    assert source in made.speed.source
    assert made.speed.value == pytest.approx(0.5, rel=0.1)
    assert remark is None or any(remark in each for each in made.remarks)
    if "/cmd_vel" in skip:
        assert made.period.value == pytest.approx(0.1)
        assert "/scan" in made.period.source
    if "/scan" in skip:
        assert (made.obstacles.obstacles, made.reach.value) == ((), None)


def test_without_robot_and_scans_plans_give_start_and_goals(tmp_path: Path) -> None:
    quiet = replace(SHORT, skip=frozenset({"/odom", "/tf", "/tf_static", "/scan", "/cmd_vel"}))
    made = facts_of(read_bag(record(tmp_path / "hall", quiet), Topics()), Choices())
    assert made.start == made.map.frame.cell(0.0, 0.0)
    assert made.period.value is None
    assert all(each.reached is None and each.toured for each in made.goals)


def test_names_of_topics_are_options(hwsw: Callable[..., Result], bag: Path) -> None:
    done = hwsw("workload", "from-bag", bag, "--scan-topic", "none", "--command-topic", "none", "--name", "quiet")
    assert done.exit_code == 0, done.output
    text = Path("quiet.yaml").read_text()
    assert "control_period: 50 ms # median step of 1,800 messages of /odom" in text
    assert "show no obstacle" in text


def test_turns_between_messages_are_interpolated_in_the_short_direction() -> None:
    """q and -q are one turn: a publisher may change the sign at any time."""
    half = math.pi / 8
    turn = np.array([0.0, 0.0, math.sin(half), math.cos(half)])
    series = Series(np.array([0.0, 1.0]), np.zeros((2, 3)), np.array([[0.0, 0.0, 0.0, 1.0], -turn]))
    found = poses({("map", "base"): series}, [("map", "base")], np.array([0.5]))
    assert found.yaws[0] == pytest.approx(half, abs=0.01)


def test_a_goal_that_was_replaced_is_left_out(tmp_path: Path) -> None:
    recording = read_bag(record(tmp_path / "hall", SHORT), Topics())
    first = recording.goals[0]
    recording.goals.insert(0, replace(first, time=first.time - 0.5, place=(5.5, 4.5, 0.0)))
    made = facts_of(recording, Choices())
    assert not made.goals[0].toured
    assert made.toured[0] == made.goals[1].cell
    assert any("goal 1 was replaced" in remark for remark in made.remarks)
