"""Breadth-first search: the circuit and the program of Vacariu et al. (2008).

- ``state_machine`` on an FPGA: the states Standby, Init, BF and Path around block RAMs or an external memory.
- ``software`` on a processor: a compiled search over arrays.
- ``software_java`` on a processor: the paper's Java program, with its memory wall.
"""

from codesign.planners.breadth_first.styles.software import Software
from codesign.planners.breadth_first.styles.state_machine import StateMachine
from codesign.planners.breadth_first.styles.tasks import TASK_STYLES
from codesign.planners.map_flood import CELL_KERNEL

ARCHITECTURES = (
    StateMachine(),
    Software("software", CELL_KERNEL),
    Software("software_java", "breadth_first_java_cell", java=True),
)

__all__ = ["ARCHITECTURES", "TASK_STYLES", "Software", "StateMachine"]
