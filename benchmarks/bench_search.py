"""Searches against the exact front: hypervolume over evaluations, of several studies and seeds.

``python -m benchmarks search`` makes the table of docs/searching.md.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from statistics import median
from unittest import mock

import codesign
from codesign.ground.figures import FIGURES
from codesign.inputs import exploration
from codesign.inputs.axes import axis_form
from codesign.inputs.exploring import exploring
from codesign.study import Study
from codesign.study.budget import Budget
from codesign.study.hypervolume import costs_of, scale_of
from codesign.study.search import Trace
from codesign.study.store import MemoryStore

SEEDS = range(5)
POINTS = (50, 100, 200)

CLOCKS = {
    "fabric.part": "XC2V6000-4,XC4VLX160-12",
    "fabric.clock": "40MHz..150MHz:5MHz",
    "pci.clock": "10MHz..66MHz:4MHz",
    "pci.setup_cycles": "2,8,16",
}
STUDIES: dict[str, tuple[str, dict[str, str]]] = {
    "labyrinth": (
        "labyrinth",
        {
            **CLOCKS,
            "relax.block": "[24,44],[36,66],[72,66]",
            "relax.iterations": "4,6,8",
            "relax.schedule": "[31,71,111],[111]",
            "relax.termination": "sound",
        },
    ),
    "wavefront-tiles": (
        "wavefront-tiles",
        {**CLOCKS, "propagate.tile": "[16,24],[24,36],[12,18]", "propagate.paths": "shortest,safe"},
    ),
    "breadth-first": ("breadth-first", {**CLOCKS, "search.micro_architecture": "three_cycles,two_cycles"}),
}
OBJECTIVES = tuple(FIGURES[name] for name in ("plan_time_worst_s", "slices", "power", "energy_j"))


def run() -> Iterator[dict[str, object]]:
    """A row for each study and search: median over the seeds of the share of the exact front's hypervolume."""
    platform = codesign.load_platform("virtex4-pci")
    for name, (shipped, axes) in STUDIES.items():
        workload = codesign.load_workload(shipped)
        forms = {axis: axis_form(values, axis) for axis, values in axes.items()}
        workload = exploring(workload, forms, {}, ())
        assert workload.explore is not None, "it was just given"
        kept = {axis: values for axis, values in workload.explore.axes.items() if axis in axes}
        section = workload.explore.model_copy(
            update={"objectives": OBJECTIVES, "axes": kept, "conditions": {}, "constraints": (), "when": {}}
        )
        workload = workload.model_copy(update={"explore": section})
        store = MemoryStore()
        begun = time.process_time()
        every = codesign.explore(platform, workload, workers=1, store=store)
        took = time.process_time() - begun
        yield _row(
            name, f"all {len(every.designs):,}", len(every.front), len(every.front), [], took, len(every.designs)
        )
        yield from _rows(name, every, platform, workload, store)


def _rows(
    name: str, every: Study, platform: object, workload: object, store: MemoryStore
) -> Iterator[dict[str, object]]:
    front = set(every.front)
    for search in ("random", "nsga2", "tpe", "bound"):
        traces: list[Trace] = []
        found: list[int] = []
        begun = time.process_time()
        for seed in SEEDS if search != "bound" else (0,):
            budget = Budget(points=POINTS[-1]) if search != "bound" else None
            # Searched, though all points are cheaper to compute.
            with mock.patch.object(exploration, "ENUMERATED", 0):
                study = codesign.explore(
                    platform, workload, workers=1, store=store, search=search, seed=seed, budget=budget
                )
            assert study.search is not None, "a search was named"
            traces.append(study.search.traces[0])
            found.append(len(front & set(traces[-1].designs)))
        took = (time.process_time() - begun) / len(traces)
        shares = [_shares(every, trace) for trace in traces]
        evaluated = int(median(len(trace.designs) for trace in traces))
        yield _row(name, search, int(median(found)), len(front), shares, took, evaluated)


def _shares(every: Study, trace: Trace) -> list[float]:
    """The share of the exact front's hypervolume after some numbers of evaluations."""
    scale = scale_of(every)
    whole = scale.hypervolume(costs_of(every, every.front))
    assert whole is not None, "moocore is of the extra search"
    return [(scale.hypervolume(costs_of(every, trace.designs[:count])) or 0.0) / whole for count in POINTS]


def _row(
    name: str, search: str, found: int, front: int, shares: Sequence[Sequence[float]], took: float, evaluated: int
) -> dict[str, object]:
    row: dict[str, object] = {"study": name, "search": search, "evaluated": evaluated}
    for place, count in enumerate(POINTS):
        column = sorted(each[place] for each in shares)
        row[f"at {count}"] = (
            f"{median(column):.3f} ({column[0]:.3f} to {column[-1]:.3f})" if len(column) > 1
            else f"{column[0]:.3f}" if column else "–"
        )  # fmt: skip
    return {**row, "of the front": f"{found} of {front}", "s": f"{took:.1f}"}
