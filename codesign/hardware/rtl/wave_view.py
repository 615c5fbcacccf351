"""How GTKWave shows the waveform of a circuit: its outputs, and below them what the model reports, with names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from codesign.ground.files import write_atomically
from codesign.ground.gtkwave import NOTHING, Shown, save_file, translation
from codesign.planners.circuits import Circuit

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
