"""Relaxation on a processor: one core, or two with the levels of the arithmetic mean side by side.

- ``sequential``: every level one after the other, as the runs of Saudi and Sulaiman (2016) were.
- ``two_core``: levels 1 and 2 in parallel, which their conclusion names: "can be carried out independently".
"""

from codesign.planners.relaxation.styles.host import TASK_STYLES, Host

ARCHITECTURES = (Host("sequential"), Host("two_core", cores=2))

__all__ = ["ARCHITECTURES", "TASK_STYLES", "Host"]
