"""Traces: messages a second, and what tracing adds to the size of files and to the process time of each shipped run."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

import codesign
from codesign.records import TaskRecord
from codesign.trace import McapListener

LEAST_A_SECOND, MOST_BLOCKS, MOST_MISSION, MOST_SIZE = 150_000, 0.25, 0.05, 0.85

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
"""The platform of each workload, and the bytes of its trace in JSON, as version 0.1.0 wrote it."""


def messages_a_second(folder: Path) -> float:
    """Messages of tasks that are encoded and written, a second of process time: the best of several runs."""
    records = [TaskRecord(1000 * n, "host", "decide", 1000 * n + 500, 99) for n in range(100_000)]
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


def run() -> Iterator[dict[str, Any]]:
    """The pace of the writer, then each workload. The runs of a workload take turns, and the least time counts."""
    size_name = f"≤ {MOST_SIZE:.0%} of JSON"
    within_name = f"blocks ≤ +{MOST_BLOCKS:.0%}, mission ≤ +{MOST_MISSION:.0%}"
    with TemporaryDirectory() as name:
        folder = Path(name)
        pace = messages_a_second(folder)
        yield {
            "run": "100,000 tasks",
            "plain": "",
            "JSON": "",
            "blocks": f"{pace:,.0f} messages/s",
            size_name: "",
            within_name: f"≥ {LEAST_A_SECOND:,}: {pace >= LEAST_A_SECOND}",
        }
        for workload, (platform, old) in RUNS.items():
            file = folder / "run.mcap"
            cases = {"plain": (None, "blocks"), "blocks": (file, "blocks"), "mission": (file, "mission")}
            times: dict[str, list[float]] = {case: [] for case in cases}
            size = 0
            for turn in range(4):
                for case, (trace, level) in cases.items():
                    spent = _spent(workload, platform, trace, level)
                    if turn:
                        times[case].append(spent)
                    if case == "blocks":
                        size = file.stat().st_size
            least = {case: min(each) for case, each in times.items()}
            more = {case: least[case] / least["plain"] - 1 for case in least}
            within = more["blocks"] <= MOST_BLOCKS and more["mission"] <= MOST_MISSION
            yield {
                "run": workload,
                "plain": f"{least['plain']:.3f} s",
                "JSON": f"{old:,} B",
                "blocks": f"{size:,} B, {size / old:.0%}",
                size_name: "yes" if size <= MOST_SIZE * old else "no",
                within_name: (f"{more['blocks']:+.0%}, {more['mission']:+.0%}: {'yes' if within else 'no'}"),
            }
