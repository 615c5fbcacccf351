"""How long commands take to begin: medians of whole processes, with compiled kernels in the cache.

``python -m benchmarks start``. Wall time is right on an idle machine only; CPU time (user and system) on any. The share
of imports is that of the CPU time which Python spends in modules, by its own account (``-X importtime``).
"""

from __future__ import annotations

import os
import re
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

RUNS = 9
IMPORT_LINE = re.compile(rb"^import time:\s+(\d+) \|", re.MULTILINE)
EXPLORE = ("explore", "virtex4-pci", "labyrinth", "--store", "labyrinth.sqlite", "-q")
COMMANDS: tuple[tuple[str, tuple[str, ...], float | None], ...] = (
    ("Python itself", ("-c", "pass"), None),
    ("import codesign", ("-c", "import codesign"), 0.15),
    ("hwsw --version", ("-m", "codesign", "--version"), 0.25),
    ("hwsw --help", ("-m", "codesign", "--help"), 0.25),
    ("hwsw list", ("-m", "codesign", "list"), None),
    ("hwsw run virtex2pro breadth-first", ("-m", "codesign", "run", "virtex2pro", "breadth-first"), None),
    ("hwsw explore of a kept study", ("-m", "codesign", *EXPLORE), None),
)
"""What is started, its arguments to Python, and the target, s."""


def run() -> Iterator[dict[str, Any]]:
    """A row for each command."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        process_seconds(("-m", "codesign", *EXPLORE), folder)
        for what, arguments, target in COMMANDS:
            process_seconds(arguments, folder)
            walls, cpus = zip(*(process_seconds(arguments, folder) for _ in range(RUNS)), strict=True)
            yield {
                "what": what,
                "wall, ms": round(statistics.median(walls) * 1e3),
                "CPU, ms": round(statistics.median(cpus) * 1e3),
                "target, ms": "" if target is None else round(target * 1e3),
                "imports, % of CPU": round(100 * _import_share(arguments, folder)),
            }


def process_seconds(arguments: tuple[str, ...], folder: Path) -> tuple[float, float]:
    """Wall and CPU time of a process, s."""
    wall, cpu = time.perf_counter(), _cpu()
    subprocess.run([sys.executable, *arguments], cwd=folder, env=_environment(), check=True, capture_output=True)
    return time.perf_counter() - wall, _cpu() - cpu


def _cpu() -> float:
    """CPU time of all processes that were started and have ended, s."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def _import_share(arguments: tuple[str, ...], folder: Path) -> float:
    """The share of a process that modules take."""
    cpu = _cpu()
    words = [sys.executable, "-X", "importtime", *arguments]
    done = subprocess.run(words, cwd=folder, env=_environment(), check=True, capture_output=True)
    return sum(map(int, IMPORT_LINE.findall(done.stderr))) / 1e6 / (_cpu() - cpu)


def _environment() -> dict[str, str]:
    """That of this process, from which the package can be imported in another folder too."""
    paths = [str(Path(__file__).parent.parent), os.environ.get("PYTHONPATH", "")]
    return os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
