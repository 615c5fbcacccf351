"""What a drive counts adds up: messages, time, energy; whenever and however it ends."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import PLACEMENTS, SECOND, Ground, rectangle

from codesign.ground.records import MessageRecord, MissionRecord, PoseRecord, Record, UtilisationRecord
from codesign.system import Result
from codesign.system.scenarios.drive.mission import drive

RATES = {"bit_error_rate": 3e-4, "retries": 1, "timeout": "2 ms", "drop": 0.1}
FAULTY: dict[str, Any] = {
    "links": {
        "pci": {"errors": {**RATES, "late": {"share": 0.1, "delay": "30 ms"}}},
        "uart": {"errors": RATES, "outages": [{"begin": "1 s", "end": "1.4 s"}]},
    }
}


def check_messages(result: Result, records: list[Record]) -> None:
    assert result.links is not None
    told = [record for record in records if isinstance(record, MessageRecord)]
    assert {record.source for record in told} <= set(result.links)
    for name, link in result.links.items():
        mine = [record for record in told if record.source == name]
        delivered = [record for record in mine if record.outcome == "delivered"]
        assert link.sent == link.delivered + sum(link.dropped.values()) + link.in_flight
        assert len(delivered) == link.delivered
        assert Counter(record.reason for record in mine if record.outcome == "dropped") == link.dropped
        assert sum(record.bits for record in delivered) == link.bits
        # Attempts of a message that is still in flight are counted by the link alone.
        again = sum(max(record.attempts - 1, 0) for record in mine)
        assert again <= link.retransmissions <= again + (100 if link.in_flight else 0)
        assert 0.0 <= link.utilisation <= 1.0


def check_energy(result: Result, robot: tuple[float, float] = (20.0, 5.0)) -> None:
    """Every part anew from utilisation and the powers of the platform of ``mission_specs``."""
    mission, utilisation = result.mission, result.utilisation
    assert mission is not None
    assert utilisation is not None
    span, energy = mission.mission_time_s, mission.energy

    def joules(name: str, busy: float, idle: float) -> float:
        return span * (busy * utilisation[name] + idle * (1 - utilisation[name]))

    assert energy.processors_j == pytest.approx(joules("host", 3.0, 1.0))
    assert energy.links_j == pytest.approx(joules("pci", 2.0, 0.5) + joules("uart", 0.2, 0.1))
    assert energy.robot_j == pytest.approx(robot[0] * mission.driving_s + robot[1] * (span - mission.driving_s))
    if result.power is not None:
        power = result.power.static.value + result.power.dynamic.value * utilisation["fpga"]
        assert energy.fpga_j == pytest.approx(span * power)
    else:
        power = sum(board.value for board in result.idle_fpgas.values())
        assert energy.fpga_j == energy.idle_fpgas_j == pytest.approx(span * power)
        assert power > 0
    parts = energy.fpga_j + energy.processors_j + energy.links_j + energy.memories_j + energy.robot_j
    assert energy.mission_energy_j == pytest.approx(parts)


def check_account(result: Result, records: list[Record]) -> None:
    mission, utilisation = result.mission, result.utilisation
    assert mission is not None
    assert utilisation is not None
    span = mission.mission_time_s
    for name, account in mission.account.items():
        assert account.compute_s + account.transfer_s + account.idle_s == pytest.approx(span)
        assert min(account.compute_s, account.transfer_s, account.wait_s, account.idle_s) >= 0.0
        assert account.compute_s + account.transfer_s == pytest.approx(span * utilisation[name])
    assert mission.account["robot"].compute_s == pytest.approx(mission.driving_s)
    assert 0.0 <= mission.driving_s <= span
    assert mission.waiting_s <= span - mission.driving_s + 1e-9
    assert sum(share.share for share in mission.latency) == pytest.approx(1.0 if mission.latency else 0.0)
    for record in records:
        if isinstance(record, UtilisationRecord):
            assert 0 <= record.busy <= record.span == round(span * SECOND)
            assert record.busy / max(record.span, 1) == pytest.approx(utilisation[record.source])


def check_course(result: Result, records: list[Record]) -> None:
    """The counts of the mission against the trace."""
    mission = result.mission
    assert mission is not None
    events = Counter(record.event for record in records if isinstance(record, MissionRecord))
    assert events["ended"] == 1
    assert events["plan_ready"] == mission.plans
    assert events["deadline_missed"] == mission.missed_deadlines
    assert events["safety_stop"] <= mission.missed_deadlines
    assert events["goal_reached"] == mission.goals_reached
    assert mission.replans <= mission.plans
    poses = [record for record in records if isinstance(record, PoseRecord)]
    assert mission.turns <= len(poses)
    last = [record for record in records if isinstance(record, MissionRecord)][-1]
    assert (last.event, last.text) == ("ended", mission.ended)
    assert last.time == round(mission.mission_time_s * SECOND) == records[-1].time


SETTINGS: dict[str, Any] = {
    "known": "none",
    "obstacles": {"random": {"count": 8, "end": "10 s", "stay": "4 s", "seed": 2}},
    "replan": {"trigger": "change"},
}


@pytest.mark.parametrize("placement", PLACEMENTS)
def test_messages_energy_and_time_add_up(tmp_path: Path, placement: str) -> None:
    result, records = Ground(tmp_path).watched(placement, platform=FAULTY, **SETTINGS)
    check_messages(result, records)
    check_energy(result)
    check_account(result, records)
    check_course(result, records)
    assert result.links is not None
    assert result.links["uart"].retransmissions > 0
    assert sum(result.links["uart"].dropped.values()) > 0


@settings(max_examples=25, derandomize=True)
@given(
    placement=st.sampled_from(sorted(PLACEMENTS)),
    limit=st.integers(0, 2_500_000),
    slow=st.booleans(),
    restart=st.booleans(),
)
def test_they_add_up_wherever_a_mission_is_cut(
    tmp_path: Path, placement: str, limit: int, slow: bool, restart: bool
) -> None:
    """A limit at any microsecond: in a message, a plan, a turn, before the first event."""
    platform = [FAULTY, {"components": {"fpga": {"clock": "1 MHz"}}} if slow else {}]
    replan = {"trigger": "change", "when_busy": "restart" if restart else "finish"}
    ground = Ground(tmp_path)
    result, records = ground.watched(
        placement, platform=platform, **{**SETTINGS, "limit": f"{limit} us", "replan": replan}
    )
    assert result.mission is not None
    assert result.mission.mission_time_s == limit / 1e6
    assert "limit" in result.mission.ended
    check_messages(result, records)
    check_energy(result)
    check_account(result, records)
    check_course(result, records)


def test_a_link_without_a_declared_power_counts_as_none_and_is_named(tmp_path: Path) -> None:
    whole = Ground(tmp_path).run()
    part = Ground(tmp_path).run(platform={"links": {"uart": {"power": None}}})
    for of in ("energy", "mission"):
        told, less = (getattr(result, of) for result in (whole, part))
        told, less = (told, less) if of == "energy" else (told.energy, less.energy)
        assert (told.not_declared, less.not_declared) == ({}, {"links": ("uart",)})
        # Of two links that wait and carry, the serial line takes 0.1 to 0.2 W.
        assert part.mission is not None
        assert 0.1 <= (told.links_j - less.links_j) / part.mission.mission_time_s <= 0.2


def test_a_message_on_the_wire_at_the_end_is_in_flight(tmp_path: Path) -> None:
    """The first scan takes longer than the mission."""
    slow = {"links": {"uart": {"baud": 300}}}
    result, records = Ground(tmp_path).watched(platform=slow, limit="50 ms")
    assert result.links is not None
    assert (result.links["uart"].sent, result.links["uart"].in_flight) == (1, 1)
    assert result.links["uart"].utilisation == 1.0
    check_messages(result, records)
    check_account(result, records)


def test_extra_tasks_keep_the_account(tmp_path: Path) -> None:
    """What nobody waits for is done behind all else, on the same host and link; each message is counted."""
    extra = {
        "tasks": [
            {"name": "record", "after": {"sense": 2000, "search": 64}, "kernel": "log_line", "units": 400},
            {"name": "upload", "after": {"record": 100}, "kernel": "log_line"},
        ],
        "mapping": {"record": {"component": "host"}, "upload": {"component": "host"}},
    }
    ground = Ground(tmp_path)
    result, records = ground.watched(workload=extra, platform=FAULTY, **SETTINGS)
    check_messages(result, records)
    check_energy(result)
    check_account(result, records)
    names = Counter(record.name for record in records if isinstance(record, MessageRecord))
    assert result.mission is not None
    assert 0 < names["record"] <= result.mission.turns + result.mission.plans
    assert "upload" not in names, "on one component nothing is sent"
    # Bare of the extra tasks the mission drives the same way.
    alone = ground.run(platform=FAULTY, **SETTINGS)
    assert alone.mission is not None
    assert alone.links is not None
    assert alone.links["uart"].sent < result.links["uart"].sent  # type: ignore[index]


def test_the_sum_of_waiting_and_driving_is_the_mission(tmp_path: Path) -> None:
    """Driving and standing of the robot itself, to the picosecond, with an end in the middle of a motion."""
    machine = Ground(tmp_path).machine(limit="3333333 us", obstacles={"appearing": [rectangle(2, 5, at="1 s")]})
    done = drive(machine)
    robot = done.scene.robot
    assert robot.speed > 0, "the case ends in motion"
    assert robot.moving + robot.standing == machine.now == 3_333_333_000_000
    assert robot.busy == robot.moving
