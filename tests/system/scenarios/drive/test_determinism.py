"""Drives are the same, bit by bit: at both granularities, watched or not, again, and in another process."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import THOROUGH
from mission_specs import COSTS, PLACEMENTS, Ground, merged, rectangle

import codesign
from codesign.ground.memo import Memo
from codesign.ground.records import Record
from codesign.planners.job import Job
from codesign.system.chain import Answer, plan_chain
from codesign.system.scenarios import bind, simulate
from codesign.views.trace import MemoryListener

ERRORS: dict[str, Any] = {
    "links": {
        "pci": {
            "errors": {
                "bit_error_rate": 1e-4,
                "retries": 3,
                "timeout": "1 ms",
                "drop": 0.02,
                "late": {"share": 0.05, "delay": "20 ms"},
                "seed": 3,
            }
        },
        "uart": {
            "errors": {"bit_error_rate": 1e-4, "retries": 2, "timeout": "5 ms", "drop": 0.05, "seed": 1},
            "outages": [{"begin": "2 s", "end": "2.5 s"}],
        },
    }
}
SLOW: dict[str, Any] = {"components": {"fpga": {"clock": "100 kHz"}, "host": {"costs": dict.fromkeys(COSTS, "20 us")}}}
OBSTACLES: dict[str, Any] = {
    "appearing": [rectangle(2, 9, 1, 2, at="3 s", until="6 s"), rectangle(13, 3, 2, 1, at="1 s")],
    "moving": [{"size": [1, 2], "route": [[1, 12], [6, 13]], "speed": "0.3 m/s"}],
    "random": {"count": 10, "size": 1, "begin": "0 s", "end": "20 s", "stay": "5 s", "seed": 4},
}
LIMIT = "8 s" if THOROUGH else "4 s"
SCENES: dict[str, dict[str, Any]] = {
    "blocked": {},
    "explore": {"purpose": "explore", "limit": LIMIT},
    "change-restart": {"replan": {"trigger": "change", "when_busy": "restart"}},
    "slow": {"slow": True, "replan": {"trigger": "change"}, "deadline": "20 ms", "limit": "6 s"},
    "slow-restart": {"slow": True, "replan": {"trigger": "change", "when_busy": "restart"}, "limit": LIMIT},
    "cut": {"slow": True, "replan": {"trigger": "change"}, "limit": "2.05 s"},
}


def comparable(records: list[Record]) -> list[Any]:
    return [
        (type(record), {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in vars(record).items()})
        for record in records
    ]


def settings(placement: str, scene: str) -> dict[str, Any]:
    scenario = {"known": "none", "obstacles": OBSTACLES, **SCENES[scene]}
    platform = [ERRORS, SLOW] if scenario.pop("slow", False) else [ERRORS]
    if placement == "harmonic-warm":
        scenario["replan"] = {**scenario.get("replan", {}), "policy": "lower_bound"}
    return {"platform": platform, **scenario}


# Every placement in one scene, and in every scene one placement on the FPGA and one on the host; of two more each in
# `make test-all`.
CASES = [
    *((placement, "slow-restart") for placement in PLACEMENTS),
    *(
        pytest.param(placement, scene, marks=[pytest.mark.slow] if more else [])
        for scene in SCENES
        if scene != "slow-restart"
        for more, both in enumerate((("harmonic-warm", "relaxation-sor"), ("harmonic-decide-on-host", "breadth-first")))
        for placement in both
    ),
    ("wavefront-tiled-track-on-host", "cut"),
]


@pytest.mark.parametrize(("placement", "scene"), CASES)
def test_granularity_and_listeners_change_nothing(tmp_path: Path, placement: str, scene: str) -> None:
    """Links that err, obstacles of all kinds, plans that are broken off, ends in the middle of a plan."""
    ground = Ground(tmp_path)
    point = ground.point(placement, **settings(placement, scene))
    ahead, visit = MemoryListener(), MemoryListener()
    memo = Memo()
    result = simulate(*point, listeners=(ahead,))
    assert simulate(*point, listeners=(visit,), granularity="visit", memo=memo) == result
    assert comparable(ahead.records) == comparable(visit.records)
    assert simulate(*point, memo=memo) == result
    assert result.mission is not None
    assert result.mission.turns > 10, "the case drives"


@pytest.mark.parametrize("policy", ["restart", "lower_bound", "continue"])
def test_granularity_changes_nothing_under_any_policy(tmp_path: Path, policy: str) -> None:
    ground = Ground(tmp_path)
    replan = {"policy": policy, "trigger": "change", "when_busy": "restart"}
    made = ground.point(
        "harmonic-warm", platform=[ERRORS, SLOW], known="none", obstacles=OBSTACLES, replan=replan, limit="6 s"
    )
    ahead, visit = MemoryListener(), MemoryListener()
    assert simulate(*made, listeners=(ahead,)) == simulate(*made, listeners=(visit,), granularity="visit")
    assert comparable(ahead.records) == comparable(visit.records)


AGAIN = """\
import sys, codesign
board, plan, trace, granularity = sys.argv[1:]
platform, workload = codesign.load_platform(board), codesign.load_workload(plan)
result = codesign.simulate(platform, workload, trace=trace, granularity=granularity)
print(result.model_dump_json())
"""


def test_the_same_seed_gives_the_same_bytes_in_every_process(tmp_path: Path) -> None:
    ground = Ground(tmp_path)
    files = ground.files("harmonic-decide-on-host", **settings("harmonic-decide-on-host", "change-restart"))
    trace = tmp_path / "there.mcap"
    done = subprocess.run(
        [sys.executable, "-c", AGAIN, *map(str, files), str(trace), "visit"],
        env={**os.environ, "PYTHONHASHSEED": "7"},
        capture_output=True,
        timeout=120,
        check=True,
    )
    there = done.stdout, hashlib.sha256(trace.read_bytes()).hexdigest()
    result = codesign.simulate(
        codesign.load_platform(files[0]), codesign.load_workload(files[1]), trace=tmp_path / "here.mcap"
    )
    digest = hashlib.sha256((tmp_path / "here.mcap").read_bytes()).hexdigest()
    assert there == (f"{result.model_dump_json()}\n".encode(), digest)


@pytest.mark.parametrize("which", ["link", "obstacles"])
def test_another_seed_gives_another_drive(tmp_path: Path, which: str) -> None:
    """Else the test above would hold of a simulation that draws nothing."""
    ground = Ground(tmp_path)
    first = ground.run("breadth-first", **settings("breadth-first", "explore"))
    platform: list[Any] = [ERRORS]
    obstacles = OBSTACLES
    if which == "link":
        platform.append({"links": {"uart": {"errors": {"seed": 99}}}})
    else:
        obstacles = merged(OBSTACLES, {"random": {"seed": 99}})
    second = ground.run(
        "breadth-first", **{**settings("breadth-first", "explore"), "platform": platform, "obstacles": obstacles}
    )
    assert first != second


@pytest.mark.parametrize("policy", ["restart", "lower_bound", "continue"])
def test_a_start_below_the_answer_changes_no_bit_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, policy: str
) -> None:
    """Under restart and lower_bound every plan of a drive is the planner's own, planned from nothing."""
    answers: list[Answer] = []
    starts: list[Any] = []

    def spied(*arguments: Any, **named: Any) -> Any:
        answer = yield from plan_chain(*arguments, **named)
        answers.append(answer)
        starts.append((named["warm"], named["start"]))
        return answer

    monkeypatch.setattr("codesign.system.scenarios.drive.mission.plan_chain", spied)
    # One stage: from nothing, a schedule ends at the first precision that leads everywhere; a start goes to its last.
    point = Ground(tmp_path).point(
        "harmonic-warm",
        mapping={"relax": {"schedule": {"=": [63]}}},
        known="none",
        replan={"policy": policy, "trigger": "change"},
    )
    result = simulate(*point)
    assert result.mission is not None
    assert result.mission.reached
    assert len(answers) == result.mission.plans > 10
    system = bind(*point)
    planner = system.planner
    for answer in answers:
        alone = planner.identity(planner.plan(Job(answer.problem, system.planning)))
        assert policy == "continue" or planner.identity(answer.plan) == alone
    # The first plan starts as the parameters have it; then the host makes each start, or none.
    assert [warm for warm, _ in starts] == [
        None if not index else policy == "lower_bound" for index in range(len(starts))
    ]
    assert all((start is not None) == (policy == "continue" and index > 0) for index, (_, start) in enumerate(starts))


def test_the_policy_sets_how_long_a_plan_takes(tmp_path: Path) -> None:
    ground = Ground(tmp_path)
    worst = set()
    for policy in ("restart", "lower_bound", "continue"):
        mission = ground.run("harmonic-warm", known="none", replan={"policy": policy}).mission
        assert mission is not None
        assert mission.replans >= 2
        host = [share.seconds for share in mission.latency if (share.kind, share.where) == ("compute", "host")]
        # The host solves once for the first plan, and under lower_bound for all.
        assert sum(host) > 0
        assert mission.plans == mission.replans + 1
        worst.add(mission.replan_latency_worst_s)
    assert len(worst) == 3
