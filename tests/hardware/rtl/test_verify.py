"""``hwsw verify``: a design point, or samples of every circuit, against the model."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from rtl_tools import needs
from toy_circuit import ToyCircuit
from toy_styles import Flipped, Install, OnHarmonic

from codesign.ground.errors import RunError
from codesign.planners.circuits import Expected
from codesign.planners.job import Job

Run = Callable[..., Result]


class Failing(ToyCircuit):
    """Its second sample raises an error of its own, its third one of the package."""

    style = "failing"

    def sample(self, seed: int, /) -> Job[Any, Any]:
        if seed == 1:
            raise ZeroDivisionError("by design")
        if seed == 2:
            raise RunError("no such sample")
        return super().sample(seed)


class Contending(ToyCircuit):
    """The model is a cycle off in every phase, and contention excuses at most one per cent."""

    style = "contending"

    def expected(self, job: Job[Any, Any], /) -> Expected:
        expected = super().expected(job)
        cycles = {phase: cycles + 9 for phase, cycles in expected.cycles.items()}
        return replace(expected, cycles=cycles, contention="a test says so")


def test_samples_of_every_circuit_are_verified(hwsw: Run, installed: Install) -> None:
    needs("cxxrtl")
    installed(ToyCircuit())
    result = hwsw("verify", "--all", "--points", 2, "--seed", 1, "--jobs", 2)
    assert result.exit_code == 0, result.output
    assert "2 design points: every event equals the model in kind, value and cycle" in result.output
    (row,) = [line.split() for line in result.output.splitlines() if "summing" in line and "planning" in line]
    toy = ToyCircuit()
    expected = [toy.expected(toy.sample(seed)) for seed in (1, 2)]
    events = sum(len(each.events.cycle) for each in expected)
    cycles = sum(sum(each.cycles.values()) for each in expected)
    assert row[-5:] == ["2", str(events), str(cycles), "0", "0"]


def test_one_flipped_bit_fails_and_leaves_a_waveform(hwsw: Run, installed: Install, tmp_path: Path) -> None:
    needs("cxxrtl")
    installed(ToyCircuit(), Flipped())
    waves = tmp_path / "difference.vcd"
    result = hwsw("verify", "--all", "--points", 1, "--waves", waves)
    assert result.exit_code == 3
    assert "toy flipped, sample 0: cycle 77: the model reports sum " in result.output
    assert "every event equals" not in result.output
    assert f"waveform: {waves}" in result.output
    assert waves.read_text(encoding="utf-8").startswith("$timescale")


def test_cycles_are_drawn_where_nothing_differs(hwsw: Run, installed: Install, tmp_path: Path) -> None:
    needs("cxxrtl")
    installed(ToyCircuit())
    waves = tmp_path / "run.vcd"
    result = hwsw("verify", "--all", "--points", 1, "--waves", waves, "--cycles", 2, 9)
    assert result.exit_code == 0, result.output
    assert f"waveform: {waves}" in result.output
    assert {each.name for each in tmp_path.iterdir()} >= {"run.vcd", "run.gtkw", "run.phase.txt", "run.event_kind.txt"}
    assert hwsw("verify", "--all", "--cycles", 2, 9).exit_code == 2
    assert hwsw("verify", "--all", "--waves", waves, "--cycles", 9, 2).exit_code == 2


def test_json_has_every_point(hwsw: Run, installed: Install) -> None:
    needs("cxxrtl")
    installed(Flipped())
    result = hwsw("verify", "--all", "--points", 1, "--json")
    assert result.exit_code == 3
    (style,) = json.loads(result.stdout)
    assert (style["planner"], style["style"], style["task"], style["equal"]) == ("toy", "flipped", "", False)
    (point,) = style["points"]
    assert point["point"] == "sample 0"
    assert point["verified"]["differences"] == 1
    assert point["verified"]["first"]["cycle"] == 77


def test_a_point_that_fails_does_not_keep_others_from_being_verified(hwsw: Run, installed: Install) -> None:
    needs("cxxrtl")
    installed(Failing())
    result = hwsw("verify", "--all", "--points", 4)
    assert result.exit_code == 1
    assert "toy failing, sample 1: ZeroDivisionError: by design" in result.output
    assert "toy failing, sample 2: no such sample" in result.output
    (row,) = [line.split() for line in result.output.splitlines() if "planning" in line]
    assert (row[-5], row[-2], row[-1]) == ("4", "0", "2")


def test_contention_excuses_one_per_cent_in_the_mean(hwsw: Run, installed: Install) -> None:
    needs("cxxrtl")
    installed(Contending())
    result = hwsw("verify", "--all", "--points", 1)
    assert result.exit_code == 3
    assert "toy contending: the cycles deviate by more than contention excuses" in result.output


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), "0 arguments"),
        (("--all", "nexys2", "robots-2"), "--all draws its design points itself"),
        (("--all", "--planner", "tou"), "no planner named 'tou' has circuits"),
        (("nexys2", "robots-2", "--points", "3"), "is for --all only"),
        (("--all", "--points", "0"), "--points"),
        (("--all", "--backend", "questa"), "questa"),
        (("--all", "--waves", "missing/file.vcd"), "folder"),
    ],
)
def test_a_wrong_command_line_is_refused(hwsw: Run, installed: Install, words: tuple[str, ...], text: str) -> None:
    installed(ToyCircuit())
    result = hwsw("verify", *words)
    assert result.exit_code == 2
    assert text in result.output


def test_a_design_point_is_verified(hwsw: Run, installed: Install, specs: tuple[Path, Path]) -> None:
    needs("cxxrtl")
    installed(OnHarmonic())
    result = hwsw("verify", *specs)
    assert result.exit_code == 0, result.output
    assert "1 design point: every event equals the model" in result.output


def test_a_design_on_a_processor_has_no_circuit(hwsw: Run, installed: Install, specs: tuple[Path, Path]) -> None:
    installed(OnHarmonic())
    result = hwsw("verify", *specs, "--set", "relax.component=host", "--set", "decide.component=host")
    assert result.exit_code == 2
    assert "task relax is on host, a processor: it has no circuit" in result.output


def test_a_style_without_a_circuit_is_named(hwsw: Run, installed: Install, specs: tuple[Path, Path]) -> None:
    installed()
    result = hwsw("verify", *specs)
    assert result.exit_code == 2
    assert "style 'bit_serial' of task relax has no circuit in Verilog" in result.output


def test_a_missing_tool_ends_the_command_with_its_remedy(
    hwsw: Run, installed: Install, monkeypatch: pytest.MonkeyPatch
) -> None:
    from codesign.hardware.rtl import tools

    installed(ToyCircuit())
    monkeypatch.setattr(tools, "command_of", lambda name: None)
    for backend, remedy in (
        ("icarus", "apt-get install iverilog"),
        ("verilator", "apt-get install verilator"),
        ("cxxrtl", "pip install 'hwsw-codesign[rtl]'"),
    ):
        result = hwsw("verify", "--all", "--points", 1, "--backend", backend)
        assert result.exit_code == 1
        assert remedy in result.output
