"""The reports of circuits, one or many design points, are compared with what the model expects, edge by edge."""

from __future__ import annotations

import platform
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from more_itertools import map_reduce
from numpy.typing import NDArray

from codesign.ground.errors import CodesignError, InputError, RunError, choose_hint
from codesign.ground.files import scratch, write_atomically
from codesign.ground.gtkwave import NOTHING, Shown, save_file, translation
from codesign.ground.interrupts import end_children
from codesign.ground.units import counted
from codesign.hardware.rtl import tools
from codesign.hardware.rtl.bench_runs import (
    HINT,
    Progress,
    Run,
    Waves,
    events_of,
    icarus,
    phases_of,
    pins_of,
    silent,
    stream_chunks,
    verilator,
)
from codesign.hardware.rtl.design import (
    bound_of,
    digest_of,
    digest_of_circuit,
    kept,
    sources_of,
    top_name,
    work_of,
    write_design,
)
from codesign.hardware.rtl.tools import MissingToolError
from codesign.planners.circuits import Circuit, CircuitStyle, Events, Expected, Pins
from codesign.planners.job import Job

# A circuit is simulated on its stream: what it reports, and the cycles of each phase.

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
    headers = files("pyosys").joinpath("share/include/backends/cxxrtl/runtime")
    command = (*_compiler(), *_OPTIONS, *defines, f"-I{headers}", "driver.cc", "-o", "run.exe")
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
        what = f"{circuit.top} has {circuit.elements:,} elements: simulators compile arrays of up to {MOST_ELEMENTS:,}"
        raise RunError(what, None, "verify a smaller design, such as one with a smaller map or smaller blocks")
    if backend not in BACKENDS:
        raise InputError(f"there is no simulator {backend!r}", "backend", choose_hint(backend, BACKENDS))
    return BACKENDS[backend](circuit, expected, waves, progress)


# How GTKWave shows the waveform of a circuit: its outputs, and below them what the model reports, with names.

_SCOPE = re.compile(r"\$scope\s+\w+\s+(\S+)\s+\$end")
_VARIABLE = re.compile(r"\$var\s+\w+\s+(\d+)\s+\S+\s+(\S+)(?:\s+\[\S+\])?\s+\$end")

_OUTPUTS = ("clk", "phase", "event_valid", "event_kind", "event_data")
_MODEL = ("event_valid", "event_kind", "event_data")
_FOUR_BITS = 4


def write_view(vcd: Path, circuit: Circuit) -> list[Path]:
    """Write a save file of GTKWave beside a waveform, and translate files for phases and kinds of events.

    Raises:
        RunError: a file cannot be written.
    """
    names = {"phase": dict(enumerate((NOTHING, *circuit.phases))), "event_kind": dict(enumerate(circuit.kinds))}
    files = {name: vcd.with_suffix(f".{name}.txt") for name in names}
    for name, path in files.items():
        write_atomically(path, translation(names[name].items(), _FOUR_BITS).encode())
    found = dict(_variables(vcd))
    groups = {
        "circuit": [_shown(found, "circuit", name, files) for name in _OUTPUTS],
        "model": [_shown(found, "model", name, files) for name in _MODEL],
    }
    kept = {group: [each for each in shown if each is not None] for group, shown in groups.items()}
    save = vcd.with_suffix(".gtkw")
    write_atomically(save, save_file(vcd, kept).encode())
    return [save, *files.values()]


def _shown(found: dict[tuple[str, ...], int], scope: str, name: str, files: dict[str, Path]) -> Shown | None:
    """The variable of the uppermost scope of this name."""
    places = [place for place in found if place[-2:] == (scope, name)]
    if not places:
        return None
    place = min(places, key=len)
    file = files[name].name if name in files else ""
    form = "hex" if name == "event_data" else "dec"
    return Shown(".".join(place), found[place], form, file)  # type: ignore[arg-type]


def _variables(vcd: Path) -> Iterator[tuple[tuple[str, ...], int]]:
    """The scopes and the name of each variable, and its width, from the head of a VCD."""
    scopes: list[str] = []
    with vcd.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            if "$enddefinitions" in line:
                return
            if scope := _SCOPE.search(line):
                scopes.append(scope[1])
            elif "$upscope" in line:
                scopes.pop()
            elif variable := _VARIABLE.search(line):
                yield (*scopes, variable[2]), int(variable[1])


MOST_DEVIATION = 0.01
"""The mean deviation of the cycles, as a share, that contention for a memory excuses."""

BEFORE, AFTER = 64, 16
"""Cycles of the waveform before and after the first difference."""


@dataclass(frozen=True)
class Difference:
    """One difference between the model and the circuit: its ``cycle``, or -1 for the run as a whole; and in words."""

    cycle: int
    words: str

    def __str__(self) -> str:
        return f"cycle {self.cycle:,}: {self.words}" if self.cycle >= 0 else self.words


@dataclass(frozen=True)
class Verified:
    """A run of a circuit that was compared with the model.

    - ``events``, ``cycles``: how many the model expects; all of them are compared.
    - ``differences``: events, phases and counts that differ. ``first``: the first one, by its cycle.
    - ``shown``: cycles in which the further outputs, such as a display's, were compared.
    - ``deviation``: by what share the cycles of all phases differ, if contention excuses it; otherwise 0.
    """

    events: int
    cycles: int
    differences: int
    first: Difference | None
    deviation: float = 0.0
    shown: int = 0


def verify(
    style: CircuitStyle,
    job: Job[Any, Any],
    backend: str = "cxxrtl",
    waves: Path | None = None,
    progress: Progress = silent,
    cycles: tuple[int, int] | None = None,
) -> Verified:
    """Run the circuit of a design point, and compare it with the model.

    ``waves``: the file of a waveform (VCD) of ``cycles``, the first and the last one; by default those around the first
    difference, where there is one. Circuit and model lie above each other in it, and files for GTKWave beside it.
    ``progress`` is called with what the simulator does.

    Raises:
        UnsuitedError: the style has no circuit for the parameters.
        MissingToolError, RunError: as ``simulate``.
    """
    circuit, expected = style.circuit(job), style.expected(job)
    verified = compared(circuit, expected, simulate(circuit, expected, backend, None, progress))
    if cycles is None and verified.first is not None:
        middle = max(0, verified.first.cycle)
        cycles = max(0, middle - BEFORE), middle + AFTER
    if waves is not None and cycles is not None:
        simulate(circuit, expected, backend, Waves(waves, *cycles), progress)
        write_view(waves, circuit)
    return verified


def compared(circuit: Circuit, expected: Expected, run: Run) -> Verified:
    """Compare a run with the model."""
    model = expected.events
    unequal = _unequal(model, run.events, cycles=not expected.contention)
    whole = list(_of_run(circuit, expected, run))
    shown, of_pins = _of_pins(circuit, expected.pins, run)
    first = next(iter((*whole, *of_pins)), None)
    if len(unequal):
        first = _of_event(circuit, model, run.events, int(unequal[0]))
    total = sum(expected.cycles.values())
    taken = sum(run.cycles.get(phase, 0) for phase in circuit.phases)
    deviation = abs(taken - total) / total if expected.contention and total else 0.0
    differences = len(unequal) + len(whole) + len(of_pins)
    return Verified(len(model.cycle), total, differences, first, deviation, shown)


def _unequal(model: Events, seen: Events, *, cycles: bool) -> NDArray[np.int64]:
    """The indexes of the events that differ, in order; an event that one side alone has differs."""
    both = min(len(model.cycle), len(seen.cycle))
    differ = (model.kind[:both] != seen.kind[:both]) | (model.value[:both] != seen.value[:both])
    if cycles:
        differ |= model.cycle[:both] != seen.cycle[:both]
    lone = np.arange(both, max(len(model.cycle), len(seen.cycle)))
    return np.append(np.flatnonzero(differ), lone)


def _of_event(circuit: Circuit, model: Events, seen: Events, index: int) -> Difference:
    expects, reports = _event(circuit, model, index), _event(circuit, seen, index)
    if expects is None or reports is None:
        cycle, words = expects or reports or (0, "")
        side, other = ("model", "circuit") if expects else ("circuit", "model")
        return Difference(cycle, f"the {side} reports {words}, the {other} nothing more")
    if expects[1] == reports[1]:
        text = f"the model reports {expects[1]} at cycle {expects[0]:,}, the circuit at cycle {reports[0]:,}"
    else:
        text = f"the model reports {expects[1]}, the circuit {reports[1]}"
        text += f" at cycle {reports[0]:,}" if reports[0] != expects[0] else ""
    return Difference(min(expects[0], reports[0]), f"{text} (event {index:,})")


def _event(circuit: Circuit, events: Events, index: int) -> tuple[int, str] | None:
    """The cycle of an event, and its kind and value in words; None where there is none."""
    if index >= len(events.cycle):
        return None
    kind, value = int(events.kind[index]), int(events.value[index])
    name = circuit.kinds[kind] if kind < len(circuit.kinds) else f"kind {kind}"
    return int(events.cycle[index]), f"{name} {value}"


def _of_run(circuit: Circuit, expected: Expected, run: Run) -> Iterator[Difference]:
    """The differences of whole runs: phases, words taken, and the end."""
    if not run.ended:
        yield Difference(-1, f"the circuit does not end within {counted(bound_of(expected), 'cycle')}")
    if not expected.contention:
        for phase in dict.fromkeys((*circuit.phases, *expected.cycles, *(each for each in run.cycles if each))):
            model, seen = expected.cycles.get(phase, 0), run.cycles.get(phase, 0)
            if model != seen:
                yield Difference(
                    -1, f"phase {phase} takes {counted(model, 'cycle')} in the model, {seen:,} in the circuit"
                )
    words = len(circuit.stream.words)
    if run.taken != words:
        yield Difference(-1, f"the circuit takes {run.taken:,} of the {counted(words, 'word')} of its stream")


def _of_pins(circuit: Circuit, model: Pins | None, run: Run) -> tuple[int, list[Difference]]:
    """The cycles in which the further outputs were compared, and each change after which they differ."""
    if not circuit.pins:
        return 0, []
    names = ", ".join(circuit.pins)
    if model is None or run.pins is None:
        return 0, [Difference(-1, f"the model says nothing of {names}, so nothing compares them")]
    seen, end = run.pins, min(model.end, run.pins.end)
    times = np.union1d(model.cycle, seen.cycle)
    times = times[(times >= max(model.cycle[0], seen.cycle[0])) & (times < end)]
    of_model, of_seen = (np.searchsorted(each.cycle, times, side="right") - 1 for each in (model, seen))
    differ = (model.value[of_model] ^ seen.value[of_seen]) | ~seen.known[of_seen]
    wrong = np.flatnonzero(differ & model.known[of_model])
    found = [
        Difference(
            int(times[i]),
            f"the model shows {_pins_words(circuit, model.value[of_model[i]], model.known[of_model[i]])},"
            f" the circuit {_pins_words(circuit, seen.value[of_seen[i]], seen.known[of_seen[i]])}",
        )
        for i in wrong.tolist()
    ]
    return max(0, end - int(model.cycle[0])), found


def _pins_words(circuit: Circuit, value: np.uint64, known: np.uint64) -> str:
    """The outputs in bits, ``x`` for one that is not known."""
    texts, shift = [], 0
    for name, width in circuit.pins.items():
        bits = (
            "x" if not int(known) >> i & 1 else str(int(value) >> i & 1)
            for i in range(shift + width - 1, shift - 1, -1)
        )
        texts.append(f"{name} {''.join(bits)}")
        shift += width
    return ", ".join(texts)


@dataclass(frozen=True, eq=False)
class Asked:
    """A point that is to be verified. ``name``: the point in words, such as ``sample 7``; ``job`` makes it."""

    style: CircuitStyle
    name: str
    job: Callable[[], Job[Any, Any]]


@dataclass(frozen=True)
class Checked:
    """A point that was verified: ``verified``, or the ``failure`` that ended it before it could be compared."""

    planner: str
    style: str
    task: str
    point: str
    verified: Verified | None
    failure: str = ""

    @property
    def equal(self) -> bool:
        """True if the circuit reports what the model expects."""
        return self.verified is not None and self.verified.first is None


@dataclass(frozen=True)
class StyleChecked:
    """All points of one circuit, added up. ``deviation``: the mean, where contention excuses cycles."""

    planner: str
    style: str
    task: str
    points: tuple[Checked, ...]

    @property
    def verified(self) -> list[Verified]:
        """The points that could be compared."""
        return [point.verified for point in self.points if point.verified is not None]

    @property
    def deviation(self) -> float:
        """The mean deviation of the cycles that contention excuses."""
        return sum(each.deviation for each in self.verified) / max(1, len(self.verified))

    @property
    def equal(self) -> bool:
        """True if every point is equal, and the cycles deviate by no more than is excused."""
        return all(point.equal for point in self.points) and self.deviation <= MOST_DEVIATION


def samples(styles: Iterable[CircuitStyle], seeds: Sequence[int]) -> list[Asked]:
    """Random design points of each style, one for each seed."""
    return [Asked(style, f"sample {seed}", _sample(style, seed)) for seed in seeds for style in styles]


def _sample(style: CircuitStyle, seed: int) -> Callable[[], Job[Any, Any]]:
    return lambda: style.sample(seed)


def verify_all(
    asked: Sequence[Asked],
    backend: str = "cxxrtl",
    jobs: int = 1,
    progress: Callable[[Checked], None] | None = None,
    waves: Path | None = None,
    within: Progress = silent,
    cycles: tuple[int, int] | None = None,
) -> tuple[StyleChecked, ...]:
    """Verify points, ``jobs`` at a time, and add them up by style.

    ``progress`` is called after each point, ``within`` with what the simulator of a single point does. ``waves``: the
    file of a waveform around the first difference of the first point that has one, or of ``cycles`` (the first and the
    last one) of that point, or else of the first point.

    Raises:
        MissingToolError: a tool is not installed.
    """
    results: dict[int, Checked] = {}
    for index, checked in _checked(asked, backend, jobs, within if len(asked) == 1 else silent):
        results[index] = checked
        if progress is not None:
            progress(checked)
    in_order = [results[index] for index in range(len(asked))]
    differing = next((i for i, checked in enumerate(in_order) if checked.verified and not checked.equal), None)
    drawn = 0 if differing is None and cycles is not None else differing
    if waves is not None and drawn is not None:
        verify(asked[drawn].style, asked[drawn].job(), backend, waves, cycles=cycles)
    groups = map_reduce(in_order, lambda checked: (checked.planner, checked.style, checked.task))
    return tuple(StyleChecked(planner, style, task, tuple(points)) for (planner, style, task), points in groups.items())


def _checked(asked: Sequence[Asked], backend: str, jobs: int, within: Progress) -> Iterator[tuple[int, Checked]]:
    """Each point by its index, as it is done. The work is done by tools, so threads suffice."""
    if jobs == 1:
        for index, each in enumerate(asked):
            yield index, _check(each, backend, within)
        return
    pool = ThreadPoolExecutor(jobs)
    try:
        futures: dict[Future[Checked], int] = {
            pool.submit(_check, each, backend, within): index for index, each in enumerate(asked)
        }
        for future in as_completed(futures):
            yield futures[future], future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        end_children()


def _check(asked: Asked, backend: str, within: Progress) -> Checked:
    style = asked.style
    names = (style.planner, style.style, style.task, asked.name)
    try:
        return Checked(*names, verify(style, asked.job(), backend, None, within))
    except MissingToolError:
        raise
    except CodesignError as fault:
        return Checked(*names, None, str(fault))
    # The code of a plug-in: it may raise anything, and the other points are still verified.
    except Exception as fault:
        return Checked(*names, None, f"{type(fault).__name__}: {fault}")
