"""The layout of a viewer for one trace: which topics it shows, where, and what it plots.

Each trace gets the panels that it has something for: the true map with everything that moves on it; beside it what a
robot knows of the map, and the field of the last plan; below them the events, and samples and speeds over time. Of the
topics that show the same for two viewers (grids and voxels, scenes and points) each viewer gets its own.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from codesign.ground.errors import InputError
from codesign.ground.records import MapRecord
from codesign.views.trace import Trace
from codesign.views.trace.shapes import Floor, floor_of

_GRID, _SCENE, _SCAN = "foxglove.Grid", "foxglove.SceneUpdate", "foxglove.LaserScan"
_VOXELS, _POINTS = "foxglove.VoxelGrid", "foxglove.PointCloud"
_SAMPLES, _POSES, _EVENTS, _LOG = "SampleRecord", "PoseRecord", "MissionRecord", "foxglove.Log"
_TRUE = "/map/"
_FIELD = "/plan_"
_MOST_SERIES = 16
"""Of a plot: as many as can be told apart."""

_FEW = 8
MARGIN = 1.08
_AXES = 0.3
"""Foxglove draws an axis of scale 1 with 0.15 m: so it is a twentieth of the map."""


_ALL, _KNOWN = "the map and all that moves on it", "what the robot knows"

_OF_BAG = ("/plan", "/goal_pose", "/scan", "/odom")


@dataclass(frozen=True)
class View:
    """A view of the map: its title, its grids, and all else that it shows."""

    title: str
    grids: tuple[str, ...]
    others: tuple[str, ...]


@dataclass(frozen=True)
class Shown:
    """The parts of a trace that can be shown. ``cells``: rows and columns of its map; None without one."""

    trace: Trace
    floor: Floor
    cells: tuple[int, int] | None

    @classmethod
    def of(cls, trace: Trace) -> Shown:
        """The parts of a trace that can be shown.

        Raises:
            TraceError: it is damaged where its map is.
        """
        if not any(channel.record == MapRecord.__name__ for channel in trace.channels):
            return cls(trace, Floor(), None)
        record: Any = next(trace.records(kinds=[MapRecord]), None)
        if record is None:
            return cls(trace, Floor(), None)
        rows, columns = record.free.shape
        return cls(trace, floor_of(record), (rows, columns))

    @property
    def middle(self) -> tuple[float, float]:
        """The middle of the map, m."""
        rows, columns = self.cells or (1, 1)
        return self.floor.point(self.floor.row + (rows - 1) / 2, self.floor.column + (columns - 1) / 2)

    @property
    def across(self) -> float:
        """The extent of the map, m. Turned by its yaw, its corners reach farther."""
        rows, columns = self.cells or (10, 10)
        width, height = columns * self.floor.cell_size, rows * self.floor.cell_size
        cos, sin = abs(math.cos(self.floor.yaw)), abs(math.sin(self.floor.yaw))
        return max(width * cos + height * sin, width * sin + height * cos)

    def topics(self, *schemas: str) -> tuple[str, ...]:
        """The topics with messages of one of these schemas, in the order of the trace."""
        return tuple(channel.topic for channel in self.trace.channels if channel.schema in schemas)

    def sources(self, record: str) -> tuple[str, ...]:
        """The topics with more than a few records of a class: what can be plotted over time."""
        channels = self.trace.channels
        return tuple(each.topic for each in channels if each.record == record and each.messages > _FEW)

    def views(self, grids: str, *others: str) -> list[View]:
        """The views of the map by the schemas of grids and of all else."""
        every, above = self.topics(grids), self.topics(*others)
        true = tuple(topic for topic in every if topic.startswith(_TRUE))
        field = tuple(topic for topic in every if _FIELD in topic)
        known = tuple(topic for topic in every if topic not in true and topic not in field)
        # What a robot does not know of is no part of what it knows.
        beside = tuple(topic for topic in above if not topic.startswith("/obstacles"))
        views = [View(_ALL, true, above)] if true or above else []
        views += [View(_KNOWN, known, beside)] if known else []
        return views + ([View("the field of the last plan", field, beside)] if field else [])

    @cached_property
    def series(self) -> dict[str, list[tuple[str, str]]]:
        """The series that are plotted over time by the title of their plot: paths to numbers, with labels."""
        speeds = [(f"{topic}.speed", topic.split("/")[1]) for topic in self.sources(_POSES)]
        plots = {"speed, m/s": speeds}
        for title, quantity in (("busy, share of the time", "busy"), ("messages that wait", "queue")):
            plots[title] = [
                (f'{topic}{{quantity=="{quantity}"}}.value', topic.split("/")[1]) for topic in self.sources(_SAMPLES)
            ]
        return {title: paths[:_MOST_SERIES] for title, paths in plots.items() if paths}


def foxglove_layout(trace: Trace) -> str:
    """A layout of Foxglove and Lichtblick, as JSON.

    Raises:
        TraceError: the trace is damaged where its map is.
    """
    shown = Shown.of(trace)
    logs = shown.topics(_LOG)[:1]
    return _layout(shown, shown.views(_GRID, _SCENE, _SCAN), logs, shown.series, frames=False)


def bag_layout(trace: Trace) -> str:
    """A layout of Foxglove and Lichtblick for the ROS 2 bag of the same run (``hwsw trace export --ros2``), as JSON.

    Raises:
        TraceError: the trace is damaged where its map is.
    """
    views = [View(_ALL, ("/true_map",), _OF_BAG), View(_KNOWN, ("/belief",), _OF_BAG)]
    series = {"speed, m/s": [("/odom.twist.twist.linear.x", "robot")]}
    return _layout(Shown.of(trace), views, ("/rosout",), series, frames=True)


def _layout(
    shown: Shown,
    views: Sequence[View],
    logs: Sequence[str],
    series: Mapping[str, Sequence[tuple[str, str]]],
    *,
    frames: bool,
) -> str:
    """Views above; events and plots below. ``frames``: robots are drawn as the axes of their frames."""
    panels: dict[str, Any] = {}

    def panel(kind: str, config: dict[str, Any]) -> str:
        name = f"{kind}!{len(panels)}"
        panels[name] = config
        return name

    scenes = [panel("3D", _scene(shown, view, frames)) for view in views]
    below = [panel("RosOut", {"topicToRender": topic, "minLogLevel": 1}) for topic in logs]
    below += [panel("Plot", _plot(title, paths)) for title, paths in series.items()]
    rows = [_beside(scenes, "row"), _beside(below, "row")]
    layout = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _beside([row for row in rows if row is not None], "column", first=68),
    }
    return json.dumps(layout, indent=2, allow_nan=False) + "\n"


def _scene(shown: Shown, view: View, frames: bool) -> dict[str, Any]:
    """A panel of the scene, seen from above."""
    own = {*view.grids, *view.others}
    every = dict.fromkeys((*shown.topics(_GRID, _SCENE, _SCAN, _VOXELS, _POINTS), *view.grids, *view.others))
    return {
        "foxglovePanelTitle": view.title,
        "followMode": "follow-none",
        "followTf": "map",
        "cameraState": _camera(shown),
        "scene": {
            "enableStats": False,
            "backgroundColor": "#e8e8e8",
            "transforms": {
                "visible": frames,
                "showLabel": False,
                "axisScale": _AXES * shown.across if frames else 0,
                "lineWidth": 0,
            },
        },
        "transforms": {},
        "topics": {topic: {"visible": topic in own} for topic in every},
        "layers": {},
    }


def _camera(shown: Shown) -> dict[str, Any]:
    """From above, with x to the right, so that the whole map is seen."""
    x, y = shown.middle
    return {
        "perspective": False,
        "distance": MARGIN * shown.across,
        "phi": 0,
        "thetaOffset": 0,
        "target": [0, 0, 0],
        "targetOffset": [x, y, 0],
        "targetOrientation": [0, 0, 0, 1],
        "fovy": 45,
        "near": 0.01,
        "far": 100_000,
    }


def _plot(title: str, paths: Sequence[tuple[str, str]]) -> dict[str, Any]:
    return {
        "foxglovePanelTitle": title,
        "title": title,
        "paths": [
            {"value": path, "label": label, "enabled": True, "timestampMethod": "receiveTime"} for path, label in paths
        ],
        "xAxisVal": "timestamp",
        "isSynced": True,
        "showLegend": True,
        "legendDisplay": "floating",
        "showXAxisLabels": True,
        "showYAxisLabels": True,
        "showPlotValuesInLegend": False,
        "sidebarDimension": 160,
    }


def _beside(panels: Sequence[Any], direction: str, first: float | None = None) -> Any:
    """Panels beside each other, of equal size, as the tree of a layout; None of none."""
    if not panels:
        return None
    if len(panels) == 1:
        return panels[0]
    return {
        "direction": direction,
        "first": panels[0],
        "second": _beside(panels[1:], direction),
        "splitPercentage": first or 100 / len(panels),
    }


INSTALL = "pip install 'hwsw-codesign[viewers]'"

_VOXELS, _POINTS, _SCAN = "foxglove.VoxelGrid", "foxglove.PointCloud", "foxglove.LaserScan"
_LOG = "foxglove.Log"
_TIMELINE = "message_log_time"
_PAPER = (232, 232, 232)
_ALMOST_ABOVE = 0.02
"""Exactly from above, Rerun does not know what is up."""

_SIGHT = 1.1
"""The height of the eye over the length of the map, so that all of it is seen."""


def write_blueprint(trace: Trace, path: Path) -> None:
    """Write a blueprint of Rerun (``.rbl``) for a trace: its views of the map from above, and its events.

    It is for this trace alone: Rerun knows a file by its name without its ending, and takes the blueprint of that name.

    Raises:
        InputError: rerun-sdk is not installed. TraceError: the trace is damaged where its map is.
    """
    blueprint = _library()
    shown = Shown.of(trace)
    views = [_view(blueprint, shown, view) for view in shown.views(_VOXELS, _POINTS, _SCAN)]
    logs = [blueprint.TextLogView(origin=topic, name="events") for topic in shown.topics(_LOG)[:1]]
    rows = [blueprint.Horizontal(*views)] if views else []
    rows += [blueprint.Horizontal(*logs)] if logs else []
    whole = blueprint.Blueprint(
        *([blueprint.Vertical(*rows, row_shares=[3, 1][: len(rows)])] if rows else []),
        blueprint.BlueprintPanel(state="collapsed"),
        blueprint.SelectionPanel(state="collapsed"),
        blueprint.TimePanel(state="collapsed", timeline=_TIMELINE),
        auto_views=not rows,
    )
    whole.save(trace.path.stem, path)


def _view(blueprint: Any, shown: Shown, view: View) -> Any:
    x, y = shown.middle
    height = _SIGHT * MARGIN * shown.across
    eye = blueprint.EyeControls3D(
        kind=blueprint.Eye3DKind.Orbital,
        position=(x, y - _ALMOST_ABOVE * height, height),
        look_target=(x, y, 0.0),
        eye_up=(0.0, 0.0, 1.0),
    )
    contents = [f"+ {topic}" for topic in (*view.grids, *view.others)] + ["+ /tf/**"]
    return blueprint.Spatial3DView(
        origin="/", contents=contents, name=view.title, eye_controls=eye, line_grid=False, background=_PAPER
    )


def _library() -> Any:
    try:
        from rerun import blueprint
    except ImportError:
        raise InputError("a blueprint of Rerun needs rerun-sdk", "--viewer rerun", INSTALL) from None
    return blueprint
