"""Drives against closed forms: the planner run alone, turns and deadlines that are counted by hand, faster parts."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import IDEAL, POINT, ROOMS, SECOND, Ground, rectangle

from codesign.components.path import NEAR, Polyline
from codesign.ground.records import MissionRecord, PoseRecord, Record, TaskRecord
from codesign.planners.job import Job
from codesign.system.results.mission import Mission
from codesign.system.scenarios import bind, simulate
from codesign.system.scenarios.drive.mission import around_corners, drive
from codesign.views.trace import MemoryListener

PERIOD = SECOND // 10
SPEED = 5.0
"""Cells a second: 0.5 m/s on cells of 0.1 m."""


def mission_of(result: Any) -> Mission:
    assert result.mission is not None
    return result.mission  # type: ignore[no-any-return]


def of(records: list[Record], event: str) -> list[int]:
    return [record.time for record in records if isinstance(record, MissionRecord) and record.event == event]


def turn_after(time: float) -> int:
    """The first turn of the control loop at ``time`` or later, ps."""
    return -int(-time // PERIOD) * PERIOD


ALONE = [
    ("breadth-first", 0),
    ("breadth-first-host", 0),
    ("wavefront", 0),
    ("wavefront-tiled-track-on-host", 0),
    ("wavefront-host", 0),
    ("relaxation", None),
    ("harmonic", None),
    # One decision is one unit of 1 us.
    ("harmonic-decide-on-host", 1_000_000),
]


@pytest.mark.parametrize(("placement", "decision"), ALONE)
def test_a_drive_over_links_that_take_no_time_is_the_planner_run_alone(
    tmp_path: Path, placement: str, decision: int | None
) -> None:
    """Known map, a point robot, nothing that comes: one plan, its way driven from end to end at full speed.

    The first command is given in the first turn after the plan; ``decision`` (ps) is what it waits for there.
    """
    ground = Ground(tmp_path)
    point = ground.point(placement, platform=[IDEAL, POINT])
    system = bind(*point)
    planner, problem = system.planner, system.problem
    plan = planner.plan(Job(problem, system.planning))
    points, arrives = planner.trajectory(problem, plan, problem.starts[0])
    assert arrives
    way = Polyline(around_corners(points, problem.free))

    machine = ground.machine(placement, platform=[IDEAL, POINT])
    done = drive(machine)
    robot, log = done.scene.robot, done.log
    assert log.first is not None
    assert planner.identity(log.first.plan) == planner.identity(plan)
    assert (log.plans, log.missed, len(robot.contacts), robot.safety_stops) == (1, 0, 0, 0)
    assert robot.distance == pytest.approx(way.length, abs=1e-4)
    assert robot.moving == pytest.approx(way.length / SPEED * SECOND, abs=1e-4 * SECOND)
    track = np.array([(row, column) for _, row, column in robot.log])
    gaps = [np.hypot(*(way.points - place).T).min() for place in track[[0, -1]]]
    assert gaps[0] == 0.0
    for place in track:
        assert distance_to(way, place) <= 100 * NEAR

    # The same plan as of scenario plan_once.
    once = ground.run(placement, platform=[IDEAL, POINT], workload={"scenario": {"=": {"type": "plan_once"}}})
    result = simulate(*point)
    mission = mission_of(result)
    assert once.time == result.time
    assert once.quality == result.quality
    assert (once.stages, once.precision) == (result.stages, result.precision)

    # First command in the first turn after the answer; then the way at full speed; told at the next turn.
    assert once.time is not None
    begin = turn_after(round(once.time.first_plan_s * SECOND))
    if decision is not None:
        end = begin + decision + way.length / SPEED * SECOND
        assert mission.mission_time_s == turn_after(end - 10) / SECOND
    assert mission.distance_m == pytest.approx(way.length * 0.1, abs=1e-5)
    assert mission.mission_time_s >= (begin + way.length / SPEED * SECOND - 10) / SECOND
    assert mission.driving_s == pytest.approx(way.length / SPEED, abs=1e-4)


def distance_to(way: Polyline, place: Any) -> float:
    base, moved = way.points[:-1], np.diff(way.points, axis=0)
    share = np.clip(((place - base) * moved).sum(axis=1) / (moved**2).sum(axis=1), 0.0, 1.0)
    return float(np.hypot(*(base + share[:, None] * moved - place).T).min())


def test_the_shortest_way_of_a_straight_corridor(tmp_path: Path) -> None:
    """14 cells at 5 cells a second: 2.8 s after the turn that follows the plan, to the middle of the goal's cell."""
    mission = mission_of(
        Ground(tmp_path).run(text="." * 16 + "\n", start=(0, 0), goals=[(0, 14)], platform=[IDEAL, POINT])
    )
    assert mission.mission_time_s == 2.9
    assert mission.shortest_m == pytest.approx(1.35)
    assert mission.distance_ratio == pytest.approx(1.4 / 1.35)
    assert mission.turns == 30
    # Between walls above and below: half a cell from the middle.
    assert mission.clearance_least_m == pytest.approx(0.05)
    assert mission.clearance_mean_m == pytest.approx(0.05)


@pytest.mark.parametrize("spare", [0, -1])
def test_a_turn_is_missed_one_picosecond_after_its_deadline(tmp_path: Path, spare: int) -> None:
    """A turn lasts as long as the scan and the command on the wire; the deadline is that, or a picosecond less."""
    ground = Ground(tmp_path)
    # A character of 10 bits carries 8.
    system = bind(*ground.point(platform=[IDEAL, slow_uart(9600), POINT]))
    scan, command = (
        next(flow.bits for flow in system.placement.graph.flows if flow.name == name) for name in ("scan", "command")
    )
    turn = sum(-(-(-(-bits // 8) * 10 * SECOND) // 9600) for bits in (scan, command))
    listener = MemoryListener()
    machine = ground.machine(
        listeners=[listener],
        platform=[IDEAL, slow_uart(9600), POINT],
        deadline=f"{turn + spare} ps",
        control_period="500 ms",
    )
    done = drive(machine)
    commanded = [record for record in listener.records if getattr(record, "name", "") == "command"]
    assert commanded
    longest = max(record.end - record.time for record in commanded)
    assert longest > 0
    if spare == 0:
        assert done.log.missed == 0
    else:
        # Every turn that commands; the first turn has no plan yet and is answered by the scan alone.
        assert done.log.missed == len(commanded) == done.log.turns - 2
        stops = of(listener.records, "safety_stop")
        assert len(stops) == done.scene.robot.safety_stops > 0
    assert done.log.reached


def slow_uart(baud: int) -> dict[str, Any]:
    return {"links": {"uart": {"=": {"type": "serial", "between": ["host", "robot"], "baud": baud, "fifo_depth": 16}}}}


@pytest.mark.parametrize("places", [("2 kHz", True), ("100 MHz", False)], ids=["slow", "fast"])
def test_decisions_wait_while_the_fpga_plans(tmp_path: Path, places: tuple[str, bool]) -> None:
    """Relaxation and decisions share the FPGA: a plan that outlasts the deadline misses one turn, and the robot stops.

    While it plans, one turn waits for it and the later ones fall out: at most one miss a plan.
    """
    clock, slow = places
    listener = MemoryListener()
    machine = Ground(tmp_path).machine(
        "harmonic",
        listeners=[listener],
        platform=[IDEAL, POINT, {"components": {"fpga": {"clock": clock}}}],
        hidden=[rectangle(7, 3, 2, 8)],
        text="\n".join(["." * 16] * 16) + "\n",
        start=(2, 2),
        goals=[(13, 12)],
        limit="10 min",
        patience="5 min",
    )
    done = drive(machine)
    assert done.log.reached
    asked, ready = of(listener.records, "plan_requested"), of(listener.records, "plan_ready")
    assert len(asked) == len(ready) == done.log.plans >= 2
    plans = list(zip(asked, ready, strict=True))[1:]
    deadline = 3 * PERIOD
    # With links that take no time the turn in which the way was found blocked waits itself for the plan.
    missed = sum(end - begin > deadline for begin, end in plans)
    decisions = of_turns(listener.records)
    assert done.log.missed >= missed
    if slow:
        assert missed == len(plans)
        assert done.scene.robot.safety_stops > 0
        assert done.log.waiting > 0
    else:
        assert done.log.missed == 0
        assert done.scene.robot.safety_stops == 0
    # Turns fall out while one waits: they lie a period apart, or as long as the one before took.
    for one, other in pairwise(decisions):
        assert other > one
        assert other % PERIOD == 0


def of_turns(records: list[Record]) -> list[int]:
    return [record.time for record in records if isinstance(record, PoseRecord)]


@settings(max_examples=examples(12), derandomize=True)
@given(
    placement=st.sampled_from(["breadth-first", "harmonic-decide-on-host", "wavefront-tiled-track-on-host"]),
    bauds=st.lists(st.integers(4800, 400_000), min_size=2, max_size=2, unique=True),
    clocks=st.lists(st.integers(1, 100), min_size=2, max_size=2, unique=True),
    point=st.booleans(),
)
def test_a_faster_link_and_a_faster_clock_are_never_slower_on_a_known_map(
    tmp_path: Path, placement: str, bauds: list[int], clocks: list[int], point: bool
) -> None:
    """Nothing is discovered, so the way is the same, and all that is earlier is earlier."""
    ground = Ground(tmp_path)

    def times(baud: int, clock: int) -> tuple[float, float]:
        changes: list[Any] = [{"links": {"uart": {"baud": baud}}, "components": {"fpga": {"clock": f"{clock} MHz"}}}]
        result = ground.run(placement, platform=[*changes, POINT if point else {}], deadline="3 s")
        assert result.time is not None
        return result.time.first_plan_s, mission_of(result).mission_time_s

    slow = times(min(bauds), min(clocks))
    link, clock, both = (times(max(bauds), min(clocks)), times(min(bauds), max(clocks)), times(max(bauds), max(clocks)))
    for one, other in ((link, slow), (clock, slow), (both, link), (both, clock)):
        assert one[0] <= other[0]
        if point:
            assert one[1] <= other[1]
        else:
            # Off the corners of the same way by what a turn drives at most: commands come at other phases.
            assert one[1] <= other[1] + 0.2
    assert link[0] < slow[0]
    assert clock[0] < slow[0]


def test_a_faster_link_can_lose_where_the_map_is_not_known(tmp_path: Path) -> None:
    """An effect of order, and a real one: what is planned earlier is planned from less.

    The faster scans find the way blocked from another place, the new plan leads another way round, and that is the
    longer one on the true map. All that hangs on speed alone is faster still.
    """
    ground = Ground(tmp_path)
    slow, fast = (
        ground.run(
            "harmonic", platform=[POINT, {"links": {"uart": {"baud": baud}}}], known="none", deadline="3 s", text=ROOMS
        )
        for baud in (38_400, 57_600)
    )
    first, second = mission_of(slow), mission_of(fast)
    assert slow.time is not None
    assert fast.time is not None
    assert fast.time.first_plan_s < slow.time.first_plan_s
    assert second.replan_latency_worst_s is not None
    assert first.replan_latency_worst_s is not None
    assert second.replan_latency_worst_s < first.replan_latency_worst_s
    # It loses time for being the longer way, at 0.5 m/s, give or take the turn in which the end is seen.
    assert second.mission_time_s > first.mission_time_s
    lost = (second.distance_m - first.distance_m) / 0.5
    assert second.mission_time_s - first.mission_time_s == pytest.approx(lost, abs=0.11)


@pytest.mark.parametrize("cores", [1, 2])
def test_control_goes_before_planning_on_a_host(tmp_path: Path, cores: int) -> None:
    """A plan of seconds on the host delays no turn: decisions preempt it, and take nothing from a second core."""
    listener = MemoryListener()
    host = {"cores": cores, "costs": {"harmonic_node_update": "100 us"}}
    machine = Ground(tmp_path).machine(
        "harmonic-host",
        listeners=[listener],
        platform=[IDEAL, POINT, {"components": {"host": host}}],
        hidden=[rectangle(7, 3, 2, 8)],
        text="\n".join(["." * 16] * 16) + "\n",
        start=(2, 2),
        goals=[(13, 12)],
        limit="10 min",
        patience="5 min",
    )
    done = drive(machine)
    assert done.log.reached
    assert done.log.plans >= 2
    assert (done.log.missed, done.scene.robot.safety_stops) == (0, 0)
    times = of_turns(listener.records)
    assert times == [PERIOD * index for index in range(len(times))], "no turn falls out"
    asked, ready = of(listener.records, "plan_requested"), of(listener.records, "plan_ready")
    assert min(end - begin for begin, end in zip(asked, ready, strict=True)) > 3 * PERIOD
    # The first decision of a plan is a part of it; those of the turns begin with them.
    decisions = [
        record.end - record.time
        for record in listener.records
        if isinstance(record, TaskRecord) and record.task == "decide" and record.time % PERIOD == 0
    ]
    assert set(decisions) == {1_000_000}
    assert len(decisions) >= len(times) // 2


def test_a_second_core_takes_decisions_off_a_plan(tmp_path: Path) -> None:
    """On one core each decision that preempts the plan puts it off by as long as it takes itself: 20 ms a turn."""
    latencies = []
    for cores in (1, 2):
        host = {"cores": cores, "costs": {"harmonic_node_update": "100 us", "harmonic_decision": "20 ms"}}
        mission = mission_of(
            Ground(tmp_path).run(
                "harmonic-host",
                platform=[IDEAL, POINT, {"components": {"host": host}}],
                hidden=[rectangle(7, 3, 2, 8)],
                text="\n".join(["." * 16] * 16) + "\n",
                start=(2, 2),
                goals=[(13, 12)],
                limit="10 min",
                patience="5 min",
            )
        )
        assert mission.missed_deadlines == 0
        assert mission.replan_latency_worst_s is not None
        latencies.append(mission.replan_latency_worst_s)
    one, two = latencies
    # Turn by turn: what is left of the plan runs 80 ms of every 100.
    assert one == pytest.approx(two / 0.8, abs=0.1)
