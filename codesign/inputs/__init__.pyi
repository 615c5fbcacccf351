from .base import Spec, fault
from .checks import cross_check
from .constraint import Constraint
from .edit import design_point, has_axis
from .exploration import Exploration
from .files import parse_value, starting_files
from .part_file import list_parts, load_part
from .pinning import held, pin
from .platform import Platform, list_platforms, load_platform
from .platform_axis import load_platforms, platforms_of
from .schema import json_schema
from .workload import TaskMapping, Workload
from .workload_file import list_workloads, load_workload

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
