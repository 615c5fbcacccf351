"""The same views of a trace for Rerun, as a blueprint.

The library rerun-sdk writes it, and is imported when it is used.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from codesign.ground.errors import InputError
from codesign.views.exports.layouts import MARGIN, Shown, View
from codesign.views.trace import Trace

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
