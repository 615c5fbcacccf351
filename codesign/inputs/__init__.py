"""Platform, part and workload files: the only package that reads YAML.

A file becomes a plain tree with the place of every key (``yaml_tree``, ``document``), pydantic models check it
(``platform``, ``components``, ``links``, ``workload``, ``problem``, ``scenario``, ``exploration``, ``part_file``), and
what is wrong comes out as faults with file, line, column, key, value and remedy, all at once (``faults``).

A design point is an edited tree (``edit``): values are put into the trees, with where they come from, and the same
models validate. A variant is a merge of its section. ``checks`` makes each point of a study with one axis moved, and
finds what is wrong with the axes before any point is computed.

PyYAML reads events only, never objects. Its own schema was rejected: it takes ``010`` for 8, ``on`` for true,
``12:30:00`` for 45000, ``1e6`` for text, and the last of two equal keys without a word.
"""

from codesign.ground.models import RefusalError, SpecModel
from codesign.inputs.base import Spec, fault
from codesign.inputs.checks import cross_check
from codesign.inputs.constraint import Constraint
from codesign.inputs.edit import design_point, has_axis
from codesign.inputs.exploration import Exploration
from codesign.inputs.files import parse_value, starting_files
from codesign.inputs.part_file import list_parts, load_part
from codesign.inputs.pinning import held, pin
from codesign.inputs.platform import Platform, list_platforms, load_platform
from codesign.inputs.platform_axis import load_platforms, platforms_of
from codesign.inputs.schema import json_schema
from codesign.inputs.workload import TaskMapping, Workload
from codesign.inputs.workload_file import list_workloads, load_workload

__all__ = [
    "Constraint",
    "Exploration",
    "Platform",
    "RefusalError",
    "Spec",
    "SpecModel",
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
