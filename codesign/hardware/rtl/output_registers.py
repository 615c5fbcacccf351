"""Let block RAMs take over the flip-flops behind their outputs, as vendors' tools do and Yosys does not.

python output_registers.py mapped.json hierarchy.json

reads what ``write_json`` of Yosys wrote, and writes the modules that the top uses. ``hwsw synth`` runs this file, and
``hwsw rtl`` puts it into every folder: it needs nothing but Python.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter
from pathlib import Path
from typing import Any

_RAMB16 = (("DOP?A(DOP?)?", {"DOA_REG": "1"}), ("DOP?B(DOP?)?", {"DOB_REG": "1"}))
_DPB = (("DOA", {"READ_MODE0": "1"}), ("DOB", {"READ_MODE1": "1"}))
_SDPB = (("DO", {"READ_MODE": "1"}),)
REGISTERS = {
    **dict.fromkeys(("RAMB16", "RAMB18E1", "RAMB36E1"), _RAMB16),
    "DP16KD": ((r"DOA\d+", {"REGMODE_A": "OUTREG"}), (r"DOB\d+", {"REGMODE_B": "OUTREG"})),
    "PDPW16KD": ((r"DO\d+", {"REGMODE": "OUTREG"}),),
    **dict.fromkeys(("DPB", "DPX9B"), _DPB),
    **dict.fromkeys(("SDPB", "SDPX9B", "SP", "SPX9", "pROM", "pROMX9"), _SDPB),
}
"""The output registers of each block RAM: a pattern of its ports, and the settings that switch the register on."""

DATA = {"TRELLIS_FF": "DI", "DFF": "D", "FDRE": "D"}
"""The flip-flops that an output register may take the place of, and their port of data."""
IDLE = {"TRELLIS_FF": {"LSR": "0", "CE": "1"}, "DFF": {}, "FDRE": {"R": "0", "CE": "1"}}
"""The value of every other port but the clock: the flip-flop takes a value at each edge."""

Module = dict[str, Any]


def finish(document: dict[str, Any], top: str) -> int:
    """Merge the output registers of a document, and leave the modules that ``top`` uses in it; how many were merged.

    A port takes flip-flops where every bit of it that is read at all is read by one flip-flop alone, which runs freely.
    """
    modules = document["modules"]
    merged = sum(_merge_module(module) for module in modules.values())
    used = {cell["type"] for module in modules.values() for cell in module["cells"].values()}
    document["modules"] = {name: module for name, module in modules.items() if name in used or name == top}
    return merged


def _merge_module(module: Module) -> int:
    memories = [cell for cell in module["cells"].values() if cell["type"] in REGISTERS]
    if not memories:
        return 0
    readers, flip_flops = _wiring(module)
    return sum(
        _merge(module, memory, pattern, settings, readers, flip_flops)
        for memory in memories
        for pattern, settings in REGISTERS[memory["type"]]
    )


def _wiring(module: Module) -> tuple[Counter[int], dict[int, str]]:
    """How often each bit of a module is read, and the free-running flip-flops by their data bit."""
    readers: Counter[int] = Counter()
    flip_flops: dict[int, str] = {}
    for port in module["ports"].values():
        if port["direction"] != "input":
            readers.update(bit for bit in port["bits"] if isinstance(bit, int))
    for name, cell in module["cells"].items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] == "input":
                readers.update(bit for bit in bits if isinstance(bit, int))
        kind, wires = cell["type"], cell["connections"]
        if kind in IDLE and all(wires.get(port, [value]) == [value] for port, value in IDLE[kind].items()):
            flip_flops[wires[DATA[kind]][0]] = name
    return readers, flip_flops


def _merge(
    module: Module,
    memory: Module,
    pattern: str,
    settings: dict[str, str],
    readers: Counter[int],
    flip_flops: dict[int, str],
) -> int:
    ports = [port for port in memory["connections"] if re.fullmatch(pattern, port)]
    read = [bit for port in ports for bit in memory["connections"][port] if readers[bit]]
    if not read or any(readers[bit] != 1 or bit not in flip_flops for bit in read):
        return 0
    behind = {bit: module["cells"].pop(flip_flops[bit])["connections"]["Q"][0] for bit in read}
    for port in ports:
        memory["connections"][port] = [behind.get(bit, bit) for bit in memory["connections"][port]]
    for name, value in settings.items():
        # A parameter is text where the family spells it, else a word of bits as wide as it was.
        old = memory["parameters"].get(name, "")
        memory["parameters"][name] = value if not value.isdigit() else value.zfill(len(old) or 1)
    return len(behind)


def top_of(document: dict[str, Any]) -> str:
    """The name of the top module."""
    return next(
        str(name) for name, each in document["modules"].items() if "1" in str(each["attributes"].get("top", ""))
    )


if __name__ == "__main__":
    tree = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    print(finish(tree, top_of(tree)), "flip-flops stand in block RAMs")
    Path(sys.argv[2]).write_text(json.dumps(tree), encoding="utf-8")
