"""Causality, by the records of a drive alone.

Nothing acts on what had not arrived, and what is acted on is what was sent.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from codesign.components.path import NEAR, Polyline, cell_of
from codesign.ground.records import (
    BeliefRecord,
    CommandRecord,
    MapRecord,
    MessageRecord,
    PlanRecord,
    PoseRecord,
    Record,
)
from codesign.system import Result

FREE = 1


class Arrivals:
    """Messages from one task to another by when they were handed to the links (ps): when they arrived.

    Of several in one picosecond the latest arrival. Tasks on one component hand each other all at once.
    """

    def __init__(self, records: Sequence[Record], name: str, origin: str, target: str) -> None:
        self.here = origin == target
        self.times: dict[int, int] = {}
        hops = defaultdict(list)
        for record in records:
            if isinstance(record, MessageRecord) and (record.name, record.outcome) == (name, "delivered"):
                hops[record.sender, record.time].append(record)
        for (sender, asked), first in hops.items():
            for hop in first if sender == origin else ():
                end = hop
                while end.receiver != target and hops.get((end.receiver, end.end)):
                    end = hops[end.receiver, end.end][0]
                if end.receiver == target:
                    self.times[asked] = max(self.times.get(asked, 0), end.end)

    def of(self, asked: int) -> int | None:
        """When what was handed over at ``asked`` arrived; None where it did not."""
        return asked if self.here else self.times.get(asked)


def check_causality(result: Result, records: Sequence[Record]) -> int:
    """Check a drive; how many commands it had."""
    places = result.places
    planning = result.component
    scans = Arrivals(records, "scan", places["sense"], places["load"])
    commands = [record for record in records if isinstance(record, CommandRecord)]
    plans = {record.number: record for record in records if isinstance(record, PlanRecord)}
    _check_beliefs(records, scans)
    for plan in plans.values():
        maps = Arrivals(records, "map", places["load"], planning)
        _check_plan(plan, maps, scans)
    sent = Arrivals(records, "command", places["command"], places["move"])
    # The robot is told what was sent, once, when that arrives.
    assert {(each.composed, each.time) for each in commands} == set(sent.times.items())
    assert len(commands) == len(sent.times)
    poses = {record.time: record for record in records if isinstance(record, PoseRecord)}
    asked = Arrivals(records, "pose", places["load"], _decider(records, places))
    for each in commands:
        scanned = scans.of(each.seen)
        assert scanned is not None
        assert scanned <= each.composed <= each.time
        plan = plans[each.plan]
        assert plan.time <= each.composed
        # By the newest plan that was there when the turn asked for its decision, or was commanded without one.
        begin = min((time for time in asked.times if time >= scanned), default=each.composed)
        newer = plans.get(each.plan + 1)
        assert plan.time <= min(begin, each.composed)
        assert newer is None or newer.time >= scanned
        pose = poses[each.seen]
        assert tuple(each.points[0]) == (pose.row, pose.column)
    if not _damaged(records):
        # Otherwise what was sent is not what arrived.
        _check_known(records, commands)
    _check_motion(records, commands)
    return len(commands)


def _damaged(records: Sequence[Record]) -> bool:
    """Whether a command was delivered damaged, and nobody noticed."""
    told = (record for record in records if isinstance(record, MessageRecord))
    return any(record.damaged and record.name == "command" for record in told)


def _decider(records: Sequence[Record], places: dict[str, str]) -> str:
    """Where poses are sent for a decision."""
    found = {record.receiver for record in records if isinstance(record, MessageRecord) and record.name == "pose"}
    return next(iter(found), places["load"])


def _check_beliefs(records: Sequence[Record], scans: Arrivals) -> None:
    for record in records:
        if isinstance(record, BeliefRecord):
            assert record.seen is not None
            scanned = scans.of(record.seen)
            assert scanned is not None
            assert scanned <= record.time


def _check_plan(plan: PlanRecord, maps: Arrivals, scans: Arrivals) -> None:
    assert plan.asked <= plan.loaded <= plan.planned <= plan.time
    scanned = scans.of(plan.seen)
    assert scanned is not None
    assert scanned <= plan.asked
    if not maps.here:
        # Where another task needs the map first, the planner is sent it later; it is still the one of ``asked``.
        assert plan.loaded in {arrival for asked, arrival in maps.times.items() if asked >= plan.asked}


def _check_known(records: Sequence[Record], commands: Sequence[CommandRecord]) -> None:
    """Of a map that is learnt on the way: what a command lets the robot drive had been seen free by then."""
    (drawn,) = [record for record in records if isinstance(record, MapRecord)]
    learnt = iter([record for record in records if isinstance(record, BeliefRecord)])
    known = np.full(drawn.free.shape, -1)
    waiting = next(learnt, None)
    for command in commands:
        while waiting is not None and waiting.time <= command.composed:
            known[tuple(waiting.cells.T)] = ~waiting.blocked
            waiting = next(learnt, None)
        cells = _cells(command)[1:]
        told = known[tuple(np.array(cells, int).reshape(-1, 2).T)]
        # What was known from the start is told by no record.
        assert (told != 0).all(), "a cell that had been seen blocked"


def _cells(command: CommandRecord) -> list[tuple[int, int]]:
    way = Polyline(command.points).head(command.end)
    return [(int(row), int(column)) for row, column in way.crossings[1][:, :2]]


def _check_motion(records: Sequence[Record], commands: Sequence[CommandRecord]) -> None:
    """Before the first command the robot stands; then it is nowhere but in cells of commands that have arrived."""
    poses = [record for record in records if isinstance(record, PoseRecord)]
    allowed = {cell_of((poses[0].row, poses[0].column))}
    following = iter(commands)
    command = next(following, None)
    for pose in poses:
        while command is not None and command.time < pose.time:
            allowed |= set(_cells(command))
            command = next(following, None)
        if pose.time <= commands[0].time if commands else True:
            assert (pose.row, pose.column) == (poses[0].row, poses[0].column)
        place = pose.row, pose.column
        near = {cell_of((pose.row + down, pose.column + along)) for down in (-NEAR, NEAR) for along in (-NEAR, NEAR)}
        assert near & allowed, f"at {pose.time} ps the robot is at {place}, where no command had sent it"
