"""The outputs of the display are compared with the model, and many faults in the Verilog are found by that."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rtl_tools import needs
from verilog_tools import in_icarus

from codesign.hardware.rtl.bench_runs import bench_files
from codesign.hardware.rtl.design import sources_of, write_design
from codesign.hardware.rtl.verify import Verified, verify
from codesign.planners.breadth_first.plan.parameters import Address, MicroArchitecture, SearchParameters, VgaController
from codesign.planners.breadth_first.plan.planner import PLANNER
from codesign.planners.breadth_first.rtl import Screen, SearchJob, StateMachineCircuit
from codesign.planners.circuits import Circuit, Expected
from codesign.planners.interface import Problem
from codesign.planners.job import Job

SMALL = Screen(half=24, line=60, sync=(50, 54), frame=30, line_sync=(24, 26))
NUMBERS = {
    "HALF = 400": "HALF = 24",
    "SYNC_BEGIN = 936": "SYNC_BEGIN = 50",
    "SYNC_END = 1072": "SYNC_END = 54",
    "LINE = 1344": "LINE = 60",
    "LINE_SYNC_BEGIN = 687": "LINE_SYNC_BEGIN = 24",
    "LINE_SYNC_END = 693": "LINE_SYNC_END = 26",
    "FRAME = 806": "FRAME = 30",
}
"""The numbers of the screen, and those of a small one: a frame in 3,600 cycles."""

MUTANTS = {
    "breadth_first_display.v": {
        "HALF = 24": "HALF = 25",
        " SYNC_BEGIN = 50": " SYNC_BEGIN = 49",
        " SYNC_END = 54": " SYNC_END = 55",
        "LINE = 60": "LINE = 61",
        "LINE_SYNC_BEGIN = 24": "LINE_SYNC_BEGIN = 25",
        "LINE_SYNC_END = 26": "LINE_SYNC_END = 27",
        "FRAME = 30": "FRAME = 31",
        "LAST_TICK = PIXEL_CYCLES - 1": "LAST_TICK = PIXEL_CYCLES",
        "STRIDE = COLUMNS + 1": "STRIDE = COLUMNS",
        "y < HEIGHT": "y <= HEIGHT",
        "column < WIDTH": "column <= WIDTH",
        "line_end || half_end": "line_end",
        "half_end ? line :": "half_end ? {ADDRESS_BITS{1'b0}} :",
        "address = {y[ROW_BITS-1:0], column[COLUMN_BITS-1:0]}": "address = {y[ROW_BITS-1:0], x[COLUMN_BITS-1:0]}",
        "{map_later[0], on_map}": "{2{on_map}}",
        "{right_later[0], x >= HALF}": "{2{x >= HALF}}",
        "horizontal_sync <= horizontal_later[1]": "horizontal_sync <= ~horizontal_later[1]",
        "vertical_sync <= vertical_later[1]": "vertical_sync <= 1'b0",
        "{3{seen}} & {1'b1, direction}": "{1'b1, direction}",
        "& {1'b1, direction}": "& {1'b1, ~direction}",
        "seen = code[1]": "seen = code[0]",
        "2'd0: colour <= 3'b000": "2'd0: colour <= 3'b001",
        "2'd1: colour <= 3'b111": "2'd1: colour <= 3'b110",
        "2'd2: colour <= 3'b100": "2'd2: colour <= 3'b010",
        "default: colour <= 3'b010": "default: colour <= 3'b011",
    },
    "breadth_first_screen_top.v": {
        ".ADDRESS_BITS(ADDRESS_BITS), .LINEAR(LINEAR)\n    ) display": ".ADDRESS_BITS(ADDRESS_BITS)\n    ) display",
        ".code(shown_code), .direction(shown_direction),": ".code(shown_direction), .direction(shown_code),",
    },
    "breadth_first_memory.v": {
        ".address_b(shown_address)": ".address_b(read_address)",
        ".read_enable(1'b1), .read_address(shown_address)": ".read_enable(read_enable), .read_address(shown_address)",
    },
    "breadth_first_machine.v": {
        "tracking ? ON_PATH : VISITED": "VISITED",
        "written_code & {2{!started}}": "written_code",
        ".write_data(mark_side ^ 2'd1)": ".write_data(mark_side)",
    },
}
"""Faults by file: what stands there, and what stands there in its place."""


def job(columns: int, address: Address, display: VgaController, micro_architecture: MicroArchitecture) -> SearchJob:
    """A search among obstacles, with a path and a goal that it does not reach."""
    free = np.random.default_rng(3).random((7, columns)) > 0.25
    free[[1, 5, 0], [1, 9, 10]] = True
    parameters = SearchParameters(micro_architecture=micro_architecture, address=address, display=display)
    return Job(Problem(free, ((5, 9), (0, 10)), ((1, 1),)), parameters)


JOBS = (
    job(SMALL.half, Address.LINEAR, VgaController.SHARED, MicroArchitecture.TWO_CYCLES),
    job(11, Address.SIDE_BY_SIDE, VgaController.COPY, MicroArchitecture.PIPELINED),
)


class OnSmallScreen(StateMachineCircuit):
    """The circuit with the numbers of a small screen, and a fault."""

    screen = SMALL

    def __init__(self, folder: Path, file: str = "", before: str = "", after: str = "") -> None:
        self.folder, self.file, self.fault = folder, file, (before, after)

    def circuit(self, job: SearchJob) -> Circuit:
        circuit = super().circuit(job)
        return replace(circuit, sources=tuple(self._changed(source) for source in circuit.sources))

    def _changed(self, source: Path) -> Path:
        text = source.read_text(encoding="utf-8")
        if source.name == "breadth_first_display.v":
            for before, after in sorted(NUMBERS.items(), key=lambda pair: -len(pair[0])):
                assert before in text, before
                text = text.replace(before, after)
        if source.name == self.file:
            assert text.count(self.fault[0]) == 1, self.fault[0]
            text = text.replace(*self.fault)
        (self.folder / source.name).write_text(text, encoding="utf-8")
        return self.folder / source.name


def in_bench(style: OnSmallScreen, job: SearchJob, folder: Path) -> str:
    """What the exported bench prints."""
    circuit, expected = style.circuit(job), style.expected(job)
    write_design(circuit, folder)
    for name, text in bench_files(circuit, expected).items():
        (folder / name).write_text(text, encoding="utf-8")
    return in_icarus(folder, [*sources_of(circuit), "hwsw_bench.v"])()


def verified(style: StateMachineCircuit, job: SearchJob) -> Verified:
    return verify(style, job, "icarus")


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    needs("icarus")
    monkeypatch.setenv("CODESIGN_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "sources").mkdir()
    (tmp_path / "bench").mkdir()
    return tmp_path / "sources", tmp_path / "bench"


@pytest.mark.parametrize("job", JOBS, ids=["shared", "copy"])
def test_the_small_screen_is_the_model_over_more_than_a_frame(job: SearchJob, folders: tuple[Path, Path]) -> None:
    style = OnSmallScreen(folders[0])
    seen = verified(style, job)
    assert seen.first is None
    assert seen.shown > SMALL.line * SMALL.frame * SMALL.pixel_cycles
    assert in_bench(style, job, folders[1]).startswith("PASS: ")


@pytest.mark.parametrize(("file", "before"), [(file, before) for file, faults in MUTANTS.items() for before in faults])
def test_a_fault_is_found_by_verify_and_by_the_bench(file: str, before: str, folders: tuple[Path, Path]) -> None:
    style = OnSmallScreen(folders[0], file, before, MUTANTS[file][before])
    wrong = next((job for job in JOBS if verified(style, job).first is not None), None)
    assert wrong is not None, "the fault is seen in neither design"
    assert in_bench(style, wrong, folders[1]).startswith("FAIL at cycle ")


def test_the_picture_shows_the_path_the_visited_cells_and_the_map() -> None:
    """A frame after the run, drawn by hand from the plan."""
    style, job = StateMachineCircuit(), JOBS[1]
    expected, pins = style.expected(job), style.expected(job).pins
    assert pins is not None
    end = sum(expected.cycles.values())
    frame, line = 1344 * 806 * 2, 1344 * 2
    begin = -(-(end + 3) // frame) * frame + 2
    path = {tuple(cell) for cell in PLANNER.plan(job).path.tolist()}
    assert path
    for row in range(7):
        for column in range(11):
            at = int(np.searchsorted(pins.cycle, begin + row * line + 2 * column, side="right")) - 1
            colour = int(pins.value[at]) >> 2
            if (row, column) in path:
                assert colour == 0b100
            elif not job.problem.free[row, column]:
                assert colour == 0b000
            else:
                assert colour in (0b111, 0b010, 0b100)


def test_a_circuit_whose_further_outputs_no_model_knows_does_not_pass() -> None:
    needs("icarus")

    class Silent(StateMachineCircuit):
        def expected(self, job: SearchJob) -> Expected:
            return replace(super().expected(job), pins=None)

    seen = verified(Silent(), JOBS[0])
    assert "nothing compares" in str(seen.first)
