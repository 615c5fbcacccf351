"""The page of names that the author of a planner imports.

A package registers one ``PlugIn`` under the entry-point group ``codesign.planners``. ``docs/extending.md`` shows how.
"""

from codesign.figures import Figure, Status
from codesign.memo import Memo
from codesign.models import RefusalError, SpecModel, TaskParameters
from codesign.part import Part
from codesign.planners.external_memory import ExternalMemoryLaw, Traffic
from codesign.planners.host import HostStyle, HostTask, one_step
from codesign.planners.interface import (
    COMMAND,
    LOAD,
    LOWER_BOUND,
    POSE,
    Planner,
    Policy,
    Problem,
    Quality,
    RobotsQuality,
)
from codesign.planners.plug_in import GROUP, PlugIn, Probe, Reproduce
from codesign.planners.reproduction import Finding, Plot, Reproduction, Row, Series, row
from codesign.planners.styles import (
    RESOURCES,
    Architecture,
    Bound,
    Demand,
    Exchange,
    Item,
    Lever,
    Memory,
    Step,
    TaskStyle,
    is_done,
)
from codesign.planners.task_graph import Flow
from codesign.planners.ways import by_sides, cell_of, from_position, judge_arrival, judge_ways
from codesign.records import FieldRecord, Record, TaskRecord

__all__ = [
    "COMMAND",
    "GROUP",
    "LOAD",
    "LOWER_BOUND",
    "POSE",
    "RESOURCES",
    "Architecture",
    "Bound",
    "Demand",
    "Exchange",
    "ExternalMemoryLaw",
    "FieldRecord",
    "Figure",
    "Finding",
    "Flow",
    "HostStyle",
    "HostTask",
    "Item",
    "Lever",
    "Memo",
    "Memory",
    "Part",
    "Planner",
    "Plot",
    "PlugIn",
    "Policy",
    "Probe",
    "Problem",
    "Quality",
    "Record",
    "RefusalError",
    "Reproduce",
    "Reproduction",
    "RobotsQuality",
    "Row",
    "Series",
    "SpecModel",
    "Status",
    "Step",
    "TaskParameters",
    "TaskRecord",
    "TaskStyle",
    "Traffic",
    "by_sides",
    "cell_of",
    "from_position",
    "is_done",
    "judge_arrival",
    "judge_ways",
    "one_step",
    "row",
]
