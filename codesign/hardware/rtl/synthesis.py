"""Synthesis of a circuit by Yosys (pyosys) for a family: the resources of its modules and of the lines of its demand.

Modules are synthesised one by one, each once for all its instances: an array of hundreds of equal nodes takes as long
as one node. The boundaries of modules remain, so that a count belongs to a module and so to a line. Block RAMs then
take over the flip-flops behind their outputs (``output_registers``). For placement the result is flattened. The steps
are in ``flow``, which ``hwsw rtl`` puts into every folder.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from codesign.ground.errors import InputError, choose_hint
from codesign.hardware.rtl.cells import FAMILIES, Counts, Family
from codesign.hardware.rtl.design import digest_of, digest_of_circuit, kept, sources_of, top_name, write_design
from codesign.hardware.rtl.netlist import Netlist, verilog_name
from codesign.hardware.rtl.output_registers import finish
from codesign.hardware.rtl.tools import version_of, yosys
from codesign.planners.circuits import Circuit

# The steps from Verilog to a flat netlist, as files. hwsw synth runs them; hwsw rtl puts them into a folder.

MAPPED, HIERARCHY, FLAT = "mapped.json", "hierarchy.json", "flat.json"
"""The netlists that the steps write."""

TWO_PORTS = "ram_2rw.v"
"""The shared memory with two ports, each of which reads or writes."""


def holds_memories(circuit: Circuit, family: Family) -> bool:
    """True if block RAMs of the family hold the memories of a circuit."""
    return family.true_two_ports or all(source.name != TWO_PORTS for source in circuit.sources)


def map_script(sources: Iterable[str], top: str, family: Family) -> str:
    """The script of Yosys that maps every module of a design by itself."""
    return (
        f"read_verilog {' '.join(sorted(sources))}\nhierarchy -check -top {top}\n{family.command} -top {top}\n"
        f"write_json {MAPPED}\n"
    )


def flatten_script(top: str) -> str:
    """The script of Yosys that flattens the mapped modules."""
    return f"read_json {HIERARCHY}\nhierarchy -top {top}\nflatten\nopt_clean\nstat\nwrite_json {FLAT}\n"


def flow_files(circuit: Circuit, family: Family) -> dict[str, str]:
    """The files of the steps by name, beside the Verilog of the circuit."""
    top, step = top_name(circuit), "output_registers.py"
    return {
        "map.ys": map_script(sources_of(circuit), top, family),
        step: program(step),
        "flatten.ys": flatten_script(top),
    }


def program(name: str) -> str:
    """The text of a program of this package that needs nothing but Python."""
    return (Path(__file__).parent / name).read_text(encoding="utf-8")


MOST_SECONDS = 1800.0
"""A longer synthesis is given up."""

_LAYOUT = "1"
"""Moves when this module makes other netlists of the same design."""


@dataclass(frozen=True)
class ModuleCounts:
    """A module of the source: its instances, and what all of them take without the modules in them."""

    module: str
    instances: int
    counts: Counts


@dataclass(frozen=True, eq=False)
class Synthesis:
    """The resources of a circuit in a family.

    - ``modules``: by module of the source. ``pieces``: by line of the demand; "" for what no line counts.
    - ``total``: of the whole circuit. ``registers``: flip-flops that block RAMs took over.
    - ``seconds``: how long Yosys took, when it ran. ``digest``: of the sources, options and versions.
    """

    family: str
    top: str
    modules: tuple[ModuleCounts, ...]
    pieces: Mapping[str, Counts]
    total: Counts
    registers: int
    seconds: float
    digest: str


def family_named(name: str) -> Family:
    """The family of that name.

    Raises:
        InputError: there is none.
    """
    if name not in FAMILIES:
        raise InputError(f"no family {name!r} is synthesised for", "--family", choose_hint(name, FAMILIES))
    return FAMILIES[name]


def _check_memories(circuit: Circuit, family: Family) -> None:
    if not holds_memories(circuit, family):
        raise InputError(
            f"{circuit.top} has memories with two ports that write, which no block RAM of {family.name} has",
            "--family",
            f"choose one of {', '.join(name for name in FAMILIES if FAMILIES[name].true_two_ports)}",
        )


def synthesis_digest(circuit: Circuit, family: Family) -> str:
    """The digest of all that a synthesis depends on."""
    images = (f"{name}\n{image.hex_text()}" for name, image in sorted(circuit.images.items()))
    return digest_of(_LAYOUT, digest_of_circuit(circuit), family.command, version_of("pyosys"), *images)


def synthesise(circuit: Circuit, family_name: str) -> Synthesis:
    """Synthesise a circuit for a family. The result is kept under the digest of the sources, options and versions.

    Raises:
        InputError: no family has the name, or its block RAMs cannot hold the memories.
        MissingToolError: pyosys is not installed.
        RunError: Yosys fails.
    """
    family = family_named(family_name)
    _check_memories(circuit, family)
    digest = synthesis_digest(circuit, family)
    with kept("synthesis", digest, lambda folder: _synthesise(circuit, family, folder)) as folder:
        netlist = Netlist.of(json.loads((folder / "netlist.json").read_text(encoding="utf-8")))
        run = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    pieces = netlist.by_piece(circuit.pieces)
    return Synthesis(
        family=family.name,
        top=top_name(circuit),
        modules=_modules(netlist),
        pieces=pieces,
        total=sum(pieces.values(), Counts()),
        registers=run["registers"],
        seconds=run["seconds"],
        digest=digest,
    )


def hierarchy(circuit: Circuit, family_name: str) -> Netlist:
    """The mapped modules of a circuit, as ``synthesise`` counts them."""
    family = family_named(family_name)
    digest = synthesis_digest(circuit, family)
    with kept("synthesis", digest, lambda folder: _synthesise(circuit, family, folder)) as folder:
        return Netlist.of(json.loads((folder / "netlist.json").read_text(encoding="utf-8")))


def flatten(circuit: Circuit, family_name: str, folder: Path) -> None:
    """Write the flattened netlist of a circuit into ``folder``, as ``flow.FLAT``."""
    family = family_named(family_name)
    digest = synthesis_digest(circuit, family)
    with kept("synthesis", digest, lambda place: _synthesise(circuit, family, place)) as kept_folder:
        (folder / HIERARCHY).write_bytes((kept_folder / "netlist.json").read_bytes())
    top = top_name(circuit)
    yosys(flatten_script(top), folder, f"flattening {top}", seconds=MOST_SECONDS)


def _synthesise(circuit: Circuit, family: Family, folder: Path) -> None:
    """Write ``netlist.json``, the mapped hierarchy, and ``run.json`` into ``folder``."""
    begun = time.monotonic()
    write_design(circuit, folder)
    top = top_name(circuit)
    script = map_script(sources_of(circuit), top, family)
    yosys(script, folder, f"synthesis of {circuit.top} for {family.name}", seconds=MOST_SECONDS)
    document = json.loads((folder / MAPPED).read_text(encoding="utf-8"))
    (folder / MAPPED).unlink()
    registers = finish(document, top)
    (folder / "netlist.json").write_text(json.dumps(document), encoding="utf-8")
    run = {"seconds": time.monotonic() - begun, "registers": registers}
    (folder / "run.json").write_text(json.dumps(run), encoding="utf-8")


def _modules(netlist: Netlist) -> tuple[ModuleCounts, ...]:
    """The modules of the source, all parameters of one name together, the largest first."""
    instances: dict[str, int] = {}
    sums: dict[str, Counts] = {}
    for name, often in netlist.instances().items():
        source = verilog_name(name)
        instances[source] = instances.get(source, 0) + often
        sums[source] = sums.get(source, Counts()) + netlist.own[name] * often
    rows = (ModuleCounts(name, instances[name], sums[name]) for name in sums)
    return tuple(sorted(rows, key=lambda row: (-row.counts.lut4, row.module)))
