"""Random studies of every kind: any point that a study holds is what a run of it alone gives, to the last bit.

Searches, conditional axes, parts that do and do not fit, serial lines and buses, schedules that are left to a search,
conditions, variants.
"""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

import codesign
from codesign.study import Study, explore
from codesign.study.budget import Budget
from codesign.study.check import check_points
from codesign.study.outcomes import State

PARTS = ["XC2V6000-4", "XC3S500E-4", "XC7A35T-1", "XC4VLX160-12", "iCE40UP5K-STD"]
BEST = [{"optimal": {"last": last, "candidates": [5, 9, 14, 21]}} for last in (23, 90, 130)]
BOARDS: dict[str, dict[str, list[Any]]] = {
    "virtex2-pci": {"link.clock": ["10 MHz", "66 MHz"], "link.width": [32, 64], "link.setup_cycles": [2, 20]},
    "nexys2-serial": {"link.baud": [9600, 921600]},
}
ALL: dict[str, list[Any]] = {
    "fabric.part": PARTS,
    "fabric.clock": ["10 MHz", "45 MHz", "300 MHz"],
    "host.clock": ["1 GHz", "3 GHz"],
    "workload.problem.map.seed": [1, 2, 3],
}
SEARCHES = ["bound", "random", *(["nsga2"] if find_spec("optuna") else [])]
PLANNERS: dict[str, tuple[dict[str, Any], dict[str, list[Any]]]] = {
    "harmonic": (
        {"relax": {"component": "fabric", "block": [6, 9], "iterations": 4, "schedule": BEST[0]}},
        {
            "relax.schedule": [*BEST, [15, 31], {"first": 7, "step": 8, "last": 63}],
            "relax.block": [[6, 9], [12, 18], [3, 3]],
            "relax.iterations": [1, 6],
            "relax.stop": ["schedule_end", "first_without_local_maxima"],
            "relax.pipeline": [0, 1],
        },
    ),
    "wavefront": (
        {"propagate": {"component": "fabric", "style": "tiled", "tile": [4, 4]}},
        {"propagate.tile": [[4, 4], [6, 9], [12, 18]]},
    ),
    "breadth_first": ({"search": {"component": "fabric"}}, {}),
}


def workload_of(planner: str, axes: dict[str, Any], **more: Any) -> dict[str, Any]:
    """A small workload as it is written."""
    return {
        "kind": "workload",
        "name": "drawn",
        "planner": planner,
        "problem": {
            "map": {"generate": "rooms", "rows": 12, "columns": 18, "room": [5, 5], "door": 2, "seed": 3},
            "goals": [[2, 2]],
            "starts": {"count": 3, "seed": 1},
        },
        "mapping": PLANNERS[planner][0],
        "explore": {"axes": axes, "conditions": more.pop("conditions", {})},
        **more,
    }


@st.composite
def studies(draw: st.DrawFn) -> tuple[str, dict[str, Any], str | None]:
    """A platform, a workload as raw YAML with what is explored, and how it is searched."""
    board, planner = (draw(st.sampled_from([*BOARDS])), draw(st.sampled_from([*PLANNERS, "harmonic", "harmonic"])))
    mapping, own = PLANNERS[planner]
    on_host = planner == "harmonic" and draw(st.booleans())
    known = {**ALL, **BOARDS[board], **own}
    names = draw(st.lists(st.sampled_from([*known]), min_size=1, max_size=4, unique=True))
    # The order of the parts decides which one is met first.
    names = [*dict.fromkeys(["fabric.part", *names])] if draw(st.booleans()) else names
    axes: dict[str, Any] = {
        name: draw(st.lists(st.sampled_from(known[name]), min_size=2, max_size=3, unique_by=str)) for name in names
    }
    conditions = {}
    if "workload.problem.map.seed" in axes and len(axes) > 1 and draw(st.booleans()):
        conditions["workload.problem.map.seed"] = axes.pop("workload.problem.map.seed")
    variants = {}
    if on_host:
        host = {**mapping["relax"], "component": "host"}
        variants["on-host"] = {"mapping": {"relax": host}}
        depending = [name for name in axes if draw(st.booleans())]
        axes = {
            "workload.variant": ["base", "on-host"],
            **{
                name: {"values": values, "when": {"workload.variant": draw(st.sampled_from(["base", "on-host"]))}}
                if name in depending
                else values
                for name, values in axes.items()
            },
        }
    workload = workload_of(planner, axes, conditions=conditions, **({"variants": variants} if variants else {}))
    several = len(axes) > 0 and any(len(values) > 1 for values in axes.values() if isinstance(values, list))
    return (board, workload, draw(st.sampled_from([None, None, *SEARCHES])) if several else None)


def explored(folder: Path, board: str, workload: dict[str, Any], search: str | None) -> Study:
    (folder / "drawn.yaml").write_text(json.dumps(workload), encoding="utf-8")
    loaded = codesign.load_workload(folder / "drawn.yaml")
    budget = None if search is None else Budget(points=12)
    seed = None if search in (None, "bound") else 1
    return explore(codesign.load_platform(board), loaded, workers=1, search=search, seed=seed, budget=budget)


@pytest.mark.usefixtures("searched")
@settings(max_examples=examples(60), deadline=None)
@given(studies())
def test_a_point_of_any_study_is_what_it_is_alone(
    tmp_path_factory: pytest.TempPathFactory, drawn: tuple[str, dict[str, Any], str | None]
) -> None:
    study = explored(tmp_path_factory.mktemp("drawn"), *drawn)
    check = check_points(study, 8)
    assert check.differences == ()
    assert check.points == min(8, np.count_nonzero(study.outcomes.state == State.DONE))


@pytest.mark.parametrize("parts", [PARTS, PARTS[::-1]], ids=["fits first", "fits last"])
def test_a_schedule_is_found_for_each_part_of_an_axis(tmp_path: Path, parts: list[str]) -> None:
    axes = {"relax.schedule": BEST, "fabric.part": parts, "fabric.clock": ["10 MHz", "20 MHz"]}
    study = explored(tmp_path, "virtex2-pci", workload_of("harmonic", axes), None)
    fits = {point.axes["fabric.part"]: point.feasible for point in study.points}
    assert set(fits.values()) == {True, False}
    assert check_points(study, 100).differences == ()
