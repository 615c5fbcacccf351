"""Platform, part and workload files: the only package that reads YAML.

A file becomes a plain tree with the place of every key (``marks``), pydantic models check it (``model``,
``fields``, ``part``, ``platform``, ``problem``, ``exploration``, ``workload``), and what is wrong comes
out as faults with file, line, column, key, value and remedy, all at once (``validate``). ``design_point``
puts values of an exploration in the place of what the files say, ``variants`` one of a workload's variants, and
``axes`` and ``pairing`` find what is wrong with those axes before any point is made.

PyYAML reads events only, never objects. Its own schema was rejected: it takes ``010`` for 8, ``on`` for true,
``12:30:00`` for 45000, ``1e6`` for text, and the last of two equal keys without a word.
"""

from codesign.spec.base import Spec, fault
from codesign.spec.design_point import has_axis, override, pin
from codesign.spec.exploration import Constraint, Exploration, ResultFigure
from codesign.spec.model import RefusalError, SpecModel
from codesign.spec.pairing import cross_check
from codesign.spec.part import Part, list_parts, load_part
from codesign.spec.platform import Platform, list_platforms, load_platform
from codesign.spec.schema import json_schema
from codesign.spec.start import parse_value, starting_files
from codesign.spec.workload import TaskMapping, Workload
from codesign.spec.workload_file import list_workloads, load_workload

__all__ = [
    "Constraint",
    "Exploration",
    "Part",
    "Platform",
    "RefusalError",
    "ResultFigure",
    "Spec",
    "SpecModel",
    "TaskMapping",
    "Workload",
    "cross_check",
    "fault",
    "has_axis",
    "json_schema",
    "list_parts",
    "list_platforms",
    "list_workloads",
    "load_part",
    "load_platform",
    "load_workload",
    "override",
    "parse_value",
    "pin",
    "starting_files",
]
