"""``hwsw rtl``: the folder of a design point simulates by itself, and is written whole or not at all."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pytest
from click.testing import Result
from rtl_tools import needs
from toy_styles import Install, OnHarmonic

from codesign.ground.errors import RunError
from codesign.ground.files import write_folder
from codesign.hardware.rtl.design import digest_of_circuit, top_name, top_text
from codesign.planners.circuits import Bits, Circuit

Run = Callable[..., Result]
Specs = tuple[Path, Path]


@pytest.fixture
def folder(hwsw: Run, installed: Install, specs: Specs, tmp_path: Path) -> Path:
    """An exported folder."""
    installed(OnHarmonic())
    result = hwsw("rtl", *specs, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    return tmp_path / "out"


def circuit() -> Circuit:
    return OnHarmonic().circuit(OnHarmonic().sample(0))


def icarus(folder: Path) -> str:
    """What the bench prints in Icarus. A warning fails the test."""
    needs("icarus")
    sources = sorted(path.name for path in folder.glob("*.v"))
    command = ["iverilog", "-g2005", "-Wall", "-s", "hwsw_bench", "-o", "bench.vvp", *sources]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert built.stderr == ""
    run = subprocess.run(["vvp", "-n", "bench.vvp"], cwd=folder, capture_output=True, text=True, check=True)
    assert run.stderr == ""
    return run.stdout


def verilator(folder: Path) -> str:
    """What the bench prints in Verilator. A warning fails the test."""
    needs("verilator")
    sources = sorted(path.name for path in folder.glob("*.v"))
    command = ["verilator", "--binary", "--top-module", "hwsw_bench", "-j", "1", *sources]
    built = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert "%Warning" not in built.stderr + built.stdout
    return subprocess.run(["./obj_dir/Vhwsw_bench"], cwd=folder, capture_output=True, text=True, check=True).stdout


def test_the_manifest_recognises_the_design(folder: Path) -> None:
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["top"] == top_name(circuit()) == f"hwsw_{manifest['digest'][:12]}"
    assert manifest["digest"] == digest_of_circuit(circuit())
    assert (manifest["planner"], manifest["style"], manifest["task"]) == ("harmonic", "bit_serial", "")
    assert (manifest["part"], manifest["clock_hz"]) == ("XC2V6000-4", 100_000_000)
    files = {path.name for path in folder.iterdir()} - {"manifest.json"}
    assert set(manifest["files"]) == files
    for name, digest in manifest["files"].items():
        assert sha256((folder / name).read_bytes()).hexdigest() == digest


def test_every_file_stands_in_the_readme(folder: Path) -> None:
    readme = (folder / "README.md").read_text(encoding="utf-8")
    assert [path.name for path in folder.iterdir() if f"`{path.name}`" not in readme] == ["README.md"]
    for name in ("clk", "in_ready", "event_data"):
        assert f"| `{name}` |" in readme


def test_the_same_design_point_gives_the_same_bytes(hwsw: Run, folder: Path, specs: Specs, tmp_path: Path) -> None:
    again = tmp_path / "again"
    assert hwsw("rtl", *specs, "-o", again).exit_code == 0
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == {
        path.name: path.read_bytes() for path in again.iterdir()
    }


def test_the_bench_passes_and_fails_with_a_flipped_bit_in_icarus(folder: Path) -> None:
    assert icarus(folder) == "PASS: 39 events in 78 cycles\n"
    for name, text in (("constant.hex", "cycle 77: the model"), ("stream.hex", "cycle 76: the model")):
        before = (folder / name).read_text(encoding="utf-8")
        lines = before.split()
        lines[-1] = f"{int(lines[-1], 16) ^ 4:x}"
        (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
        output = icarus(folder)
        assert output.startswith(f"FAIL at {text} reports "), output
        (folder / name).write_text(before, encoding="utf-8")


@pytest.mark.slow
def test_the_bench_passes_in_verilator(folder: Path) -> None:
    assert verilator(folder).startswith("PASS: 39 events in 78 cycles\n")


def test_the_bench_writes_a_waveform(folder: Path) -> None:
    icarus(folder)
    command = ["vvp", "-n", "bench.vvp", "+waves", "+first=40", "+last=44"]
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert "waves.vcd ends at cycle 44" in run.stdout
    assert "$enddefinitions" in (folder / "waves.vcd").read_text(encoding="utf-8")


def test_a_parameter_of_many_bits_has_the_width_of_its_declaration() -> None:
    narrow, wide = replace(circuit(), parameters={"N": 5}), replace(circuit(), parameters={"N": Bits(5, 70)})
    assert ".N(5)" in top_text(narrow)
    assert ".N(70'd5)" in top_text(wide)
    with pytest.raises(AssertionError, match="has more bits than a number without a width"):
        top_text(replace(circuit(), parameters={"N": 1 << 31}))


@pytest.mark.parametrize(
    ("part", "suffix", "text"),
    [
        ("XC7A100T-1", ".xdc", "create_clock -name clk -period 20.000 [get_ports {clk}]"),
        ("XC2V6000-4", ".ucf", 'TIMESPEC "TS_clk" = PERIOD "clk" 20.000 ns HIGH 50 %;'),
        ("LFE5U-85F-8", ".lpf", 'FREQUENCY PORT "clk" 50.000000 MHZ;'),
    ],
)
def test_the_clock_is_constrained_for_the_tools_of_the_part(
    hwsw: Run, installed: Install, specs: Specs, tmp_path: Path, part: str, suffix: str, text: str
) -> None:
    installed(OnHarmonic())
    out = tmp_path / "out"
    result = hwsw("rtl", *specs, "--set", f"fpga.part={part}", "--set", "fpga.clock=50MHz", "-o", out)
    assert result.exit_code == 0, result.output
    (file,) = out.glob(f"hwsw_*{suffix}")
    assert text in file.read_text(encoding="utf-8")
    assert json.loads((out / "manifest.json").read_text())["settings"] == {"fpga.clock": "50MHz", "fpga.part": part}


def test_a_folder_with_files_is_refused_without_force(hwsw: Run, folder: Path, specs: Specs) -> None:
    (folder / "mine.txt").write_text("notes", encoding="utf-8")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    result = hwsw("rtl", *specs, "-o", folder)
    assert result.exit_code == 2
    assert "is not empty\n  hint: name another folder, or add --force" in result.output
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_force_replaces_the_files_of_the_command_alone(hwsw: Run, folder: Path, specs: Specs) -> None:
    (folder / "mine.txt").write_text("notes", encoding="utf-8")
    (folder / "build").mkdir()
    (folder / "build" / "design.bit").write_text("bits", encoding="utf-8")
    settings = ("--set", "fpga.part=LFE5U-85F-8", "--set", "fpga.clock=50MHz")
    result = hwsw("rtl", *specs, *settings, "--force", "-o", folder)
    assert result.exit_code == 0, result.output
    assert (folder / "mine.txt").read_text(encoding="utf-8") == "notes"
    assert (folder / "build" / "design.bit").exists()
    assert not list(folder.glob("*.ucf"))
    assert list(folder.glob("*.lpf"))


def test_a_design_that_does_not_fit_is_refused_and_nothing_is_written(
    hwsw: Run, installed: Install, specs: Specs, tmp_path: Path
) -> None:
    installed(OnHarmonic())
    small = ("--set", "fpga.part=XC3S500E-4", "--set", "relax.block=[24, 36]")
    result = hwsw("rtl", *specs, *small, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "the design does not fit XC3S500E" in result.output
    assert not (tmp_path / "out").exists()


def test_a_file_in_place_of_the_folder_is_refused(hwsw: Run, installed: Install, specs: Specs, tmp_path: Path) -> None:
    installed(OnHarmonic())
    (tmp_path / "out").write_text("a file", encoding="utf-8")
    result = hwsw("rtl", *specs, "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert "is no folder" in result.output


def test_a_folder_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "out"
    write_folder(target, {"a": b"1", "b": b"2"})
    write = Path.write_bytes

    def full(path: Path, content: bytes) -> int:
        if path.name == "b":
            raise OSError(28, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(RunError, match="No space left on device"):
        write_folder(target, {"a": b"3", "b": b"4"})
    assert {path.name: path.read_bytes() for path in target.iterdir()} == {"a": b"1", "b": b"2"}
    assert list(tmp_path.iterdir()) == [target]
