"""Contacts of a fleet: told at the moment at which bodies first touch, and never hidden by an arrival of all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from fleet_specs import Ground
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.ground.records import MissionRecord, PositionsRecord, Record
from codesign.planners.velocity_obstacle.plan.kernels import first_touches
from codesign.system.scenarios.fleet.scenario import ARRIVED, fly

FINE = 20_001
coordinate = st.floats(-8.0, 8.0, allow_subnormal=False)
vectors = st.lists(st.tuples(coordinate, coordinate), min_size=3, max_size=3).map(np.array)


@settings(max_examples=examples(300))
@given(vectors, vectors, vectors, st.floats(0.5, 6.0))
def test_the_first_touch_is_that_of_a_dense_walk(before: Any, after: Any, drift: Any, limit: float) -> None:
    shares = np.linspace(0.0, 1.0, FINE)
    curve = after - before - drift
    first = first_touches(before, after, drift, limit)
    for pair, (one, other) in enumerate(zip(*np.triu_indices(3, 1), strict=True)):
        a, b, c = (each[other] - each[one] for each in (before, drift, curve))
        away = np.hypot(*(a[:, None] + b[:, None] * shares + c[:, None] * shares**2))
        near = np.flatnonzero(away < limit)
        at = first[pair]
        if len(near):
            # No sample before the moment touches, and the first one that does comes at most a step later.
            assert shares[near[0]] - 1.0 / (FINE - 1) - 1e-9 <= at <= shares[near[0]] + 1e-9
        elif at <= 1.0:
            # Between two samples: there the distance is the limit.
            there = np.hypot(*(a + b * at + c * at**2))
            assert there == pytest.approx(limit, abs=1e-6)


def flown(folder: Path, pace: str, **scene: Any) -> tuple[Any, list[Record]]:
    records: list[Record] = []
    parameters = "responsibility: full, margin: 0"
    machine = Ground(folder).machine(
        scenario=f"pace: {pace}", parameters=parameters, listeners=(records.append,), **scene
    )
    return fly(machine), records


def contacts_of(records: list[Record]) -> list[MissionRecord]:
    return [r for r in records if isinstance(r, MissionRecord) and r.event == "contact"]


@pytest.mark.parametrize("clock", ["50 MHz", "2600 Hz"])
def test_a_contact_in_real_time_has_its_moment_between_two_positions(tmp_path: Path, clock: str) -> None:
    """Late or in time: at the moment of the record the centres are two radii apart, on the motion of equation 2b."""
    _, records = flown(tmp_path, "real_time", clock=clock)
    contacts = contacts_of(records)
    assert contacts
    positions = [r for r in records if isinstance(r, PositionsRecord)]
    times = np.array([r.time for r in positions])
    inside = 0
    for contact in contacts:
        after = int(np.searchsorted(times, contact.time))
        assert times[0] < contact.time <= times[after]
        inside += bool(contact.time < times[after])
        one, other = [int(word) for word in contact.text.split() if word.isdigit()][:2]
        gap = [np.hypot(*(each.positions[one] - each.positions[other])) for each in positions]
        assert min(gap[max(0, after - 1) : after + 2]) < 2 * 5.0 + 1.0
        assert gap[after - 1] >= 2 * 5.0
    assert inside, "a contact exactly at an update is a rarity"


def test_robots_that_drove_through_one_another_are_no_success(tmp_path: Path) -> None:
    flight, records = flown(tmp_path, "free_running")
    pairs = {contact.text.partition(" touch")[0] for contact in contacts_of(records)}
    assert flight.figures.ended == f"{ARRIVED}, but {len(pairs)} pairs of them touched on the way and drove on"
    assert not flight.figures.completed
