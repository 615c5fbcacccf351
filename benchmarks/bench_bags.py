"""ROS 2 bags: from a bag of ten minutes to a workload whose run begins."""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests" / "support"))

REPEATS = 3
MOST_SECONDS = 5.0
"""What may pass from a bag of ten minutes to the begin of its run. The table has processor times."""


def run() -> list[dict[str, Any]]:
    """A bag of 600 s with 10 scans of 360 rays a second, and 20 or 50 messages a second of odometry and transforms."""
    from recorded_bags import Hall, record

    rows = []
    for odom_rate, storage in ((20.0, "mcap"), (50.0, "mcap"), (50.0, "sqlite3")):
        with tempfile.TemporaryDirectory() as folder:
            bag = record(Path(folder) / "hall", Hall(seconds=600.0, odom_rate=odom_rate), storage)
            size = sum(path.stat().st_size for path in bag.iterdir())
            rows.append(
                {"case": f"{odom_rate:g} Hz, {storage}", "MB": f"{size / 1e6:.1f}", **_times(bag, Path(folder))}
            )
    return rows


def _times(bag: Path, folder: Path) -> dict[str, str]:
    from codesign.views.bags import Choices, Topics, facts_of, read_bag

    read, drawn = [], []
    for _ in range(REPEATS):
        begin = process_time()
        recording = read_bag(bag, Topics())
        middle = process_time()
        facts = facts_of(recording, Choices())
        read.append(middle - begin)
        drawn.append(process_time() - middle)
    starts = [_start(bag, folder / f"out-{number}") for number in range(REPEATS)]
    return {
        "reading, s": f"{min(read):.2f}",
        "obstacles, s": f"{min(drawn):.2f}",
        "obstacles": str(len(facts.obstacles.obstacles)),
        "from-bag, s": f"{min(made for made, _ in starts):.2f}",
        "begin of the run, s": f"{min(begun for _, begun in starts):.2f}",
        "share of 5 s": f"{min(sum(both) for both in starts) / MOST_SECONDS:.0%}",
    }


def _start(bag: Path, out: Path) -> tuple[float, float]:
    """Processor times of the command, and of all that a run does before it simulates (``hwsw check``)."""
    commands = (["workload", "from-bag", str(bag), "-o", str(out)], ["check", "virtex2pro", str(out / "hall.yaml")])
    times = []
    for command in commands:
        before = _of_children()
        subprocess.run([sys.executable, "-m", "codesign", *command], check=True, capture_output=True)
        times.append(_of_children() - before)
    return times[0], times[1]


def _of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
