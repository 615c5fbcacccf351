"""What a robot drove is never less than the shortest path, and its clearance holds over all of its path."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mission_specs import KINEMATICS, Ground, rectangle
from numpy.typing import NDArray

from codesign.components.path import Polyline
from codesign.ground.records import PoseRecord
from codesign.maps import OccupancyGrid, to_text
from codesign.system.scenarios.drive.world.clearance import STEP, Clearance

PLACES = ["breadth-first", "wavefront", "harmonic-host", "relaxation"]


@st.composite
def missions(draw: st.DrawFn) -> dict[str, Any]:
    """A random map with a robot of any kinematics, a tour, and walls that vanish."""
    random = np.random.Generator(np.random.PCG64([draw(st.integers(0, 2**32))]))
    free = random.random((16, 16)) > draw(st.sampled_from([0.0, 0.1, 0.25]))
    radius = draw(st.sampled_from([0.0, 0.04]))
    reach = math.ceil(radius / 0.1)
    inside = st.integers(1, 14)
    cells = draw(st.lists(st.tuples(inside, inside).map(list), min_size=2, max_size=4, unique_by=tuple))
    for row, column in cells:
        free[row - reach : row + reach + 1, column - reach : column + reach + 1] = True
    gone = {"until": f"{draw(st.integers(1, 3000))} ms", "at": "0 s"}
    appearing = [rectangle(6, 0, 1, 16, **gone)] if draw(st.booleans()) else []
    moving = [{"route": [[5, 1], [5, 10]], "speed": "0.5 m/s"}] if draw(st.booleans()) else []
    return {
        "placement": draw(st.sampled_from(PLACES)),
        "platform": [
            KINEMATICS[draw(st.sampled_from(sorted(KINEMATICS)))],
            {"components": {"robot": {"radius": f"{radius} m"}}},
        ],
        "text": to_text(OccupancyGrid(free)),
        "start": cells[0],
        "goals": [cells[1]],
        "tour": cells[2:],
        "known": draw(st.sampled_from(["all", "none"])),
        "obstacles": {"appearing": appearing, "moving": moving},
        "limit": "60 s",
        "patience": "4 s",
    }


@settings(
    max_examples=25,
    derandomize=True,
    suppress_health_check=[HealthCheck.filter_too_much, *settings().suppress_health_check],
)
@given(case=missions())
def test_no_robot_drives_less_than_the_shortest_path(tmp_path: Path, case: dict[str, Any]) -> None:
    mission = Ground(tmp_path).run(**case).mission
    assert mission is not None
    if not mission.reached:
        assert mission.distance_ratio is None
        return
    assert mission.shortest_m is not None, "what was driven is a path"
    assert mission.distance_m >= mission.shortest_m - 1e-6
    assert mission.distance_ratio is None or mission.distance_ratio >= 1 - 1e-6


@pytest.mark.parametrize("kinematics", sorted(KINEMATICS))
def test_on_a_straight_line_the_bound_is_met_but_for_the_goals_cell(tmp_path: Path, kinematics: str) -> None:
    mission = Ground(tmp_path).run(
        "relaxation", text=("." * 16 + "\n") * 3, start=(1, 1), goals=[(1, 14)], platform=KINEMATICS[kinematics]
    ).mission  # fmt: skip
    assert mission is not None
    assert mission.shortest_m == pytest.approx(1.25)
    assert mission.distance_ratio is not None
    assert 1.0 <= mission.distance_ratio <= 1.3 / 1.25 + 1e-6


def brute(free: NDArray[np.bool_], point: NDArray[np.float64]) -> float:
    """Distance from a point to the squares of all blocked cells and to the rim."""
    rows, columns = free.shape
    found = [point[0] + 0.5, point[1] + 0.5, rows - 0.5 - point[0], columns - 0.5 - point[1]]
    gaps = np.maximum(np.abs(np.argwhere(~free) - point) - 0.5, 0.0)
    return float(min([*found, *np.hypot(gaps[:, 0], gaps[:, 1])]))


@settings(max_examples=examples(60), derandomize=True)
@given(seed=st.integers(0, 2**32), share=st.sampled_from([0.0, 0.02, 0.1, 0.3]), legs=st.integers(1, 6))
def test_clearance_is_exact_between_looks(seed: int, share: float, legs: int) -> None:
    """Against dense sampling, on paths that keep out of blocked cells."""
    random = np.random.Generator(np.random.PCG64([seed]))
    free = random.random((20, 30)) >= share
    points = [np.array([random.uniform(0, 19), random.uniform(0, 29)])]
    for _ in range(legs):
        points.append(points[-1] + random.normal(0, 2, 2))
    path = np.clip(np.array(points), 0, [19, 29])
    dense = np.concatenate([one + np.linspace(0, 1, 150)[:, None] * (other - one) for one, other in pairwise(path)])
    entered = Polyline(path).crossings[1].reshape(-1, 2)
    inside = entered[((entered >= 0) & (entered < free.shape)).all(axis=1)]
    free[inside[:, 0], inside[:, 1]] = True
    told = Clearance()
    told.stand(free, (float(path[0, 0]), float(path[0, 1])))
    told.drive(free, path)
    sampled = np.array([brute(free, point) for point in dense])
    steps = np.hypot(*np.diff(dense, axis=0).T)
    assert told.least <= sampled.min() + 1e-9
    assert told.least >= sampled.min() - steps.max() / 2 - 1e-9
    if steps.sum() > 0.1:
        mean = float((0.5 * (sampled[1:] + sampled[:-1]) * steps).sum() / steps.sum())
        assert told.mean == pytest.approx(mean, abs=STEP / 4 + steps.max() / 4)


def test_clearance_sees_what_comes_while_the_robot_stands(tmp_path: Path) -> None:
    """Between two turns, and gone again before the next one."""
    passes = {"appearing": [{**rectangle(1, 2), "at": "1040 ms", "until": "1060 ms"}]}
    result, records = Ground(tmp_path).watched(
        text=("." * 16 + "\n") * 16, start=(1, 1), goals=[(14, 14)], limit="2 s", obstacles=passes,
        platform={"components": {"fpga": {"clock": "100 Hz"}}},
    )  # fmt: skip
    assert result.mission is not None
    assert result.mission.distance_m == 0.0
    assert {record.column for record in records if isinstance(record, PoseRecord)} == {1.0}
    # From the middle of column 1 to the near side of column 2; at the start, to the rim.
    assert result.mission.clearance_least_m == pytest.approx(0.05)
    assert result.mission.clearance_mean_m == pytest.approx(0.15)
