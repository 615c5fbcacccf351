"""Whatever fleet a workload describes, check and run raise nothing but errors of this project, and agree."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import example, given, settings
from hypothesis import strategies as st

from codesign.ground.errors import CodesignError, InputError, SpecError
from codesign.inputs import load_platform
from codesign.planners.velocity_obstacle.plan import AvoidParameters, avoid, generate
from codesign.planners.velocity_obstacle.plan.avoid import fault_of
from codesign.system import catalog
from codesign.system.scenarios import bind
from codesign.system.scenarios.run import simulate_system

number = st.one_of(
    st.floats(0.1, 60.0),
    st.sampled_from([5e-324, 1e-300, 1e-9, 0.01, 1.0, 63.9, 300.0, 4095.9, 4096.0, 4096.1, 1e300, 0.0, -1.0]),
)
gain = st.one_of(st.floats(-0.1, 2.1), number)
TAME: dict[tuple[str, str], st.SearchStrategy[Any]] = {
    ("robots", "count"): st.integers(2, 6),
    ("robots", "arrangement"): st.sampled_from(["circle", "crossing", "random"]),
    ("robots", "seed"): st.integers(0, 99),
    ("robots", "radius"): st.floats(0.1, 6.0),
    ("robots", "arena"): st.sampled_from([[100.0, 100.0], [300.0, 200.0]]),
    ("avoid", "updates"): st.integers(1, 40),
    ("avoid", "turn"): st.sampled_from([45.0, 135.0, 180.0]),
    ("avoid", "detection"): st.sampled_from(["published", "approaching"]),
    ("avoid", "responsibility"): st.sampled_from(["full", "half"]),
    ("avoid", "margin"): st.floats(0.0, 5.0),
    ("avoid", "gains"): st.sampled_from([{}, {"proportional": 0.5, "derivative": 0.1}]),
    ("scenario", "type"): st.just("fleet"),
    ("scenario", "pace"): st.sampled_from(["real_time", "free_running"]),
    ("scenario", "report"): st.sampled_from(["all", "none"]),
}
"""What every fleet has: values that are accepted."""
WILD: dict[tuple[str, str], st.SearchStrategy[Any]] = {
    ("robots", "count"): st.integers(-1, 70),
    ("robots", "seed"): st.sampled_from([2**64 - 1, 2**64, -1]),
    ("robots", "radius"): number,
    ("robots", "speed"): number,
    ("robots", "acceleration"): number,
    ("robots", "arena"): st.tuples(number, number).map(list),
    ("avoid", "updates"): st.sampled_from([0, 10**5 + 1]),
    ("avoid", "width"): st.integers(7, 25),
    ("avoid", "time_step"): st.sampled_from(["1 us", "3 ms", "1 s", "100 s", "101 s", "0 s"]),
    ("avoid", "directions"): st.sampled_from([8, 16, 24, 512, 520]),
    ("avoid", "speeds"): st.sampled_from([0, 1, 3, 64, 65]),
    ("avoid", "turn"): number,
    ("avoid", "margin"): number,
    ("avoid", "range"): number,
    ("avoid", "tolerance"): number,
    ("avoid", "gains"): st.dictionaries(st.sampled_from(["proportional", "derivative", "integral"]), gain),
    ("scenario", "limit"): st.sampled_from(["1 us", "1 s", "0 s"]),
    ("scenario", "events"): st.sampled_from([0, 1, 50]),
}
"""What a fleet may have besides, or instead: of any size."""


@st.composite
def fleets(draw: Any) -> dict[str, dict[str, Any]]:
    """Sections of a workload: accepted values, of which up to three are replaced by any."""
    told: dict[str, dict[str, Any]] = {"robots": {}, "avoid": {}, "scenario": {}}
    wild = draw(st.lists(st.sampled_from(sorted(WILD)), max_size=3, unique=True))
    for (section, key), values in (TAME | {at: WILD[at] for at in wild}).items():
        told[section][key] = draw(values)
    return told


CLOCKS = st.sampled_from(["1 Hz", "70 Hz", "10 kHz", "50 MHz", "100 MHz"])
PLATFORM = """\
kind: platform
name: boards
components:
  fpga: {{type: fpga, part: XC3S500E-4, clock: {clock}}}
  pc: {{type: processor, clock: 2 GHz, costs: {{render_robot: 0 s}}, power: {{busy: 60 W, idle: 20 W}}}}
links:
  line: {{type: serial, baud: 115200, fifo_depth: 16, between: [fpga, pc]}}
"""


def attempt(action: Callable[[], Any]) -> tuple[Any, CodesignError | None]:
    """What an action gives, or the project's own error; any other exception is let through."""
    try:
        return action(), None
    except CodesignError as error:
        return None, error


@settings(max_examples=examples(150))
@given(fleets(), CLOCKS, st.sampled_from(["sequential", "pipelined"]))
@example(
    {
        "robots": {"count": 2, "arrangement": "circle"},
        "avoid": {"updates": 1, "directions": 512},
        "scenario": {"type": "fleet", "pace": "real_time"},
    },
    "50 MHz",
    "pipelined",
)
def test_any_fleet(tmp_path: Path, fleet: dict[str, dict[str, Any]], clock: str, style: str) -> None:
    board, file = tmp_path / "board.yaml", tmp_path / "robots.yaml"
    board.write_text(PLATFORM.format(clock=clock), encoding="utf-8")
    tree = {
        "kind": "workload",
        "name": "fleet",
        "planner": "velocity_obstacle",
        "problem": {"robots": fleet["robots"]},
        "scenario": fleet["scenario"],
        "mapping": {"avoid": {"component": "fpga", "style": style, **fleet["avoid"]}, "display": {"component": "pc"}},
    }
    file.write_text(json.dumps(tree), encoding="utf-8")
    system, refused = attempt(lambda: bind(load_platform(board), catalog.load_workload(file)))
    if refused is not None:
        assert isinstance(refused, SpecError)
        assert all(fault.line == 1 for fault in refused.faults)
        return
    # What check accepts, run carries to a result.
    result = simulate_system(system)
    if result.feasible:
        assert result.fleet is not None
        quality = result.quality
        assert (quality.shortfall is None) == (quality.robots_arrived == quality.robots)
        assert math.isfinite(quality.closest_approach)
        assert result.fleet.completed == (quality.robots_arrived == quality.robots)
        if fleet["scenario"]["pace"] == "real_time":
            assert result.fleet.robots_s == result.fleet.span_s


SCALES = st.one_of(st.floats(1e-3, 4096.0), st.sampled_from([5e-324, 1e-300, 1e-30, 4096.0]))


@settings(max_examples=examples(300))
@given(
    st.tuples(SCALES, SCALES, SCALES),
    st.sampled_from([1e-3, 1.0, 100.0, 4096.0]),
    st.sampled_from(["1 us", "1 ms", "100 ms", "100 s"]),
    st.integers(8, 24),
    st.tuples(st.floats(0.0, 4096.0), st.none() | SCALES, SCALES),
    st.sampled_from([(16, 1), (64, 10), (512, 64)]),
)
@example((0.1, 1.0, 1.0), 1.0, "100 ms", 24, (4096.0, None, 0.1), (64, 10))
@example((0.1, 0.1, 0.1), 1.0, "100 s", 24, (0.0, 4096.0, 0.1), (64, 10))
@example((0.1, 0.1, 0.1), 1.0, "100 s", 24, (0.0, None, 4096.0), (64, 10))
@example((0.1, 0.01, 4096.0), 1.0, "100 s", 20, (0.0, None, 0.1), (64, 10))
@example((0.1, 1e-300, 4096.0), 1.0, "100 ms", 16, (0.0, None, 0.1), (64, 10))
@example((0.1, 4096.0, 5e-324), 1.0, "1 us", 16, (0.0, None, 0.1), (64, 10))
def test_limits_of_any_scale_are_computed_with_or_refused_by_a_sentence(
    limits: tuple[float, float, float],
    side: float,
    step: str,
    width: int,
    distances: tuple[float, float | None, float],
    array: tuple[int, int],
) -> None:
    radius, speed, acceleration = limits
    margin, sight, tolerance = distances
    problem, refused = attempt(
        lambda: generate("circle", 3, radius=radius, speed=speed, acceleration=acceleration, arena=(side, side))
    )
    if refused is not None:
        assert isinstance(refused, InputError)
        return
    chosen = AvoidParameters(
        updates=5,
        time_step=step,
        width=width,
        margin=margin,
        range=sight,
        tolerance=tolerance,
        directions=array[0],
        speeds=array[1],
    )
    fault = fault_of(problem, chosen)
    if fault is not None:
        assert fault[0] in AvoidParameters.model_fields
        assert len(fault[1]) < 300
        with pytest.raises(InputError):
            avoid(problem, chosen)
        return
    run = avoid(problem, chosen)
    assert np.isfinite(run.cells).all()
    assert np.abs(run.positions).max() < 2**24
