"""Circuits in Icarus and Verilator: both run the test bench, which writes down what it sees."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from os import cpu_count
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import RunError
from codesign.ground.files import scratch
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.design import (
    bound_of,
    digest_of,
    kept,
    range_of,
    sources_of,
    top_name,
    work_of,
    write_design,
)
from codesign.planners.circuits import Circuit, Events, Expected, Pins

# One run of a circuit, whichever simulator runs it.

Progress = Callable[[str, int, int], None]
"""Called with what a simulator does, the cycles that it has simulated, and those expected: 0 while it builds."""


def silent(_words: str, _done: int, _expected: int) -> None:
    """Report no progress."""


HINT = "verify a smaller design, such as one with smaller blocks or a smaller map, or try another --backend"
"""The remedy where a simulator does not end in time."""


@dataclass(frozen=True)
class Waves:
    """A waveform that is wanted: the VCD file, and its first and last cycle."""

    file: Path
    first: int
    last: int


@dataclass(frozen=True, eq=False)
class Run:
    """One run of a circuit.

    - ``events``: what it reported. ``cycles``: by phase, and under "" those outside of all phases.
    - ``taken``: words of the stream that it took. ``ended``: whether ``done`` was seen within the bound.
    - ``pins``: what its further outputs showed, up to the cycle that was simulated last; None where it has none.
    """

    events: Events
    cycles: Mapping[str, int]
    taken: int
    ended: bool
    pins: Pins | None = None


def phases_of(circuit: Circuit, counts: Mapping[int, int]) -> dict[str, int]:
    """The cycles by the name of the phase, from those by its number. A number without a name keeps it as its name."""
    names = ("", *circuit.phases)
    return {names[i] if i < len(names) else f"phase {i}": count for i, count in counts.items() if count}


def stream_chunks(circuit: Circuit) -> bytes:
    """The words of the stream in chunks of 32 bits, the lowest first, as the native simulator reads them."""
    width = -(-circuit.stream.width // 32) * 4
    return b"".join(int(word).to_bytes(width, "little") for word in circuit.stream.words)


def events_of(records: NDArray[np.uint64]) -> Events:
    """Events from rows of (cycle, kind, value) as uint64."""
    return Events(records[:, 0].astype(np.int64), records[:, 1].astype(np.uint8), records[:, 2].copy())


def pins_of(circuit: Circuit, changes: NDArray[np.uint64], end: int, known: NDArray[np.uint64] | None = None) -> Pins:
    """Pins from rows of (cycle, anything, value) as uint64; ``known``: the bits that are 0 or 1, by default all."""
    every = np.uint64((1 << sum(circuit.pins.values())) - 1)
    known = np.full(len(changes), every) if known is None else known
    return Pins(changes[:, 0].astype(np.int64), changes[:, 2].copy(), known, end)


# The test bench of a design point: Verilog-2005 that feeds the stream, and compares every event with the model.

BENCH = "hwsw_bench"
"""The module of the bench."""

_CYCLE_DIGITS = 12


@cache
def template(name: str) -> Any:
    """A template of this package."""
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined, keep_trailing_newline=True, autoescape=False)
    folder = files("codesign.hardware.rtl") / "templates"
    return environment.from_string((folder / f"{name}.jinja").read_text(encoding="utf-8"))


def bench_files(circuit: Circuit, expected: Expected) -> dict[str, str]:
    """The bench, and the files that it reads from the current folder."""
    return {
        f"{BENCH}.v": _bench_text(circuit, expected),
        "stream.hex": circuit.stream.hex_text() or "0\n",
        "expected.hex": _expected_text(circuit, expected),
        **({"pins.hex": _pins_text(circuit, expected.pins)} if circuit.pins and expected.pins else {}),
    }


def _expected_text(circuit: Circuit, expected: Expected) -> str:
    """The expected events for ``$readmemh``: cycle, kind and value in hexadecimal, joined by ``_``."""
    digits = _digits(circuit)
    events = expected.events
    rows = zip(events.cycle.tolist(), events.kind.tolist(), events.value.tolist(), strict=True)
    lines = [f"{cycle:0{_CYCLE_DIGITS}x}_{kind:x}_{value:0{digits}x}\n" for cycle, kind, value in rows]
    return "".join(lines) or "0\n"


def _pins_text(circuit: Circuit, pins: Pins) -> str:
    """The changes of the further outputs for ``$readmemh``: cycle, value and the bits that count, joined by ``_``."""
    digits = _pin_digits(circuit)
    rows = zip(pins.cycle.tolist(), pins.value.tolist(), pins.known.tolist(), strict=True)
    lines = (f"{cycle:0{_CYCLE_DIGITS}x}_{value:0{digits}x}_{known:0{digits}x}\n" for cycle, value, known in rows)
    return "".join(lines)


def _pin_digits(circuit: Circuit) -> int:
    return -(-sum(circuit.pins.values()) // 4)


def _digits(circuit: Circuit) -> int:
    return -(-circuit.event_bits // 4)


def _bench_text(circuit: Circuit, expected: Expected) -> str:
    text: str = template("hwsw_bench.v").render(
        top=top_name(circuit),
        words=len(circuit.stream.words),
        events=len(expected.events.cycle),
        event_bits=circuit.event_bits,
        value_bits=4 * _digits(circuit),
        bound=bound_of(expected),
        contention=expected.contention,
        in_range=range_of(circuit.stream.width),
        event_range=range_of(circuit.event_bits),
        pins={name: range_of(width) for name, width in circuit.pins.items()},
        pin_bits=sum(circuit.pins.values()),
        pin_width=4 * _pin_digits(circuit),
        changes=len(expected.pins.cycle) if expected.pins else 0,
        watched=expected.pins.end if expected.pins else 0,
        kinds=circuit.kinds,
        phases=circuit.phases,
        cycles_by_phase=[expected.cycles.get(phase, 0) for phase in circuit.phases],
    )
    return text


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
    netlist: Callable[[Circuit, Path], str] | None = None,
) -> Run:
    """Run a circuit in Icarus. ``netlist``: writes a file into the folder, returns its name; it stands for the Verilog.

    Raises:
        MissingToolError: it is not installed.
        RunError: it refuses the Verilog.
    """
    compile_, vvp = tools.require("iverilog"), tools.require("vvp")
    with scratch() as folder:
        files = _write(circuit, expected, folder)
        if netlist is not None:
            files = [netlist(circuit, folder), f"{BENCH}.v"]
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
    cycle, kind, value = words
    try:
        return int(cycle), int(kind), int(value, 16)
    except ValueError:
        return int(cycle), _UNKNOWN, 0
