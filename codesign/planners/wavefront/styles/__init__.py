"""The wavefront planner: the circuit of Möller and Paschke (1998), the circuit that they compare it with, and software.

- ``delay_line`` on an FPGA: the paper's node, three flip-flops and a register; one for each node of the map.
- ``adder_comparator`` on an FPGA: the node of Hassoun and Sanghvi (1990), eight adders and eight comparators.
- ``tiled`` on an FPGA: an array of delay-line nodes smaller than the map, which visits its tiles.
- ``software`` on a processor: the improved Dijkstra algorithm.
"""

from codesign.planners.wavefront.styles.array import AdderComparator, DelayLine
from codesign.planners.wavefront.styles.software import Software
from codesign.planners.wavefront.styles.tasks import TASK_STYLES
from codesign.planners.wavefront.styles.tiled import Tiled

ARCHITECTURES = (DelayLine(), AdderComparator(), Tiled(), Software())

__all__ = ["ARCHITECTURES", "TASK_STYLES", "AdderComparator", "DelayLine", "Software", "Tiled"]
