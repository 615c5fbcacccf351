"""The pace of a processor: what its load and its jitter leave of a core."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.figures import Figure, Status
from codesign.laws.acts import UNDISTURBED, KernelLaw, pace_of

SHARES = st.floats(0.0, 0.99)
FACTORS = st.floats(1.0, 100.0)


def figure(values: Any) -> Figure:
    low, value, high = sorted(values)
    return Figure(value, "1", Status.ASSUMED, "a sample", low, high)


def board(**keys: Any) -> dict[str, Any]:
    power = {"busy": "2 W", "idle": "1 W"}
    host = {"type": "processor", "clock": "1 GHz", "costs": {"breadth_first_cell": "8 ns"}, "power": power} | keys
    return {"kind": "platform", "name": "here", "components": {"host": host}}


def plan(**keys: Any) -> Any:
    costs = {f"breadth_first_{kernel}cell": "8 ns" for kernel in ("", "map_", "wall_")}
    problem = {"map": {"generate": "empty", "rows": 9, "columns": 9}, "goals": [[8, 8]], "starts": [[0, 0]]}
    mapping = {"search": {"component": "host", "style": "software"}}
    workload = {"kind": "workload", "name": "here", "planner": "breadth_first", "problem": problem, "mapping": mapping}
    return codesign.simulate(board(costs=costs, **keys), workload)


@given(st.tuples(SHARES, SHARES, SHARES), FACTORS, FACTORS)
def test_the_pace_lies_in_its_interval_and_jitter_and_load_only_slow_down(loads: Any, one: float, other: float) -> None:
    median, p99 = sorted((one, other))
    pace = pace_of(figure(loads), figure([median] * 3), figure([p99] * 3))
    assert pace is not None
    assert 0 <= pace.low <= pace.value <= pace.high <= UNDISTURBED
    assert pace.value <= UNDISTURBED * (1 - sorted(loads)[1]) / median < pace.value + 1
    assert pace.low <= UNDISTURBED * (1 - max(loads)) / p99 < pace.low + 1


def test_a_host_that_declares_neither_has_no_pace() -> None:
    assert pace_of(None, None, None) is None
    assert KernelLaw(8).rate() == 10**12
    assert "host.pace" not in plan().terms.inputs
    assert "load" not in codesign.load_platform(board()).model_dump_json()


def test_half_a_core_takes_twice_the_time_and_the_99th_percentile_is_the_worst() -> None:
    alone, half = plan(), plan(load=0.5)
    assert half.task.plan_time_mean_s == pytest.approx(2 * alone.task.plan_time_mean_s, rel=1e-12)
    late = plan(load=0.5, jitter={"median": 1.25, "p99": 2})
    assert late.task.plan_time_mean_s == pytest.approx(2.5 * alone.task.plan_time_mean_s, rel=1e-9)
    low, high = late.terms.interval("plan_time_mean_s")
    assert low == pytest.approx(2 * alone.task.plan_time_mean_s, rel=1e-6)
    assert high == pytest.approx(4 * alone.task.plan_time_mean_s, rel=1e-6)


def test_load_and_jitter_that_cannot_be_are_refused_together() -> None:
    with pytest.raises(SpecError) as caught:
        codesign.load_platform(board(load=1, jitter={"median": 1.2, "p99": 1.1}))
    text = str(caught.value)
    assert "components.host.load: 1 is out of bounds" in text
    assert "components.host.jitter.p99: 1.1 is below the median" in text
