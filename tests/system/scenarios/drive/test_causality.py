"""No effect before its cause: by the records of drives, shipped and random."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from causality import Arrivals, check_causality
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import KINEMATICS, PLACEMENTS, SECOND, Ground
from places import ROOT

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.records import BeliefRecord, CommandRecord, PlanRecord, PoseRecord
from codesign.inputs import design_point
from codesign.inputs.scenario import Drive
from codesign.system.scenarios import simulate
from codesign.views.trace import MemoryListener

DRIVES = [
    path.stem
    for path in sorted((ROOT / "workloads").glob("*.yaml"))
    if isinstance(codesign.load_workload(path).scenario, Drive)
]
VARIANTS = ["decide-on-host", "warm-start", "host-relaxation", "wave-track-on-host", "host-wave"]


NAMED = [
    ("zynq", "office-harmonic"),
    ("pc-3400mhz", "office-relaxation"),
    ("arty-a7", "office-breadth-first"),
    ("virtex4-pci", "office-wavefront"),
    ("virtex2pro", "warehouse"),
    ("zynq", "office-partition"),
]
"""Those of docs/missions.md."""


def check_point(platform: str, workload: str, values: dict[str, Any]) -> int:
    """Check a shipped mission with values put in; how many commands it had."""
    board = codesign.load_platform(ROOT / "platforms" / f"{platform}.yaml")
    plan = codesign.load_workload(ROOT / "workloads" / f"{workload}.yaml")
    listener = MemoryListener()
    result = simulate(*design_point(board, plan, values), listeners=(listener,))
    return check_causality(result, listener.records) if result.feasible else -1


@pytest.mark.parametrize(("platform", "workload"), NAMED)
def test_shipped_missions(platform: str, workload: str) -> None:
    assert check_point(platform, workload, {"workload.scenario.limit": "6 s"}) > 20


@pytest.mark.slow
@pytest.mark.parametrize(("platform", "workload"), NAMED)
def test_shipped_missions_to_their_end(platform: str, workload: str) -> None:
    """What appears after some seconds, and plans that are made for it, are in no beginning of a mission."""
    assert check_point(platform, workload, {}) > 500


@pytest.mark.slow
@pytest.mark.parametrize("workload", DRIVES)
def test_every_shipped_drive_on_every_platform_that_ships(workload: str) -> None:
    """Over its own line and over one of 9,600 baud, where a command is on the line for long."""
    done = []
    for platform in sorted(path.stem for path in (ROOT / "platforms").glob("*.yaml")):
        for baud in ({}, {"body.baud": 9600}):
            try:
                done.append(check_point(platform, workload, {"workload.scenario.limit": "8 s", **baud}))
            except SpecError:
                # Not made for each other.
                break
    assert max(done) > 5


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_variants_of_the_partition_study(variant: str) -> None:
    values = {"workload.scenario.limit": "5 s", "workload.variant": variant, "body.baud": 38400}
    assert check_point("zynq", "office-partition", values) > 5


@settings(max_examples=examples(20), derandomize=True)
@given(data=st.data(), placement=st.sampled_from(sorted(PLACEMENTS)))
def test_drives_over_links_and_planners_of_any_speed(tmp_path: Path, data: st.DataObject, placement: str) -> None:
    """Scans and commands that take from microseconds to longer than a period, plans as well, lost messages too."""
    draw = data.draw
    baud = draw(st.sampled_from([4800, 9600, 19_200, 115_200, 2_000_000]))
    errors = {"bit_error_rate": 1e-4, "checksum_bits": 0, "drop": 0.05, "retries": 1, "timeout": "3 ms"}
    faults = errors | {"late": {"share": 0.1, "delay": "20 ms"}} if draw(st.booleans()) else None
    clock = draw(st.sampled_from(["50 kHz", "1 MHz", "50 MHz"]))
    platform = [
        KINEMATICS[draw(st.sampled_from(sorted(KINEMATICS)))],
        {"links": {name: {"errors": faults} for name in ("uart", "pci")} if faults else {}},
        {"links": {"uart": {"baud": baud}, "pci": {"clock": draw(st.sampled_from(["20 kHz", "33 MHz"]))}}},
        {"components": {"fpga": {"clock": clock}, "host": {"costs": {"way_following": "2 ms"}}}},
    ]
    policies = ["restart", "continue"] if placement in {"harmonic", "harmonic-host"} else ["restart"]
    replan = {
        "trigger": draw(st.sampled_from(["blocked", "change"])),
        "when_busy": draw(st.sampled_from(["finish", "restart"])),
        "policy": draw(st.sampled_from(policies)),
    }
    result, records = Ground(tmp_path).watched(
        placement,
        platform=platform,
        known=draw(st.sampled_from(["all", "none"])),
        purpose=draw(st.sampled_from(["reach", "explore"])),
        obstacles={"random": {"count": 6, "end": "6 s", "stay": "3 s", "seed": draw(st.integers(0, 9))}},
        replan=replan,
        deadline=draw(st.sampled_from(["100 ms", "2 s"])),
        limit="7 s",
    )
    check_causality(result, records)


def test_who_keeps_the_map_sends_it_to_who_commands(tmp_path: Path) -> None:
    """Apart from each other, no command is made from what has not been sent."""
    mapping = {"load": {"component": "fpga"}, "command": {"component": "host"}}
    result, records = Ground(tmp_path).watched("breadth-first", mapping=mapping, known="none")
    assert result.mission is not None
    assert result.mission.reached
    assert check_causality(result, records) > 20
    sent = Arrivals(records, "seen", "fpga", "host").times
    for command in records:
        if isinstance(command, CommandRecord):
            assert any(command.seen < asked <= end <= command.composed for asked, end in sent.items())


def test_a_plan_that_arrives_behind_a_command_is_not_in_it(tmp_path: Path) -> None:
    """At 9,600 baud a command takes 12.5 ms; what becomes known meanwhile goes with the next one."""
    result, records = Ground(tmp_path).watched(
        "harmonic", platform={"links": {"uart": {"baud": 9600}}}, known="none", deadline="2 s",
        replan={"trigger": "change"},
    )  # fmt: skip
    check_causality(result, records)
    plans = {record.number: record.time for record in records if isinstance(record, PlanRecord)}
    overtaken = [
        command
        for command in records
        if isinstance(command, CommandRecord)
        and any(command.composed < ready <= command.time for ready in plans.values())
    ]
    assert overtaken, "the case has such plans"
    assert all(plans[command.plan] <= command.composed for command in overtaken)


def test_what_a_robot_does_with_a_command_is_read_from_the_records(tmp_path: Path) -> None:
    """The checker finds a command that came too early, one of another plan, and a robot off its way."""
    result, records = Ground(tmp_path).watched("breadth-first", known="none", replan={"trigger": "change"})
    check_causality(result, records)
    commands = [index for index, record in enumerate(records) if isinstance(record, CommandRecord)]
    middle = commands[len(commands) // 2]
    command = records[middle]
    assert isinstance(command, CommandRecord)
    last = max(record.number for record in records if isinstance(record, PlanRecord))
    for wrong in (
        replace(command, time=command.time - 1),
        replace(command, plan=last),
        replace(command, seen=command.seen + SECOND // 10),
        replace(command, points=command.points + 1.0),
    ):
        with pytest.raises((AssertionError, KeyError)):
            check_causality(result, [*records[:middle], wrong, *records[middle + 1 :]])
    learnt = next(record for record in records if isinstance(record, BeliefRecord))
    early = replace(learnt, time=0)
    with pytest.raises(AssertionError):
        check_causality(result, [early if record is learnt else record for record in records])
    moved = [
        replace(record, row=record.row + 3.0)
        if isinstance(record, PoseRecord) and record.time == command.seen - SECOND // 10
        else record
        for record in records
    ]
    with pytest.raises(AssertionError):
        check_causality(result, moved)
