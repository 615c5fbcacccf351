"""Waveforms, read back with a parser of VCD that is not the one that writes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from trace_samples import a_mission, a_run, write
from waveform_reader import VCDVCD

from codesign.cli import main
from codesign.ground.records import MessageRecord, PoseRecord, Record, StageRecord, TaskRecord, VisitsRecord
from codesign.views.exports.waveform import waveform_of, write_waveform

A_STAGE: list[Record] = [
    MessageRecord(0, "pci", "host", "fpga", "map", 8, 0, 1_000),
    MessageRecord(500, "pci", "host", "fpga", "goal", 8, 1_000, 2_000),
    TaskRecord(2_000, "fpga", "load", 3_000, 1),
    VisitsRecord(3_000, "fpga", 9_000, 0, 7, np.array([0, 3, 1], np.int32), np.array([1, 4, 1], np.int32)),
    StageRecord(9_000, "fpga", 3_000, 0, 7, 1, 3, 6, 54, 12, np.zeros((2, 2))),
    PoseRecord(9_500, "robot", 0.0, 0.0, 0.0, 0.25),
]


def read(records: list[Record], path: Path) -> VCDVCD:
    write_waveform(waveform_of(records), path)
    return VCDVCD(str(path))


def changes(wave: VCDVCD, name: str) -> list[tuple[int, str]]:
    return list(wave[name].tv)


def numbers(wave: VCDVCD, name: str) -> list[tuple[int, int]]:
    return [(time, int(value, 2)) for time, value in changes(wave, name)]


def test_signals_change_at_the_picosecond_of_the_record(tmp_path: Path) -> None:
    wave = read(A_STAGE, tmp_path / "run.vcd")
    assert wave.timescale["timescale"] * 10**12 == 1
    assert numbers(wave, "pci.busy") == [(0, 1), (2_000, 0)]
    assert numbers(wave, "pci.waiting") == [(0, 0), (500, 1), (1_000, 0)]
    assert numbers(wave, "fpga.busy") == [(0, 0), (2_000, 1), (9_000, 0)]
    assert numbers(wave, "fpga.precision") == [(0, 0), (3_000, 7), (9_000, 0)]
    assert numbers(wave, "fpga.local_maxima")[-1] == (9_000, 12)
    assert [float(value) for _, value in changes(wave, "robot.speed")][-1] == 0.25


def test_visits_are_placed_by_their_iterations(tmp_path: Path) -> None:
    wave = read(A_STAGE, tmp_path / "run.vcd")
    # 6 iterations in 6,000 ps.
    assert numbers(wave, "fpga.block")[-2:] == [(4_000, 3), (8_000, 1)]
    assert numbers(wave, "fpga.iterations")[-3:] == [(3_000, 1), (4_000, 4), (8_000, 1)]


def test_names_are_numbers_with_a_translate_file(tmp_path: Path) -> None:
    wave = read(A_STAGE, tmp_path / "run.vcd")
    lines = (tmp_path / "run.pci.message_to_fpga.txt").read_text().splitlines()
    names = {int(line.split(" ", 1)[0], 16): line.split(" ", 1)[1] for line in lines}
    assert [(time, names[number]) for time, number in numbers(wave, "pci.message_to_fpga")] == [
        (0, "map"), (1_000, "goal"), (2_000, "-"),
    ]  # fmt: skip
    save = (tmp_path / "run.gtkw").read_text()
    assert "run.pci.message_to_fpga.txt" in save
    assert str(tmp_path) not in save, "the folder may be moved"


@pytest.mark.parametrize("records", [a_run(), a_mission(), [*a_run(), *a_mission()]])
def test_every_run_reads_back(records: list[Record], tmp_path: Path) -> None:
    wave = read(records, tmp_path / "run.vcd")
    assert wave.signals
    for name in wave.signals:
        times = [time for time, _ in wave[name].tv]
        assert times == sorted(set(times))


def test_a_part_of_a_run_has_what_reaches_into_it(tmp_path: Path) -> None:
    whole, part = waveform_of(A_STAGE), waveform_of(A_STAGE, 8_500, 9_200)
    assert {scope for scope, _ in part.signals} == {"fpga"}
    assert whole.signals["fpga", "stage"].changes == part.signals["fpga", "stage"].changes


def test_hostile_names_stay_names(tmp_path: Path) -> None:
    records: list[Record] = [TaskRecord(0, "a $end\nb", "x $end\n$var é", 5, 1)]
    wave = read(records, tmp_path / "run.vcd")
    assert wave.signals == ["a__end_b.busy", "a__end_b.task"]


def test_the_same_run_gives_the_same_files(tmp_path: Path) -> None:
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        write_waveform(waveform_of(a_mission()), tmp_path / folder / "run.vcd")
    one, two = ({path.name: path.read_bytes() for path in (tmp_path / folder).iterdir()} for folder in ("one", "two"))
    assert one == two


def test_the_command_line_says_what_it_wrote(tmp_path: Path) -> None:
    path, vcd = write(tmp_path / "run.mcap", a_mission()), tmp_path / "run.vcd"
    done = CliRunner().invoke(main, ["trace", "export", str(path), "--vcd", str(vcd), "--to", "1 s"])
    assert done.exit_code == 0, done.output
    written = {Path(line.removeprefix("written: ")) for line in done.output.splitlines()}
    assert written == {each for each in tmp_path.iterdir() if each != path}
    late = CliRunner().invoke(main, ["trace", "export", str(path), "--vcd", str(vcd), "--from", "2 s", "--to", "1 s"])
    assert late.exit_code == 2
