"""The steps from Verilog to a flat netlist, as files. ``hwsw synth`` runs them; ``hwsw rtl`` puts them into a folder.

yosys -s map.ys                                            every module by itself, into mapped.json
python3 output_registers.py mapped.json hierarchy.json     flip-flops into block RAMs; its cells are counted
yosys -s flatten.ys                                        one module, into flat.json, for a placer
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from codesign.hardware.rtl.cells import Family
from codesign.hardware.rtl.design import sources_of, top_name
from codesign.planners.circuits import Circuit

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
