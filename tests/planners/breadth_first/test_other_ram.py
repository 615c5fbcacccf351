"""RAM of a part besides its block RAM: what moves there, what may not, and that a map fits by it."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import codesign
from codesign.ground.figures import Figure, Status
from codesign.ground.models import OtherRam
from codesign.inputs import design_point, load_part, load_platform
from codesign.planners.breadth_first.plan.parameters import Address, MemoryPlace, SearchParameters, VgaController
from codesign.planners.breadth_first.styles import resources
from codesign.system.scenarios import simulate

PARTS = {name: load_part(name) for name in ("XCK26-2LV", "XCZU7EV-2", "iCE40UP5K-STD", "XC7Z020-1", "XC7A35T-1")}
SIDES = st.integers(2, 1200)
PARAMETERS = st.builds(
    SearchParameters,
    display=st.sampled_from(VgaController),
    address=st.sampled_from(Address),
    memory=st.sampled_from(MemoryPlace),
)


@given(st.sampled_from(sorted(PARTS)), SIDES, SIDES, PARAMETERS)
def test_a_memory_moves_only_for_want_of_block_ram_to_what_holds_it(
    name: str, rows: int, columns: int, parameters: SearchParameters
) -> None:
    part, shape = PARTS[name], (rows, columns)
    words, held = resources.memories(rows, columns, parameters), resources.held(shape, parameters, part)
    plain = {memory: ("", resources.block_rams(*each, part)) for memory, each in words.items()}
    assert held.keys() == words.keys()
    if sum(blocks for _, blocks in plain.values()) <= part.resources["block_rams"].value or not part.other_rams:
        assert held == plain
    for kind, ram in part.other_rams.items():
        inside = {memory: blocks for memory, (each, blocks) in held.items() if each == kind}
        assert sum(inside.values()) <= ram.count.value
        assert ram.ports == 2 or set(inside) <= {"directions"}, "the others are read and written in one cycle"
        for memory, blocks in inside.items():
            depth, width = words[memory]
            assert blocks * max(rows * bits for rows, bits in ram.shapes) >= depth * width, "it has room for its bits"
    assert resources.block_ram_total(rows, columns, parameters, part) <= sum(blocks for _, blocks in plain.values())


def searched(platform: str, side: int, clock: str, **parameters: Any) -> Any:
    search = {"component": "fpga", "style": "state_machine", "display": "none", **parameters}
    problem = {"map": {"generate": "rooms", "rows": side, "columns": side, "room": [30, 30], "door": 4, "seed": 1}}
    workload = {
        "kind": "workload",
        "name": "large",
        "planner": "breadth_first",
        "problem": {**problem, "goals": [[2, 2]], "starts": [[side - 3, side - 3]], "arrive": 0},
        "mapping": {"search": search},
    }
    return simulate(*design_point(load_platform(platform), codesign.load_workload(workload), {"fpga.clock": clock}, ""))


def test_a_map_that_block_ram_cannot_hold_fits_with_ultraram() -> None:
    """512 × 512 cells: 320 block RAMs of 288, or 64 and 64 UltraRAM of 64. A part without UltraRAM is short of them."""
    result = searched("kv260", 512, "50 MHz")
    assert result.feasible, result.reasons
    assert {each.resource: each.demand for each in result.resources}["block_rams"] == 64
    assert not searched("pynq-z2", 512, "50 MHz").feasible


def test_what_needs_two_ports_does_not_fit_single_port_ram() -> None:
    """On an iCE40UP5K the directions of 100 × 100 cells move; the queue does not, though it would have room."""
    part, parameters = PARTS["iCE40UP5K-STD"], SearchParameters(display=VgaController.NONE)
    held = resources.held((100, 100), parameters, part)
    assert held["directions"] == ("SPRAM", 1)
    assert held["queue"][0] == held["cells"][0] == ""
    roomy = part.model_copy(update={"other_rams": {"SPRAM": _of_two_ports(part.other_rams["SPRAM"])}})
    assert resources.held((100, 100), parameters, roomy)["queue"] == ("SPRAM", 1)


def _of_two_ports(ram: OtherRam) -> OtherRam:
    return OtherRam(ram.count, ram.shapes, 2, ram.clock)


def test_its_clock_and_its_blocks_count() -> None:
    part, parameters = PARTS["XCK26-2LV"], SearchParameters(display=VgaController.NONE)
    slow = Figure(10_000_000, "Hz", Status.ASSUMED, "a test")
    ram = part.other_rams["UltraRAM"]
    part = part.model_copy(update={"other_rams": {"UltraRAM": OtherRam(ram.count, ram.shapes, ram.ports, slow)}})
    assert resources.ram_clock((512, 512), parameters, part) == slow
    assert resources.ram_clock((100, 100), parameters, part) == part.block_ram_clock
    (line,) = resources.other_rams((512, 512), parameters, part)
    assert (line.name, line.figure.value, line.limit) == ("UltraRAM", 64, 64)
    assert line.figure.status is Status.ASSUMED
    assert resources.other_rams((100, 100), parameters, part) == ()


@pytest.mark.parametrize("name", ["zynq", "virtex4-pci"])
def test_a_part_without_other_ram_has_the_digest_that_it_had(name: str) -> None:
    chip = next(spec.chip for spec in load_platform(name).components.values() if spec.chip is not None)
    assert "other_rams" not in chip.model_dump(mode="json", exclude_defaults=True)
