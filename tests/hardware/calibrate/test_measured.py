"""A plan measured on the board: against the model, and back into the figures that decide the next verdict."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES
from codesign.hardware.calibrate.measured import Compared, compare_measured
from codesign.inputs import load_platform
from codesign.system.verdicts import need_verdict

WORST = FIGURES["plan_time_worst_s"]
WORKLOAD = """
kind: workload
name: small
planner: PLANNER
problem:
  map: {generate: rooms, rows: 60, columns: 80, room: [18, 20], door: 3, seed: 4}
  goals: [[5, 5]]
  starts: [[50, 70], [30, 40]]
mapping: {TASK: {component: COMPONENT, style: STYLE}}
"""
MEASURED = """kind: measured
platform: {platform}
workload: work.yaml
date: 2026-11-20
runs: 500
time_of_a_plan: {{median: {median}, p99: {p99}}}
"""


def compared(
    folder: Path, median: float, p99: float, platform: str = "raspberry-pi-4", work: tuple[str, ...] = ()
) -> Compared:
    """A measurement, with times in s."""
    planner, task, component, style = work or ("breadth_first", "search", "host", "software")
    text = WORKLOAD.replace("PLANNER", planner).replace("TASK", task).replace("STYLE", style)
    (folder / "work.yaml").write_text(text.replace("COMPONENT", component))
    times = {name: f"{round(1e12 * value)} ps" for name, value in (("median", median), ("p99", p99))}
    (folder / "m.yaml").write_text(MEASURED.format(platform=platform, **times))
    return compare_measured(folder / "m.yaml", folder)


def model(folder: Path, platform: Any = "raspberry-pi-4") -> Any:
    return codesign.simulate(platform, str(folder / "work.yaml"))


@pytest.mark.parametrize("share", [0.2, 0.7, 0.95])
@pytest.mark.parametrize("spread", [1.0, 1.1, 1.5])
def test_the_platform_that_follows_says_what_was_measured(tmp_path: Path, share: float, spread: float) -> None:
    low, high = compared(tmp_path, 1e-4, 1e-4).interval
    median = low + share * (high - low)
    found = compared(tmp_path, median, spread * median)
    assert found.off == 1.0
    result = model(tmp_path, yaml.safe_load(found.text))
    assert result.figure(WORST) == pytest.approx(median, rel=1e-3)
    assert result.interval(WORST) == pytest.approx((median, spread * median), rel=1e-3)
    assert {figure.status for figure in found.figures.values()} == {"measured"}
    assert all("m.yaml of 2026-11-20" in figure.source for figure in found.figures.values())


@pytest.mark.parametrize(("factor", "state"), [(0.9, "refuted"), (1.02, "depends"), (1.3, "proved")])
def test_a_need_that_depended_holds_or_fails(tmp_path: Path, factor: float, state: str) -> None:
    """Between median and 99th percentile it still depends."""
    low, high = compared(tmp_path, 1e-4, 1e-4).interval
    median = (low * high) ** 0.5
    found = compared(tmp_path, median, 1.1 * median)
    limit = factor * median
    assert need_verdict(model(tmp_path), WORST, limit).state == "depends"
    assert need_verdict(model(tmp_path, yaml.safe_load(found.text)), WORST, limit).state == state


def test_declared_load_and_jitter_are_not_counted_twice(tmp_path: Path) -> None:
    platform = yaml.safe_load((codesign.inputs.files.data_folder("platforms") / "raspberry-pi-4.yaml").read_text())
    platform["components"]["host"] |= {"load": 0.2, "jitter": {"median": 1.05, "p99": 1.5}}
    (tmp_path / "loaded.yaml").write_text(yaml.safe_dump(platform))
    low, high = compared(tmp_path, 1e-4, 1e-4, "loaded.yaml").interval
    median = (low * high) ** 0.5
    for spread in (1.2, 3.0):
        found = compared(tmp_path, median, spread * median, "loaded.yaml")
        assert not any(name.endswith(".pace") for name in found.figures)
        least, most = found.narrowed
        assert least <= median
        # The declared jitter is the least spread that the platform has.
        assert most == pytest.approx(median * max(spread, 1.5 / 1.05), rel=1e-3)


def test_a_link_that_decides_is_solved_for(tmp_path: Path) -> None:
    """On an FPGA behind a serial line the open figure of the platform is not a cost."""
    platform = {
        "kind": "platform",
        "name": "mine",
        "components": {
            "fpga": {"type": "fpga", "part": "XC7A35T-1", "clock": "50 MHz"},
            "host": {"type": "processor", "host": "cortex-a72"},
        },
        "links": {
            "line": {
                "type": "bus",
                "between": ["host", "fpga"],
                "width": 8,
                "setup_cycles": 4,
                "burst_words": 16,
                "clock": {
                    "value": "1 MHz",
                    "low": "500 kHz",
                    "high": "4 MHz",
                    "status": "assumed",
                    "source": "a guess",
                },
            }
        },
        "roles": {"host": "host", "fabric": "fpga", "link": "line"},
    }
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(platform))
    work = ("breadth_first", "search", "fpga", "state_machine")
    low, high = compared(tmp_path, 2e-3, 2e-3, "mine.yaml", work).interval
    median = (low * high) ** 0.5
    found = compared(tmp_path, median, 1.2 * median, "mine.yaml", work)
    assert set(found.figures) == {"line.clock"}
    clock = found.figures["line.clock"]
    assert clock.low < clock.value == clock.high, "slower is the end of the 99th percentile"
    assert model(tmp_path, yaml.safe_load(found.text)).figure(WORST) == pytest.approx(median, rel=1e-2)


def test_outside_is_said_and_is_the_answer_no(tmp_path: Path, hwsw: Callable[..., Any]) -> None:
    low, high = compared(tmp_path, 1e-4, 1e-4).interval
    assert compared(tmp_path, 2 * high, 2 * high).off == pytest.approx(2, rel=1e-3)
    assert compared(tmp_path, low / 4, low).off == pytest.approx(0.25, rel=1e-3)
    done = hwsw("measured", tmp_path / "m.yaml", "--write", tmp_path / "new.yaml")
    assert done.exit_code == 3
    assert "outside, 0.25 times the least" in done.output
    assert load_platform(str(tmp_path / "new.yaml")).name == "raspberry-pi-4"
    again = hwsw("measured", tmp_path / "m.yaml", "--json")
    assert json.loads(again.stdout)["inside"] is False


def test_every_fault_of_a_measurement_is_told_at_once(tmp_path: Path, hwsw: Callable[..., Any]) -> None:
    compared(tmp_path, 1e-4, 1e-4)
    text = MEASURED.format(platform="raspberry-pi-4", median="3 ms", p99="2 ms").replace("runs", "run")
    (tmp_path / "m.yaml").write_text(text)
    done = hwsw("measured", tmp_path / "m.yaml")
    assert done.exit_code == 2
    assert "m.yaml:5:1: run: unknown key" in done.output
    assert "did you mean runs?" in done.output
    assert "m.yaml:6:" in done.output
    assert "time_of_a_plan.p99: the 99th percentile is below the median" in done.output


def test_a_time_that_no_cost_explains_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"time_of_a_plan.median: no value of host.costs"):
        compared(tmp_path, 3600.0, 3600.0)
