"""Workload files: found by name or path, read, and checked with their variants and the axes that they explore."""

from __future__ import annotations

from dataclasses import replace

from codesign.inputs.axes import with_listed_axes
from codesign.inputs.checks import workload_faults
from codesign.inputs.faults import validate
from codesign.inputs.files import Source, read_spec, shipped_names
from codesign.inputs.workload import ProblemModels, TaskModels, Workload


def load_workload(source: Source, tasks: TaskModels | None = None, problems: ProblemModels | None = None) -> Workload:
    """The workload with a shipped name (``labyrinth``), or in a file, in YAML text or in a dict.

    Args:
        source: see ``read_spec``.
        tasks: the models that parameters are checked against. Without, they are taken as they stand.
        problems: the models of problems other than a map with goals and starts.

    Raises:
        InputError: no shipped workload of that name.
        SpecError: all the faults of the file.
    """
    document = replace(with_listed_axes(read_spec(source, "workloads")), context={"tasks": tasks, "problems": problems})
    return validate(Workload, document, workload_faults).with_document(document)


def list_workloads() -> list[str]:
    """Names of the shipped workloads."""
    return shipped_names("workloads")
