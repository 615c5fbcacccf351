"""Synthesise and place designs of this package, and record the rows that laws are fitted to.

python -m benchmarks.measure resources ROOM [FAMILY ...]
python -m benchmarks.measure clocks ROOM [PART ...]
python -m benchmarks.measure activity ROOM

A design with a row of the same Verilog by the same tools is neither synthesised nor placed again: ``again`` in the
place of ``resources`` does so, after a change of the families in ``codesign/hardware/rtl/cells.py`` or of the pieces of
a circuit.

Rows go to ``codesign/planners/ROOM/measured``; each is written as soon as it is there, and a later one of the same
design takes its place. In the end the rows of circuits that are no longer among the designs are removed, in the
families or parts that were measured. The designs stand in ``codesign/hardware/fidelity/designs.yaml``.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import codesign
from benchmarks.activity import activity
from codesign.ground.files import write_atomically
from codesign.hardware.fidelity.points import (
    Design,
    Placed,
    activities,
    circuit_of,
    clocks,
    job_of,
    resources,
    variables_of,
    words_of,
)
from codesign.hardware.rtl.cells import FAMILIES
from codesign.hardware.rtl.design import digest_of_circuit
from codesign.hardware.rtl.place import Device, Placement, device_of, place
from codesign.hardware.rtl.synthesis import Synthesis, synthesise
from codesign.hardware.rtl.tools import version_of
from codesign.planners.circuits import Circuit, CircuitStyle
from codesign.planners.measured import (
    ActivityRow,
    ClockRow,
    ResourceRow,
    Row,
    activity_rows,
    clock_rows,
    resource_rows,
    rows_text,
)

READERS = {"resources": resource_rows, "clocks": clock_rows, "activity": activity_rows}


def file_of(room: str, kind: str) -> Path:
    return Path(codesign.__file__).parent / "planners" / room / "measured" / f"{kind}.json"


def read(room: str, kind: str, styles: Sequence[CircuitStyle]) -> list[Row]:
    reader = READERS[kind]
    reader.cache_clear()
    return [row for each in styles for row in reader(room, each.style, each.task)]


def put(room: str, kind: str, styles: Sequence[CircuitStyle], row: Row) -> None:
    """Write a row into the file of its room, in the place of one of the same key."""
    write(room, kind, [*(other for other in read(room, kind, styles) if other.key != row.key), row])


def write(room: str, kind: str, rows: Sequence[Row]) -> None:
    path = file_of(room, kind)
    path.parent.mkdir(exist_ok=True)
    write_atomically(path, rows_text(sorted(rows, key=lambda each: each.key)).encode())


def drop(room: str, kind: str, styles: Sequence[CircuitStyle], stale: Callable[[Any], bool]) -> None:
    """Remove the rows of circuits that no design has."""
    rows = read(room, kind, styles)
    current = [row for row in rows if not stale(row)]
    if len(current) < len(rows):
        write(room, kind, current)
        print(f"{room}: {len(rows) - len(current)} stale rows removed", flush=True)


def circuits_of(room: str, designs: Sequence[Design]) -> Iterator[tuple[CircuitStyle, Circuit]]:
    """The circuit of each design, with its style."""
    for design in designs:
        style = circuit_of(room, design)
        yield style, style.circuit(job_of(room, design))


def resource_row(style: CircuitStyle, circuit: Circuit, synthesis: Synthesis) -> ResourceRow:
    return ResourceRow(
        style=style.style,
        task=style.task,
        family=synthesis.family,
        digest=digest_of_circuit(circuit),
        variables=variables_of(circuit),
        pieces={
            piece: {kind: amount for kind, amount in counts.by_resource().items() if amount}
            for piece, counts in synthesis.pieces.items()
        },
        tools=version_of("pyosys"),
    )


def measure_resources(room: str, families: Sequence[str], again: bool) -> None:
    styles = import_module(f"codesign.planners.{room}.plug_in").PLUG_IN.circuits
    digests = set()
    tools = version_of("pyosys")
    current = {(row.family, row.digest) for row in read(room, "resources", styles) if row.tools == tools and not again}
    for style, circuit in circuits_of(room, resources(room)):
        digests.add(digest_of_circuit(circuit))
        for family in families:
            if (family, digest_of_circuit(circuit)) in current:
                continue
            begun = time.monotonic()
            synthesis = synthesise(circuit, family)
            put(room, "resources", styles, resource_row(style, circuit, synthesis))
            took = time.monotonic() - begun
            print(f"{room} {style.style} {variables_of(circuit)} {family}: {synthesis.total}, {took:.1f} s", flush=True)
    drop(room, "resources", styles, lambda row: row.family in families and row.digest not in digests)


def tools_of(device: Device) -> str:
    """What places on a device, with versions."""
    return f"{version_of('pyosys')}, {version_of(device.tool)}"


def clock_row(style: CircuitStyle, circuit: Circuit, synthesis: Synthesis, placements: Sequence[Placement]) -> ClockRow:
    by_clock = sorted(placements, key=lambda each: each.clock)
    median = by_clock[(len(by_clock) - 1) // 2]
    path = median.path
    device, _ = device_of(median.part)
    return ClockRow(
        style=style.style,
        task=style.task,
        family=synthesis.family,
        part=median.part,
        digest=digest_of_circuit(circuit),
        variables=variables_of(circuit),
        totals=synthesis.total.by_resource(),
        clocks=[each.clock for each in placements],
        source=path.source,
        source_ns=path.source_ns,
        levels=path.levels,
        logic_ns=path.logic_ns,
        routing_ns=path.routing_ns,
        setup_ns=path.setup_ns,
        path=path.words,
        tools=tools_of(device),
    )


def measure_clocks(room: str, placements: Sequence[Placed], parts: Sequence[str]) -> None:
    styles = import_module(f"codesign.planners.{room}.plug_in").PLUG_IN.circuits
    designs = set()
    current = {(row.part, row.digest, row.tools) for row in read(room, "clocks", styles)}
    for placed in placements:
        if parts and placed.part not in parts:
            continue
        [(style, circuit)] = circuits_of(room, [placed.design])
        device, digest = device_of(placed.part)[0], digest_of_circuit(circuit)
        designs.add((placed.part, digest))
        if (placed.part, digest, tools_of(device)) in current:
            continue
        synthesis = synthesise(circuit, device.family)
        done: list[Placement] = []
        for seed in placed.seeds:
            done.append(place(circuit, placed.part, seed))
            put(room, "clocks", styles, clock_row(style, circuit, synthesis, done))
            clock, path, took = done[-1].clock / 1e6, done[-1].path.words, done[-1].seconds
            print(
                f"{room} {style.style} {placed.part} {variables_of(circuit)} "
                f"seed {seed}: {clock:.1f} MHz, {took:.0f} s, {path}",
                flush=True,
            )
    drop(room, "clocks", styles, lambda row: (not parts or row.part in parts) and (row.part, row.digest) not in designs)


def measure_activity(room: str) -> None:
    styles = import_module(f"codesign.planners.{room}.plug_in").PLUG_IN.circuits
    for design in activities(room):
        [(style, circuit)] = circuits_of(room, [design])
        job = job_of(room, design)
        begun = time.monotonic()
        counted = activity(circuit, style.expected(job))
        row = ActivityRow(
            style=style.style,
            task=style.task,
            digest=digest_of_circuit(circuit),
            variables=variables_of(circuit),
            design=words_of(job, design),
            seed=design.seed,
            toggles=counted.toggles,
            nets=counted.bits,
            cycles=counted.cycles,
            tools=f"{version_of('pyosys')}, {version_of('iverilog')}",
        )
        put(room, "activity", styles, row)
        took = time.monotonic() - begun
        print(f"{room} {row.style} {row.design} seed {row.seed}: {row.rate:.4f}, {took:.0f} s", flush=True)


def main(words: list[str]) -> None:
    match words:
        case [("resources" | "again") as word, room, *families]:
            # No block RAM of the iCE40 has two ports that write.
            families = families or [name for name in FAMILIES if FAMILIES[name].true_two_ports]
            measure_resources(room, families, word == "again")
        case ["clocks", room, *parts]:
            measure_clocks(room, clocks(room), parts)
        case ["activity", room]:
            measure_activity(room)
        case _:
            raise SystemExit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
