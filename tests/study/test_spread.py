"""A study that is cut off after any number of points has values of every axis, those that move what is computed too."""

from __future__ import annotations

import json
import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import codesign
from codesign.ground.figures import FIGURES
from codesign.study import Study, explore, load_study
from codesign.study.budget import Budget
from codesign.study.explored import Explored
from codesign.study.outcomes import State
from codesign.study.partition import Together, Turns, parted
from codesign.study.space import Space

PRICES: dict[str, list[Any]] = {
    "fpga.clock": [f"{mhz} MHz" for mhz in range(10, 22)],
    "pci.clock": [f"{mhz} MHz" for mhz in range(10, 20)],
}
COMPUTED: dict[str, list[Any]] = {
    "relax.iterations": [1, 2, 3, 4, 6],
    "relax.block": [[6, 9], [12, 18], [4, 6], [3, 9]],
    "workload.variant": ["base", "deep"],
}
SMALL: dict[str, Any] = {
    "kind": "workload",
    "name": "small",
    "planner": "harmonic",
    "problem": {
        "map": {"generate": "rooms", "rows": 12, "columns": 18, "room": [5, 5], "door": 2, "seed": 3},
        "goals": [[2, 2]],
        "starts": {"count": 3, "seed": 1},
    },
    "mapping": {"relax": {"component": "fpga", "block": [6, 9], "iterations": 4, "schedule": [15]}},
    "variants": {
        "deep": {"mapping": {"relax": {"component": "fpga", "block": [6, 9], "iterations": 4, "schedule": [31]}}}
    },
}


def explored(
    folder: Path, axes: dict[str, Any], points: int, conditions: dict[str, Any] | None = None
) -> tuple[Study, Study]:
    """A study cut off after some points, as it was computed and as its store has it."""
    workload = {**SMALL, "explore": {"axes": axes, "conditions": conditions or {}}}
    (folder / "small.yaml").write_text(json.dumps(workload), encoding="utf-8")
    loaded, store = codesign.load_workload(folder / "small.yaml"), folder / "small.sqlite"
    budget = Budget(points=points)
    study = explore(codesign.load_platform("virtex4-pci"), loaded, workers=1, store=store, budget=budget)
    assert "was used up" in budget.ended
    return study, load_study(store)


def done(study: Study) -> np.ndarray[Any, Any]:
    return np.flatnonzero(study.outcomes.state != State.MISSING)


def assert_spread(study: Study) -> None:
    """Each value was taken about as often as its share of the space asks."""
    every, own = (study.space.levels(points) for points in (np.arange(len(study.points)), done(study)))
    for axis, values in study.every_axis.items():
        for place in range(len(values)):
            asked = np.mean(every[axis] == place) * len(own[axis])
            assert 0.5 * asked - 2 <= np.sum(own[axis] == place) <= 2 * asked + 2, (axis, values[place])
            assert asked < 6 or np.any(own[axis] == place), (axis, values[place])


@pytest.mark.parametrize("seed", range(6))
def test_the_first_points_have_values_of_every_axis(tmp_path: Path, seed: int) -> None:
    draw = random.Random(seed)
    names = draw.sample([*PRICES, *COMPUTED], 5)
    axes = {name: {**PRICES, **COMPUTED}[name] for name in names}
    if seed % 3 == 1:
        axes["pci.clock"] = {"values": axes["pci.clock"], "when": {"workload.variant": "deep"}}
    conditions = {"relax.iterations": axes.pop("relax.iterations")} if seed % 3 == 2 else None
    points = draw.randint(60, 200)
    study, kept = explored(tmp_path, axes, points, conditions)
    assert len(done(study)) == points
    np.testing.assert_array_equal(done(kept), done(study))
    assert_spread(study)


def test_what_is_shared_is_computed_once_however_a_study_is_cut(tmp_path: Path) -> None:
    axes = {**COMPUTED, **PRICES}
    settings, simulated, had = 5 * 4 * 2, 0, 0
    for points in (150, 150, 300):
        study, kept = explored(tmp_path, axes, points)
        had += points
        simulated += study.simulations or 0
        assert len(done(study)) == len(done(kept)) == had
        assert simulated <= settings
        assert_spread(study)
    whole = explore(codesign.load_platform("virtex4-pci"), codesign.load_workload(tmp_path / "small.yaml"), workers=1)
    assert whole.simulations == settings
    for number, point in enumerate(done(study).tolist()):
        one, other = study.points[point], whole.points[point]
        assert all(one.figure(figure) == other.figure(figure) for figure in FIGURES.values())
        # A full result is simulated anew.
        assert number % 50 or one.result == other.result


def test_500_of_a_million_points_are_of_every_block_schedule_and_clock() -> None:
    explored = Explored.of(codesign.load_platform("virtex4-pci"), codesign.load_workload("million"))
    space = Space(explored.section.every_axis, "")
    points = Turns(space, 1).first(np.arange(len(space)), 500)
    for axis, column in space.levels(points).items():
        values = len(space.axes[axis])
        counts = np.bincount(column, minlength=values)
        assert counts.max() <= 2 * 500 / values + 2, axis
        assert values > 100 or counts.min() >= 0.5 * 500 / values, axis
    works = list(parted(explored, space, points))
    # 2,000 settings compute something of their own.
    assert all(isinstance(work, Together) for work in works)
    assert len({json.dumps(work.axes["relax.block"]) for work in works if isinstance(work, Together)}) == 20
