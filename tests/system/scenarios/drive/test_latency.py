"""Where the time of plans went adds up to the picosecond, and the trace holds all the work that was done."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import IDEAL, PLACEMENTS, Ground, rectangle

from codesign.ground.records import MissionRecord, Record, TaskRecord, UtilisationRecord, VisitsRecord
from codesign.system import Result
from codesign.system.results.ledger import Spent
from codesign.system.scenarios.drive.mission import drive

ERRORS: dict[str, Any] = {
    "bit_error_rate": 3e-5,
    "retries": 1,
    "timeout": "2 ms",
    "drop": 0.1,
    "late": {"share": 0.1, "delay": "30 ms"},
}
LINKS: dict[str, dict[str, Any]] = {
    "sound": {},
    "ideal": IDEAL,
    "faulty": {"links": {"pci": {"errors": ERRORS}, "uart": {"errors": ERRORS}}},
    "down": {"links": {"pci": {"outages": [{"begin": "900 ms", "end": "1500 ms"}]}}},
}
COMES = {"appearing": [rectangle(2, 5, at="1 s"), rectangle(7, 2, 2, 2, at="2 s", until="3 s")]}

CROSSED: dict[str, Any] = {
    "placement": "harmonic",
    "platform": {"components": {"fpga": {"clock": "50 kHz"}}},
    "known": "none",
    "limit": "2200 ms",
    "obstacles": {"moving": [{"route": [[3, 2], [3, 6]], "speed": "1 m/s"}]},
}
"""Each turn something moves before the robot's eyes, and a plan takes longer than a turn."""

missions = st.fixed_dictionaries(
    {
        "placement": st.sampled_from(sorted(PLACEMENTS)),
        "links": st.sampled_from(sorted(LINKS)),
        "clock": st.sampled_from(["50 kHz", "1 MHz", "100 MHz"]),
        "trigger": st.sampled_from(["blocked", "change"]),
        "when_busy": st.sampled_from(["finish", "restart"]),
        "policy": st.booleans(),
        "known": st.sampled_from(["all", "none"]),
        "limit": st.integers(0, 4_000_000),
    }
)


def specs(mission: dict[str, Any]) -> dict[str, Any]:
    """The mission as keywords of ``Ground``."""
    replan = {"trigger": mission["trigger"], "when_busy": mission["when_busy"]}
    if mission["policy"] and mission["placement"].startswith("harmonic"):
        replan["policy"] = "lower_bound" if mission["placement"] == "harmonic-warm" else "continue"
    return {
        "placement": mission["placement"],
        "platform": [LINKS[mission["links"]], {"components": {"fpga": {"clock": mission["clock"]}}}],
        "limit": f"{mission['limit']} us",
        "known": mission["known"],
        "replan": replan,
        "obstacles": COMES,
    }


@settings(max_examples=examples(40), derandomize=True)
@given(mission=missions)
def test_the_ledger_adds_up_to_all_requests(tmp_path: Path, mission: dict[str, Any]) -> None:
    """Over policies, triggers, links: each picosecond from a scan to what became of its request is booked once."""
    heard: list[Record] = []
    log = drive(Ground(tmp_path).machine(listeners=(heard.append,), **specs(mission))).log
    assert log.planning.total + log.asking.total == sum(one.ended - one.scan for one in log.requests)
    assert min([*log.planning.spent.values(), *log.asking.spent.values()], default=0) >= 0
    told = Counter(record.event for record in heard if isinstance(record, MissionRecord))
    assert len(log.requests) == told["plan_requested"]
    fates = Counter(one.fate for one in log.requests)
    assert fates["answered"] == log.plans == told["plan_ready"]
    assert fates["refused"] == told["no_way"]
    assert (log.planning.spent.keys() >= {(Spent.BROKEN_OFF, "fpga")}) <= (log.broken_off > 0)
    latencies = sorted(one.ended - one.scan for one in log.requests if one.fate == "answered" and one.seen)
    assert latencies == sorted(log.latencies)


@pytest.mark.parametrize(
    ("when_busy", "kinds"), [("finish", {Spent.BEHIND, Spent.UNFINISHED}), ("restart", {Spent.BROKEN_OFF})]
)
def test_requests_that_wait_for_slow_plans_are_in_the_ledger(tmp_path: Path, when_busy: str, kinds: set[Spent]) -> None:
    """Where a plan takes longer than a turn, nearly all of a request's time is spent on other plans."""
    machine = Ground(tmp_path).machine(**CROSSED, replan={"trigger": "change", "when_busy": when_busy})
    log = drive(machine).log
    assert log.planning.total + log.asking.total == sum(one.ended - one.scan for one in log.requests)
    assert {kind for (kind, _), time in log.planning.spent.items() if time > 0} >= kinds


def busy_in_trace(records: list[Record], name: str) -> int:
    """Picoseconds that tasks and visits of a component cover; what overlaps counts once."""
    spans = [
        (record.time, record.end)
        for record in records
        if isinstance(record, TaskRecord | VisitsRecord) and record.source == name
    ]
    covered = until = 0
    for begin, end in sorted(spans):
        covered += max(0, end - max(begin, until))
        until = max(until, end)
    return covered


def check_busy(result: Result, records: list[Record]) -> None:
    told = {record.source: record.busy for record in records if isinstance(record, UtilisationRecord)}
    for name in ("fpga", "host"):
        assert busy_in_trace(records, name) == told[name], name
    assert result.mission is not None
    assert result.mission.account["fpga"].compute_s == pytest.approx(told["fpga"] / 1e12)


@settings(max_examples=examples(25), derandomize=True)
@given(mission=missions)
def test_the_trace_holds_all_the_time_that_a_component_worked(tmp_path: Path, mission: dict[str, Any]) -> None:
    """Broken-off and unfinished tasks too, at both granularities alike."""
    ground = Ground(tmp_path)
    ahead, records = ground.watched(**specs(mission))
    check_busy(ahead, records)
    visits, singly = ground.watched(granularity="visit", **specs(mission))
    assert visits == ahead
    assert [repr(record) for record in singly] == [repr(record) for record in records]


def test_a_livelock_is_said_with_what_ends_it(tmp_path: Path) -> None:
    replan = {"trigger": "change", "when_busy": "restart"}
    result, records = Ground(tmp_path).watched(**CROSSED, replan=replan)
    mission = result.mission
    assert mission is not None
    assert not mission.reached
    assert mission.broken_off_in_a_row >= 10
    assert mission.broken_off >= mission.broken_off_in_a_row
    (told,) = [record for record in records if isinstance(record, MissionRecord) and record.event == "livelock"]
    assert mission.bottleneck is not None
    for text in (told.text, mission.ended, mission.bottleneck.text):
        assert "in a row" in text
        assert "when_busy" in text
    assert mission.latency[0].kind == "broken_off"
    finished = Ground(tmp_path).run(**CROSSED, replan={**replan, "when_busy": "finish"})
    assert finished.mission is not None
    assert (finished.mission.broken_off, finished.mission.broken_off_in_a_row) == (0, 0)
    assert finished.mission.plans > mission.plans
    assert "in a row" not in finished.mission.ended


def test_a_livelock_that_passes_is_said_too(tmp_path: Path) -> None:
    """Once what moves is gone, the mission goes on; its result says how long it had no plan."""
    crosses = {
        "appearing": [
            rectangle(3, 2 + step % 4, at=f"{step * 100} ms", until=f"{step * 100 + 100} ms") for step in range(20)
        ]
    }
    replan = {"trigger": "change", "when_busy": "restart"}
    result = Ground(tmp_path).run(**{**CROSSED, "limit": "8 s", "obstacles": crosses}, replan=replan)
    mission = result.mission
    assert mission is not None
    assert mission.broken_off_in_a_row >= 10
    assert "in a row" not in mission.ended
    assert mission.bottleneck is not None
    assert f"{mission.broken_off_in_a_row} plans in a row were broken off" in mission.bottleneck.text


def test_one_plan_broken_off_is_no_livelock(tmp_path: Path) -> None:
    replan = {"trigger": "change", "when_busy": "restart"}
    result, records = Ground(tmp_path).watched(known="none", replan=replan, limit="3 s")
    assert result.mission is not None
    assert result.mission.broken_off_in_a_row < 10
    assert not [record for record in records if isinstance(record, MissionRecord) and record.event == "livelock"]
