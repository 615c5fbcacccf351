"""A fleet flies the updates of any style: it asks for no more than ``FleetUpdates`` offers."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fleet_specs import Ground
from numpy.typing import NDArray

from codesign.ground.records import MissionRecord, PositionsRecord, Record
from codesign.plugin import FleetUpdates, Step
from codesign.system.scenarios.fleet.scenario import ARRIVED, fly

CYCLES = 1000
THROUGH = f"{ARRIVED}, but 1 pair of them touched on the way and drove on"
UPDATES = 3


class Straight(FleetUpdates):
    """Four robots that go one column to the right in each of three updates; robots 0 and 1 touch in the second."""

    step_ps = 10**11

    def __init__(self, *, leaves: bool = False) -> None:
        self.cycles = np.arange(1, 5) * CYCLES
        self.leaves = leaves
        self.updates = 0

    @property
    def over(self) -> bool:
        return self.updates == UPDATES or self.departure is not None

    @property
    def departure(self) -> str | None:
        return "robot 2 has left" if self.leaves and self.updates == 1 else None

    @property
    def done(self) -> int:
        return self.updates

    @property
    def arrived(self) -> NDArray[np.bool_]:
        return np.full(4, self.over)

    @property
    def positions(self) -> NDArray[np.float64]:
        return np.column_stack([np.arange(4.0), np.full(4, float(self.updates))])

    def decide(self) -> None:
        """Nothing to decide."""

    def hold(self, steps: int) -> None:
        raise AssertionError(f"no update is late, yet it is held for {steps} steps")

    def act(self) -> None:
        self.updates += 1

    def touches(self) -> NDArray[np.float64]:
        return np.array([0.25 if self.updates == 2 else np.inf, *([np.inf] * 5)])

    def steps(self, robot: int, *, visits: bool) -> Generator[Step, None, None]:
        count = 10 if visits else 1
        yield Step("straight", np.full(count, self.cycles[robot] // count))

    def plan(self) -> int:
        return self.updates

    def arrivals(self, plan: int) -> list[int | None]:
        return [plan - 1] * 4

    def collisions(self, plan: int) -> int:
        return int(plan >= 2)

    def time_steps(self, plan: int) -> int:
        return plan


def flown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, updates: Straight, **settings: Any
) -> tuple[Any, list[Record]]:
    records: list[Record] = []
    machine = Ground(tmp_path).machine(listeners=(records.append,), **settings)
    system = machine.system
    monkeypatch.setattr(type(system.architecture), "updates", lambda *_arguments: updates)
    monkeypatch.setattr(type(system.planner), "trajectory", lambda *_arguments: (np.zeros((1, 2)), True))
    return fly(machine), records


@pytest.mark.parametrize("granularity", ["run_ahead", "visit"])
def test_a_style_of_another_planner_flies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, granularity: str) -> None:
    flight, records = flown(tmp_path, monkeypatch, Straight(), granularity=granularity)
    # The slowest of four robots takes 4,000 cycles of 20 ns.
    assert flight.ends == tuple(update * 4 * CYCLES * 20_000 for update in (1, 2, 3))
    assert (flight.plan, flight.figures.ended, flight.figures.updates) == (UPDATES, THROUGH, UPDATES)
    assert flight.figures.robots_s == pytest.approx(0.3)
    positions = [record for record in records if isinstance(record, PositionsRecord)]
    assert [record.positions[0].tolist() for record in positions] == [[0.0, float(column)] for column in range(4)]
    contacts = [record for record in records if isinstance(record, MissionRecord) and record.event == "contact"]
    assert [(record.time, record.text) for record in contacts] == [
        (flight.ends[1], "robots 0 and 1 touch 25 ms after they began the motion of update 2")
    ]


def test_a_departure_of_another_planner_ends_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flight, records = flown(tmp_path, monkeypatch, Straight(leaves=True))
    assert flight.figures.ended == "robot 2 has left"
    ended = [record for record in records if isinstance(record, MissionRecord) and record.event == "ended"]
    assert [record.text for record in ended] == ["robot 2 has left"]
