"""What a synthesis counts: by module, by line of the demand, with the output registers of block RAMs."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from places import ROOT

from codesign.ground.errors import InputError, RunError
from codesign.hardware.rtl.cells import FAMILIES, Counts, counts_of
from codesign.hardware.rtl.synthesis import FLAT, Netlist, flatten, synthesise, verilog_name
from codesign.planners import circuits
from codesign.planners.circuits import Circuit, Image

pytest.importorskip("pyosys")

SHARED = Path(circuits.__file__).parent / "verilog"
TOY = ROOT / "tests" / "support" / "toy" / "memories.v"


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))


def memories(register: int) -> Circuit:
    return Circuit(
        top="memories",
        sources=(TOY, SHARED / "ram_1w1r.v", SHARED / "ram_2rw.v"),
        parameters={"OUTPUT_REGISTER": register},
        stream=Image(1, [1]),
        phases=("run",),
        kinds=("word",),
        event_bits=18,
        pieces={"stores": ("ram_1w1r", "ram_2rw")},
    )


@pytest.mark.parametrize(
    ("family", "of_fabric"),
    [
        ("ecp5", False),
        ("gowin", False),
        pytest.param("xc4v", False, marks=pytest.mark.slow),
        pytest.param("xc2v", True, marks=pytest.mark.slow),
    ],
)
def test_block_rams_take_the_registers_that_their_family_has(family: str, of_fabric: bool) -> None:
    plain, registered = synthesise(memories(0), family), synthesise(memories(1), family)
    assert plain.registers == 0
    assert registered.registers == (0 if of_fabric else 3 * 18)
    expected = 3 * 18 if of_fabric else 0
    assert registered.total.flip_flops - plain.total.flip_flops == expected
    assert registered.pieces["stores"].flip_flops == expected
    assert registered.pieces["stores"].block_rams == plain.pieces["stores"].block_rams == 2


def test_a_flat_netlist_has_the_same_cells_and_the_mode_of_the_registers(tmp_path: Path) -> None:
    circuit = memories(1)
    counted = synthesise(circuit, "ecp5")
    flatten(circuit, "ecp5", tmp_path)
    netlist = Netlist.of(json.loads((tmp_path / FLAT).read_text(encoding="utf-8")))
    assert list(netlist.modules) == [counted.top]
    assert netlist.own[counted.top] == counted.total
    blocks = [cell for cell in netlist.cells(counted.top).values() if cell["type"] == "DP16KD"]
    assert {cell["parameters"]["REGMODE_B"].strip() for cell in blocks} == {"OUTREG"}


def test_modules_add_up_to_the_total() -> None:
    counted = synthesise(memories(1), "ecp5")
    assert sum((row.counts for row in counted.modules), Counts()) == counted.total
    assert {row.module: row.instances for row in counted.modules}["ram_2rw"] == 1


def test_a_family_without_two_port_memories_is_refused_before_it_fills_with_flip_flops() -> None:
    with pytest.raises(InputError, match="two ports that write") as fault:
        synthesise(memories(0), "ice40")
    assert "ecp5" in str(fault.value)


def test_an_unknown_family_is_refused_with_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean ecp5"):
        synthesise(memories(0), "ecp")


def test_a_cell_that_is_not_counted_is_no_zero() -> None:
    with pytest.raises(RunError, match="USRMCLK"):
        counts_of("USRMCLK")


def test_names_of_modules_are_those_of_the_source() -> None:
    assert verilog_name("$paramod\\node\\PIPELINE=s32'00000000000000000000000000000001") == "node"
    assert set(FAMILIES) == {"xc2v", "xc2vp", "xc3se", "xc4v", "xc7", "ecp5", "gowin", "ice40"}
