"""Layouts for viewers."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from trace_samples import a_mission, write

import codesign
from codesign.cli import main
from codesign.views.exports.layouts import Shown, bag_layout, foxglove_layout
from codesign.views.trace import open_trace


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("mission") / "run.mcap"
    codesign.simulate("zynq", "office-harmonic", trace=path)
    return path


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("plan") / "run.mcap"
    codesign.simulate("virtex4-pci", "labyrinth", trace=path)
    return path


def panels(layout: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    return [config for name, config in layout["configById"].items() if name.startswith(f"{kind}!")]


def leaves(tree: Any) -> Iterator[str]:
    if isinstance(tree, str):
        yield tree
        return
    assert tree["direction"] in ("row", "column")
    assert 0 < tree["splitPercentage"] < 100
    yield from leaves(tree["first"])
    yield from leaves(tree["second"])


def topics_named(layout: dict[str, Any]) -> set[str]:
    named = {topic for panel in panels(layout, "3D") for topic in panel["topics"]}
    named |= {panel["topicToRender"] for panel in panels(layout, "RosOut")}
    for panel in panels(layout, "Plot"):
        named |= {path["value"].split(".")[0].split("{")[0] for path in panel["paths"]}
    return named


def visible(panel: dict[str, Any]) -> set[str]:
    return {topic for topic, config in panel["topics"].items() if config["visible"]}


def test_a_layout_names_topics_of_the_trace_alone_and_places_each_panel_once(mission: Path, plan: Path) -> None:
    for path in (mission, plan):
        opened = open_trace(path)
        layout = json.loads(foxglove_layout(opened))
        assert topics_named(layout) <= {channel.topic for channel in opened.channels}
        assert sorted(leaves(layout["layout"])) == sorted(layout["configById"])


def test_a_mission_is_seen_with_its_map_path_belief_and_obstacles(mission: Path) -> None:
    layout = json.loads(foxglove_layout(open_trace(mission)))
    everything, known, field = map(visible, panels(layout, "3D"))
    assert everything >= {"/map/grid", "/path", "/obstacles", "/goals", "/robots", "/trails"}
    assert known >= {"/robot/grid", "/path", "/robots"}
    assert "/obstacles" not in known
    assert "/fpga/plan_grid" in field
    # Two grids in one place would hide each other; voxels and points are for another viewer.
    for shown in (everything, known, field):
        assert len([topic for topic in shown if topic.endswith("grid")]) == 1
        assert not [topic for topic in shown if topic.endswith(("voxels", "points"))]
    assert [panel["topicToRender"] for panel in panels(layout, "RosOut")] == ["/log"]
    assert {panel["title"] for panel in panels(layout, "Plot")} == {
        "speed, m/s",
        "busy, share of the time",
        "messages that wait",
    }


def test_a_plan_has_its_field_beside_its_map_and_nothing_over_time(plan: Path) -> None:
    layout = json.loads(foxglove_layout(open_trace(plan)))
    assert [visible(panel) & {"/map/grid", "/fpga/plan_grid"} for panel in panels(layout, "3D")] == [
        {"/map/grid"},
        {"/fpga/plan_grid"},
    ]
    assert not panels(layout, "Plot")
    assert not panels(layout, "RosOut")


def test_the_camera_sees_the_whole_map_wherever_it_lies(tmp_path: Path) -> None:
    opened = open_trace(write(tmp_path / "run.mcap", a_mission()))
    layout = json.loads(foxglove_layout(opened))
    camera = panels(layout, "3D")[0]["cameraState"]
    shown = Shown.of(opened)
    assert shown.cells is not None
    rows, columns = shown.cells
    corners = [
        shown.floor.point(shown.floor.row + row, shown.floor.column + column)
        for row in (-0.5, rows - 0.5)
        for column in (-0.5, columns - 0.5)
    ]
    x, y, _ = camera["targetOffset"]
    assert all(math.dist((x, y), corner) <= camera["distance"] for corner in corners)
    assert all(abs(px - x) <= camera["distance"] / 2 and abs(py - y) <= camera["distance"] / 2 for px, py in corners)


def test_the_layout_of_the_bag_names_topics_of_the_bag(mission: Path, tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="no bag was written: pip install rosbags (extra ros2)")
    done = CliRunner().invoke(main, ["trace", "export", str(mission), "--ros2", str(tmp_path / "bag")])
    assert done.exit_code == 0, done.output
    bag = open_trace(next((tmp_path / "bag").glob("*.mcap")))
    layout = json.loads(bag_layout(open_trace(mission)))
    shown = {topic for panel in panels(layout, "3D") for topic in visible(panel)}
    logs = {panel["topicToRender"] for panel in panels(layout, "RosOut")}
    plotted = {path["value"].split(".")[0] for panel in panels(layout, "Plot") for path in panel["paths"]}
    assert shown | logs | plotted <= {channel.topic for channel in bag.channels}


def test_the_command_writes_a_layout_beside_the_trace(tmp_path: Path) -> None:
    path = write(tmp_path / "run.mcap", a_mission())
    run = CliRunner().invoke
    done = run(main, ["trace", "layout", str(path)])
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "run.json").read_text())["configById"]
    assert run(main, ["trace", "layout", str(path), "-o", str(path)]).exit_code == 2
    missing = run(main, ["trace", "layout", str(path), "-o", str(tmp_path / "none" / "x.json")])
    assert missing.exit_code == 2
    assert "none" in missing.output


def test_a_cut_trace_gets_a_layout_of_what_it_has(tmp_path: Path) -> None:
    whole = write(tmp_path / "run.mcap", a_mission()).read_bytes()
    for part in range(5, 100, 19):
        path = tmp_path / f"{part}.mcap"
        path.write_bytes(whole[: len(whole) * part // 100])
        done = CliRunner().invoke(main, ["trace", "layout", str(path)])
        assert done.exit_code in (0, 1), done.output
        assert "Traceback" not in done.output
        if done.exit_code == 0:
            layout = json.loads(path.with_suffix(".json").read_text())
            assert topics_named(layout) <= {channel.topic for channel in open_trace(path).channels}
