"""Workload files: found by name or path, read, and checked with their variants and the axes that they explore."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from codesign.inputs.checks import workload_faults
from codesign.inputs.faults import validate
from codesign.inputs.files import find_spec, shipped_names
from codesign.inputs.workload import ProblemModels, TaskModels, Workload
from codesign.inputs.yaml_tree import read_document


def load_workload(
    source: str | Path, tasks: TaskModels | None = None, problems: ProblemModels | None = None
) -> Workload:
    """The workload with a shipped name (``labyrinth``), or in a file (with a separator or ``.yaml``).

    Args:
        source: name or path.
        tasks: the models that parameters are checked against. Without, they are taken as they stand.
        problems: the models of problems other than a map with goals and starts.

    Raises:
        InputError: no shipped workload of that name.
        SpecError: all the faults of the file.
    """
    path, shown = find_spec(source, "workloads")
    document = replace(read_document(path, shown), context={"tasks": tasks, "problems": problems})
    return validate(Workload, document, workload_faults).with_document(document)


def list_workloads() -> list[str]:
    """Names of the shipped workloads."""
    return shipped_names("workloads")
