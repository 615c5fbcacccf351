"""Few pins for a placement: the inputs of a circuit come from a shift register, its outputs meet in one parity.

python few_pins.py flat.json

changes the flat netlist of Yosys for a Gowin part in its place. ``hwsw synth --place`` runs this file, and ``hwsw rtl``
puts it into the folder of a part that is placed so: it needs nothing but Python.

Where a placer takes no port without a pin, a circuit of a hundred ports would need a list of pins for each package.
What is added is no part of the circuit: one flip-flop for each bit of the inputs, one LUT for each three of the
outputs. The parity drives a pin, which no clock limits, so the clock remains that of the circuit.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

PARITY = format(0x6996, "016b")
"""The table of a LUT of four inputs that gives their parity."""


def with_few_pins(document: dict[str, Any], top: str) -> tuple[int, int]:
    """Give the flat netlist of a circuit for Gowin the ports ``clk``, ``serial_in`` and ``parity`` alone, in its place.

    Returns the LUT and the flip-flops that were added.
    """
    module = document["modules"][top]
    cells, ports = module["cells"], module["ports"]
    bits = [bit for cell in cells.values() for each in cell["connections"].values() for bit in each]
    free = max((bit for bit in bits if isinstance(bit, int)), default=1) + 1
    free = max(free, *(bit + 1 for port in ports.values() for bit in port["bits"] if isinstance(bit, int)))

    def new() -> int:
        nonlocal free
        free += 1
        return free - 1

    def add(kind: str, inputs: dict[str, int | str], output: str, bit: int, **parameters: str) -> int:
        cells[f"pins.{kind}_{len(cells)}"] = {
            "hide_name": 0,
            "type": kind,
            "parameters": parameters,
            "attributes": {},
            "port_directions": {**dict.fromkeys(inputs, "input"), output: "output"},
            "connections": {**{name: [value] for name, value in inputs.items()}, output: [bit]},
        }
        return bit

    clock, serial, parity = new(), new(), new()
    add("IBUF", {"I": clock}, "O", ports["clk"]["bits"][0])
    last = add("IBUF", {"I": serial}, "O", new())
    shifted = [
        bit for name, port in ports.items() if port["direction"] == "input" and name != "clk" for bit in port["bits"]
    ]
    for bit in shifted:
        last = add("DFF", {"CLK": ports["clk"]["bits"][0], "D": last}, "Q", bit)
    tree = [bit for port in ports.values() if port["direction"] == "output" for bit in port["bits"]]
    luts = 0
    while len(tree) > 1:
        four, tree = tree[:4], tree[4:]
        names = zip("0123", [*four, *"000"], strict=False)
        tree.append(add("LUT4", {f"I{name}": bit for name, bit in names}, "F", new(), INIT=PARITY))
        luts += 1
    add("OBUF", {"I": tree[0]}, "O", parity)
    module["ports"] = {
        "clk": {"direction": "input", "bits": [clock]},
        "serial_in": {"direction": "input", "bits": [serial]},
        "parity": {"direction": "output", "bits": [parity]},
    }
    return luts, len(shifted)


if __name__ == "__main__":
    flat = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    whole = next(name for name, each in flat["modules"].items() if "1" in str(each["attributes"].get("top", "")))
    print("{} LUT and {} flip-flops are added for the pins".format(*with_few_pins(flat, whole)))
    Path(sys.argv[1]).write_text(json.dumps(flat), encoding="utf-8")
