"""Three frictions that had figures, on the drawn map ``house``: each was an answer, and a wrong one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import house_map
import numpy as np
import pytest
from places import ROOT

import codesign
from codesign import maps
from codesign.maps import Steps
from codesign.planners.interface import Quality
from codesign.system import catalog
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate

HOUSE = ROOT / "workloads" / "maps" / "house.yaml"
GOAL, NEAR, FAR = [195, 200], [195, 201], [140, 246]

HARMONIC: dict[str, Any] = {"block": [24, 24], "iterations": 8, "schedule": {"first": 15, "step": 8, "last": 39}}
MAPPINGS: dict[str, dict[str, Any]] = {
    "harmonic": {"relax": {"component": "fabric", **HARMONIC}, "decide": {"component": "fabric"}},
    "wavefront": {"propagate": {"component": "fabric", "style": "tiled", "tile": [32, 32], "stop": "whole_map"}},
    "breadth_first": {"search": {"component": "fabric"}},
}
SOFTWARE: dict[str, dict[str, Any]] = {
    "wavefront": {"propagate": {"component": "host", "style": "software"}},
    "breadth_first": {"search": {"component": "host", "style": "software"}},
    "relaxation": {"relax": {"component": "host", "method": "sor", "omega": 1.9}},
}


def planned(planner: str, mapping: Any, *, starts: Any = None, board: str = "arty-a7", crop: str = "free") -> Result:
    problem: dict[str, Any] = {"map": {"file": str(HOUSE), "crop": crop}, "goals": [GOAL]}
    if starts is not None:
        problem["starts"] = starts
    tree = {"kind": "workload", "name": "house", "planner": planner, "problem": problem, "mapping": mapping}
    return simulate(codesign.load_platform(board), catalog.load_workload(tree), levers=True)


def worst(result: Result) -> float:
    assert result.task is not None
    return result.task.plan_time_worst_s


@pytest.mark.parametrize(
    ("planner", "mapping"),
    [*MAPPINGS.items(), *SOFTWARE.items()],
    ids=[*(f"{name} on an FPGA" for name in MAPPINGS), *(f"{name} on a host" for name in SOFTWARE)],
)
def test_swapped_starts_change_no_time(planner: str, mapping: Any) -> None:
    """A search took 616 ns or 21.13 ms, and the wave 49.82 ms both times: one was timed for its first start."""
    orders = ([NEAR, FAR], [FAR, NEAR])
    first, second = (planned(planner, mapping, starts=starts, board="pynq-z2") for starts in orders)
    assert first.task == second.task
    assert isinstance(first.quality, Quality)
    assert isinstance(second.quality, Quality)
    # The cells that a plan has reached are those of the first start.
    assert replace(first.quality, planned_cells=0) == replace(second.quality, planned_cells=0)
    assert worst(first) == worst(planned(planner, mapping, starts=[FAR], board="pynq-z2"))


def test_a_search_from_beside_the_goal_is_another_task() -> None:
    mapping = SOFTWARE["breadth_first"]
    near, far = (worst(planned("breadth_first", mapping, starts=[each], board="pynq-z2")) for each in (NEAR, FAR))
    assert far > 10 * near


def test_the_shipped_map_is_the_one_that_is_drawn() -> None:
    assert (HOUSE.parent / "house.pgm").read_bytes() == house_map.image()
    assert HOUSE.read_text(encoding="utf-8") == house_map.DESCRIPTION


def test_a_bare_image_of_a_scan_does_not_count_unknown_as_free() -> None:
    """146,586 cells counted as free, without a fault."""
    bare, described = maps.read_map(HOUSE.parent / "house.pgm"), maps.read_map(HOUSE)
    assert np.array_equal(bare.free, described.free)
    assert int(bare.free.sum()) == 7954
    first, second = maps.read_prepared(HOUSE.parent / "house.pgm", Steps()).remarks
    assert "137,519 pixels of grey 205 taken as unknown; name house.yaml in its place" in first
    assert second.startswith("137,519 of 147,456 cells are unknown, and count as blocked")


@pytest.mark.parametrize("planner", MAPPINGS)
def test_a_scan_fits_once_it_is_cropped(planner: str) -> None:
    """384 × 384 cells were infeasible on an Artix-7; the 102 × 109 with all free cells take 14 to 40 ms."""
    whole, cropped = (planned(planner, MAPPINGS[planner], crop=crop) for crop in ("none", "free"))
    assert {reason.kind for reason in cropped.reasons} <= {"quality"}
    assert 0.01 < worst(cropped) < 0.04
    if planner == "wavefront":
        # Tiles are worked off one after another: the whole map fits, and takes its time.
        assert worst(whole) > 10 * worst(cropped)
        assert whole.quality == cropped.quality
    else:
        assert whole.reasons
        assert {reason.kind for reason in whole.reasons} <= {"resource", "bound"}


def test_a_precision_that_a_lever_names_is_held_to_the_starts_that_arrive() -> None:
    """ "Feasible: yes", with 0 of 32 starts arriving, at the block and precision that the lever recommended."""
    whole = planned("harmonic", MAPPINGS["harmonic"], crop="none")
    (bound,) = whole.reasons
    schedule = next(lever for lever in bound.levers if lever.startswith("relax.schedule"))
    bits = int(schedule.partition("end at ")[2].partition(" ")[0])
    mapping = {**MAPPINGS["harmonic"], "relax": {"component": "fabric", **HARMONIC, "schedule": [bits]}}
    result = planned("harmonic", mapping, crop="none")
    assert not result.feasible
    (reason,) = result.reasons
    assert isinstance(result.quality, Quality)
    assert (reason.kind, reason.demand, reason.limit) == ("quality", result.quality.starts_arrived, 64)
    assert result.quality.starts_arrived < 64


def test_a_lever_for_starts_that_do_not_arrive_is_tried() -> None:
    few = planned("harmonic", MAPPINGS["harmonic"], board="nexys-video")
    (reason,) = few.reasons
    assert reason.kind == "quality"
    (lever,) = reason.levers
    bits = int(lever.partition("end at ")[2].partition(" ")[0])
    assert lever.endswith("bits: does not fit (words of a block RAM), but 64 of 64 starts arrive")
    mapping = {**MAPPINGS["harmonic"], "relax": {"component": "fabric", **HARMONIC, "schedule": [15, bits]}}
    (bound,) = planned("harmonic", mapping, board="nexys-video").reasons
    assert bound.name == "words of a block RAM"
