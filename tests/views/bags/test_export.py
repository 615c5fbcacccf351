"""Runs as ROS 2 bags: the library reads them, the map is that of map_server, and places lie where the run has them."""

from __future__ import annotations

import math
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bag_missions import ORIGIN, cells_of, messages_of, write_mission, yard
from click.testing import Result
from places import ROOT, SHARED

pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'hwsw-codesign[ros2]'")

import codesign
from codesign.ground.records import CommandRecord, MapRecord, PoseRecord, PositionsRecord, Record, TrajectoryRecord
from codesign.maps import read_map
from codesign.views.bags import BagListener
from codesign.views.trace import MemoryListener

MAPS = [*(ROOT / "workloads" / "maps").glob("*.yaml"), *(SHARED / "maps" / "ros").glob("*/*.yaml")]
TOPICS = {
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/belief": "nav_msgs/msg/OccupancyGrid",
    "/true_map": "nav_msgs/msg/OccupancyGrid",
    "/plan": "nav_msgs/msg/Path",
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/scan": "sensor_msgs/msg/LaserScan",
    "/goal_pose": "geometry_msgs/msg/PoseStamped",
    "/rosout": "rcl_interfaces/msg/Log",
}


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Record]]:
    """The bag of the small mission, and its records."""
    folder = tmp_path_factory.mktemp("mission")
    platform, workload = write_mission(folder)
    records = MemoryListener()
    with BagListener(folder / "bag") as bag:
        result = codesign.simulate(platform, workload, listeners=[records, bag])
    assert result.mission is not None
    assert result.mission.reached
    return folder / "bag", records.records


def test_the_bag_has_every_topic_with_its_type(mission: tuple[Path, list[Record]]) -> None:
    from rosbags.rosbag2 import Reader

    with Reader(mission[0]) as reader:
        assert {each.topic: each.msgtype for each in reader.connections} == TOPICS
        durability = {each.topic: each.ext.offered_qos_profiles[0].durability.name for each in reader.connections}
        assert reader.message_count == sum(each.msgcount for each in reader.connections)
    latched = {topic for topic, name in durability.items() if name == "TRANSIENT_LOCAL"}
    assert latched == {"/map", "/belief", "/true_map", "/tf_static"}


def test_the_map_is_that_of_map_server_at_its_origin(mission: tuple[Path, list[Record]]) -> None:
    ((time, grid),) = messages_of(mission[0], ["/map"])["/map"]
    assert time == 0
    assert grid.header.frame_id == "map"
    np.testing.assert_array_equal(cells_of(grid), yard())  # without the obstacle that the robot does not know
    origin = grid.info.origin
    assert (origin.position.x, origin.position.y) == ORIGIN[:2]
    assert 2 * math.atan2(origin.orientation.z, origin.orientation.w) == pytest.approx(ORIGIN[2])
    assert grid.info.resolution == np.float32(0.1)


def test_poses_agree_with_the_records(mission: tuple[Path, list[Record]]) -> None:
    bag, records = mission
    found = messages_of(bag)
    poses = [record for record in records if isinstance(record, PoseRecord)]
    assert len(poses) == len(found["/odom"]) == len(found["/tf"]) == len(found["/scan"])
    frame = read_map(bag.parent / "yard-map.yaml").frame
    assert frame is not None
    for record, (time, odom), (_, tf) in zip(poses, found["/odom"], found["/tf"], strict=True):
        assert time == record.time // 1000 == odom.header.stamp.sec * 10**9 + odom.header.stamp.nanosec
        place, moved = odom.pose.pose.position, tf.transforms[0].transform.translation
        assert (place.x, place.y) == (moved.x, moved.y) == frame.point(record.row, record.column)
        turn = odom.pose.pose.orientation
        yaw = 2 * math.atan2(turn.z, turn.w)
        assert math.cos(yaw - (ORIGIN[2] - record.heading)) == pytest.approx(1.0)
        assert odom.twist.twist.linear.x == record.speed


def test_scans_meet_the_obstacles_of_the_true_map(mission: tuple[Path, list[Record]]) -> None:
    found = messages_of(mission[0])
    grid = found["/map"][0][1]
    free = cells_of(grid) == 0
    frame = read_map(mission[0].parent / "yard-map.yaml").frame
    assert frame is not None
    hits = hidden = beside = 0
    for (_, scan), (_, odom) in zip(found["/scan"], found["/odom"], strict=True):
        turn, place = odom.pose.pose.orientation, odom.pose.pose.position
        angles = scan.angle_min + np.arange(len(scan.ranges)) * scan.angle_increment + 2 * math.atan2(turn.z, turn.w)
        met = np.isfinite(scan.ranges)
        assert (scan.ranges[met] <= scan.range_max * (1 + 1e-6)).all()
        for angle, length in zip(angles[met], scan.ranges[met], strict=True):
            behind = float(length) + 1e-3
            row, column = frame.cell(place.x + behind * math.cos(angle), place.y + behind * math.sin(angle))
            known = free[min(max(row, 0), 19), min(max(column, 0), 29)]
            there = (column == 20 and 15 <= row < 18) or (2 <= row < 5 and 15 <= column < 17)
            hits += 1
            hidden += bool(known and there)
            beside += bool(known and not there)
    assert hidden > 100
    # A ray that grazes a corner may come out behind it.
    assert beside < 0.005 * hits


def test_goals_and_plans_follow_each_other(mission: tuple[Path, list[Record]]) -> None:
    found = messages_of(mission[0])
    frame = read_map(mission[0].parent / "yard-map.yaml").frame
    assert frame is not None
    goals = [frame.cell(goal.pose.position.x, goal.pose.position.y) for _, goal in found["/goal_pose"]]
    assert goals == [(3, 26), (16, 26), (16, 3)]
    for index, (time, _) in enumerate(found["/goal_pose"]):
        plan = next(plan for at, plan in found["/plan"] if at >= time)
        last = plan.poses[-1].pose.position
        assert frame.cell(last.x, last.y) == goals[index]
    texts = [line.msg for _, line in found["/rosout"]]
    assert texts[-1].startswith("ended: all goals are reached")


def test_the_belief_ends_with_what_the_robot_met(mission: tuple[Path, list[Record]]) -> None:
    found = messages_of(mission[0])
    begin, end = (cells_of(found["/belief"][index][1]) for index in (0, -1))
    np.testing.assert_array_equal(begin, yard())
    assert (end[15:18, 20] == 100).any()
    truth = cells_of(found["/true_map"][0][1])
    assert (truth[15:18, 20] == 100).all()


def test_run_and_export_write_the_same_bytes(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    platform, workload = write_mission(tmp_path)
    done = hwsw("run", platform, workload, "--no-levers", "--trace", "run.mcap", "--ros2", "bag")
    assert done.exit_code == 0, done.output
    assert "bag: bag" in done.output
    (tmp_path / "again").mkdir()
    done = hwsw("trace", "export", "run.mcap", "--ros2", "again/bag")
    assert done.exit_code == 0, done.output
    for name in ("bag.mcap", "metadata.yaml"):
        assert (tmp_path / "bag" / name).read_bytes() == (tmp_path / "again" / "bag" / name).read_bytes()
    later = hwsw("trace", "export", "run.mcap", "--ros2", "later", "--ros2-begin", "1700000000")
    assert later.exit_code == 0, later.output
    times = [[time for time, _ in messages_of(tmp_path / name, ["/odom"])["/odom"]] for name in ("bag", "later")]
    assert [time + 1_700_000_000 * 10**9 for time in times[0]] == times[1]
    assert not [path for path in tmp_path.iterdir() if path.name.endswith(".part")]


@pytest.mark.skipif(not MAPS, reason="no maps of map_server lie here")
@pytest.mark.parametrize("path", MAPS, ids=lambda path: path.stem)
def test_cells_are_those_of_map_server(path: Path, tmp_path: Path) -> None:
    """The rule of nav2_map_server for ``trinary``, written again with Pillow."""
    import yaml
    from PIL import Image

    about = yaml.safe_load(path.read_text())
    pixels = np.asarray(Image.open(path.parent / about["image"]).convert("L"), np.float64)
    shade = pixels / 255 if about["negate"] else (255 - pixels) / 255
    expected = np.full(shade.shape, -1)
    expected[shade > about["occupied_thresh"]] = 100
    expected[shade < about["free_thresh"]] = 0
    grid = read_map(path)
    assert grid.origin is not None
    goals, origin = np.zeros((0, 2), np.int32), np.array(grid.origin)
    with BagListener(tmp_path / "bag") as bag:
        bag(MapRecord(0, "map", grid.free, goals, grid.resolution, 0, 0, origin, unknown=grid.unknown))
    ((_, message),) = messages_of(tmp_path / "bag", ["/map"])["/map"]
    np.testing.assert_array_equal(cells_of(message), expected)
    assert (message.info.origin.position.x, message.info.origin.position.y) == tuple(about["origin"][:2])
    assert message.info.resolution == np.float32(about["resolution"])


def test_the_robots_of_a_fleet_have_a_namespace_each(tmp_path: Path) -> None:
    with BagListener(tmp_path / "bag") as bag:
        bag(MapRecord(0, "map", np.ones((8, 8), bool), np.array([[0, 7], [7, 0]], np.int32), 0.5))
        bag(PositionsRecord(0, "fleet", 0, np.array([[0.0, 0.0], [7.0, 7.0]])))
        bag(PositionsRecord(10**12, "fleet", 1, np.array([[0.0, 1.0], [6.0, 7.0]])))
        bag(TrajectoryRecord(10**12, "robot_0", np.array([[0.0, 0.0], [0.0, 1.0]]), False))
    found = messages_of(tmp_path / "bag")
    assert {"/robot_0/odom", "/robot_1/odom", "/robot_0/goal_pose", "/robot_1/goal_pose", "/robot_0/path"} <= set(found)
    first, second = (found[f"/robot_{robot}/odom"][1][1] for robot in (0, 1))
    assert (first.header.frame_id, first.child_frame_id) == ("robot_0/odom", "robot_0/base_link")
    assert first.twist.twist.linear.x == pytest.approx(0.5)
    turns = [2 * math.atan2(each.pose.pose.orientation.z, each.pose.pose.orientation.w) for each in (first, second)]
    assert turns == pytest.approx([0.0, math.pi / 2])
    assert [len(message.transforms) for _, message in found["/tf"]] == [2, 2]


def test_a_plan_of_a_map_has_its_goal_and_paths(hwsw: Callable[..., Result], specs: tuple[Path, Path]) -> None:
    done = hwsw("run", *specs, "--ros2", "bag", "-q")
    assert done.exit_code == 0, done.output
    found = messages_of(Path("bag"))
    assert set(found) == {"/map", "/true_map", "/goal_pose", "/plan"}
    assert len(found["/goal_pose"]) == 1


def test_a_design_that_does_not_fit_leaves_no_bag(hwsw: Callable[..., Result], specs: tuple[Path, Path]) -> None:
    done = hwsw("run", *specs, "--set", "fpga.part=XC3S500E-4", "--set", "relax.block=[24, 36]", "--ros2", "bag")
    assert done.exit_code == 3, done.output
    assert "bag: bag is not written" in done.output
    assert not Path("bag").exists()


def test_a_broken_run_leaves_nothing(tmp_path: Path) -> None:
    def broken() -> None:
        with BagListener(tmp_path / "bag") as bag:
            bag(PoseRecord(0, "robot", 0.0, 0.0, 0.0, 0.0))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        broken()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("kind", ["file", "full", "no folder"])
def test_a_bag_that_cannot_be_written_is_refused_at_once(hwsw: Callable[..., Result], kind: str) -> None:
    Path("there").mkdir()
    Path("there/file").write_text("x")
    target = {"file": "there/file", "full": "there", "no folder": "absent/bag"}[kind]
    done = hwsw("run", "virtex2-pci", "labyrinth", "--ros2", target)
    assert done.exit_code == 2
    assert f"--ros2 {target}: " in done.output
    assert "hint: " in done.output


def test_a_full_disk_is_an_error_and_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from rosbags.rosbag2.storage_mcap import McapWriter

    from codesign.ground.errors import RunError

    def full(*_arguments: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(McapWriter, "close_chunk", full)
    what = "cannot be written: No space left on device"
    with pytest.raises(RunError, match=what), BagListener(tmp_path / "bag") as bag:
        bag(PoseRecord(0, "robot", 0.0, 0.0, 0.0, 0.0))
    assert list(tmp_path.iterdir()) == []


def test_records_from_elsewhere_do_no_harm(tmp_path: Path) -> None:
    """Cells outside of the map, paths without points and texts of any kind, as a trace of another program may have."""
    from codesign.ground.records import BeliefRecord, GoalRecord, MissionRecord, ObstacleRecord, RobotRecord

    outside = np.array([[99, 99]], np.int32)
    with BagListener(tmp_path / "bag") as bag:
        bag(MapRecord(0, "map", np.ones((4, 4), bool), outside, 0.5, unknown=np.ones((2, 2), bool)))
        bag(RobotRecord(0, "robot", 0.1, 0.5, 2.0, 8, outside, True))
        bag(GoalRecord(0, "robot", outside))
        bag(ObstacleRecord(1, "map", outside, True))
        bag(BeliefRecord(1, "robot", outside, np.array([True])))
        bag(TrajectoryRecord(2, "robot", np.zeros((0, 2)), False))
        bag(MissionRecord(3, "\x1b[31m", "no_way", "\x00" * 10 + "é" * 10_000))
        bag(CommandRecord(4, "robot", 1, 0, 0, np.zeros((0, 2)), 0.0))
        bag(PoseRecord(4, "robot", 99.0, 99.0, 0.0, 0.0))
    assert len(messages_of(tmp_path / "bag")["/scan"]) == 1


def test_without_the_library_the_command_to_install_it_is_named(
    hwsw: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    for command in (("run", "virtex2-pci", "labyrinth", "--ros2", "bag"), ("workload", "from-bag", ".")):
        done = hwsw(*command)
        assert done.exit_code == 1
        assert "pip install 'hwsw-codesign[ros2]'" in done.output


@pytest.mark.skipif(shutil.which("rerun") is None, reason="rerun is not installed: pip install rerun-sdk")
def test_rerun_decodes_grids_transforms_goals_and_log(mission: tuple[Path, list[Record]], tmp_path: Path) -> None:
    """Rerun's own converter. It keeps paths, scans and odometry as messages that it does not draw."""
    out = tmp_path / "run.rrd"
    subprocess.run(["rerun", "mcap", "convert", mission[0] / "bag.mcap", "-o", out], check=True, capture_output=True)
    text = subprocess.run(["rerun", "rrd", "print", out], check=True, capture_output=True, text=True).stdout
    rows: dict[tuple[str, str], int] = {}
    for count, entity, columns in re.findall(r"with (\d+) rows .*? - (/\w+) - data columns: \[(.*)\]", text):
        for kind in ("GridMap:data", "Transform3D:translation", "InstancePoses3D", "TextLog:text", "LaserScan:message"):
            if kind in columns:
                rows[entity, kind] = rows.get((entity, kind), 0) + int(count)
    found = {topic: len(each) for topic, each in messages_of(mission[0]).items()}
    assert rows["/map", "GridMap:data"] == 1
    assert rows["/belief", "GridMap:data"] == found["/belief"]
    assert rows["/tf", "Transform3D:translation"] == found["/tf"]
    assert rows["/goal_pose", "InstancePoses3D"] == found["/goal_pose"]
    assert rows["/rosout", "TextLog:text"] == found["/rosout"]
    assert rows["/scan", "LaserScan:message"] == found["/scan"]
