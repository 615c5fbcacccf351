"""Circuits in Icarus and Verilator: both run the test bench, which writes down what it sees."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from contextlib import suppress
from os import cpu_count
from pathlib import Path

import numpy as np

from codesign.ground.errors import RunError
from codesign.ground.files import scratch
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.bench import BENCH, bench_files
from codesign.hardware.rtl.cache import digest_of, kept
from codesign.hardware.rtl.design import sources_of, work_of, write_design
from codesign.hardware.rtl.gates import write_gates
from codesign.hardware.rtl.runs import HINT, Progress, Run, Waves, events_of, phases_of, pins_of, silent
from codesign.planners.circuits import Circuit, Expected, Pins

_BUILD_S = 1800.0
_RUN_S = 3600.0
_OPTIONS = ("--binary", "--top-module", BENCH, "-o", "run.exe")
LONG = 3 * 10**8
"""Above this number of elements times cycles, a program that runs fast is worth its compilation."""

WATCHED = 100_000
"""Cycles after the end in which Icarus looks at further outputs: it takes a minute for a frame of a display."""

_UNKNOWN = 255
"""The kind of an event with bits that are unknown (x)."""
_ZERO, _SAID = str.maketrans("xz", "00"), str.maketrans("01xz", "1100")


def icarus(
    circuit: Circuit,
    expected: Expected,
    waves: Waves | None = None,
    progress: Progress = silent,
    *,
    gates: bool = False,
) -> Run:
    """Run a circuit in Icarus. ``gates``: as the netlist that ``rtl.gates`` makes of it.

    Raises:
        MissingToolError: it is not installed.
        RunError: it refuses the Verilog.
    """
    compile_, vvp = tools.require("iverilog"), tools.require("vvp")
    with scratch() as folder:
        files = _write(circuit, expected, folder)
        if gates:
            files = [write_gates(circuit, folder), f"{BENCH}.v"]
        command = (*compile_, "-g2005", "-s", BENCH, "-o", "run.vvp", *files)
        progress("Icarus compiles the circuit", 0, 0)
        tools.checked(command, folder, f"Icarus, of {circuit.top},", seconds=_BUILD_S, hint=HINT)
        progress("Icarus simulates the circuit", 0, 0)
        watch = _watch(folder, expected, "Icarus", progress)
        command = (*vvp, "-n", "run.vvp", f"+pins={WATCHED}")
        return _run(circuit, command, folder, waves, watch, expected)


def verilator(circuit: Circuit, expected: Expected, waves: Waves | None = None, progress: Progress = silent) -> Run:
    """Run a circuit in the program that Verilator makes of it; it is kept.

    Raises:
        MissingToolError: it is not installed.
        RunError: it refuses the Verilog.
    """
    command = (*tools.require("verilator"), *_OPTIONS, "-MAKEFLAGS", _levels(circuit, expected))
    trace = ("--trace",) if waves else ()

    def build(folder: Path) -> None:
        files = _write(circuit, expected, folder)
        what = f"Verilator, of {circuit.top},"
        progress("Verilator compiles the circuit", 0, 0)
        cores = ("-j", str(cpu_count() or 1))
        tools.checked((*command, *cores, *trace, *files), folder, what, seconds=_BUILD_S, hint=HINT)
        (folder / "obj_dir" / "run.exe").rename(folder / "run.exe")
        shutil.rmtree(folder / "obj_dir")

    with scratch() as folder:
        files = _write(circuit, expected, folder)
        texts = ((folder / name).read_text(encoding="utf-8") for name in files)
        digest = digest_of(*texts, *command[1:], *trace, tools.version_of("verilator"))
        with kept("verilator", digest, build) as program:
            progress("Verilator simulates the circuit", 0, 0)
            watch = _watch(folder, expected, "Verilator", progress)
            command = (str((program / "run.exe").absolute()),)
            return _run(circuit, command, folder, waves, watch, expected)


def _levels(circuit: Circuit, expected: Expected) -> str:
    """The options that parts of a program are compiled with. -O1 takes twice as long as -O0, and runs twice as fast."""
    level = "-O1" if work_of(circuit, expected) > LONG else "-O0"
    return f"OPT_FAST={level} OPT_SLOW=-O0 OPT_GLOBAL={level}"


def _watch(folder: Path, expected: Expected, name: str, progress: Progress) -> Callable[[], None]:
    """Report the cycle of the last event in the log."""
    cycles, log = sum(expected.cycles.values()), folder / "events.log"

    def watch() -> None:
        with suppress(OSError, ValueError, IndexError), log.open("rb") as file:
            file.seek(max(0, log.stat().st_size - 200))
            # The first line and the last one may be cut off.
            events = [line for line in file.read().splitlines()[1:-1] if line.startswith(b"event ")]
            done = int(events[-1].split()[1])
            progress(f"cycles simulated in {name}", min(done, cycles), cycles)

    return watch


def _write(circuit: Circuit, expected: Expected, folder: Path) -> list[str]:
    """Write the circuit and its bench; the names of the Verilog files."""
    write_design(circuit, folder)
    for name, text in bench_files(circuit, expected).items():
        (folder / name).write_text(text, encoding="utf-8")
    return [*sources_of(circuit), f"{BENCH}.v"]


def _run(
    circuit: Circuit,
    command: tuple[str, ...],
    folder: Path,
    waves: Waves | None,
    watch: Callable[[], None],
    expected: Expected,
) -> Run:
    window = ("+waves", f"+first={waves.first}", f"+last={waves.last}") if waves else ()
    finished = tools.run((*command, "+log", *window), folder, seconds=_RUN_S, hint=HINT, watch=watch)
    log = folder / "events.log"
    lines = log.read_text(encoding="utf-8").splitlines() if log.exists() else []
    if finished.code or not lines or not lines[-1].startswith("end "):
        raise RunError(f"the simulation of {circuit.top} failed: {finished.complaints}")
    if waves:
        shutil.copyfile(folder / "waves.vcd", waves.file)
    rows = [_event(line.split()[1:]) for line in lines if line.startswith("event ")]
    phases = (line.split()[1:] for line in lines if line.startswith("phase "))
    counts = {int(phase): int(count) for phase, count in phases}
    _, taken, ended, last = lines[-1].split()
    events = events_of(np.array(rows, np.uint64).reshape(-1, 3))
    pins = _pins(circuit, lines, int(last)) if circuit.pins and expected.pins else None
    return Run(events, phases_of(circuit, counts), int(taken), ended == "1", pins)


def _pins(circuit: Circuit, lines: list[str], end: int) -> Pins:
    """The changes of the further outputs in the log; a bit that is unknown in the simulation is none that is known."""
    changes = [line.split()[1:] for line in lines if line.startswith("pins ")]
    bits = [(int(cycle), text.translate(_ZERO), text.translate(_SAID)) for cycle, text in changes]
    rows = np.array([(cycle, 0, int(value, 2)) for cycle, value, _ in bits], np.uint64).reshape(-1, 3)
    return pins_of(circuit, rows, end, np.array([int(said, 2) for *_, said in bits], np.uint64))


def _event(words: list[str]) -> tuple[int, int, int]:
    """Cycle, kind and value of an event in the log."""
    cycle, kind, value = words
    try:
        return int(cycle), int(kind), int(value, 16)
    except ValueError:
        return int(cycle), _UNKNOWN, 0
