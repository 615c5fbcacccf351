"""What sets the pace of a mission is found by running it with a lever moved, and told in the figures of those runs."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from click.testing import Result as Done
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import KINEMATICS, PLACEMENTS, Ground, rectangle

import codesign
from codesign.ground import interrupts
from codesign.ground.errors import EXIT_TERMINATED, Terminated
from codesign.inputs import Platform, Workload, design_point
from codesign.system import Result, System
from codesign.system.results.mission import Mission
from codesign.system.scenarios import bind, simulate
from codesign.system.scenarios.drive import levers
from codesign.system.scenarios.drive.levers import HELPS, MissionLever, levers_of
from codesign.system.verdicts import RunDocument
from codesign.views.report import render_text, result_tables

Hwsw = Callable[..., Done]

CLAIMS = re.compile(r"would|does not|faster|twice|saves?\b|ends .* earlier", re.IGNORECASE)
"""Words of a claim about what a change of the design does."""

SLOW: dict[str, Any] = {
    "platform": {"components": {"fpga": {"clock": "50 kHz"}}},
    "known": "none",
    "limit": "2200 ms",
    "replan": {"trigger": "change", "when_busy": "restart"},
    "obstacles": {"moving": [{"route": [[3, 2], [3, 6]], "speed": "1 m/s"}]},
}


def mission_of(result: Result) -> Mission:
    assert result.mission is not None
    return result.mission


def check_levers(platform: Platform, workload: Workload) -> None:
    """Each lever's figures are those of a run by itself, and the sentence holds no others."""
    plain = simulate(platform, workload)
    told = mission_of(codesign.simulate(platform, workload, levers=True))
    assert told.levers is not None
    assert told.model_copy(update={"levers": None, "bottleneck": mission_of(plain).bottleneck}) == plain.mission
    found = {lever.path: lever for lever in levers_of(bind(platform, workload), plain)}
    assert {run.path for run in told.levers} == found.keys()
    helpful = []
    for run in told.levers:
        lever = found[run.path]
        if lever.refused:
            assert run.refused == lever.refused
            assert run.mission_time_s is None
            continue
        alone = simulate(*design_point(platform, workload, {lever.path: lever.value}))
        if not alone.feasible:
            assert run.refused
            continue
        moved = mission_of(alone)
        figures = (run.reached, run.mission_time_s, run.mission_energy_j, run.missed_deadlines, run.ended)
        assert figures == (
            moved.reached, moved.mission_time_s, moved.energy.mission_energy_j, moved.missed_deadlines, moved.ended
        )  # fmt: skip
        if moved.reached and (not told.reached or moved.mission_time_s < (1 - HELPS) * told.mission_time_s):
            helpful.append((moved.mission_time_s, run.path))
    assert told.bottleneck is not None
    if helpful:
        best = min(helpful)
        assert told.bottleneck.kind == "lever"
        assert told.bottleneck.text.startswith(f"{best[1]} ")
        assert f"{best[0]:.4g} s in place of" in told.bottleneck.text
        assert best[1].startswith(told.bottleneck.name)
    elif any(run.mission_time_s is not None for run in told.levers):
        assert "None of the levers that were run" in told.bottleneck.text


@settings(max_examples=3, derandomize=True)
@given(
    placement=st.sampled_from(sorted(PLACEMENTS)),
    kinematics=st.sampled_from(sorted(KINEMATICS)),
    baud=st.sampled_from([9600, 115200]),
    clock=st.sampled_from(["1 MHz", "100 MHz"]),
    hidden=st.booleans(),
)
def test_levers_say_what_their_runs_give(
    tmp_path: Path, placement: str, kinematics: str, baud: int, clock: str, hidden: bool
) -> None:
    board = {"components": {"fpga": {"clock": clock}}, "links": {"uart": {"baud": baud}}}
    spec: dict[str, Any] = {"platform": [KINEMATICS[kinematics], board], "limit": "1 min"}
    if hidden:
        spec["hidden"] = [rectangle(4, 4), rectangle(9, 6)]
    check_levers(*Ground(tmp_path).point(placement, **spec))


def test_a_livelock_is_ended_by_levers_that_are_run(tmp_path: Path) -> None:
    """The robot drives nearly all the time, on plans that come late."""
    point = Ground(tmp_path).point("harmonic", **SLOW)
    told = mission_of(codesign.simulate(*point, levers=True))
    assert told.broken_off_in_a_row >= 10
    assert told.levers is not None
    paths = [run.path for run in told.levers]
    for path in ("fpga.clock", "workload.scenario.replan.when_busy", "workload.scenario.control_period"):
        assert path in paths


def test_where_no_lever_was_run_nothing_is_claimed(tmp_path: Path) -> None:
    """In Python by default, and in explorations."""
    ground = Ground(tmp_path)
    slow_line = {"links": {"uart": {"baud": 2400}}}
    for placement, spec in (
        ("breadth-first", {}),
        ("harmonic", SLOW),
        ("breadth-first", {"platform": slow_line, "limit": "20 s"}),
        ("harmonic", {"platform": {"components": {"fpga": {"clock": "10 Hz"}}}, "limit": "5 s"}),
    ):
        mission = mission_of(ground.run(placement, **spec))
        assert mission.levers is None
        assert mission.bottleneck is not None
        assert not CLAIMS.search(mission.bottleneck.text), mission.bottleneck.text
    explore = {"axes": {"fpga.clock": ["50 MHz"]}, "objectives": ["mission_time_s"]}
    study = codesign.explore(*ground.point(workload={"explore": explore}))
    (point,) = study.points
    assert point.result is not None
    assert mission_of(point.result).levers is None


def test_a_lever_at_its_limit_is_refused_with_the_reason(tmp_path: Path) -> None:
    point = Ground(tmp_path).point(platform={"components": {"fpga": {"clock": "500 MHz"}}})
    platform, workload = design_point(*point, {"fpga.clock": "100 MHz"})
    result = simulate(platform, workload)
    assert result.clock is not None
    limit = int(result.clock.limit.value)
    at_limit = design_point(platform, workload, {"fpga.clock": f"{limit} Hz"})
    told = mission_of(codesign.simulate(*at_limit, levers=True))
    assert told.levers is not None
    (clock,) = [run for run in told.levers if run.path == "fpga.clock"]
    assert clock.mission_time_s is None
    assert clock.refused is not None
    assert "is the most that" in clock.refused
    assert told.levers[-1] == clock, "those that were run come first"


def test_the_command_runs_them_unless_it_is_told_not_to(hwsw: Hwsw, tmp_path: Path) -> None:
    files = Ground(tmp_path).files()
    whole = json.loads(hwsw("run", *files, "--json", "--html", tmp_path / "run.html").stdout)
    jsonschema.validate(whole, json.loads(hwsw("schema", "result").stdout))
    assert {run["path"] for run in whole["mission"]["levers"]} >= {"fpga.clock", "robot.kinematics.speed"}
    bare = json.loads(hwsw("run", *files, "--json", "--no-levers").stdout)
    assert bare["mission"]["levers"] is None
    assert bare["mission"]["mission_time_s"] == whole["mission"]["mission_time_s"]
    tables = [render_text(table) for table in result_tables(RunDocument.model_validate(whole))]
    assert any("Levers, each run by itself" in table for table in tables)
    page = (tmp_path / "run.html").read_text(encoding="utf-8")
    assert "Levers, each run by itself" in page
    assert whole["mission"]["bottleneck"]["text"].split(":")[0] in page


def test_the_trace_holds_the_result_with_its_levers(tmp_path: Path) -> None:
    """As it is printed."""
    point = Ground(tmp_path).point(limit="1 s")
    result = codesign.simulate(*point, trace=tmp_path / "run.mcap", levers=True)
    (told,) = [
        record
        for record in codesign.open_trace(tmp_path / "run.mcap").records()
        if type(record).__name__ == "SummaryRecord"
    ]
    assert told.result == {**result.model_dump(mode="json"), "provenance": None}  # type: ignore[attr-defined]


def test_a_signal_during_the_levers_keeps_the_mission(
    hwsw: Hwsw, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board, plan = Ground(tmp_path).files()
    run, done = levers._run, []

    def strike(*arguments: Any) -> Any:
        if done:
            monkeypatch.setattr(interrupts._ending, "struck", Terminated)
            raise Terminated
        done.append(run(*arguments))
        return done[0]

    monkeypatch.setattr(levers, "_run", strike)
    page, trace = tmp_path / "page.html", tmp_path / "run.mcap"
    ended = hwsw("run", board, plan, "--json", "--html", page, "--trace", trace)
    assert ended.exit_code == EXIT_TERMINATED
    assert [lever["path"] for lever in json.loads(ended.stdout)["mission"]["levers"]] == [done[0].path]
    assert "terminated; the mission is complete, but not all of its levers were run" in ended.stderr
    assert page.exists()
    assert trace.exists()
    monkeypatch.setattr(interrupts._ending, "struck", None)


def test_an_interrupt_from_python_is_raised(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def strike(*_: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(levers, "_run", strike)
    with pytest.raises(KeyboardInterrupt):
        codesign.simulate(*Ground(tmp_path).point(), levers=True)


@pytest.mark.slow
def test_the_office_on_a_slow_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """The robot drives nearly all the time; what a faster planner gives is said by its run alone."""
    values = {
        "fpga.clock": "25 MHz",
        "workload.scenario.replan.when_busy": "restart",
        "workload.scenario.replan.trigger": "change",
    }
    point = design_point(codesign.load_platform("zynq"), codesign.load_workload("office-harmonic"), values)

    def the_clock(system: System, result: Result) -> tuple[MissionLever, ...]:
        return tuple(lever for lever in levers_of(system, result) if lever.path == "fpga.clock")

    monkeypatch.setattr(levers, "levers_of", the_clock)
    plain, told = mission_of(simulate(*point)), mission_of(codesign.simulate(*point, levers=True))
    moved = mission_of(simulate(*design_point(*point, {"fpga.clock": "50 MHz"})))
    assert plain.bottleneck is not None
    assert not CLAIMS.search(plain.bottleneck.text)
    assert told.bottleneck is not None
    if moved.mission_time_s < (1 - HELPS) * plain.mission_time_s:
        said = f"{moved.mission_time_s:.4g} s in place of {plain.mission_time_s:.4g} s"
        assert told.bottleneck.text.startswith(f"fpga.clock 25 MHz → 50 MHz: {said}")
    else:
        assert "None of the levers that were run ends the mission earlier" in told.bottleneck.text
