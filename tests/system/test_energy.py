"""Every FPGA that a platform declares draws its static power for the whole run, whether a task is on it or not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import PLACEMENTS, Ground

import codesign
from codesign.ground.records import UtilisationRecord
from codesign.inputs import design_point
from codesign.inputs.library import load_part
from codesign.system import Result
from codesign.system.scenarios import simulate
from codesign.views.report import render_text, result_tables
from codesign.views.trace import MemoryListener

SECOND_BOARD: dict[str, Any] = {
    "components": {"spare": {"type": "fpga", "part": "XC3S500E-4", "clock": "50 MHz"}},
    "links": {"spare_line": {"=": {"type": "ideal", "between": ["host", "spare"]}}},
}
"""Changes of the platform: one FPGA more, on which nothing is done."""

STATIC = {"fpga": "XC4VLX160-12", "spare": "XC3S500E-4"}


def static_of(name: str) -> float:
    return load_part(STATIC[name]).static_power.value


def check_boards(result: Result, records: list[Any], boards: tuple[str, ...]) -> None:
    """Static energy of every board, the dynamic energy of those that worked, and nothing else."""
    energy = result.energy
    assert energy is not None
    assert result.utilisation is not None
    span = next(record.span for record in records if isinstance(record, UtilisationRecord)) / 1e12
    static = {name: static_of(name) for name in boards}
    assert energy.fpga_j >= sum(static.values()) * span * (1 - 1e-12)
    used = set(result.places.values())
    idle = sum(watts for name, watts in static.items() if name not in used)
    assert energy.idle_fpgas_j == pytest.approx(idle * span)
    assert {name: power.value for name, power in result.idle_fpgas.items()} == {
        name: watts for name, watts in static.items() if name not in used
    }
    dynamic = 0.0
    if result.power is not None:
        worker = next(name for name in used if name in boards)
        dynamic = result.power.dynamic.value * result.utilisation[worker]
    assert energy.fpga_j == pytest.approx(span * (sum(static.values()) + dynamic))
    assert energy.energy_j >= energy.fpga_j
    if result.mission is not None:
        assert result.mission.energy.fpga_j == energy.fpga_j
        assert result.mission.energy.idle_fpgas_j == energy.idle_fpgas_j


@settings(max_examples=12, derandomize=True)
@given(placement=st.sampled_from(sorted(PLACEMENTS)), spare=st.booleans(), drives=st.booleans())
def test_every_declared_fpga_draws_its_static_power(tmp_path: Path, placement: str, spare: bool, drives: bool) -> None:
    scenario = {"limit": "1 s"} if drives else {"=": {"type": "plan_once"}}
    point = Ground(tmp_path).point(placement, platform=SECOND_BOARD if spare else (), workload={"scenario": scenario})
    listener = MemoryListener()
    result = simulate(*point, listeners=(listener,))
    assert result.feasible, result.reasons
    check_boards(result, listener.records, ("fpga", "spare") if spare else ("fpga",))


def test_moving_the_plan_to_the_host_keeps_the_static_power_of_the_fpga(tmp_path: Path) -> None:
    """At one length of the mission, the host saves dynamic energy of the FPGA alone."""
    ground = Ground(tmp_path)
    fabric, host = (ground.run(placement, limit="2 s") for placement in ("breadth-first", "breadth-first-host"))
    assert fabric.mission is not None
    assert host.mission is not None
    assert fabric.mission.mission_time_s == host.mission.mission_time_s == 2.0
    static = static_of("fpga") * 2.0
    assert host.mission.energy.fpga_j == host.mission.energy.idle_fpgas_j == pytest.approx(static)
    assert fabric.mission.energy.idle_fpgas_j == 0.0
    assert fabric.power is not None
    assert fabric.utilisation is not None
    saved = fabric.power.dynamic.value * 2.0 * fabric.utilisation["fpga"]
    assert fabric.mission.energy.fpga_j - host.mission.energy.fpga_j == pytest.approx(saved)


def test_explorations_pay_for_the_idle_fpga(tmp_path: Path) -> None:
    """The points of a study are what single runs give."""
    platform, workload = Ground(tmp_path).point(
        "breadth-first",
        limit="1 s",
        workload={
            "variants": {
                "host": {
                    "mapping": {"search": {"component": "host", "style": "software"}, "track": {"component": "host"}}
                },
                "fabric": {
                    "mapping": {
                        "search": {"component": "fpga", "style": "state_machine"},
                        "track": {"component": "fpga"},
                    }
                },
            },
            "explore": {"axes": {"workload.variant": ["host", "fabric"]}, "objectives": ["energy_j", "first_plan_s"]},
        },
    )
    study = codesign.explore(platform, workload)
    for point in study.points:
        alone = simulate(*design_point(platform, workload, point.axes))
        assert point.result is not None
        assert point.result.energy == alone.energy
        assert point.result.energy is not None
        assert (point.result.energy.idle_fpgas_j > 0) == (point.axes["workload.variant"] == "host")


def test_reports_name_the_power_of_boards_without_a_task(tmp_path: Path) -> None:
    result = Ground(tmp_path).run("breadth-first-host", limit="1 s")
    text = "\n".join(render_text(table) for table in result_tables(result))
    assert "static power of fpga, which has no task" in text
    assert "FPGAs without any task drew" in text
    assert load_part(STATIC["fpga"]).static_power.source.split()[0] in text
