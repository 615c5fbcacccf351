from .base import Spec, fault
from .checks import cross_check, list_workloads, load_platforms, load_workload, platforms_of
from .constraint import Constraint
from .edit import design_point, has_axis
from .exploration import Exploration
from .exploring import held, pin
from .files import parse_value, starting_files
from .library import list_parts, load_part
from .platform import Platform, list_platforms, load_platform
from .schema import json_schema
from .workload import TaskMapping, Workload

__all__ = [
    "Constraint",
    "Exploration",
    "Platform",
    "Spec",
    "TaskMapping",
    "Workload",
    "cross_check",
    "design_point",
    "fault",
    "has_axis",
    "held",
    "json_schema",
    "list_parts",
    "list_platforms",
    "list_workloads",
    "load_part",
    "load_platform",
    "load_platforms",
    "load_workload",
    "parse_value",
    "pin",
    "platforms_of",
    "starting_files",
]
