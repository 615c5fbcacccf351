"""The circuit of one robot against the planner and the laws, and its Verilog against three readers."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from itertools import chain
from pathlib import Path

import pytest

from codesign.ground.errors import UnsuitedError
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.bench_runs import Run
from codesign.hardware.rtl.verify import simulate, verify
from codesign.planners.circuits import Image
from codesign.planners.job import Job
from codesign.planners.velocity_obstacle.plan.avoid import avoid
from codesign.planners.velocity_obstacle.plan.parameters import AvoidParameters, Detector, Unit
from codesign.planners.velocity_obstacle.plan.problem import generate
from codesign.planners.velocity_obstacle.published import TABLE_II, Style
from codesign.planners.velocity_obstacle.rtl import CIRCUITS, KINDS, TAKEN, RobotCircuit
from codesign.planners.velocity_obstacle.styles import timing

FEW, MANY = range(2), range(2, 102)
BACKEND = "icarus"


@pytest.fixture(autouse=True)
def own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "cache"))


def needs(program: str) -> None:
    if tools.command_of(program) is None:
        pytest.skip(f"{program} is not installed")


def assert_decides_as_the_planner(circuit: RobotCircuit, seed: int) -> None:
    needs("iverilog")
    result = verify(circuit, circuit.sample(seed), BACKEND)
    assert (result.differences, result.first) == (0, None), f"seed {seed}"


@pytest.mark.parametrize("circuit", CIRCUITS, ids=lambda each: each.style)
def test_the_circuit_decides_as_the_planner_does(circuit: RobotCircuit) -> None:
    for seed in FEW:
        assert_decides_as_the_planner(circuit, seed)


@pytest.mark.slow
@pytest.mark.parametrize("circuit", CIRCUITS, ids=lambda each: each.style)
def test_hundreds_of_circuits_decide_as_the_planner_does(circuit: RobotCircuit) -> None:
    for seed in MANY:
        assert_decides_as_the_planner(circuit, seed)


def run(circuit: RobotCircuit, job: Job[object, AvoidParameters]) -> Run:
    needs("iverilog")
    return simulate(circuit.circuit(job), circuit.expected(job), BACKEND)


@pytest.mark.parametrize("style", list(Style))
@pytest.mark.parametrize("robots", [2, 4, 8])
def test_a_trial_takes_the_cycles_of_table_ii(style: Style, robots: int) -> None:
    """At the start nobody moves: the first velocity is tried, and the cycles of the trial are those of the paper."""
    job = Job(generate("circle", robots), AvoidParameters(updates=1))
    seen = run(RobotCircuit(style), job)
    trials = int(avoid(job.problem, job.parameters).trials[0, 0])
    assert seen.ended
    assert seen.cycles["verify"] == TABLE_II[style][robots] * trials


def test_samples_cover_every_verdict_and_option() -> None:
    jobs = [circuit.sample(seed) for circuit in CIRCUITS for seed in range(30)]
    kinds = chain.from_iterable(CIRCUITS[1].expected(job).events.kind.tolist() for job in jobs if job.problem.count < 6)
    assert set(kinds) == set(range(len(KINDS)))
    decisions = [avoid(job.problem, job.parameters).candidates[:, 0] for job in jobs]
    assert {min(each, 0) for each in chain.from_iterable(each.tolist() for each in decisions)} == {-2, -1, 0}
    for name in ("detector", "unit", "detection", "responsibility"):
        assert len({getattr(job.parameters, name) for job in jobs}) == 2
    assert {job.parameters.range is None for job in jobs} == {True, False}
    assert {8, 24} <= {job.parameters.width for job in jobs}
    # A sample is the same for the same seed.
    again = CIRCUITS[2].sample(7)
    assert again.parameters == CIRCUITS[2].sample(7).parameters


def test_a_flipped_bit_of_the_array_of_velocities_is_seen() -> None:
    circuit = CIRCUITS[1]
    job = Job(generate("circle", 3), AvoidParameters(updates=2))
    needs("iverilog")
    whole, expected = circuit.circuit(job), circuit.expected(job)
    taken = next(
        int(value) for kind, value in zip(expected.events.kind, expected.events.value, strict=True) if kind == TAKEN
    )
    words = list(whole.images["velocities_x.hex"].words)
    words[taken] ^= 1 << 9
    images = {**whole.images, "velocities_x.hex": Image(job.parameters.width, words)}
    seen = simulate(replace(whole, images=images), expected, BACKEND)
    assert seen.events.value.tolist() != expected.events.value.tolist()


def test_the_sequential_circuit_has_one_datapath() -> None:
    job = Job(generate("circle", 4), AvoidParameters(update_units=2, detect_units=3))
    with pytest.raises(UnsuitedError) as caught:
        CIRCUITS[0].circuit(job)
    assert [(fault.key, fault.hint) for fault in caught.value.faults] == [
        ("avoid.update_units", "take 1"),
        ("avoid.detect_units", "take 1"),
    ]


def test_a_circuit_is_described_without_a_plan(monkeypatch: pytest.MonkeyPatch) -> None:
    def planned(*_: object) -> None:
        raise AssertionError("a plan is computed")

    monkeypatch.setattr("codesign.planners.velocity_obstacle.rtl.avoid", planned)
    circuit = CIRCUITS[0].circuit(Job(generate("circle", 4), AvoidParameters()))
    assert circuit.phases == timing.PHASES
    with pytest.raises(AssertionError, match="computed"):
        len(circuit.stream.words)


def lint_point(**options: object) -> Job[object, AvoidParameters]:
    return Job(generate("circle", 5), AvoidParameters(updates=1, **options))


@pytest.mark.parametrize(
    "job",
    [
        lint_point(width=17),
        lint_point(width=24, unit=Unit.PARALLEL, update_units=2, detect_units=3),
        lint_point(width=16, detector=Detector.CROSS_PRODUCT, range=40.0, update_units=5, detect_units=1),
        lint_point(width=20, detector=Detector.CROSS_PRODUCT, unit=Unit.PARALLEL, responsibility="full"),
    ],
)
def test_verilator_and_icarus_have_no_warning(job: Job[object, AvoidParameters], tmp_path: Path) -> None:
    needs("verilator")
    circuit = CIRCUITS[2].circuit(job)
    for name, image in circuit.images.items():
        (tmp_path / name).write_text(image.hex_text(), encoding="utf-8")
    numbers = {name: value for name, value in circuit.parameters.items() if isinstance(value, int)}
    sources = [str(source) for source in circuit.sources]
    command = ["verilator", "--lint-only", "-Wall", "--top-module", circuit.top]
    command += [f"-G{name}={value}" for name, value in numbers.items()]
    done = subprocess.run([*command, *sources], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stderr, done.returncode) == ("", 0)
    command = ["iverilog", "-Wall", "-g2005", "-t", "null", "-s", circuit.top]
    command += [f"-P{circuit.top}.{name}={value}" for name, value in numbers.items()]
    done = subprocess.run([*command, *sources], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stderr, done.returncode) == ("", 0)
