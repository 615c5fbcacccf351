"""One problem for designs of several planners."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from codesign.errors import Fault, InputError, SpecError
from codesign.inputs import Platform, Workload, design_point, has_axis
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.problem import ProblemSpec


def problem_of(workload: Workload) -> ProblemSpec:
    """The map, goals and starts of a workload.

    Raises:
        InputError: its planner has a problem of another kind.
    """
    if not isinstance(workload.problem, ProblemSpec):
        raise InputError(
            f"the problem of {workload.name} is not a map with goals and starts",
            hint="choose a workload of another planner",
        )
    return workload.problem


def problem_from_map(file: Path, goal: tuple[int, int], start: tuple[int, int]) -> ProblemSpec:
    """The problem of one goal and one start, (row, column), on a map file.

    Raises:
        SpecError: the file is none, or a cell is on no map; told at --map, --goal and --start.
    """
    tree = {"map": {"file": str(file.resolve())}, "goals": [list(goal)], "starts": [list(start)]}
    try:
        return validate(ProblemSpec, Document("command line", Path(), tree))
    except SpecError as wrong:
        raise at_options(wrong) from None


def with_problem(workload: Workload, problem: ProblemSpec) -> Workload:
    """The workload on another map, with its goals and starts.

    Raises:
        InputError: its planner takes no map.
    """
    problem_of(workload)
    return workload.model_copy(update={"problem": problem})


def applicable(
    platform: Platform, workload: Workload, settings: Mapping[str, Any]
) -> tuple[Platform, Workload]:
    """Platform and workload with those settings that name a parameter or a field they have.

    Raises:
        SpecError: a value that is not accepted.
    """
    chosen = {axis: value for axis, value in settings.items() if has_axis(platform, workload, axis)}
    return design_point(platform, workload, chosen, "--set ") if chosen else (platform, workload)


_OPTIONS = {"map": "--map", "goals": "--goal", "starts": "--start"}


def at_options(wrong: SpecError) -> SpecError:
    """The same faults, those of the map, its goal and its start at the options that gave them."""
    return SpecError(_at_option(fault) for fault in wrong.faults)


def _at_option(fault: Fault) -> Fault:
    first = fault.key.removeprefix("problem.").partition(".")[0].partition("[")[0]
    option = _OPTIONS.get(first)
    return fault if option is None else Fault(option, 0, 0, "", fault.what, fault.hint)
