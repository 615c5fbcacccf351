"""Bags that are no bags, lack something, are damaged or are hostile: a clear error, or a safe result."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import Result

pytest.importorskip("rosbags", reason="rosbags is not installed: pip install 'hwsw-codesign[ros2]'")

from recorded_bags import EPOCH, Hall, _Make, hall, record

from codesign.ground.errors import InputError
from codesign.views.bags import Topics, read_bag

TINY = Hall(seconds=8.0, rays=36, odom_rate=10.0)


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("bags") / "hall", TINY)


def write(folder: Path, *messages: tuple[float, str, Any]) -> Path:
    """A bag of these messages."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    with Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        connections: dict[str, Any] = {}
        for time, topic, message in messages:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], EPOCH + round(time * 1e9), store.serialize_cdr(message, kind))
    return folder


def make(late: float = 0.0) -> _Make:
    from rosbags.typesys import Stores, get_typestore

    return _Make(get_typestore(Stores.ROS2_HUMBLE).types, late)


def assert_refused(hwsw: Callable[..., Result], bag: Path, *words: str) -> str:
    """The error of a bag that is refused: it names the bag, and has a hint."""
    before = set(Path().rglob("*"))
    done = hwsw("workload", "from-bag", bag, "-o", "made")
    assert done.exit_code == 2, done.output
    assert done.stderr.startswith(f"{bag}: ") or f"\n{bag}: " in done.stderr, done.stderr
    assert "hint: " in done.stderr
    for word in words:
        assert word in done.stderr, done.stderr
    assert set(Path().rglob("*")) == before
    return done.stderr


def test_what_is_no_bag_is_refused(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    assert_refused(hwsw, tmp_path / "absent", "does not exist")
    folder = tmp_path / "folder"
    folder.mkdir()
    assert_refused(hwsw, folder, "has no metadata.yaml")
    text = tmp_path / "notes.txt"
    text.write_text("no bag")
    assert_refused(hwsw, text, "is no ROS 2 bag")
    old = tmp_path / "old.bag"
    old.write_bytes(b"#ROSBAG V2.0\n")
    assert_refused(hwsw, old, "is a bag of ROS 1", "rosbags-convert --src")
    for name in ("empty.mcap", "empty.db3"):
        empty = tmp_path / name
        empty.write_bytes(b"")
        assert_refused(hwsw, empty)


def test_a_native_trace_is_no_bag(hwsw: Callable[..., Result], specs: tuple[Path, Path]) -> None:
    assert hwsw("run", *specs, "--trace", "run.mcap", "-q").exit_code == 0
    assert_refused(hwsw, Path("run.mcap"), "rofile is not ros2", "hwsw trace export FILE --ros2 DIR")


def test_a_bag_without_a_map_names_the_topics(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    bare = write(tmp_path / "bare", (0.0, "/goal_pose", make().goal(0.0, (1.0, 1.0))))
    assert_refused(hwsw, bare, "has no topic /map", "topics: /goal_pose")
    other = write(tmp_path / "other", (0.0, "/static_map", make().map(hall())), (0.0, "/old_map", make().map(hall())))
    assert_refused(hwsw, other, "/old_map, /static_map", "--map-topic /old_map")
    wrong = write(tmp_path / "wrong", (0.0, "/map", make().goal(0.0, (1.0, 1.0))))
    assert_refused(hwsw, wrong, "topic /map has messages of geometry_msgs/msg/PoseStamped")
    empty = write(tmp_path / "empty")
    assert_refused(hwsw, empty, "holds no message")


def test_a_bag_with_a_map_alone_has_no_mission(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    alone = write(tmp_path / "alone", (0.0, "/map", make().map(hall())))
    assert_refused(hwsw, alone, "shows no goal, no plan and no robot")
    lost = write(
        tmp_path / "lost", (0.0, "/map", make().map(hall())), (1.0, "/goal_pose", make().goal(1.0, (1.0, 1.0)))
    )
    assert_refused(hwsw, lost, "does not show where the robot is")


def test_of_two_maps_one_is_taken_and_that_is_said(tmp_path: Path) -> None:
    grown = hall()
    grown[20:30, 20:30] = 100
    both = write(
        tmp_path / "both",
        (0.0, "/map", make().map(hall())), (1.0, "/map", make().map(hall())), (2.0, "/map", make().map(grown)),
    )  # fmt: skip
    for last, expected in ((True, grown), (False, hall())):
        recording = read_bag(both, Topics(), last_map=last)
        assert recording.map is not None
        np.testing.assert_array_equal(recording.map.cells, expected[::-1])
        assert recording.remarks[0].startswith("2 different maps on /map: the ")


@pytest.mark.parametrize(
    ("jump", "words"), [(-30.0, "goes back by"), (5000.0, "jumps ahead by"), (20.0, None)], ids=["back", "ahead", "gap"]
)
def test_clocks_that_jump(hwsw: Callable[..., Result], tmp_path: Path, jump: float, words: str | None) -> None:
    messages = [(0.0, "/map", make().map(hall())), (0.0, "/goal_pose", make().goal(0.0, (1.0, 1.0)))]
    for step in range(200):
        stamp = step * 0.1 + (jump if step >= 100 else 0.0)
        messages.append((step * 0.1, "/odom", make().odom(stamp, 0.1, 0.1, 0.0, 0.0)))
    jumped = write(tmp_path / "jumped", *messages)
    if words is not None:
        assert_refused(hwsw, jumped, "the clock of /odom", words, "cut the bag there")
    else:
        assert any("/odom has a gap of 20.1 s" in remark for remark in read_bag(jumped, Topics()).remarks)


def test_places_outside_of_the_map_are_refused(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    far = write(
        tmp_path / "far", (0.0, "/map", make().map(hall())), (1.0, "/goal_pose", make().goal(1.0, (99.0, 0.0))),
        (1.0, "/odom", make().odom(1.0, 0.0, 0.0, 0.0, 0.0)),
    )  # fmt: skip
    assert_refused(hwsw, far, "goal 1 at (99.000, 0.000) m lies outside of the map of 10 × 6 m")
    inside = write(
        tmp_path / "inside", (0.0, "/map", make().map(hall())), (1.0, "/goal_pose", make().goal(1.0, (4.5, 3.0))),
        (1.0, "/odom", make().odom(1.0, 0.0, 0.0, 0.0, 0.0)),
    )  # fmt: skip
    assert_refused(hwsw, inside, "goal 1 at (4.500, 3.000) m lies on no free cell")
    nowhere = write(
        tmp_path / "nowhere",
        (0.0, "/map", make().map(hall())),
        (1.0, "/goal_pose", make().goal(1.0, (float("nan"), 0))),
    )
    assert_refused(hwsw, nowhere, "a goal at (nan, 0)")


@pytest.mark.parametrize("fault", ["cells", "resolution", "tilted", "rays", "numbers"])
def test_hostile_messages(hwsw: Callable[..., Result], tmp_path: Path, fault: str) -> None:
    plan, scan = make().map(hall()), make().scan(1.0, np.ones(8, np.float32), 3.0)
    odom = make().odom(1.0, 0.0, 0.0, 0.0, 0.0)
    if fault == "cells":
        plan.info.width = 2**31
    elif fault == "resolution":
        plan.info.resolution = float("inf")
    elif fault == "tilted":
        plan.info.origin.orientation.x = 1.0
    elif fault == "rays":
        scan.angle_increment = 0.0
    else:
        odom.pose.pose.position.x = 1e300
    bad = write(
        tmp_path / "bad", (0.0, "/map", plan), (1.0, "/scan", scan), (1.0, "/odom", odom),
        (1.0, "/goal_pose", make().goal(1.0, (1.0, 1.0))),
    )  # fmt: skip
    done = hwsw("workload", "from-bag", bad, "-o", "made")
    assert done.exit_code == 2, done.output
    assert str(bad) in done.stderr


def test_hostile_texts_stay_texts(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    evil = "base\n  evil: [1]\x1b[31m # \"'"
    odom = make().odom(1.0, 0.0, 0.0, 0.0, 0.0)
    odom.child_frame_id = evil
    bad = write(
        tmp_path / "bag with \"quotes\" # and more", (0.0, "/map", make().map(hall())), (1.0, "/odom", odom),
        (1.0, "/goal_pose", make().goal(1.0, (1.0, 1.0))),
    )  # fmt: skip
    done = hwsw("workload", "from-bag", bad, "-o", "made")
    assert done.exit_code == 0, done.output
    assert "\x1b" not in done.output
    (made,) = Path("made").glob("*quotes*[!sp].yaml")
    assert "\x1b" not in made.read_text()
    assert hwsw("check", "virtex2pro", made).exit_code == 0


def test_a_bag_cut_anywhere_gives_an_error(bag: Path, tmp_path: Path) -> None:
    copy = tmp_path / "cut"
    shutil.copytree(bag, copy)
    file = copy / "hall.mcap"
    whole = file.read_bytes()
    for share in range(0, 100, 4):
        file.write_bytes(whole[: len(whole) * share // 100])
        with pytest.raises(InputError) as caught:
            read_bag(copy, Topics())
        assert str(copy) in str(caught.value)


@pytest.mark.parametrize("seed", range(40))
def test_damaged_bytes_end_in_an_error_or_a_result(bag: Path, tmp_path: Path, seed: int) -> None:
    copy = tmp_path / "damaged"
    shutil.copytree(bag, copy)
    random = np.random.default_rng(seed)
    file = copy / ("metadata.yaml" if seed % 4 == 0 else "hall.mcap")
    content = bytearray(file.read_bytes())
    for place in random.integers(0, len(content), 12).tolist():
        content[place] = int(random.integers(0, 256))
    file.write_bytes(bytes(content))
    try:
        recording = read_bag(copy, Topics())
    except InputError as refusal:
        assert str(copy) in str(refusal)  # noqa: PT017
    else:
        assert recording.map is not None


def test_a_chunk_unpacks_to_no_more_than_it_declares(tmp_path: Path) -> None:
    """A bomb: a few bytes that would unpack to 4 GiB."""
    import sys

    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd
    from rosbags.rosbag2 import storage_mcap

    from codesign.views.bags.library import MAX_CHUNK_BYTES, bound_decompression

    bound_decompression()
    packed = zstd.compress(bytes(2**26))
    unpack = storage_mcap.DECOMPRESSORS["zstd"]
    assert len(unpack(packed, 1000)) == 1001
    with pytest.raises(Exception, match="a chunk of"):
        unpack(packed, MAX_CHUNK_BYTES + 1)
    assert len(unpack(packed, 2**26)) == 2**26


@pytest.mark.parametrize("target", ["file", "/proc/nowhere"])
def test_a_folder_that_cannot_be_written(hwsw: Callable[..., Result], bag: Path, target: str) -> None:
    Path("file").write_text("x")
    done = hwsw("workload", "from-bag", bag, "-o", target)
    assert done.exit_code in (1, 2), done.output
    assert target in done.stderr


def test_other_faults_of_the_command(hwsw: Callable[..., Result], bag: Path) -> None:
    for arguments, words in (
        (("--like", "nothing"), "there is no shipped workload"),
        (("--like", "robots-8"), "plans on no map with a goal"),
        (("--base-frame", "wheel"), "no transform leads to frame 'wheel'"),
    ):
        done = hwsw("workload", "from-bag", bag, *arguments)
        assert done.exit_code == 2, done.output
        assert words in done.stderr
