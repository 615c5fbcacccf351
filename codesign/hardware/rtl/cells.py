"""The cells that Yosys maps a design to, by family: what each counts as, and how a family is synthesised.

A count is in the units of ``Part.resources``. ``lut4`` counts LUT of any number of inputs one for one: a family whose
parts have LUT of six inputs is budgeted one such LUT for one of a law (``inputs.library``), so both sides agree.
"""

from __future__ import annotations

import math
import re
from dataclasses import asdict, astuple, dataclass

from codesign.ground.errors import RunError


@dataclass(frozen=True)
class Counts:
    """Resources by kind, as ``figures.RESOURCES`` names them. Slices are a matter of packing and are not counted."""

    lut4: float = 0
    flip_flops: float = 0
    block_rams: float = 0
    multipliers: float = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(mine + theirs for mine, theirs in zip(astuple(self), astuple(other), strict=True)))

    def __mul__(self, times: int) -> Counts:
        return Counts(*(value * times for value in astuple(self)))

    def by_resource(self) -> dict[str, int]:
        """The counts by resource, rounded up: half of a multiplier takes one."""
        return {name: math.ceil(value) for name, value in asdict(self).items()}


@dataclass(frozen=True)
class Family:
    """The synthesis of designs for a family of parts.

    ``command``: of Yosys, for the hierarchy without flattening. ``true_two_ports``: True if a block RAM has two ports
    that both read and write.
    """

    name: str
    command: str
    true_two_ports: bool = True


def _xilinx(name: str) -> Family:
    # Without wide multiplexers: Yosys gives most functions of five and six inputs to MUXF5 and MUXF6 otherwise, two and
    # four LUT each. ISE did so only where it saved time, and the papers count LUT.
    command = f"synth_xilinx -family {name} -noiopad -noclkbuf -nowidelut"
    return Family(name, command)


FAMILIES = {
    family.name: family
    for family in (
        _xilinx("xc2v"),
        _xilinx("xc2vp"),
        _xilinx("xc3se"),
        _xilinx("xc4v"),
        Family("xc7", "synth_xilinx -family xc7 -noiopad -noclkbuf"),
        Family("ecp5", "synth_ecp5 -noflatten -nowidelut"),
        Family("gowin", "synth_gowin -family gw2a -noflatten -nowidelut -noiopads"),
        Family("ice40", "synth_ice40 -noflatten", true_two_ports=False),
    )
}
"""The families that designs are synthesised for, by the name that Yosys gives them."""

COUNTED = tuple(
    (re.compile(pattern), counts)
    for pattern, counts in (
        # An inverter of its own takes a LUT. A cell of an adder of the ECP5 takes two, one of Gowin one.
        (r"LUT[1-6]|SB_LUT4|INV|ALU", Counts(lut4=1)),
        (r"CCU2C|LUT6_2", Counts(lut4=2)),
        # Carry and wide multiplexers stand beside the LUT and take none; a carry of the iCE40 shares the cell of a LUT.
        (r"MUXCY|XORCY|CARRY4|SB_CARRY|MUXF[5-8]|PFUMX|L6MUX21|MUX2_LUT[5-8]|MUX2|GND|VCC|BUF\w*", Counts()),
        (r"SRL16E?|SRLC16E?|SRLC32E|RAM16X1S|RAM32X1S", Counts(lut4=1)),
        (r"RAM16X1D|RAM32X1D|RAM64X1D", Counts(lut4=2)),
        (r"RAM32M|RAM64M|RAM16SDP4", Counts(lut4=4)),
        # Four LUT hold the words, and the two of a third slice drive the writes.
        (r"TRELLIS_DPR16X4", Counts(lut4=6)),
        (r"FD[RSCP]\w*|TRELLIS_FF|SB_DFF\w*|DFF\w*", Counts(flip_flops=1)),
        (r"RAMB16\w*|RAMB18E1|DP16KD|PDPW16KD|SB_RAM40_4K\w*", Counts(block_rams=1)),
        (r"SPX?9?|SDPX?9?B|DPX?9?B|pROM(X9)?", Counts(block_rams=1)),
        # A block of 36 kbit counts as two of 18.
        (r"RAMB36E1", Counts(block_rams=2)),
        (r"MULT18X18\w*|DSP48\w*|SB_MAC16|MULT18X18D", Counts(multipliers=1)),
        (r"MULT9X9\w*", Counts(multipliers=0.5)),
        (r"MULT36X36\w*", Counts(multipliers=4)),
    )
)
"""The resources that a cell counts as: the first pattern that its whole name matches."""


def counts_of(cell: str) -> Counts:
    """The resources that a cell of any family counts as.

    Raises:
        RunError: the cell stands in no pattern.

    >>> counts_of("CCU2C"), counts_of("RAMB16_S18_S18").block_rams
    (Counts(lut4=2, flip_flops=0, block_rams=0, multipliers=0), 1)
    """
    for pattern, counts in COUNTED:
        if pattern.fullmatch(cell):
            return counts
    raise RunError(f"Yosys mapped a part of the design to the cell {cell}, which is not counted", "hwsw synth")
