"""Traces: messages a second, and what tracing adds to the size of files and to the process time of each shipped run.

What is asked for is of the process of each mission: ``hwsw run`` from its start to its end. Beside it stands what the
simulation alone takes, in one process for all.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import codesign
from benchmarks.bench_start import process_seconds
from codesign.ground.records import TaskRecord
from codesign.views.trace import McapListener, open_trace

LEAST_A_SECOND, MOST_BLOCKS, MOST_MISSION, MOST_SIZE = 150_000, 0.25, 0.05, 0.85
"""Messages a second, time added at both levels, and the size against JSON that are asked for."""

RUNS: dict[str, tuple[str, int]] = {
    "labyrinth": ("virtex4-pci", 388_651),
    "breadth-first": ("virtex2pro", 54_999),
    "breadth-first-java": ("pentium4-java", 37_667),
    "breadth-first-large": ("virtex2pro", 1_487_458),
    "wavefront-rooms": ("wavefront-array", 115_238),
    "wavefront-tiles": ("virtex4-pci", 134_651),
    "floor-plan": ("pc-3400mhz", 674_512),
    "floor-plan-mam": ("pc-3400mhz", 682_804),
    "office-harmonic": ("zynq", 1_075_334),
    "office-breadth-first": ("arty-a7", 1_728_073),
    "office-wavefront": ("virtex4-pci", 959_566),
    "office-relaxation": ("pc-3400mhz", 964_269),
    "office-partition": ("zynq", 1_199_324),
    "warehouse": ("virtex2pro", 820_932),
    "robots-2": ("nexys2", 140_152),
    "robots-4": ("nexys2", 151_469),
    "robots-8": ("nexys2", 182_266),
    "robots-4-fleet": ("nexys2-serial", 174_459),
    "robots-8-fleet": ("nexys2-serial", 290_609),
    "robots-64": ("nexys2-serial", 820_225),
}
"""The platform of each workload, and the bytes of its trace in JSON.

The bytes were measured by running commit f3b78b0, the last one that wrote JSON as version 0.1.0 did.
"""

MISSIONS = ("office-", "warehouse", "robots-")
PLANNED_ONCE = ("robots-2", "robots-4", "robots-8")


def messages_a_second(folder: Path) -> float:
    """Messages of tasks that are encoded and written, a second of process time: the best of several runs.

    No two tasks are equally long, as messages that repeat take less time.
    """
    records = [TaskRecord(1000 * n, "host", "decide", 1001 * n + 500, 99) for n in range(100_000)]
    best = 0.0
    for _ in range(5):
        begin = process_time()
        with McapListener(folder / "tasks.mcap") as listener:
            for record in records:
                listener(record)
        best = max(best, len(records) / (process_time() - begin))
    return best


def _spent(workload: str, platform: str, trace: Path | None, level: str) -> float:
    gc.collect()
    begin = process_time()
    codesign.simulate(platform, workload, levers=False, trace=trace, trace_level=level)
    return process_time() - begin


def _process(workload: str, platform: str, folder: Path, level: str | None) -> float:
    words = ["-m", "codesign", "run", platform, workload, "--no-levers", "-q"]
    words += [] if level is None else ["--trace", "run.mcap", "--trace-level", level]
    return process_seconds(tuple(words), folder)[1]


def processes(workload: str, platform: str, folder: Path) -> dict[str, float]:
    """The share that each level adds to the process of a mission: the least of three turns."""
    times: dict[str | None, list[float]] = {None: [], "mission": [], "blocks": []}
    for _ in range(3):
        for level, spent in times.items():
            spent.append(_process(workload, platform, folder, level))
    return {level: min(spent) / min(times[None]) - 1 for level, spent in times.items() if level is not None}


def run() -> Iterator[dict[str, Any]]:
    """The pace of the writer, then each workload. The runs of a workload take turns, and the least time counts."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        pace = messages_a_second(folder)
        yield _row("100,000 tasks", second=f"{pace:,.0f}", met=pace >= LEAST_A_SECOND)
        for workload, (platform, old) in RUNS.items():
            file = folder / "run.mcap"
            cases = {"plain": (None, "blocks"), "mission": (file, "mission"), "blocks": (file, "blocks")}
            times: dict[str, list[float]] = {case: [] for case in cases}
            for turn in range(5):
                for case, (trace, level) in cases.items():
                    spent = _spent(workload, platform, trace, level)
                    if turn:
                        times[case].append(spent)
            least = {case: min(each) for case, each in times.items()}
            more = {case: least[case] / least["plain"] - 1 for case in least}
            written, size = open_trace(file), file.stat().st_size
            mission = workload.startswith(MISSIONS) and workload not in PLANNED_ONCE
            process = processes(workload, platform, folder) if mission else {}
            yield _row(
                workload,
                plain=f"{least['plain'] * 1000:,.0f} ms",
                mission=f"{more['mission']:+.0%}",
                blocks=f"{more['blocks']:+.0%}",
                **{f"process, {level}": f"{added:+.0%}" for level, added in process.items()},
                size=f"{size / 1000:,.0f} kB",
                share=f"{size / old:.0%}",
                messages=f"{written.messages:,}",
                second=f"{written.messages / max(least['blocks'] - least['plain'], 1e-4):,.0f}",
                met=process.get("blocks", 0.0) <= MOST_BLOCKS
                and process.get("mission", 0.0) <= MOST_MISSION
                and size <= MOST_SIZE * old,
            )


def _row(run: str, *, second: str, met: bool, **texts: str) -> dict[str, Any]:
    """``second``: messages for each second of process time that tracing adds."""
    row: dict[str, Any] = {"run": run}
    names = ("plain", "mission", "blocks", "process, mission", "process, blocks", "size", "share", "messages")
    row |= {name: texts.get(name, "") for name in names}
    return row | {"messages/s": second, "all met": "yes" if met else "no"}
