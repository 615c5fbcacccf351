"""Circuits are simulated, and compared with what the model expects, by every simulator that is here."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rtl_tools import NEEDS, needs
from toy_circuit import ToyCircuit, ToyParameters
from waveform_reader import VCDVCD

from codesign.ground.errors import RunError
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.bench_runs import Run
from codesign.hardware.rtl.verify import BACKENDS, Verified, compared, simulate, verify
from codesign.planners.circuits import Circuit, Expected, Image
from codesign.planners.job import Job

TOY = ToyCircuit()
JOB: Job[object, ToyParameters] = Job(np.arange(1, 13), ToyParameters())


# What Verilator builds is checked by the long run below.
@pytest.mark.parametrize("backend", [name for name in NEEDS if name != "verilator"])
def test_a_circuit_reports_what_the_model_expects(backend: str) -> None:
    needs(backend)
    for seed in range(2):
        assert verify(TOY, TOY.sample(seed), backend) == verified(TOY.sample(seed))


def verified(job: Job[object, ToyParameters]) -> Verified:
    expected = TOY.expected(job)
    return Verified(len(expected.events.cycle), sum(expected.cycles.values()), 0, None)


def test_a_large_array_is_simulated_by_verilator_where_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    circuit, expected = TOY.circuit(JOB), TOY.expected(JOB)
    run = Run(expected.events, expected.cycles, 12, True)
    used: list[str] = []

    def backend(name: str) -> Callable[..., Run]:
        return lambda *_: used.append(name) or run  # type: ignore[func-returns-value]

    monkeypatch.setattr("codesign.hardware.rtl.verify.BACKENDS", {name: backend(name) for name in BACKENDS})
    monkeypatch.setattr(tools, "command_of", lambda _name: ("tool",))
    large = replace(circuit, elements=10_000)
    expected = replace(expected, cycles={"load": 12, "sum": 10_000})
    simulate(circuit, expected, "auto")
    simulate(large, expected, "auto")
    simulate(large, expected, "icarus")
    monkeypatch.setattr(tools, "command_of", lambda _name: None)
    words: list[str] = []
    simulate(large, expected, "auto", None, lambda text, *_: words.append(text))
    assert used == ["cxxrtl", "verilator", "icarus", "cxxrtl"]
    assert words == ["a large array: Verilator simulates it several times as fast (apt-get install verilator)"]


# Verilator compiles the circuit to C++, which takes longer than the run of the two others.
@pytest.mark.parametrize(
    "backend", [pytest.param(each, marks=[pytest.mark.slow] * (each == "verilator")) for each in NEEDS]
)
def test_a_long_run_says_how_far_it_is(backend: str, monkeypatch: pytest.MonkeyPatch) -> None:
    needs(backend)
    monkeypatch.setattr(tools, "_WATCH_S", 0.02)
    job: Job[object, ToyParameters] = Job(np.arange(20_000), ToyParameters(width=32))
    seen: list[tuple[str, int, int]] = []
    assert verify(TOY, job, backend, None, lambda *report: seen.append(report)).differences == 0
    name = {"cxxrtl": "CXXRTL", "icarus": "Icarus", "verilator": "Verilator"}[backend]
    assert seen[:2] == [(f"{name} compiles the circuit", 0, 0), (f"{name} simulates the circuit", 0, 0)]
    cycles = [done for _, done, _ in seen[2:]]
    assert cycles == sorted(cycles)
    assert {(words, expected) for words, _, expected in seen[2:]} <= {(f"cycles simulated in {name}", 40_002)}


def test_an_array_that_no_simulator_compiles_is_refused_at_once() -> None:
    circuit = replace(TOY.circuit(JOB), elements=65_536)
    with pytest.raises(RunError, match=r"toy_sum has 65,536 elements.*up to 10,000") as caught:
        simulate(circuit, TOY.expected(JOB))
    assert "a smaller map" in str(caught.value)


def test_every_backend_is_tested() -> None:
    assert set(BACKENDS) == set(NEEDS)


def run_of(circuit: Circuit, expected: Expected) -> str:
    needs("cxxrtl")
    return str(compared(circuit, expected, simulate(circuit, expected)).first)


def test_the_first_difference_is_named() -> None:
    circuit, expected = TOY.circuit(JOB), TOY.expected(JOB)
    one_bit = replace(circuit, images={"constant.hex": Image(8, [4])})
    assert run_of(one_bit, expected) == "cycle 25: the model reports sum 83, the circuit sum 82 (event 12)"
    flipped = replace(circuit, stream=Image(8, [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13]))
    assert run_of(flipped, expected).startswith("cycle 24: the model reports partial sum 78, the circuit ")
    late = replace(expected, events=replace(expected.events, cycle=expected.events.cycle + 1))
    assert run_of(circuit, late).startswith(
        "cycle 13: the model reports partial sum 1 at cycle 14, the circuit at cycle 13"
    )
    assert run_of(circuit, replace(expected, cycles={"load": 12, "sum": 15})) == (
        "phase sum takes 15 cycles in the model, 14 in the circuit"
    )
    assert run_of(replace(circuit, stream=Image(8, [*range(1, 14)])), expected) == (
        "the circuit takes 12 of the 13 words of its stream"
    )


def test_a_circuit_that_never_ends_is_a_difference() -> None:
    circuit, expected = TOY.circuit(JOB), TOY.expected(JOB)
    starved = replace(circuit, stream=Image(8, [1, 2, 3]))
    needs("cxxrtl")
    result = compared(starved, expected, simulate(starved, expected))
    assert str(result.first) == "cycle 13: the model reports partial sum 1, the circuit nothing more"


def test_contention_excuses_cycles_and_no_value() -> None:
    needs("cxxrtl")
    circuit, expected = TOY.circuit(JOB), TOY.expected(JOB)
    late = replace(
        expected,
        events=replace(expected.events, cycle=expected.events.cycle + 1),
        cycles={"load": 12, "sum": 15},
        contention="two blocks read one memory",
    )
    result = compared(circuit, late, simulate(circuit, expected))
    assert (result.differences, result.first, round(result.deviation, 3)) == (0, None, 0.037)
    wrong = replace(late, events=replace(late.events, value=late.events.value + np.uint64(1)))
    assert compared(circuit, wrong, simulate(circuit, expected)).differences == 13


def test_verilog_that_does_not_compile_is_an_error_in_words(tmp_path: Path) -> None:
    needs("cxxrtl")
    bad = tmp_path / "toy_sum.v"
    bad.write_text("module toy_sum (input wire clk)\nendmodule\n", encoding="utf-8")
    circuit = replace(TOY.circuit(JOB), sources=(bad,))
    with pytest.raises(RunError, match=r"Yosys, of toy_sum, fails .*toy_sum.v:2"):
        simulate(circuit, TOY.expected(JOB))


def test_a_waveform_is_written_around_the_first_difference(tmp_path: Path) -> None:
    needs("cxxrtl")

    class Wrong(ToyCircuit):
        def circuit(self, job: Job[object, ToyParameters], /) -> Circuit:
            return replace(super().circuit(job), images={"constant.hex": Image(8, [4])})

    waves = tmp_path / "difference.vcd"
    assert verify(TOY, JOB, waves=waves).first is None
    assert not waves.exists()
    assert verify(Wrong(), JOB, waves=waves).first is not None
    text = waves.read_text(encoding="utf-8")
    assert "$var" in text
    assert "event_valid" in text
    times = [int(line[1:]) for line in text.splitlines() if line.startswith("#")]
    assert max(times) >= 2 * 25


@pytest.mark.parametrize("backend", [name for name in NEEDS if name != "verilator"])
def test_circuit_and_model_lie_above_each_other_in_a_waveform(backend: str, tmp_path: Path) -> None:
    needs(backend)
    waves = tmp_path / "run.vcd"
    assert verify(TOY, JOB, backend, waves, cycles=(0, 60)).first is None
    wave = VCDVCD(str(waves))
    names = ("event_valid", "event_kind", "event_data")
    of_circuit, of_model = (_signals(wave, scope, names) for scope in ("circuit", "model"))
    times = sorted({time for signal in (*of_circuit, *of_model) for time, _ in signal.tv})
    shown, expected = (_events_at(times, *signals) for signals in (of_circuit, of_model))
    assert len(set(expected)) > 2
    assert shown == expected
    save = (tmp_path / "run.gtkw").read_text(encoding="utf-8")
    assert [line[1:] for line in save.splitlines() if line.startswith("-")] == [
        "circuit", "circuit", "model", "model",
    ]  # fmt: skip
    assert "1 load" in (tmp_path / "run.phase.txt").read_text(encoding="utf-8").splitlines()


def _signals(wave: VCDVCD, scope: str, names: tuple[str, ...]) -> list[Any]:
    """The signals of the uppermost scope of this name."""
    return [
        wave[
            min(
                (each for each in wave.signals if re.search(rf"\b{scope}\.{name}(\[|$)", each)),
                key=lambda each: each.count("."),
            )
        ]
        for name in names
    ]


def _events_at(times: list[int], valid: Any, kind: Any, value: Any) -> list[tuple[int, int] | None]:
    """Kind and value of the event at each time, or None."""
    return [(int(kind[time], 2), int(value[time], 2)) if valid[time] == "1" else None for time in times]


def test_a_missing_tool_names_the_command_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(tools.TOOLS, "none", tools.Tool(programs=("no-such-tool",), install="apt-get install none"))
    with pytest.raises(tools.MissingToolError) as caught:
        tools.require("none")
    assert str(caught.value) == "none is not installed\n  hint: install it: apt-get install none"
