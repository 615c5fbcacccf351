"""``hwsw plot``: pictures for papers, in three formats, the same bytes each time."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import Result
from trace_samples import a_mission

import codesign
from codesign.ground.errors import InputError
from codesign.views.report import front_picture
from codesign.views.report.canvas import format_of, picture_bytes
from codesign.views.trace import McapListener

WORKLOAD = """\
kind: workload
name: small-map
planner: breadth_first
problem:
  map: {generate: random, rows: 20, columns: 24, density: 0.2, seed: 2}
  goals: [[0, 0]]
  starts: {count: 4, seed: 1}
mapping: {search: {component: host, style: software}}
explore:
  axes: {host.clock: [1 GHz, 2 GHz, 3 GHz]}
  objectives: [plan_time_worst_s, energy_j]
"""
STAGES = """\
kind: workload
name: two-rooms
planner: harmonic
problem:
  map: {generate: rooms, rows: 24, columns: 36, room: [11, 17], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 2, seed: 1}
mapping:
  relax: {component: host, style: software, block: [24, 36], iterations: 6, schedule: {first: 7, step: 8, last: 63}}
  decide: {component: host}
"""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a workload, its exploration and the trace of its run."""
    folder = tmp_path_factory.mktemp("plots")
    (folder / "small.yaml").write_text(WORKLOAD, encoding="utf-8")
    workload = codesign.load_workload(folder / "small.yaml")
    codesign.explore("pc-3400mhz", workload, store=folder / "small.sqlite")
    codesign.simulate("pc-3400mhz", workload, trace=folder / "small.mcap")
    return folder


def fonts(pdf: bytes) -> set[bytes]:
    return set(re.findall(rb"/Subtype\s*/(Type3|Type1|TrueType|CIDFontType2)", pdf))


@pytest.mark.parametrize("name", ["front small.sqlite", "map small.yaml", "map small.mcap", "timeline small.mcap"])
def test_each_plot_in_each_format(files: Path, hwsw: Callable[..., Result], tmp_path: Path, name: str) -> None:
    """A front is drawn twice in each format, and any other plot in one: nothing in the bytes rests on the run."""
    kind, source = name.split()
    again = {"front": {"pdf", "svg", "png"}, "map": {"svg"}, "timeline": {"pdf"}}[kind]
    for suffix in ("pdf", "svg", "png", *(["PNG"] if kind == "front" else [])):
        out = tmp_path / f"out.{suffix}"
        result = hwsw("plot", kind, str(files / source), "-o", str(out))
        assert result.exit_code == 0, result.output
        assert f"written: {out}" in result.output
        first = out.read_bytes()
        if suffix in again:
            assert hwsw("plot", kind, str(files / source), "-o", str(out)).exit_code == 0
            assert out.read_bytes() == first
        if suffix == "svg":
            assert ElementTree.fromstring(first).tag.endswith("svg")
        elif suffix == "pdf":
            assert first.startswith(b"%PDF")
            assert fonts(first) <= {b"CIDFontType2", b"TrueType"} != set()
            assert b"Date" not in first
        else:
            assert first.startswith(b"\x89PNG")


def test_the_bytes_are_those_of_another_process(files: Path, hwsw: Callable[..., Result], tmp_path: Path) -> None:
    here, there = tmp_path / "here.pdf", tmp_path / "there.pdf"
    words = ["plot", "front", str(files / "small.sqlite"), "-o"]
    command = [sys.executable, "-m", "codesign", *words, str(there)]
    subprocess.run(command, check=True, env={**os.environ, "PYTHONHASHSEED": "1"})
    assert hwsw(*words, here).exit_code == 0
    assert there.read_bytes() == here.read_bytes()


def test_a_run_may_be_given_as_platform_and_workload(files: Path, hwsw: Callable[..., Result], tmp_path: Path) -> None:
    out = tmp_path / "out.svg"
    for kind in ("map", "timeline"):
        result = hwsw("plot", kind, "pc-3400mhz", str(files / "small.yaml"), "-o", str(out))
        assert result.exit_code == 0, result.output


def test_the_width_is_that_asked_for(files: Path, hwsw: Callable[..., Result], tmp_path: Path) -> None:
    out = tmp_path / "out.pdf"
    for width in (60, 88, 180):
        assert hwsw("plot", "front", str(files / "small.sqlite"), "-o", str(out), "--width", str(width)).exit_code == 0
        box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+)", out.read_bytes())
        assert box is not None
        assert float(box[1]) / 72 * 25.4 == pytest.approx(width, abs=4)


def test_figures_can_be_chosen_and_restyled(files: Path, tmp_path: Path) -> None:
    from codesign.study import load_study

    picture = front_picture(load_study(files / "small.sqlite"))
    assert picture.figure is not None
    assert picture.data == picture_bytes(picture.figure, "png")
    picture.figure.axes[0].set_title("my title")
    picture.write(tmp_path / "out.svg")
    assert picture.data != picture_bytes(picture.figure, "png")
    assert "data" not in repr(picture)
    assert picture._repr_html_().startswith('<img alt="Scatter plot of energy')


def test_a_front_of_other_figures(files: Path, hwsw: Callable[..., Result], tmp_path: Path) -> None:
    store, out = str(files / "small.sqlite"), str(tmp_path / "out.png")
    chosen = ["--x", "energy", "--y", "cycles", "--colour", "time", "--marker", "host.clock", "--need", "time < 1 s"]
    assert hwsw("plot", "front", store, "-o", out, *chosen).exit_code == 0
    assert hwsw("plot", "front", store, "-o", out, "--colour", "none").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["front", "small.sqlite", "-o", "out.gif"], "out.gif is neither PDF, SVG nor PNG"),
        (["front", "small.sqlite", "-o", "no/out.png"], "folder"),
        (["front", "small.sqlite", "-o", "out.png", "--x", "enrgy_j"], "--x: no figure enrgy_j"),
        (["front", "small.sqlite", "-o", "out.png", "--marker", "clock"], "no axis of the study"),
        (["front", "small.sqlite", "-o", "out.png", "--need", "time < 1 ns"], "no feasible point"),
        (["front", "small.yaml", "-o", "out.png"], "small.yaml"),
        (["map", "small.yaml", "-o", "out.png", "--at", "1 s"], "a workload has no moments"),
        (["map", "robots-4", "-o", "out.png"], "not a map with goals and starts"),
        (["map", "nothing", "-o", "out.png"], "no shipped workload"),
        (["timeline", "small.yaml", "-o", "out.png"], "name a trace of hwsw run --trace"),
        (["timeline", "missing.mcap", "-o", "out.png"], "missing.mcap"),
        (["timeline", "cut.mcap", "-o", "out.png"], "cut.mcap"),
        (["map", "other.mcap", "-o", "out.png"], "other.mcap: is no MCAP file"),
        (["schedule", "small.mcap", "-o", "out.png"], "nothing of this kind in the run"),
        (["schedule", "virtex2-pci", "labyrinth", "x", "-o", "out.png"], "needs a run"),
        (["front", "small.sqlite", "-o", "out.png", "--width", "1e9"], "--width"),
    ],
)
def test_what_cannot_be_drawn_is_refused(
    files: Path, hwsw: Callable[..., Result], monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    (files / "cut.mcap").write_bytes(b"\x89MCAP0\r\n")
    (files / "other.mcap").write_text("no trace", encoding="utf-8")
    monkeypatch.chdir(files)
    result = hwsw("plot", *arguments)
    assert result.exit_code in (1, 2), result.output
    assert message in result.output
    assert "unexpected" not in result.output
    assert not Path("out.png").exists()


def test_a_mission_is_drawn_whole_or_at_a_moment(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    trace, out = tmp_path / "mission.mcap", tmp_path / "out.png"
    with McapListener(trace) as listener:
        for record in a_mission():
            listener(record)
    pictures = []
    for options in ((), ("--at", "0 s"), ("--at", "10 s")):
        result = hwsw("plot", "map", str(trace), "-o", str(out), *options)
        assert result.exit_code == 0, result.output
        pictures.append(out.read_bytes())
    assert len(set(pictures)) == 3
    assert hwsw("plot", "timeline", str(trace), "-o", str(out)).exit_code == 0


@pytest.mark.slow
def test_the_stages_of_harmonic_control(hwsw: Callable[..., Result], tmp_path: Path) -> None:
    (tmp_path / "rooms.yaml").write_text(STAGES, encoding="utf-8")
    out = tmp_path / "out.svg"
    result = hwsw("plot", "schedule", "pc-3400mhz", str(tmp_path / "rooms.yaml"), "-o", str(out))
    assert result.exit_code == 0, result.output


def test_the_format_is_the_end_of_the_name() -> None:
    assert format_of(Path("a.b.PDF")) == "pdf"
    with pytest.raises(InputError, match="neither PDF"):
        format_of(Path("pdf"))
