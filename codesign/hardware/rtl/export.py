"""The folder of a design point: Verilog, bench, images, constraints, golden vectors, a core file and a README.

The same design point gives the same bytes: nothing depends on the date or on the tools of this machine.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

from codesign.ground.errors import printable
from codesign.ground.models import Part
from codesign.ground.units import PICOSECONDS_PER_SECOND, format_frequency
from codesign.hardware.rtl.bench_runs import BENCH, bench_files, template
from codesign.hardware.rtl.cells import FAMILIES
from codesign.hardware.rtl.design import bound_of, digest_of_circuit, ports_of, sources_of, top_name
from codesign.hardware.rtl.place import placing_files
from codesign.hardware.rtl.placed import Placed
from codesign.hardware.rtl.synthesis import flow_files, holds_memories
from codesign.planners import measured
from codesign.planners.circuits import Circuit, Expected
from codesign.version import __version__

MANIFEST = "manifest.json"


@dataclass(frozen=True)
class Origin:
    """The origin of a design point, as the user named it: specs, and the raw value of each axis that was set."""

    platform: str
    workload: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    study: str | None = None
    point: int | None = None


def export_files(design: Placed, origin: Origin) -> dict[str, str]:
    """Every file of the folder by its name.

    Raises:
        UnsuitedError: the style has no circuit for the parameters.
    """
    circuit, expected = design.style.circuit(design.job), design.style.expected(design.job)
    top = top_name(circuit)
    built = building(design.part, design.clock, top)
    steps, placing = _open_flow(design, circuit)
    files = {
        **sources_of(circuit),
        **{name: image.hex_text() for name, image in circuit.images.items()},
        **bench_files(circuit, expected),
        **built.files,
        **steps,
        "golden.csv": _golden_text(circuit, expected),
    }
    words = _words(design, origin, circuit, expected, built) | {"steps": list(steps), "placing": placing}
    for name, target in (("test_hwsw.py", "test_hwsw.py"), ("hwsw.core", f"{top}.core")):
        files[target] = template(name).render(words)
    files["README.md"] = template("README.md").render(words, contents=_contents(circuit, built, top, steps))
    files[MANIFEST] = _manifest(design, origin, circuit, files)
    return files


def _open_flow(design: Placed, circuit: Circuit) -> tuple[dict[str, str], str]:
    """The files of the steps that ``hwsw synth`` runs for the part, and the command that places; "" where none is."""
    name, exact = measured.family_of(design.part.family)
    if not exact or not holds_memories(circuit, FAMILIES[name]):
        return {}, ""
    placing, files = placing_files(design.part.full_name)
    return flow_files(circuit, FAMILIES[name]) | files, " ".join(placing)


def _words(design: Placed, origin: Origin, circuit: Circuit, expected: Expected, built: Building) -> dict[str, Any]:
    top, part = top_name(circuit), design.part
    phases = circuit.phases
    return {
        "top": top,
        "circuit": circuit,
        "planner": design.style.planner,
        "style": design.style.style,
        "task": design.style.task,
        "platform": _cell(origin.platform),
        "workload": _cell(origin.workload),
        "settings": {_cell(axis): _cell(json.dumps(value)) for axis, value in _settings(origin).items()},
        "part": part.full_name,
        "clock": format_frequency(design.clock),
        "digest": digest_of_circuit(circuit),
        "ports": ports_of(circuit),
        "meanings": _MEANINGS,
        "phases": [(i + 1, name, f"{expected.cycles.get(name, 0):,}") for i, name in enumerate(phases)],
        "events": len(expected.events.cycle),
        "words": len(circuit.stream.words),
        "bound": bound_of(expected),
        "contention": expected.contention,
        "sources": list(sources_of(circuit)),
        "images": list(circuit.images),
        "constraints": list(built.files),
        "vivado": part.full_name.lower() if built.tools == "vivado" else "",
        "core": f"hwsw:{design.style.planner}:{top}:{__version__}",
        "build": built,
        "version": __version__,
    }


def _cell(text: str) -> str:
    """A text of the user as a cell of a Markdown table."""
    return printable(text).replace("|", "\\|").replace("`", "'")


_MEANINGS = {
    "clk": "the clock; rising edges count",
    "reset": "synchronous, high for one edge or more",
    "start": "high for one edge: the run begins",
    "in_data": "a word of the load stream",
    "in_valid": "`in_data` has a word",
    "in_ready": "the word is taken at this edge",
    "phase": "what the circuit does; see Phases",
    "event_valid": "the circuit reports an event at this edge",
    "event_kind": "the kind of the event; see Events",
    "event_data": "the value of the event",
    "done": "high for at least one edge: the run has ended",
}


_STEPS = {
    "map.ys": "Yosys maps every module by itself, as `hwsw synth` does",
    "output_registers.py": "block RAMs take over the flip-flops behind their outputs",
    "flatten.ys": "Yosys makes one module of it, and counts its cells",
    "few_pins.py": "three pins in place of all ports, so that a placer without pins takes the circuit",
    "pins.cst": "the three pins",
}


def _contents(circuit: Circuit, built: Building, top: str, steps: Iterable[str]) -> list[tuple[str, str]]:
    return [
        (f"{top}.v", "the top module"),
        *((source.name, "Verilog of the circuit") for source in circuit.sources),
        *((name, "contents of a memory at power-up") for name in circuit.images),
        (f"{BENCH}.v", "the self-checking test bench"),
        ("stream.hex", "the load stream, with the map"),
        ("expected.hex", "the expected events: cycle, kind and value in hexadecimal"),
        *([("pins.hex", "what the further outputs show: each change")] if circuit.pins else []),
        ("golden.csv", "the expected events for cocotb and for programs"),
        ("test_hwsw.py", "the design in cocotb, against golden.csv"),
        *((name, "constraints: the clock") for name in built.files),
        *((name, _STEPS[name]) for name in steps),
        (f"{top}.core", "the core file of FuseSoC (CAPI 2)"),
        (MANIFEST, "the design point, and the digest of each file"),
    ]


def _golden_text(circuit: Circuit, expected: Expected) -> str:
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(("cycle", "kind", "event", "value"))
    events = expected.events
    for cycle, kind, value in zip(events.cycle.tolist(), events.kind.tolist(), events.value.tolist(), strict=True):
        rows.writerow((cycle, kind, circuit.kinds[kind], value))
    return text.getvalue()


def _settings(origin: Origin) -> dict[str, Any]:
    study = {} if origin.study is None else {"study": origin.study, "point": origin.point}
    return {**study, **origin.settings}


def _manifest(design: Placed, origin: Origin, circuit: Circuit, files: Mapping[str, str]) -> str:
    style = design.style
    manifest = {
        "top": top_name(circuit),
        "digest": digest_of_circuit(circuit),
        "planner": style.planner,
        "style": style.style,
        "task": style.task,
        "platform": origin.platform,
        "workload": origin.workload,
        "settings": dict(origin.settings),
        "study": origin.study,
        "point": origin.point,
        "component": design.component,
        "part": design.part.full_name,
        "clock_hz": design.clock,
        "circuit": circuit.top,
        "parameters": dict(circuit.parameters),
        "version": __version__,
        "files": {name: sha256(text.encode()).hexdigest() for name, text in sorted(files.items())},
    }
    return json.dumps(manifest, indent=2, ensure_ascii=False, default=str) + "\n"


VIVADO = frozenset({"Artix-7", "Zynq-7000", "Zynq UltraScale+"})
ISE = frozenset({"Virtex-II", "Virtex-II Pro", "Virtex-4", "Spartan-3E"})
GOWIN = frozenset({"GW1N", "GW2A"})


@dataclass(frozen=True)
class Building:
    """The build of a design: ``tools`` of its family, constraints by file name, and what nextpnr calls the part."""

    tools: str
    files: Mapping[str, str]
    size: str = ""
    grade: str = ""


def building(part: Part, hertz: int, top: str) -> Building:
    """The build with the tools of the part's family, for a clock in Hz."""
    # Rounded down to whole picoseconds: a tool that meets the constraint meets the clock.
    period = f"{PICOSECONDS_PER_SECOND // hertz / 1000:.3f}"
    sdc = f"create_clock -name clk -period {period} [get_ports {{clk}}]\n"
    if part.family in VIVADO:
        return Building("vivado", {f"{top}.xdc": sdc})
    if part.family in ISE:
        text = f'NET "clk" TNM_NET = "clk";\nTIMESPEC "TS_clk" = PERIOD "clk" {period} ns HIGH 50 %;\n'
        return Building("ise", {f"{top}.ucf": text})
    if part.family == "ECP5":
        text = f'FREQUENCY PORT "clk" {hertz / 1e6:.6f} MHZ;\n'
        size = part.name.partition("-")[2].rstrip("F") + "k"
        return Building("ecp5", {f"{top}.lpf": text}, size, part.speed_grade.lstrip("-"))
    if part.family in GOWIN:
        pins = '// Pins are for the board, as in: IO_LOC "clk" NUMBER;\n'
        return Building("gowin", {f"{top}.sdc": sdc, f"{top}.cst": pins})
    return Building("other", {f"{top}.sdc": sdc})
