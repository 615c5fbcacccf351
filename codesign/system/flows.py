"""What a planner says flows between its tasks, once it is found to be sound."""

from __future__ import annotations

from typing import Any

from codesign.errors import InputError
from codesign.planners.interface import COMMAND, LOAD, Planner
from codesign.planners.job import Job
from codesign.planners.task_graph import Flow, TaskGraph


def sound_flows(planner: Planner, job: Job[Any, Any]) -> tuple[Flow, ...]:
    """``planner.flows`` of a job.

    Raises:
        InputError: they are not what ``Planner.flows`` promises: the plug-in is at fault, not the workload.
    """
    flows: Any = planner.flows(job)
    wrong = _fault(planner, flows)
    if wrong is not None:
        where = f"{type(planner).__module__}.{type(planner).__qualname__}.flows"
        raise InputError(
            f"planner plug-in {planner.name}: {wrong}",
            where,
            "mend or uninstall the package that registers it",
        )
    return tuple(flows)


def _fault(planner: Planner, flows: Any) -> str | None:
    if not isinstance(flows, tuple | list) or not all(isinstance(flow, Flow) for flow in flows):
        return f"flows gives {type(flows).__name__}, not a tuple of Flow"
    known, seen = tuple(dict.fromkeys((LOAD, *planner.tasks, COMMAND))), set()
    for flow in flows:
        way = f"{flow.name!r} from {flow.sender!r} to {flow.receiver!r}"
        strange = [task for task in (flow.sender, flow.receiver) if task not in known]
        if strange:
            return f"flow {way} names {strange[0]!r}, which is no task: accepted are {', '.join(known)}"
        if type(flow.bits) is not int or flow.bits <= 0:
            return f"flow {way} has {flow.bits!r} bits: give an integer above 0"
        if (flow.sender, flow.receiver, flow.name) in seen:
            return f"flow {way} is listed twice"
        seen.add((flow.sender, flow.receiver, flow.name))
    try:
        TaskGraph(known, tuple(flows))
    except InputError as circle:
        return circle.what
    return None
