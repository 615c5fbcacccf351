"""Harmonic control: the bit-serial circuit of Girau et al. (2008), and software on a processor.

- ``bit_serial`` on an FPGA: one serial node for each cell of a block, 18 nodes around a block RAM.
- ``software`` on a processor: the same relaxation at a cost for each node update that does not depend on the
  precision, as the paper's "around 100 µs per iteration".
- ``software_limbs`` on a processor: the same, at that cost of a node update for each 64-bit limb of the
  value.
"""

from codesign.planners.harmonic.styles.bit_serial import BitSerial
from codesign.planners.harmonic.styles.software import Software
from codesign.planners.harmonic.styles.tasks import TASK_STYLES

ARCHITECTURES = (BitSerial(), Software("software"), Software("software_limbs", limbs=True))

__all__ = ["ARCHITECTURES", "TASK_STYLES", "BitSerial", "Software"]
