"""Where a wave ends: cycles, resources, messages and quality of a result are those of the same run."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from mission_specs import Ground
from numpy.typing import NDArray

from codesign.inputs import Platform, Workload
from codesign.maps import OccupancyGrid
from codesign.planners.wavefront.paper.measures import adder_circuit, dijkstra
from codesign.planners.wavefront.plan import register_bits
from codesign.system import Result
from codesign.system.scenarios import simulate

Cell = tuple[int, int]

STYLES = {
    "delay_line": ("wavefront", {"style": "delay_line"}),
    "adder_comparator": ("wavefront", {"style": "adder_comparator"}),
    "tiled": ("wavefront", {"style": "tiled", "tile": [4, 3]}),
    "software": ("wavefront-host", {"style": "software"}),
}
TIMELY = ("delay_line", "tiled", "software")
"""The styles that end once the start that asks is reached; an array of adders cannot."""


@cache
def point(style: str, stop: str) -> tuple[Platform, Workload]:
    placement, mapping = STYLES[style]
    # Tracked elsewhere, so that the potentials are sent and their width is seen.
    track = {"component": "host" if placement == "wavefront" else "fpga"}
    given_ = {"propagate": {**mapping, "stop": stop, "corner_cutting": True}, "track": track}
    with TemporaryDirectory() as folder:
        once = {"scenario": {"=": {"type": "plan_once"}}}
        slow = {"components": {"fpga": {"clock": "50 MHz"}}}
        return Ground(Path(folder)).point(placement, mapping=given_, workload=once, platform=slow)


def planned(style: str, stop: str, free: NDArray[np.bool_], goal: Cell, starts: list[Cell]) -> Result:
    platform, workload = point(style, stop)
    problem = workload.problem.model_copy(update={"goals": (goal,), "starts": tuple(starts)})
    workload = workload.model_copy(update={"problem": problem})
    result = simulate(platform, workload, grid=OccupancyGrid(free))
    assert result.feasible, result.reasons
    return result


def wave(result: Result) -> int:
    """Cycles of the wave, with the exchange of tiles; what is loaded and tracked takes the same with any stop."""
    assert result.cycles is not None
    return sum(result.cycles.get(phase, 0) for phase in ("propagate", "exchange"))


@st.composite
def problems(draw: st.DrawFn) -> tuple[NDArray[np.bool_], Cell, list[Cell], bool]:
    """A map, a goal, starts that are reached, and whether one of them is the farthest cell."""
    rows, columns = draw(st.integers(4, 9)), draw(st.integers(3, 9))
    free = np.random.default_rng(draw(st.integers(0, 10**6))).random((rows, columns)) >= draw(st.floats(0, 0.5))
    free[:, 0] = True
    potentials = dijkstra(free, [(0, 0)])
    cells = [(int(row), int(column)) for row, column in np.argwhere(potentials >= 0)]
    starts = draw(st.lists(st.sampled_from(cells), min_size=1, max_size=3, unique=True))
    farthest = max(potentials[start] for start in starts) == potentials.max()
    if draw(st.booleans()) and not farthest:
        starts, farthest = [*starts, max(cells, key=lambda cell: int(potentials[cell]))], True
    return free, (0, 0), starts, farthest


@pytest.mark.parametrize("style", STYLES)
@given(problem=problems())
@settings(max_examples=examples(25))
def test_a_wave_that_stops_takes_no_longer_and_is_judged_by_what_it_reached(
    style: str, problem: tuple[NDArray[np.bool_], Cell, list[Cell], bool]
) -> None:
    free, goal, starts, farthest = problem
    potentials = dijkstra(free, [goal])
    stopped, whole = (planned(style, stop, free, goal, starts) for stop in ("starts", "whole_map"))
    assert wave(stopped) <= wave(whole)
    last = widest = int(potentials.max())
    if style in TIMELY:
        # The cycles are those of the first start; the design is sized for all of them.
        last, widest = int(potentials[starts[0]]), max(int(potentials[start]) for start in starts)
        assert stopped.details["stop_potential"] == last
        assert stopped.parameters["propagate"]["stop"] == "starts"
    assert stopped.details["largest_potential"] == last
    reached = int(((potentials >= 0) & (potentials <= last)).sum())
    assert stopped.details["reached_cells"] == reached
    assert stopped.quality is not None
    assert whole.quality is not None
    assert stopped.quality.planned_cells == reached - 1
    assert whole.quality.planned_cells == whole.quality.reachable_cells
    # The message that brings the potentials to the tracker holds the widths of the same wave.
    assert stopped.links is not None
    assert whole.links is not None
    saved = (register_bits(int(potentials.max())) - register_bits(widest)) * free.size
    assert whole.links["pci"].bits - stopped.links["pci"].bits == saved
    assert stopped.quality.starts_arrived == whole.quality.starts_arrived == len(starts)
    assert stopped.quality.path_length_ratio_mean == whole.quality.path_length_ratio_mean
    if farthest and style == "delay_line":
        # Registers and memories are the same. Only an array that waits for a start selects whether it is reached.
        demands = [{use.resource: use for use in result.resources} for result in (stopped, whole)]
        for kind in ("flip_flops", "block_rams"):
            assert demands[0].get(kind) == demands[1].get(kind)
        selected = [
            next(item.figure.value for item in demand["lut4"].items if item.name == "read-out") for demand in demands
        ]
        assert selected[0] > selected[1]
    elif farthest and style == "tiled":
        # Only tiles that wait for a start remember whether it was reached.
        demands = [{use.resource: use.demand for use in result.resources} for result in (stopped, whole)]
        assert demands[0].get("block_rams") == demands[1].get("block_rams")
        assert 0 < demands[0]["flip_flops"] - demands[1]["flip_flops"] < 40
    elif farthest:
        assert stopped.resources == whole.resources
    if last == potentials.max():
        assert stopped.quality == whole.quality
        if style in {"software", "adder_comparator"}:
            assert wave(stopped) == wave(whole)


@given(problem=problems())
@settings(max_examples=25)
def test_an_array_of_adders_runs_over_the_whole_map_and_says_so(
    problem: tuple[NDArray[np.bool_], Cell, list[Cell], bool],
) -> None:
    """A smaller potential may still come by a path of more steps: the paper says that only its own array can stop."""
    free, goal, starts, _ = problem
    stopped, whole = (planned("adder_comparator", stop, free, goal, starts) for stop in ("starts", "whole_map"))
    (note,) = (note for note in stopped.notes if note.startswith("propagate.stop: "))
    assert "whole_map" in note
    assert not any(note.startswith("propagate.stop: ") for note in whole.notes)
    told = {"notes": (), "time": None}
    assert stopped.model_copy(update=told) == whole.model_copy(update=told)
    assert stopped.time == whole.time
    # One cycle before the first update: sources to 0, all others to infinity.
    assert wave(stopped) == 1 + adder_circuit(free, [goal])[1]
