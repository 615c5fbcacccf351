"""The memory of a processor bounds the maps that software plans on."""

from __future__ import annotations

import copy
from typing import Any

import pytest

import codesign
from codesign.ground.figures import Figure
from codesign.system import catalog
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate
from codesign.system.verdicts import fit_verdict
from codesign.views.report.study_tables import study_sentence

ROOMS = {"generate": "rooms", "rows": 24, "columns": 32, "room": [10, 14], "door": 2}
CELLS = 24 * 32

PLATFORM = """\
kind: platform
name: small
components:
  host:
    type: processor
    clock: 600 MHz
    costs:
      breadth_first_cell: 100 ns
      breadth_first_map_cell: 0 s
      breadth_first_wall_cell: 0 s
      wavefront_map_cell: 0 s
      wavefront_time_step: 0 s
      relaxation_map_cell: 0 s
      relaxation_diagonal: 0 s
      relaxation_check_cell: 0 s
      wavefront_cell: 100 ns
      relaxation_node_update: 100 ns
      harmonic_node_update: 100 ns
      grid_search_map_cell: 1 ns
      grid_search_expansion: 100 ns
      grid_search_heap_entry: 100 ns
    power: {{busy: 0.5 W, idle: 0.3 W}}
{memory}
roles: {{host: host}}
"""

SCHEDULE = {"iterations": 6, "schedule": {"first": 31, "last": 111, "step": 40}}
MAPPINGS: dict[str, tuple[dict[str, Any], int]] = {
    "breadth_first": ({"search": {"component": "host", "style": "software"}}, 6),
    "wavefront": ({"propagate": {"component": "host", "style": "software"}}, 9),
    "relaxation": ({"relax": {"component": "host"}}, 9),
    "grid_search": ({"search": {"component": "host"}}, 20),
    "harmonic": ({"relax": {"component": "host", "style": "software", "block": [24, 32], **SCHEDULE}}, 17),
}


def run(planner: str, mapping: Any, memory: str = "") -> Result:
    tree = {
        "kind": "workload",
        "name": "rooms",
        "planner": planner,
        "problem": {"map": ROOMS, "goals": [[2, 2]]},
        "mapping": mapping,
    }
    platform = codesign.load_platform(PLATFORM.format(memory=memory))
    return simulate(platform, catalog.load_workload(tree))


@pytest.mark.parametrize("planner", MAPPINGS)
def test_the_bytes_of_a_plan_are_held_against_the_memory(planner: str) -> None:
    mapping, bytes_a_cell = MAPPINGS[planner]
    need = bytes_a_cell * CELLS
    unbounded = run(planner, mapping)
    assert unbounded.feasible, unbounded.reasons
    enough = run(planner, mapping, f"    memory: {need} B")
    assert enough.feasible
    assert enough.task == unbounded.task
    short = run(planner, mapping, f"    memory: {need - 1} B")
    (reason,) = short.reasons
    assert (reason.kind, reason.name, reason.unit) == ("bound", "memory of the processor", "bytes")
    assert (reason.demand, reason.limit) == (need, need - 1)
    assert not short.simulated
    assert "crop or downsample" in reason.levers[0]


def test_a_host_file_brings_its_memory() -> None:
    host = codesign.load_platform("teensy-4-1").components["host"]
    assert host.type == "processor"
    assert host.memory is not None
    assert host.memory.value == 8 * 2**20
    assert codesign.load_platform("raspberry-pi-4").components["host"].memory is None  # type: ignore[union-attr]


@pytest.mark.parametrize("share", [0.05, 0.3, 0.9, 1.1, 3.0, 50.0])
@pytest.mark.parametrize("planner", sorted(MAPPINGS))
def test_the_verdict_about_memory_holds_at_both_ends_of_the_bytes_a_cell(
    planner: str, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``share``: the memory, of what the plan takes at the assumed bytes a cell."""
    mapping, _ = MAPPINGS[planner]
    need = run(planner, mapping, "    memory: 1 GiB").bounds[0].figure
    memory = f"    memory: {max(1, round(share * need.value))} B"
    result = run(planner, mapping, memory)
    verdict = fit_verdict(result)
    assert verdict.decides == "memory of the processor"
    style, fits = catalog.architectures()[planner, result.style], []
    for end in need.interval:
        exact = Figure(end / CELLS, "B", need.status, need.source)
        monkeypatch.setattr(type(style), "bytes_a_cell", lambda _style, _job, exact=exact: exact)
        fits.append(run(planner, mapping, memory).feasible)
    assert verdict.fits == {(True, True): "yes", (False, False): "no", (True, False): "uncertain"}[tuple(fits)]  # type: ignore[index]
    # A verdict that depends names the value at which it changes, and a note says so.
    assert (verdict.flips_at is not None) == (verdict.fits == "uncertain")
    assert any("it is not sure whether the design fits" in note for note in result.notes) == (
        verdict.fits == "uncertain"
    )


def test_a_limit_with_an_interval_decides_too() -> None:
    planner, (mapping, _) = next(iter(MAPPINGS.items()))
    need = run(planner, mapping, "    memory: 1 GiB").bounds[0].figure.interval[1]
    memory = f"    memory: {{value: {2 * need:.0f} B, low: {need / 2:.0f} B, status: assumed, source: a guess}}"
    assert fit_verdict(run(planner, mapping, memory)).fits == "uncertain"


def test_an_exploration_holds_software_to_the_memory_as_a_run_does() -> None:
    rows = {"workload.problem.map.rows": [100, 512, 2000]}
    planner, platform = "breadth_first", codesign.load_platform("teensy-4-1")
    tree = {
        "kind": "workload",
        "name": "sizes",
        "planner": planner,
        "problem": {"map": {"generate": "empty", "rows": 100, "columns": 512}, "goals": [[2, 2]], "starts": [[9, 9]]},
        "mapping": {"search": {"component": "host", "style": "software"}},
        "explore": {"axes": rows},
    }
    study = codesign.explore(platform, codesign.load_workload(tree))
    fates = []
    for count, point in zip(*rows.values(), study.points, strict=True):
        alone = copy.deepcopy(tree)
        alone["problem"]["map"]["rows"] = count  # type: ignore[index]
        del alone["explore"]
        result = codesign.simulate(platform, codesign.load_workload(alone))
        assert (point.feasible, point.reasons) == (result.feasible, result.reasons)
        fates.append(point.feasible)
    assert fates == [True, False, False]
    # At 1 byte a cell both would fit, 512 × 512 and 2,000 × 512.
    assert "1 feasible, 2 infeasible, 2 of these not surely" in study_sentence(study)
