"""The memory of a processor bounds the maps that software plans on."""

from __future__ import annotations

from typing import Any

import pytest

import codesign
from codesign.results.result import Result
from codesign.scenarios import simulate
from codesign.system import catalog

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
    power: {{busy: 0.5 W, idle: 0.3 W}}
{memory}
roles: {{host: host}}
"""

SCHEDULE = {"iterations": 6, "schedule": {"first": 31, "last": 111, "step": 40}}
MAPPINGS: dict[str, tuple[dict[str, Any], int]] = {
    "breadth_first": ({"search": {"component": "host", "style": "software"}}, 6),
    "wavefront": ({"propagate": {"component": "host", "style": "software"}}, 9),
    "relaxation": ({"relax": {"component": "host"}}, 9),
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
