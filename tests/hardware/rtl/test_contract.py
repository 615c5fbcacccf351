"""Every circuit that is installed: as a bench that stands alone, in every simulator, and against the model.

``tests/planners/test_contract.py`` runs one sample of each natively: it is a rule of the suite for plug-ins.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from examples import THOROUGH
from rtl_tools import needs, quickest
from verilog_tools import SIMULATORS, output_of

from codesign.hardware.rtl.bench_runs import bench_files
from codesign.hardware.rtl.design import sources_of, write_design
from codesign.planners.circuits import Circuit, CircuitStyle, Expected
from codesign.system import catalog

CIRCUITS = catalog.circuits()
each_circuit = pytest.mark.parametrize(
    "style", CIRCUITS.values(), ids=["-".join(filter(None, key)) for key in CIRCUITS]
)

LEAST_POINTS = 60
"""Design points that are verified over all styles."""

POINTS = 20
"""Exported benches of each style."""


NARROW = 6 if THOROUGH else 2
"""Samples of each style on a map of one row or one column."""

TRIES = 20
"""Bits that are drawn before those that matter are looked for."""


def bench(style: CircuitStyle, seed: int, folder: Path) -> tuple[Circuit, Expected, list[str]]:
    """Write the circuit of a sample and its bench; the Verilog files."""
    job = style.sample(seed)
    circuit, expected = style.circuit(job), style.expected(job)
    write_design(circuit, folder)
    for name, text in bench_files(circuit, expected).items():
        (folder / name).write_text(text, encoding="utf-8")
    return circuit, expected, [*sources_of(circuit), "hwsw_bench.v"]


def check_bench(style: CircuitStyle, seed: int, folder: Path, simulator: str) -> None:
    """The bench passes, and fails once a bit of a memory or of the stream that loads it is another."""
    circuit, expected, files = bench(style, seed, folder)
    run = SIMULATORS[simulator](folder, files)
    assert run().startswith(f"PASS: {len(expected.events.cycle)} events in "), (style.style, seed)
    names = [name for name, image in circuit.images.items() if len(image.words)]
    names += ["stream.hex"] if len(circuit.stream.words) else []
    assert any(fails_with_a_flipped_bit(folder / name, seed, run) for name in names), (style.style, seed)


def fails_with_a_flipped_bit(path: Path, seed: int, run: Callable[[], str]) -> bool:
    """Whether the bench fails with one bit of a file flipped.

    Most bits move nothing: an obstacle behind obstacles, or a cell that the robot is not beside. Some bits are drawn.
    If none of them matters, a bit of every word is flipped, then of half of the words with which the bench still fails,
    down to one word.
    """
    before = path.read_text(encoding="utf-8")
    words = before.split()

    def fails(flipped: Sequence[int], digit: int) -> bool:
        lines = list(words)
        for index in flipped:
            word = words[index]
            # The first digit of a word may stand for fewer than four bits: its lowest is always there.
            lines[index] = f"{word[:digit]}{int(word[digit], 16) ^ 1:x}{word[digit + 1 :]}"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        output = run()
        path.write_text(before, encoding="utf-8")
        assert output.startswith(("PASS: ", "FAIL at cycle ")), output
        return output.startswith("FAIL at cycle ")

    random, digits = np.random.default_rng(seed), min(map(len, words))
    if any(fails([int(random.integers(len(words)))], int(random.integers(digits))) for _ in range(TRIES)):
        return True
    for digit in range(digits):
        flipped: Sequence[int] = range(len(words))
        while fails(flipped, digit):
            if len(flipped) == 1:
                return True
            half = len(flipped) // 2
            first = flipped[:half]
            flipped = first if fails(first, digit) else flipped[half:]
    return False


def test_every_planner_has_circuits() -> None:
    assert {planner for planner, *_ in CIRCUITS} >= {"breadth_first", "velocity_obstacle", "wavefront"}


@each_circuit
def test_a_bench_stands_alone_in_icarus(style: CircuitStyle, tmp_path: Path) -> None:
    needs("icarus")
    check_bench(style, 1, tmp_path, "icarus")


@each_circuit
def test_the_verilog_is_without_warnings_in_verilator(style: CircuitStyle, tmp_path: Path) -> None:
    needs("verilator")
    circuit, _, files = bench(style, 0, tmp_path)
    top = Path(files[-2]).stem
    lint = ("verilator", "--lint-only", "-Wall", "--top-module", top)
    assert output_of(tmp_path, *lint, *files[:-1]) == ""
    assert circuit.top in (tmp_path / files[-2]).read_text(encoding="utf-8")


@each_circuit
def test_a_map_of_one_row_or_one_column_is_without_warnings(style: CircuitStyle, tmp_path: Path) -> None:
    needs("verilator")
    needs("icarus")
    narrow = [seed for seed in range(100) if 1 in getattr(style.sample(seed).problem, "shape", ())]
    for seed in narrow[:NARROW]:
        folder = tmp_path / str(seed)
        folder.mkdir()
        _, _, files = bench(style, seed, folder)
        lint = ("verilator", "--lint-only", "-Wall", "--top-module", Path(files[-2]).stem)
        assert output_of(folder, *lint, *files[:-1]) == "", seed
        built = ("iverilog", "-g2005", "-Wall", "-s", "hwsw_bench", "-o", "bench.vvp")
        assert output_of(folder, *built, *files) == "", seed


@pytest.mark.slow
@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("seed", range(POINTS))
@each_circuit
def test_benches_of_random_points_stand_alone(style: CircuitStyle, seed: int, simulator: str, tmp_path: Path) -> None:
    needs(simulator)
    check_bench(style, seed, tmp_path, simulator)


@pytest.mark.slow
def test_the_model_holds_on_random_points_of_every_style(hwsw: Callable[..., Result]) -> None:
    points = -(-LEAST_POINTS // len(CIRCUITS))
    result = hwsw("verify", "--all", "--points", points, "--seed", 100, "--backend", quickest())
    assert result.exit_code == 0, result.output
    assert f"{points * len(CIRCUITS)} design points: every event equals the model" in result.output
