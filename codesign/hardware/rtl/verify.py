"""The reports of a circuit are compared with what the model expects, clock edge by clock edge."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.files import write_atomically
from codesign.ground.gtkwave import NOTHING, Shown, save_file, translation
from codesign.ground.units import counted
from codesign.hardware.rtl.design import bound_of
from codesign.hardware.rtl.runs import Progress, Run, Waves, silent
from codesign.hardware.rtl.simulate import simulate
from codesign.planners.circuits import Circuit, CircuitStyle, Events, Expected, Pins
from codesign.planners.job import Job

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
