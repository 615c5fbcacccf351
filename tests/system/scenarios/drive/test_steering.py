"""How a drive is led by its plans: by a whole way, by a few cells at a time, by one decision a turn."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mission_specs import IDEAL, POINT, Ground

from codesign.ground.errors import SpecError
from codesign.ground.records import FieldRecord, MessageRecord, MissionRecord, Record, TaskRecord
from codesign.planners.harmonic.plan.precision import converged_field
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.relaxation.styles.host import SEARCH_UNITS
from codesign.planners.wavefront.plan.parameters import PropagateParameters
from codesign.planners.wavefront.plan.planner import PLANNER
from codesign.system.chain import Answer
from codesign.system.results.ledger import Ledger
from codesign.system.scenarios import bind, simulate
from codesign.system.scenarios.drive.mission import ActivePlan, drive
from codesign.system.scenarios.drive.scenario import first_plan_fields

NODE_UPDATE = 10_000
"""ps, of the platform's kernel ``relaxation_node_update``."""


@pytest.fixture
def ground(tmp_path: Path) -> Ground:
    return Ground(tmp_path)


def messages(records: list[Record], name: str) -> list[MessageRecord]:
    return [record for record in records if isinstance(record, MessageRecord) and record.name == name]


def tasks(records: list[Record], source: str, name: str) -> list[TaskRecord]:
    return [
        record
        for record in records
        if isinstance(record, TaskRecord) and (record.source, record.task) == (source, name)
    ]


def course(kind: str, steps: int = 1) -> dict[str, Any]:
    return {"propagate": {"course": kind, "steps": steps}}


def test_a_local_course_is_asked_for_at_every_turn(ground: Ground) -> None:
    result, records = ground.watched("wavefront", mapping=course("local", 3))
    assert result.mission is not None
    assert result.mission.reached
    asked, told = messages(records, "pose"), messages(records, "way")
    # Turns before the first plan stands have nobody to ask, and the last one ends the mission.
    assert result.mission.turns - 3 <= len(asked) <= result.mission.turns
    assert len(told) == len(asked) + result.mission.plans
    assert {record.bits for record in told} == {3 * 64}
    tracked = [record.cycles for record in tasks(records, "fpga", "track")]
    assert len(tracked) == len(told)
    assert set(tracked) <= {2 + 10 * steps for steps in (1, 2, 3)}


def test_a_complete_course_is_sent_once_a_plan(ground: Ground) -> None:
    result, records = ground.watched("wavefront", mapping=course("complete"))
    assert result.mission is not None
    assert result.mission.reached
    assert messages(records, "pose") == []
    assert len(messages(records, "way")) == len(tasks(records, "fpga", "track")) == result.mission.plans


@pytest.mark.parametrize("placement", ["wavefront", "wavefront-tiled-track-on-host", "wavefront-host"])
def test_a_robot_that_knows_few_cells_drives_no_faster_than_it_can_brake(ground: Ground, placement: str) -> None:
    runs = {
        steps: ground.run(placement, platform=[IDEAL], mapping=course("local", steps)).mission for steps in (1, 2, 9)
    }
    whole = ground.run(placement, platform=[IDEAL], mapping=course("complete")).mission
    assert whole is not None
    times = []
    for mission in (*runs.values(), whole):
        assert mission is not None
        assert (mission.reached, mission.contacts, mission.safety_stops) == (True, 0, 0)
        times.append(mission.mission_time_s)
    # One cell is 0.1 m, in which 0.5 m/s² stops 0.32 m/s; to stop from 0.5 m/s takes 2.5 cells.
    assert times[0] > times[1] > times[2] == times[3]


def test_a_robot_that_stops_at_once_needs_the_next_cell_only(ground: Ground) -> None:
    runs = [
        ground.run("wavefront", platform=[IDEAL, POINT], mapping=course(kind)).mission for kind in ("local", "complete")
    ]
    assert runs[0] is not None
    assert runs[1] is not None
    assert runs[0].distance_m == runs[1].distance_m
    assert runs[0].mission_time_s == runs[1].mission_time_s


def test_ways_that_cut_corners_are_refused_for_a_drive(ground: Ground) -> None:
    point = ground.point("wavefront", mapping={"propagate": {"corner_cutting": True}})
    with pytest.raises(SpecError, match=r"mapping\.propagate\.corner_cutting") as refused:
        bind(*point)
    assert "no robot can drive" in str(refused.value)
    assert "hint: set corner_cutting: false" in str(refused.value)
    once = ground.point(
        "wavefront",
        mapping={"propagate": {"corner_cutting": True}},
        workload={"scenario": {"=": {"type": "plan_once"}}},
    )
    assert simulate(*once).feasible


def test_one_step_of_a_descent_is_what_a_turn_takes(ground: Ground) -> None:
    result, records = ground.watched("relaxation")
    assert result.mission is not None
    assert result.mission.reached
    spent = [record.end - record.time for record in tasks(records, "host", "search")]
    single = SEARCH_UNITS * NODE_UPDATE
    whole = [time for time in spent if time > single]
    # The search of a plan goes all the way; that of a turn tells the next cell.
    assert len(whole) == result.mission.plans
    assert all(time % single == 0 for time in whole)
    assert len(spent) - len(whole) >= result.mission.turns - 3
    assert set(spent) - set(whole) == {single}


def test_a_robot_beyond_the_wave_has_lost_its_way() -> None:
    free = np.ones((5, 20), np.bool_)
    problem = Problem(free, ((2, 2),), ((2, 10),))
    parameters = PropagateParameters(corner_cutting=False)
    answer = Answer(problem, PLANNER.plan(Job(problem, parameters)), 0, 0, 0, Ledger())
    # The wave stopped when it came to the start: behind it no potential tells the way.
    places = (2.0, 10.9), (2.0, 11.7)
    close, far = (ActivePlan(answer, PLANNER, place, again=True) for place in places)
    assert (close.lost(places[0], free), close.target, close.arrives) == (False, (2, 2), True)
    assert (far.lost(places[1], free), far.path.length, far.arrives) == (True, 0.0, False)


@pytest.mark.parametrize("placement", ["breadth-first", "wavefront"])
def test_each_plan_of_a_drive_tells_its_field(ground: Ground, placement: str) -> None:
    result, records = ground.watched(placement, known="none", replan={"trigger": "change"})
    assert result.mission is not None
    fields = [record for record in records if isinstance(record, FieldRecord)]
    assert len(fields) == result.mission.plans > 1
    # Each before its plan is said to be ready, which is when a trace shows it.
    story = [
        record
        for record in records
        if isinstance(record, FieldRecord) or (isinstance(record, MissionRecord) and record.event == "plan_ready")
    ]
    assert [isinstance(record, FieldRecord) for record in story] == [True, False] * len(fields)


@pytest.mark.parametrize("policy", ["restart", "continue"])
def test_a_drive_that_goes_on_from_old_values_tells_how_many_are_wrong(ground: Ground, policy: str) -> None:
    listener: list[Record] = []
    machine = ground.machine(
        "harmonic",
        listeners=(listener.append,),
        known="none",
        purpose="explore",
        mapping={"relax": {"stop": "schedule_end"}},
        replan={"policy": policy},
    )
    done = drive(machine)
    assert done.log.plans > 1
    assert done.log.last is not None
    last = done.log.last
    plan = last.plan
    exact = converged_field(last.problem.free, last.problem.goals, plan.precision)
    wrong = int((exact.limbs != plan.field.limbs).any(axis=2).sum())
    fields = first_plan_fields(machine, done.log.first, last, None)
    told = fields.get("details", {})
    assert fields["quality"].wrong_cells == 0
    if policy == "continue":
        assert told["wrong_cells_of_the_last_plan"] == wrong > 0
    else:
        assert wrong == 0
        assert "wrong_cells_of_the_last_plan" not in told


def test_a_drive_without_a_plan_has_no_figures_of_one(ground: Ground) -> None:
    machine = ground.machine("harmonic")
    assert first_plan_fields(machine, None, None, None) == {}
