"""The page of names that the author of a planner imports.

A package registers one ``PlugIn`` under the entry-point group ``codesign.planners``. ``docs/extending.md`` shows how.
"""

from codesign.ground.errors import Fault, UnsuitedError
from codesign.ground.figures import RESOURCES, Figure, Status
from codesign.ground.memo import Memo
from codesign.ground.models import Part, RefusalError, SpecModel, TaskParameters
from codesign.ground.records import ArrayOf, FieldRecord, Record, TaskRecord
from codesign.planners.circuits import Circuit, CircuitStyle, Events, Expected, Image, phase_cycles
from codesign.planners.clock_law import on_family
from codesign.planners.external_memory import ExternalMemoryLaw, Traffic
from codesign.planners.interface import (
    COMMAND,
    LOAD,
    LOWER_BOUND,
    POSE,
    LoadParameters,
    MapWork,
    Planner,
    Policy,
    Problem,
    Quality,
    RobotsQuality,
    by_sides,
    cell_of,
    from_position,
    judge_arrival,
    judge_paths,
)
from codesign.planners.job import Demand, Flow, Job, Lever, Line
from codesign.planners.plug_in import PlugIn, Probe, Reproduce, Samples, Timed
from codesign.planners.registered import GROUP
from codesign.planners.reproduction import Finding, Plot, Reproduction, Row, Series, row
from codesign.planners.styles import (
    Architecture,
    Designs,
    Exchange,
    Family,
    FleetUpdates,
    HostStyle,
    HostTask,
    Memory,
    MemoryStep,
    Step,
    TaskStyle,
    map_read,
    one_step,
)

__all__ = [
    "COMMAND",
    "GROUP",
    "LOAD",
    "LOWER_BOUND",
    "POSE",
    "RESOURCES",
    "Architecture",
    "ArrayOf",
    "Circuit",
    "CircuitStyle",
    "Demand",
    "Designs",
    "Events",
    "Exchange",
    "Expected",
    "ExternalMemoryLaw",
    "Family",
    "Fault",
    "FieldRecord",
    "Figure",
    "Finding",
    "FleetUpdates",
    "Flow",
    "HostStyle",
    "HostTask",
    "Image",
    "Job",
    "Lever",
    "Line",
    "LoadParameters",
    "MapWork",
    "Memo",
    "Memory",
    "MemoryStep",
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
    "Samples",
    "Series",
    "SpecModel",
    "Status",
    "Step",
    "TaskParameters",
    "TaskRecord",
    "TaskStyle",
    "Timed",
    "Traffic",
    "UnsuitedError",
    "by_sides",
    "cell_of",
    "from_position",
    "judge_arrival",
    "judge_paths",
    "map_read",
    "on_family",
    "one_step",
    "phase_cycles",
    "row",
]
