"""A circuit is simulated on its stream: what it reports, and the cycles of each phase.

All simulators follow the contract of ``planners.circuits``: outputs are sampled just before a rising edge, inputs
change after it, and the edge after the one that takes ``start`` is cycle 0.
"""

from __future__ import annotations

import platform
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from codesign.ground.errors import InputError, RunError, choose_hint
from codesign.ground.files import scratch
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.bench_runs import icarus, verilator
from codesign.hardware.rtl.cache import digest_of, kept
from codesign.hardware.rtl.design import bound_of, digest_of_circuit, sources_of, top_name, work_of, write_design
from codesign.hardware.rtl.runs import HINT, Progress, Run, Waves, events_of, phases_of, pins_of, silent, stream_chunks
from codesign.planners.circuits import Circuit, Expected

# The native simulator: Yosys writes C++ (CXXRTL), a compiler of C++ makes a program of it, and the program is kept.

_PINS_KIND = 16
"""The kind under which the driver writes a change of the further outputs: four bits have none of it."""

_COMPILE_S = 900.0
_RUN_S = 3600.0
_OPTIONS = ("-std=c++14", "-O1", "-w", "-DCXXRTL_NDEBUG")
"""-O1 compiles twice as fast as -O2, and runs nearly as fast. An index that is too large reads zero: no abort."""


def cxxrtl(circuit: Circuit, expected: Expected, waves: Waves | None = None, progress: Progress = silent) -> Run:
    """Run a circuit in the program that CXXRTL makes of it.

    Raises:
        MissingToolError: pyosys, or a compiler of C++, is not installed.
        RunError: Yosys or the compiler refuses the Verilog.
    """
    tools.require("pyosys")
    driver = files("codesign.hardware.rtl").joinpath("templates", "driver.cc").read_text(encoding="utf-8")
    images = [text for name in sorted(circuit.images) for text in (name, circuit.images[name].hex_text())]
    what = "waves" if waves else "no waves"
    toolchain = (tools.version_of("pyosys"), *_compiler(), _compiler_version(), *_OPTIONS)
    digest = digest_of(digest_of_circuit(circuit), *images, what, driver, *toolchain, platform.machine())

    def build(folder: Path) -> None:
        progress("CXXRTL compiles the circuit", 0, 0)
        _build(circuit, folder, driver, waves is not None)

    with kept("cxxrtl", digest, build) as folder, scratch() as place:
        progress("CXXRTL simulates the circuit", 0, 0)
        return _run(circuit, folder / "run.exe", place, expected, waves, progress)


@cache
def _compiler() -> tuple[str, ...]:
    """The words that start a compiler of C++: the system's, or the one of ziglang."""
    return tools.command_of("c++") or (*tools.require("ziglang"), "c++")


@cache
def _compiler_version() -> str:
    return tools.version_of("c++" if tools.command_of("c++") else "ziglang")


def _build(circuit: Circuit, folder: Path, driver: str, waves: bool) -> None:
    write_design(circuit, folder)
    sources, top = list(sources_of(circuit)), top_name(circuit)
    script = [
        *(f"read_verilog {name}" for name in sources),
        f"hierarchy -check -top {top}",
        "proc",
        # Modules stay apart, so a module that is used a hundred times is compiled once. Nets as wide as an array are
        # split: each slice of one would be a type of its own in C++.
        "opt_clean",
        "splitnets -driver",
        "opt_clean -purge",
        f"write_cxxrtl -noflatten {'-g4' if waves else '-g0'} design.cc",
    ]
    tools.yosys("\n".join(script) + "\n", folder, f"Yosys, of {circuit.top},", seconds=_COMPILE_S, hint=HINT)
    name = "p_" + top.replace("_", "__")
    defines = (f"-DTOP={name}", *(("-DWAVES",) if waves else ()), *_pins_define(circuit))
    (folder / "driver.cc").write_text(driver, encoding="utf-8")
    command = (*_compiler(), *_OPTIONS, *defines, f"-I{_headers()}", "driver.cc", "-o", "run.exe")
    tools.checked(command, folder, f"the compiler of C++, of {circuit.top},", seconds=_COMPILE_S, hint=HINT)
    for file in folder.iterdir():
        if file.name != "run.exe":
            file.unlink()


def _pins_define(circuit: Circuit) -> tuple[str, ...]:
    """The further outputs as one number in C++, the first one lowest."""
    if not circuit.pins:
        return ()
    shift, terms = 0, []
    for name, width in circuit.pins.items():
        terms.append(f"top.p_{name.replace('_', '__')}.get<uint64_t>() << {shift}")
        shift += width
    return (f"-DPINS=({' | '.join(terms)})",)


def _headers() -> str:
    """The folder of CXXRTL's headers, which pyosys brings."""
    return str(files("pyosys").joinpath("share/include/backends/cxxrtl/runtime"))


def _run(
    circuit: Circuit, program: Path, place: Path, expected: Expected, waves: Waves | None, progress: Progress
) -> Run:
    window: tuple[str, ...] = ()
    if waves:
        events = expected.events
        columns = (events.cycle, events.kind, events.value)
        np.column_stack([column.astype(np.uint64) for column in columns]).tofile(place / "model")
        window = (str(waves.file.absolute()), str(waves.first), str(waves.last), "model")
    cycles = sum(expected.cycles.values())

    def watch() -> None:
        """The program writes the number of its cycle into a file."""
        with suppress(OSError, ValueError):
            done = int((place / "cycle").read_text(encoding="utf-8"))
            progress("cycles simulated in CXXRTL", min(done, cycles), cycles)

    watched = expected.pins.end if expected.pins else 0
    bounds = (len(circuit.stream.words), bound_of(expected), watched)
    command = (str(program.absolute()), *map(str, bounds), *window)
    chunks = stream_chunks(circuit)
    finished = tools.run(command, place, seconds=_RUN_S, stdin=chunks, hint=HINT, watch=watch)
    numbers = np.frombuffer(finished.stdout, np.uint64) if len(finished.stdout) % 8 == 0 else np.empty(0, np.uint64)
    if finished.code or len(numbers) < 18 or len(numbers) % 3:
        raise RunError(f"the simulation of {circuit.top} failed (exit code {finished.code}): {finished.complaints}")
    counts = {phase: int(count) for phase, count in enumerate(numbers[-18:-2])}
    taken, ended = int(numbers[-2]), bool(numbers[-1])
    records = numbers[:-18].reshape(-1, 3)
    of_pins = records[:, 1] == _PINS_KIND
    pins = pins_of(circuit, records[of_pins], watched) if circuit.pins else None
    return Run(events_of(records[~of_pins]), phases_of(circuit, counts), taken, ended, pins)


Backend = Callable[[Circuit, Expected, Waves | None, Progress], Run]

BACKENDS: Mapping[str, Backend] = {"cxxrtl": cxxrtl, "icarus": icarus, "verilator": verilator}
"""Every simulator by its name, the default first."""

AUTO = "auto"
"""The simulator that is the fastest for the size of the design, of those that are installed."""

_LARGE = 10**8
"""Above this number of elements times cycles Verilator is the faster one: measured, see docs/rtl.md."""

MOST_ELEMENTS = 10_000
"""A larger array would take hours to compile: the time grows faster than the number of its elements."""


def simulate(
    circuit: Circuit,
    expected: Expected,
    backend: str = "cxxrtl",
    waves: Waves | None = None,
    progress: Progress = silent,
) -> Run:
    """Run a circuit until it is done, or until it has run for much longer than expected.

    Raises:
        MissingToolError: the simulator or a compiler is not installed; the hint has the command that installs it.
        RunError: the array is too large, the Verilog cannot be compiled, or a tool does not end in time.
        InputError: there is no such backend.
    """
    if backend == AUTO:
        large = work_of(circuit, expected) > _LARGE
        backend = "verilator" if large and tools.command_of("verilator") else "cxxrtl"
        if large and backend == "cxxrtl":
            install = tools.TOOLS["verilator"].install
            progress(f"a large array: Verilator simulates it several times as fast ({install})", 0, 0)
    if circuit.elements > MOST_ELEMENTS:
        raise RunError(
            f"{circuit.top} has {circuit.elements:,} elements: simulators compile arrays of up to {MOST_ELEMENTS:,}",
            None,
            "verify a smaller design, such as one with a smaller map or smaller blocks",
        )
    if backend not in BACKENDS:
        raise InputError(f"there is no simulator {backend!r}", "backend", choose_hint(backend, BACKENDS))
    return BACKENDS[backend](circuit, expected, waves, progress)
