"""How long one design point takes to make, platform and workload, without simulating it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from itertools import islice
from typing import Any

from codesign.inputs import design_point, load_platform
from codesign.inputs.faults import context_of
from codesign.inputs.workload import Workload
from codesign.study.space import Space
from codesign.system import catalog

PASSES = 5


def seconds_each(action: Callable[[Any], object], items: Iterable[Any], passes: int = PASSES) -> float:
    """Time of this thread for one item, the shortest of several passes through all of them."""
    listed = list(items)
    shortest = float("inf")
    for _ in range(passes):
        begin = time.thread_time()
        for item in listed:
            action(item)
        shortest = min(shortest, time.thread_time() - begin)
    return shortest / len(listed)


def rows(platform_name: str, workload_name: str, most: int) -> list[Any]:
    """The points of a shipped study, each once in a pass, beside what validating its workload takes."""
    platform, workload = load_platform(platform_name), catalog.load_workload(workload_name)
    assert workload.explore is not None, "a study"
    document = workload.document
    tree = {key: raw for key, raw in document.tree.items() if key not in ("explore", "variants")}
    whole = seconds_each(lambda _: Workload.model_validate(tree, context=context_of(document)), range(300))
    axes = workload.explore.axes
    space = Space(axes, "")
    # Spread over the study, so that every axis moves.
    points = [point.axes for point in islice(space.points(), 0, None, max(1, len(space) // most))]
    first = seconds_each(lambda values: design_point(platform, workload, values), points, passes=1)
    each = seconds_each(lambda values: design_point(platform, workload, values), points)
    name = f"{platform_name} {workload_name}"
    point = f"{name}: a design point, {len(axes)} axes"
    return [
        {"case": case, "points": count, "ms": f"{seconds * 1e3:.3f}", "ratio": f"{seconds / whole:.2f}"}
        for case, count, seconds in (
            (f"{name}: validating the workload", "", whole),
            (f"{point}, first pass", str(len(points)), first),
            (point, str(len(points)), each),
        )
    ]


def run() -> list[Any]:
    """The rows of the table."""
    return [*rows("virtex4-pci", "labyrinth", 1500), *rows("zynq", "office-partition", 1500)]
