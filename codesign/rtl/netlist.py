"""Netlists of Yosys as JSON: modules counted, their hierarchy walked, output registers merged into block RAMs."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from codesign.rtl.cells import Counts, Family, OutputRegister, counts_of

Cells = dict[str, dict[str, Any]]


def verilog_name(module: str) -> str:
    r"""The name of a module in its source: Yosys adds the parameters or their digest.

    >>> verilog_name(r"$paramod$317dc02e\ram_1w1r"), verilog_name(r"$paramod\node\PIPELINE=s32'01"), verilog_name("top")
    ('ram_1w1r', 'node', 'top')
    """
    return module.split("\\")[1] if module.startswith("$paramod") else module.lstrip("\\")


@dataclass(frozen=True, eq=False)
class Netlist:
    """A hierarchy of mapped modules. ``modules``: of the JSON, without those of the cell library; ``top``: one name."""

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
        """The cells of a module by name: those of the library, and the modules in it."""
        cells: Cells = self.modules[module]["cells"]
        return cells

    @cached_property
    def own(self) -> dict[str, Counts]:
        """What each module counts as by itself, without the modules in it."""
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
        """How often each module stands in the whole design."""
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


_DATA = {"TRELLIS_FF": "DI", "DFF": "D", "FDRE": "D"}
"""The flip-flops that an output register of a block RAM may take the place of, and their port of data."""
_IDLE: Mapping[str, Mapping[str, str]] = {
    "TRELLIS_FF": {"LSR": "0", "CE": "1"},
    "DFF": {},
    "FDRE": {"R": "0", "CE": "1"},
}
"""What every other port but the clock has to be: the flip-flop takes a value at each edge."""


@dataclass
class _Wiring:
    """Who reads each bit of a module, and the free-running flip-flops by their data bit."""

    readers: Counter[int] = field(default_factory=Counter)
    flip_flops: dict[int, str] = field(default_factory=dict)


def _wiring(module: Mapping[str, Any]) -> _Wiring:
    wiring = _Wiring()
    for port in module["ports"].values():
        if port["direction"] != "input":
            wiring.readers.update(bit for bit in port["bits"] if isinstance(bit, int))
    for name, cell in module["cells"].items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] == "input":
                wiring.readers.update(bit for bit in bits if isinstance(bit, int))
        kind = cell["type"]
        idle = _IDLE.get(kind)
        if idle is not None and all(
            cell["connections"].get(port, [value]) == [value] for port, value in idle.items()
        ):
            wiring.flip_flops[cell["connections"][_DATA[kind]][0]] = name
    return wiring


def merge_output_registers(netlist: Netlist, family: Family) -> int:
    """Let block RAMs take over the flip-flops behind their outputs, as vendors' tools do; returns how many.

    A port takes them where every bit of it that is read at all is read by one flip-flop alone, which runs freely.
    """
    merged = 0
    for module in netlist.modules.values():
        memories = [cell for cell in module["cells"].values() if cell["type"] in family.registers]
        wiring = _wiring(module) if memories else _Wiring()
        for cell in memories:
            for register in family.registers[cell["type"]]:
                merged += _merge(module, cell, register, wiring)
    return merged


def _merge(module: dict[str, Any], memory: dict[str, Any], register: OutputRegister, wiring: _Wiring) -> int:
    ports = [port for port in memory["connections"] if re.fullmatch(register.outputs, port)]
    bits = [bit for port in ports for bit in memory["connections"][port]]
    read = [bit for bit in bits if wiring.readers[bit]]
    if not read or any(wiring.readers[bit] != 1 or bit not in wiring.flip_flops for bit in read):
        return 0
    behind = {bit: module["cells"].pop(wiring.flip_flops[bit])["connections"]["Q"][0] for bit in read}
    for port in ports:
        memory["connections"][port] = [behind.get(bit, bit) for bit in memory["connections"][port]]
    for name, value in register.settings.items():
        # A parameter is text where the family spells it, else a word of bits as wide as it was.
        old = memory["parameters"].get(name, "")
        memory["parameters"][name] = value if not value.isdigit() else value.zfill(len(old) or 1)
    return len(behind)
