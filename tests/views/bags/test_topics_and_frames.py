"""Random names of topics and random trees of frames: a workload is that of one robot, or the bag is refused."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result
from examples import examples
from hypothesis import assume, given, settings
from hypothesis import strategies as st

pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'hwsw-codesign[ros2]'")

from recorded_bags import EPOCH, GOALS, Hall, _Make, _messages, hall

from codesign.ground.errors import InputError
from codesign.ground.models import Frame
from codesign.views.bags import Choices, Topics, facts_of, read_bag
from codesign.views.bags.reading import ROLES, choose_topics
from codesign.views.bags.recording import (
    RecordedGoal,
    RecordedMap,
    RecordedPlan,
    Recording,
    Series,
    chain,
    known_times,
    poses,
)

TYPES = {role: rule.types[0] for role, rule in ROLES.items()}
OWN = ("scan", "odom", "goal", "plan", "command")
NAMES = st.lists(st.sampled_from(["tb3", "robot_0", "a", "b", "front"]), max_size=2).map(
    lambda parts: "".join(f"/{part}" for part in parts)
)


@given(NAMES, NAMES, st.sets(st.sampled_from(OWN)), st.sets(st.sampled_from(OWN)), st.booleans())
@settings(max_examples=examples(300))
def test_the_topics_of_two_robots_are_never_mixed(
    one: str, two: str, first: set[str], second: set[str], named: bool
) -> None:
    """Each role comes from one robot, or is not there; which robot can be asked for."""
    assume(one != two)
    assume(first & {"odom", "command", "goal", "plan"})
    assume(second & {"odom", "command", "goal", "plan"})
    # A part of the robot may publish in a namespace of its own: it shares no role with the rest.
    assume(first & second - {"scan"})
    present = {"/map": TYPES["map"], "/tf": TYPES["tf"], "/tf_static": TYPES["tf_static"]}
    robots = {one: first, two: second}
    for space, roles in robots.items():
        present |= {f"{space}/{ROLES[role].usual}": TYPES[role] for role in roles}
    wanted = Topics(namespace=one) if named else Topics()
    try:
        chosen = choose_topics(wanted, present, "bag")
    except InputError as refusal:
        assert "--namespace" in str(refusal)  # noqa: PT017
        assert not named
        return
    assert [chosen[role] for role in ("map", "tf", "tf_static")] == ["/map", "/tf", "/tf_static"]
    read = {chosen[role].rsplit("/", 1)[0] for role in OWN if chosen[role] in present}
    assert len(read) == 1
    robot = one if named else read.pop()
    assert {role for role in OWN if chosen[role] in present} == robots[robot]
    left = {f"{two}/{ROLES[role].usual}" for role in second} if named else set()
    assert left - {f"{two}/plan"} <= set(chosen.unread)


@given(
    st.dictionaries(st.sampled_from(OWN), st.sampled_from(["", "/front", "/move_base_simple", "/a/b"])),
    st.sampled_from(["", "/tb3", "/fleet/robot_7"]),
    st.sampled_from(["", "_filtered", "_raw"]),
)
@settings(max_examples=examples(200))
def test_one_robot_is_found_whatever_its_topics_are_called(inside: dict[str, str], space: str, ending: str) -> None:
    """By its type a topic is found at any depth of the robot's namespace, and under other names."""
    usual = {"odom": f"{space}/odom"}
    present = {usual["odom"]: TYPES["odom"], "/map": TYPES["map"]}
    for role, deeper in inside.items():
        if role != "odom":
            name = f"{space}{deeper}/{ROLES[role].usual}{ending}"
            usual[role], present[name] = name, TYPES[role]
    assume(ending or not {"goal", "plan", "command"} & {role for role in usual if inside.get(role)})
    chosen = choose_topics(Topics(), present, "bag")
    assert {role: chosen[role] for role in usual} == usual
    assert chosen.unread == ()


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["/front/scan_filtered", "/odom"], {"scan": "/front/scan_filtered"}),
        (["/move_base_simple/goal", "/odom"], {"goal": "/move_base_simple/goal"}),
        (["/goal_pose", "/move_base_simple/goal", "/odom"], {"goal": "/goal_pose"}),
        (["/tb3/odom", "/tb3/goal_pose", "/tb3/tf"], {"tf": "/tb3/tf", "goal": "/tb3/goal_pose"}),
        (["/odometry/filtered", "/scan"], {"odom": "/odometry/filtered"}),
        (["/odom", "/plan", "/local_plan"], {"plan": "/plan"}),
        (["/odom", "/local_plan"], {"plan": "/plan"}),
        (["/odom", "/robot_pose"], {"goal": "/goal_pose"}),
    ],
)
def test_names_that_robots_have(names: list[str], expected: dict[str, str]) -> None:
    kinds = {"pose": "goal", "goal": "goal", "scan": "scan", "odom": "odom", "plan": "plan", "tf": "tf"}
    present = {"/map": TYPES["map"], "/global_costmap/costmap": TYPES["map"]}
    for name in names:
        present[name] = TYPES[next(role for word, role in kinds.items() if word in name)]
    chosen = choose_topics(Topics(), present, "bag")
    assert {role: chosen[role] for role in expected} == expected
    assert chosen["map"] == "/map"


@pytest.mark.parametrize(
    ("wanted", "present", "words"),
    [
        (Topics(scan="/scn"), {"/scan": "scan"}, "did you mean /scan?"),
        (Topics(namespace="/c"), {"/a/odom": "odom"}, "namespaces of robots: /a"),
        (Topics(), {"/front/scan": "scan", "/rear/scan": "scan", "/odom": "odom"}, "--scan-topic /front/scan"),
        (Topics(), {"/a/odom": "odom", "/b/goal_pose": "goal"}, "--namespace /a"),
        (Topics(odom="/scan"), {"/scan": "scan"}, "accepted: nav_msgs/msg/Odometry"),
    ],
)
def test_what_cannot_be_told_is_refused(wanted: Topics, present: dict[str, str], words: str) -> None:
    with pytest.raises(InputError) as caught:
        choose_topics(wanted, {name: TYPES[role] for name, role in present.items()}, "bag")
    assert words in str(caught.value)


def random_series(random: np.random.Generator, moving: bool) -> Series:
    times = np.sort(random.uniform(0.0, 10.0, random.integers(2, 9) if moving else 1))
    turns = np.zeros((len(times), 4))
    yaws = random.uniform(-math.pi, math.pi) + np.cumsum(random.uniform(-0.3, 0.3, len(times)))
    turns[:, 2], turns[:, 3] = np.sin(yaws / 2), np.cos(yaws / 2)
    places = random.uniform(-2.0, 2.0, (len(times), 3))
    places[:, 2] = 0.0
    return Series(times, places, turns, moving)


def matrix(series: Series, time: float) -> np.ndarray:
    """The pose of a child in its parent at a time that a message has, or of a static transform."""
    index = int(np.searchsorted(series.times, time)) if len(series.times) > 1 else 0
    (x, y, _), (_, _, sine, cosine) = series.places[index], series.turns[index]
    yaw = 2 * math.atan2(sine, cosine)
    return np.array([[math.cos(yaw), -math.sin(yaw), x], [math.sin(yaw), math.cos(yaw), y], [0, 0, 1]])


@st.composite
def trees(draw: st.DrawFn) -> tuple[dict[tuple[str, str], Series], list[str]]:
    """A random tree of frames, whose transforms are static or move. Moving ones have the same times."""
    size = draw(st.integers(2, 8))
    frames = [f"f{index}" for index in range(size)]
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    edges = {}
    times = np.sort(random.uniform(0.0, 10.0, 6))
    for index in range(1, size):
        moving = draw(st.booleans())
        series = random_series(random, moving)
        if moving:
            more = [random_series(random, False) for _ in times]
            series = Series(
                times, np.concatenate([each.places for each in more]),
                np.concatenate([each.turns for each in more]),
            )  # fmt: skip
        edges[frames[draw(st.integers(0, index - 1))], frames[index]] = series
    order = draw(st.permutations(list(edges)))
    return {edge: edges[edge] for edge in order}, frames


@given(trees(), st.data())
@settings(max_examples=examples(150))
def test_any_frame_is_placed_in_any_other(
    tree: tuple[dict[tuple[str, str], Series], list[str]], data: st.DataObject
) -> None:
    """Up and down the tree, against products of matrices; the times are those of all that moves between the two."""
    edges, frames = tree
    outer, inner = data.draw(st.sampled_from(frames)), data.draw(st.sampled_from(frames))
    path = chain(edges, outer, inner)
    assert path is not None
    moving = [each for step in path for each in (edges.get(step) or edges[step[::-1]],) if each.moving]
    times = known_times(edges, path)
    assert times.tolist() == sorted({time for each in moving for time in each.times.tolist()})
    at = times if len(times) else np.array([1.0])
    found = poses(edges, path, at)
    above = {child: parent for parent, child in edges}

    def to_root(frame: str, time: float) -> np.ndarray:
        whole = np.eye(3)
        while frame in above:
            whole = matrix(edges[above[frame], frame], time) @ whole
            frame = above[frame]
        return whole

    for index, time in enumerate(at.tolist()):
        expected = np.linalg.inv(to_root(outer, time)) @ to_root(inner, time)
        np.testing.assert_allclose(found.places[index, :2], expected[:2, 2], atol=1e-9)
        np.testing.assert_allclose(found.turns[index, :2, :2], expected[:2, :2], atol=1e-9)


def recording_of(edges: dict[tuple[str, str], Series], goals: list[RecordedGoal]) -> Recording:
    cells = np.zeros((400, 400), np.int8)
    plan = RecordedMap(0.0, cells, Frame(400, 0.1, (-20.0, -20.0, 0.0)), "map")
    topics = {role: f"/{rule.usual}" for role, rule in ROLES.items()}
    return Recording(Path("bag"), topics, map=plan, edges=edges, goals=goals)


@given(st.integers(0, 4), st.data())
@settings(max_examples=60)
def test_a_static_frame_anywhere_in_the_chain_freezes_nothing(statics: int, data: st.DataObject) -> None:
    """The robot drives 8 m along x. Static frames without an offset, before, between or behind what moves, or a map
    that hangs beside the odometry below a common frame, change no fact."""
    times = np.linspace(0.0, 16.0, 161)
    places = np.zeros((161, 3))
    places[:, 0] = times / 2
    upright = np.zeros((161, 4))
    upright[:, 3] = 1.0
    still = Series(np.zeros(1), np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]), False)
    names = ["map", "odom", "base_link"]
    for index in range(statics):
        names.insert(data.draw(st.integers(1, len(names) - 1)), f"s{index}")
    mover = data.draw(st.integers(1, len(names) - 1))
    edges = {}
    for index in range(1, len(names)):
        edge = (names[index - 1], names[index])
        if index == 1 and data.draw(st.booleans()):
            edges["world", "map"], edge = still, ("world", names[index])
        edges[edge] = Series(times, places, upright) if index == mover else still
    goals = [RecordedGoal(1.0, "map", (3.0, 0.0, 0.0)), RecordedGoal(9.0, "map", (7.0, 0.0, 0.0))]
    made = facts_of(recording_of(edges, goals), Choices())
    assert [each.toured for each in made.goals] == [True, True]
    assert [each.reached for each in made.goals] == [pytest.approx(5.4 - 1.0), pytest.approx(13.4 - 1.0)]
    assert made.start == made.map.frame.cell(0.5, 0.0)
    assert made.speed.value == pytest.approx(0.5)
    assert made.remarks == ()


def test_frames_that_nothing_moves_place_no_robot() -> None:
    still = Series(np.zeros(1), np.zeros((1, 3)), np.array([[0.0, 0.0, 0.0, 1.0]]), False)
    alone = recording_of({("base_link", "laser"): still}, [RecordedGoal(1.0, "map", (3.0, 0.0, 0.0))])
    with pytest.raises(InputError, match="does not show where the robot is"):
        facts_of(alone, Choices())
    with pytest.raises(InputError, match="moves frame 'laser'"):
        facts_of(alone, Choices(Topics(base="laser")))


def moving_base() -> dict[tuple[str, str], Series]:
    times = np.linspace(0.0, 10.0, 101)
    places, turns = np.zeros((101, 3)), np.zeros((101, 4))
    places[:, 0], turns[:, 3] = times / 2, 1.0
    return {("map", "base_link"): Series(times, places, turns)}


def test_a_goal_where_the_robot_stands_is_no_mission() -> None:
    here = RecordedGoal(2.0, "map", (1.02, 0.02, 0.0))
    with pytest.raises(InputError, match="where the robot stands, so there is no mission"):
        facts_of(recording_of(moving_base(), [here]), Choices())
    there = RecordedGoal(4.0, "map", (4.0, 0.0, 0.0))
    made = facts_of(recording_of(moving_base(), [here, there]), Choices())
    assert [each.toured for each in made.goals] == [False, True]
    assert (made.begin, made.goals[0].time, made.goals[1].time) == (4.0, -2.0, 0.0)
    assert made.start == made.map.frame.cell(2.0, 0.0)
    assert made.start != made.toured[0]
    assert "goal 1 is where the robot stands" in made.remarks[0]


def test_an_answer_that_was_not_recorded_is_absent() -> None:
    plans = [RecordedPlan(time, "map", (0.0, 0.0, 0.0), (4.0, 0.0, 0.0), 4.0) for time in (1.0, 2.0)]
    without = recording_of(moving_base(), [])
    without.plans = plans
    assert [each.answered for each in facts_of(without, Choices()).goals] == [None]
    asked = recording_of(moving_base(), [RecordedGoal(1.0, "map", (4.0, 0.0, 0.0))])
    asked.plans = plans
    assert [each.answered for each in facts_of(asked, Choices()).goals] == [1.0]


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two robots of the hall in one bag, the second 50 s behind the first, with one map and one tree of frames."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    folder = tmp_path_factory.mktemp("bags") / "fleet"
    make, plan = _Make(store.types, 0.0), Hall(seconds=20.0, rays=36)
    out: list[tuple[float, str, Any]] = [(0.0, "/map", make.map(hall()))]
    for name in ("tb3_0", "tb3_1"):
        for time, topic, message in _messages(plan, store.types):
            if topic == "/map":
                continue
            for each in getattr(message, "transforms", []):
                each.header.frame_id, each.child_frame_id = (
                    frame if frame == "map" else f"{name}/{frame}"
                    for frame in (each.header.frame_id, each.child_frame_id)
                )
            if topic == "/odom":
                message.header.frame_id, message.child_frame_id = f"{name}/odom", f"{name}/base_link"
            if topic == "/scan":
                message.header.frame_id = f"{name}/laser"
            out.append((time, topic if topic.startswith("/tf") else f"/{name}{topic}", message))
    with Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        connections: dict[str, Any] = {}
        for time, topic, message in sorted(out, key=lambda item: item[0]):
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], EPOCH + round(time * 1e9), store.serialize_cdr(message, kind))
    return folder


def test_a_bag_of_two_robots_needs_a_namespace(hwsw: Callable[..., Result], fleet: Path) -> None:
    refused = hwsw("workload", "from-bag", fleet, "-o", "made")
    assert refused.exit_code == 2
    assert "several robots: /tb3_0, /tb3_1" in refused.stderr
    assert "--namespace /tb3_0" in refused.stderr
    done = hwsw("workload", "from-bag", fleet, "-o", "made", "--namespace", "tb3_1")
    assert done.exit_code == 0, done.output
    text = Path("made/fleet.yaml").read_text()
    assert "/tb3_1/goal_pose" in text
    made = facts_of(read_bag(fleet, Topics(namespace="/tb3_1")), Choices())
    assert [each.cell for each in made.goals] == [made.map.frame.cell(*goal) for goal in GOALS[: len(made.goals)]]
    assert made.start == made.map.frame.cell(0.0, 0.0)
    assert made.goals[0].reached is not None
    assert made.reach.value == pytest.approx(3.5)
    assert any("/tb3_0/scan" in remark for remark in made.remarks)


def test_a_board_that_answers_no_goal_has_no_latency() -> None:
    from codesign.ground.records import GoalRecord, PlanRecord
    from codesign.views.report.scenario_tables import board_latencies

    fields: dict[str, Any] = {"component": "robot"}
    goal = lambda time: _record(GoalRecord, time, fields)  # noqa: E731
    plan = lambda time: _record(PlanRecord, time, fields)  # noqa: E731
    assert board_latencies([goal(0), goal(5), plan(9), plan(11), goal(20), plan(21)]) == [None, 4, 1]


def _record(kind: Any, time: int, fields: dict[str, Any]) -> Any:
    """A record of which the time alone is read."""
    record = object.__new__(kind)
    object.__setattr__(record, "time", time)
    return record


@given(st.integers(2, 5), st.integers(0, 2**32))
@settings(max_examples=50)
def test_times_are_those_of_every_moving_edge(length: int, seed: int) -> None:
    """Transforms of a chain are published at rates of their own."""
    random = np.random.default_rng(seed)
    frames = [f"f{index}" for index in range(length + 1)]
    moving = random.random(length) < 0.6
    edges = {(frames[index], frames[index + 1]): random_series(random, bool(moving[index])) for index in range(length)}
    path = chain(edges, frames[0], frames[-1])
    assert path is not None
    expected = sorted(
        {time for each, moves in zip(edges.values(), moving, strict=True) if moves for time in each.times.tolist()}
    )
    assert known_times(edges, path).tolist() == expected


def test_the_frame_of_a_robot_lies_in_its_namespace() -> None:
    """Without odometry, /tf has the frames of two robots: the namespace tells them apart."""
    edges = {
        ("map", f"{name}/base_link"): replace(moving_base()["map", "base_link"], places=np.full((101, 3), offset))
        for name, offset in (("tb3_0", 5.0), ("tb3_1", -5.0))
    }
    for name, offset in (("tb3_0", 5.0), ("tb3_1", -5.0)):
        recording = recording_of(edges, [RecordedGoal(1.0, "map", (0.0, 0.0, 0.0))])
        recording.namespace = f"/{name}"
        made = facts_of(recording, Choices())
        assert made.start == made.map.frame.cell(offset, offset)
