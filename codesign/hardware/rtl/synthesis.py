"""Synthesis of a circuit by Yosys (pyosys) for a family: the resources of its modules and of the lines of its demand.

Modules are synthesised one by one, each once for all its instances: an array of hundreds of equal nodes takes as long
as one node. The boundaries of modules remain, so that a count belongs to a module and so to a line. Block RAMs then
take over the flip-flops behind their outputs (``output_registers``). For placement the result is flattened. The steps
are in ``flow``, which ``hwsw rtl`` puts into every folder.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from codesign.ground.errors import InputError, choose_hint
from codesign.hardware.rtl.cells import FAMILIES, Counts, Family, counts_of
from codesign.hardware.rtl.design import digest_of, digest_of_circuit, kept, sources_of, top_name, write_design
from codesign.hardware.rtl.output_registers import finish
from codesign.hardware.rtl.tools import version_of, yosys
from codesign.planners.circuits import Circuit

Cells = dict[str, dict[str, Any]]


def verilog_name(module: str) -> str:
    r"""The name of a module in its source: Yosys adds the parameters or their digest.

    >>> verilog_name(r"$paramod$317dc02e\ram_1w1r"), verilog_name(r"$paramod\node\PIPELINE=s32'01"), verilog_name("top")
    ('ram_1w1r', 'node', 'top')
    """
    return module.split("\\")[1] if module.startswith("$paramod") else module.lstrip("\\")


@dataclass(frozen=True, eq=False)
class Netlist:
    """A hierarchy of mapped modules. ``modules``: of the JSON, without the cell library; ``top``: one name."""

    modules: Mapping[str, dict[str, Any]]
    top: str

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Netlist:
        """The netlist of what ``write_json`` wrote."""
        modules = {
            name: module
            for name, module in document["modules"].items()
            if not _is_set(module, "blackbox") and not _is_set(module, "whitebox")
        }
        return cls(modules, next(name for name, module in modules.items() if _is_set(module, "top")))

    def cells(self, module: str) -> Cells:
        """The cells of a module by name: cells of the library, and the modules in it."""
        cells: Cells = self.modules[module]["cells"]
        return cells

    @cached_property
    def own(self) -> dict[str, Counts]:
        """The resources of each module by itself, without the modules in it."""
        return {
            name: sum(
                (
                    counts_of(kind) * times
                    for kind, times in Counter(cell["type"] for cell in self.cells(name).values()).items()
                    if kind not in self.modules and not kind.startswith("$")
                ),
                Counts(),
            )
            for name in self.modules
        }

    @cached_property
    def inside(self) -> dict[str, Counter[str]]:
        """The modules that stand in each module, with how often."""
        return {
            name: Counter(cell["type"] for cell in self.cells(name).values() if cell["type"] in self.modules)
            for name in self.modules
        }

    def instances(self) -> Counter[str]:
        """The number of instances of each module in the whole design."""
        often: Counter[str] = Counter()

        def add(module: str, times: int) -> None:
            often[module] += times
            for name, number in self.inside[module].items():
                add(name, times * number)

        add(self.top, 1)
        return often

    def paths(self) -> Iterator[tuple[str, str]]:
        """Every instance with its path, ``nodes[3].node``, and its module in the source, the outermost first."""

        def below(module: str, path: str) -> Iterator[tuple[str, str]]:
            for name, cell in self.cells(module).items():
                if cell["type"] in self.modules:
                    whole = f"{path}{name}"
                    yield whole, verilog_name(cell["type"])
                    yield from below(cell["type"], f"{whole}.")

        return below(self.top, "")

    def by_piece(self, pieces: Mapping[str, tuple[str, ...]]) -> dict[str, Counts]:
        """The counts of each piece, ``Circuit.pieces``; what stands in none under "".

        A module that is in no piece is counted with the module that contains it.
        """
        piece_of = {module: piece for piece, names in pieces.items() for module in names}
        sums: dict[str, Counts] = {piece: Counts() for piece in pieces}

        def add(module: str, around: str, times: int) -> None:
            piece = piece_of.get(verilog_name(module), around)
            sums[piece] = sums.get(piece, Counts()) + self.own[module] * times
            for name, number in self.inside[module].items():
                add(name, piece, times * number)

        add(self.top, "", 1)
        return sums


def _is_set(module: Mapping[str, Any], attribute: str) -> bool:
    return any(digit == "1" for digit in str(module.get("attributes", {}).get(attribute, "")))


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
        what = f"{circuit.top} has memories with two ports that write, which no block RAM of {family.name} has"
        hint = f"choose one of {', '.join(name for name in FAMILIES if FAMILIES[name].true_two_ports)}"
        raise InputError(what, "--family", hint)


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
    with _kept(circuit, family) as folder:
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
        digest=synthesis_digest(circuit, family),
    )


def _kept(circuit: Circuit, family: Family) -> AbstractContextManager[Path]:
    """The folder of a synthesis, which is made where it is not kept."""
    return kept("synthesis", synthesis_digest(circuit, family), lambda folder: _synthesise(circuit, family, folder))


def hierarchy(circuit: Circuit, family_name: str) -> Netlist:
    """The mapped modules of a circuit, as ``synthesise`` counts them."""
    with _kept(circuit, family_named(family_name)) as folder:
        return Netlist.of(json.loads((folder / "netlist.json").read_text(encoding="utf-8")))


def flatten(circuit: Circuit, family_name: str, folder: Path) -> None:
    """Write the flattened netlist of a circuit into ``folder``, as ``flow.FLAT``."""
    with _kept(circuit, family_named(family_name)) as kept_folder:
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
