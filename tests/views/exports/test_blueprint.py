"""Blueprints of Rerun, read back by Rerun's own printer."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner
from trace_samples import a_mission, write

from codesign.cli import main
from codesign.views.exports.layouts import Shown, write_blueprint
from codesign.views.trace import open_trace


def printed(path: Path) -> str:
    rerun = shutil.which("rerun") or str(Path(sys.executable).with_name("rerun"))
    return subprocess.run([rerun, "rrd", "print", "-vvv", path], check=True, capture_output=True, text=True).stdout


def test_a_blueprint_shows_the_views_of_the_trace(tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="no blueprint was written: pip install rerun-sdk (extra viewers)")
    path = write(tmp_path / "office.mcap", a_mission())
    done = CliRunner().invoke(main, ["trace", "layout", str(path), "--viewer", "rerun"])
    assert done.exit_code == 0, done.output
    text = printed(tmp_path / "office.rbl")
    assert '"office"' in text, "the application id that Rerun gives to office.mcap"
    opened = open_trace(path)
    shown = Shown.of(opened)
    views = shown.views("foxglove.VoxelGrid", "foxglove.PointCloud", "foxglove.LaserScan")
    assert views
    for view in views:
        assert view.title in text
    # The printer cuts long cells into lines.
    asked = set(re.findall(r"\+ (/[\w/]+)", text)) - {"/tf/"}
    expected = {topic for view in views for topic in (*view.grids, *view.others)}
    assert all(any(topic.startswith(part) for topic in expected) for part in asked)
    assert all(any(topic.startswith(part) for part in asked) for topic in expected)
    assert expected <= {channel.topic for channel in opened.channels}


def test_without_rerun_the_error_names_the_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rerun", None)
    path = write(tmp_path / "run.mcap", a_mission())
    done = CliRunner().invoke(main, ["trace", "layout", str(path), "--viewer", "rerun"])
    assert done.exit_code == 2
    assert "pip install 'hwsw-codesign[viewers]'" in done.output
    assert sorted(file.name for file in tmp_path.iterdir()) == ["run.mcap"]


def test_a_trace_without_anything_to_show_has_a_blueprint_too(tmp_path: Path) -> None:
    pytest.importorskip("rerun", reason="no blueprint was written: pip install rerun-sdk (extra viewers)")
    write_blueprint(open_trace(write(tmp_path / "empty.mcap", [])), tmp_path / "empty.rbl")
    assert '"empty"' in printed(tmp_path / "empty.rbl")
