"""Two local processes and a cluster of two workers beside one process: the efficiency on points of 20 ms and up.

Each round computes the same points in one process, in two processes and on a cluster of a scheduler and two workers on
this machine. The clock starts when each worker is warm, and a fifth of the points is in. The scheduler and
the process that takes what comes in share the two cores with the workers. Efficiency is the time of one process over
twice the time of two; the best of the rounds counts, as other programs may take a core in any of them. Efficiency by
processor is the same of processor time over all processes: no other program moves it, and waiting does not count.
"""

from __future__ import annotations

import os
import pickle
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import psutil

import codesign
from benchmarks.local_cluster import cluster
from codesign.study import ClusterExecutor, Executor, ProcessExecutor, SerialExecutor, Space
from codesign.study.evaluation import Pricer
from codesign.study.explored import Explored
from codesign.study.partition import Work, parted
from codesign.study.work_queue import Packing

ROUNDS = int(os.environ.get("ROUNDS", "3"))
POINTS = int(os.environ.get("POINTS", "800"))
WARM = POINTS // 4

WORKLOAD = """\
kind: workload
name: mazes
planner: harmonic
problem:
  map: {generate: rooms, rows: 96, columns: 144, room: [11, 11], door: 3, seed: 1, extra_doors: 0.2}
  goals: [[5, 5]]
  starts: {count: 64, seed: 0}
mapping:
  relax: {component: fpga, block: [24, 36], iterations: 1, schedule: {first: 7, step: 8, last: 63}}
  decide: {component: fpga}
explore:
  axes:
    workload.problem.map.seed: {from: 1, to: COUNT}
"""


def works() -> tuple[list[Work], Pricer]:
    """A map of its own for each point, so that points share nothing."""
    workload = codesign.load_workload(WORKLOAD.replace("COUNT", str(POINTS + WARM)))
    explored = Explored.of(codesign.load_platform("virtex4-pci"), workload)
    space = Space(explored.section.every_axis, "")
    return list(parted(explored, space, np.arange(len(space)))), Pricer(explored, space)


@dataclass(frozen=True)
class Taken:
    """The ms of a point since the first ones came in; ``processor``: over all processes. ``whole``: seconds of all."""

    wall: float
    processor: float
    whole: float


def timed(executor: Executor, parts: list[Work], pricer: Pricer) -> Taken:
    start, begun, last = time.perf_counter(), (0.0, 0.0), (0.0, 0.0)
    cold, first = executor.workers, 0
    for came, done in enumerate(executor.run(parts, pricer), start=1):
        assert done.together
        # The first point of a worker, which loads kernels, is not timed.
        cold -= done.took_s is None
        if not first and came >= WARM and cold <= 0:
            first, begun = came, (time.perf_counter(), processor())
        elif came == len(parts):
            last = time.perf_counter(), processor()
    assert first, "a worker took no part"
    wall, own = (1e3 * (now - before) / (len(parts) - first) for now, before in zip(last, begun, strict=True))
    return Taken(wall, own, time.perf_counter() - start)


def processor() -> float:
    """The processor time of this process and of all that it began, in s."""
    here = psutil.Process()
    times = [each.cpu_times() for each in (here, *here.children(recursive=True))]
    return sum(each.user + each.system for each in times)


def rounds(executors: dict[str, Executor]) -> Iterator[dict[str, Taken]]:
    """What each executor took, round by round, with an evaluator of its own: none finds what another one computed."""
    for _ in range(ROUNDS):
        yield {name: timed(executor, *works()) for name, executor in executors.items()}


def run() -> list[Any]:
    """The rows of the table."""
    with (
        tempfile.TemporaryDirectory() as folder,
        cluster(Path(folder)) as started,
        ClusterExecutor(started.address) as executor,
    ):
        parts, pricer = works()
        list(executor.run(parts[:WARM], pricer))
        executors = {"one process": SerialExecutor(), "two processes": ProcessExecutor(2), "cluster": executor}
        taken = list(rounds(executors))
    rows = []
    for name in executors:
        workers = 1 if name == "one process" else 2
        by_wall = [each["one process"].wall / (workers * each[name].wall) for each in taken]
        by_processor = [each["one process"].processor / each[name].processor for each in taken]
        best = taken[by_wall.index(max(by_wall))][name]
        rows.append(
            {
                "case": name,
                "points": POINTS,
                "ms a point": f"{best.wall:.1f}",
                "processor ms": f"{best.processor:.1f}",
                "with start, s": f"{best.whole:.1f}",
                "efficiency": f"{max(by_wall):.2f}",
                "by processor": f"{max(by_processor):.2f}",
                "rounds": ", ".join(f"{each:.2f}" for each in by_wall),
            }
        )
    return rows + [dict.fromkeys(rows[0], "") | row for row in network()]


def network() -> list[dict[str, str]]:
    """Bytes that travel: what computes, once to each worker; works there, and outcomes back."""
    parts, pricer = works()
    some = parts[:25]
    outcomes = [*map(Packing(pricer), some)]
    sent = {"what computes, to each worker": pricer, "25 works to a worker": some, "25 outcomes back": outcomes}
    return [{"case": name, "rounds": f"{len(pickle.dumps(each, 5)):,} bytes"} for name, each in sent.items()]
