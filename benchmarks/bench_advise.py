"""Processor time of ``hwsw advise`` about all shipped boards: a first question about a map, and other rates after it.

The start of the command is in it. Kernels are compiled before. A first question finds an empty cache; the others find
what was settled before them.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from codesign import maps

QUESTIONS = (
    (512, "256,300", ("100Hz", "110Hz")),
    (512, "256,300", ("1kHz", "900Hz", "1100Hz")),
    (512, "256,300", ("350Hz", "400Hz")),
    (512, "256,300", ("400Hz", "420Hz")),
    (100, "52,60", ("1kHz", "1100Hz")),
    (100, "52,60", ("10kHz", "9kHz", "11kHz")),
)
"""Side of the map of rooms, the goal, and the rates that are asked for one after the other."""

BUDGET_S = 600.0


def drawn(folder: Path, side: int) -> Path:
    """A map of rooms, of 512 × 512 cells the one of the questions that are answered in the documentation."""
    file = folder / f"rooms-{side}.png"
    room = (30, 30) if side >= 200 else (14, 14)
    maps.write_image(maps.generate("rooms", rows=side, columns=side, room=room, door=4, seed=1, extra_doors=0.2), file)
    return file


def answered(file: Path, goal: str, rate: str) -> tuple[dict[str, Any], float]:
    """The answer of the command about all boards, and the seconds of processor time that it took in all."""
    begun = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = ["advise", str(file), "--goal", goal, "--rate", rate, "--budget", str(BUDGET_S), "--json"]
    asked = subprocess.run([sys.executable, "-m", "codesign", *words], capture_output=True, check=False, timeout=1800)
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = ended.ru_utime + ended.ru_stime - begun.ru_utime - begun.ru_stime
    return json.loads(asked.stdout), spent


def run() -> Iterator[dict[str, Any]]:
    """A row for each question."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["CODESIGN_CACHE_DIR"] = str(folder / "warm")
        for side in (40, 60):
            answered(drawn(folder, side), "12,6", "20kHz")
        for number, (side, goal, rates) in enumerate(QUESTIONS):
            os.environ["CODESIGN_CACHE_DIR"] = str(folder / str(number))
            for rate in rates:
                answer, spent = answered(drawn(folder, side), goal, rate)
                yield {
                    "map": f"rooms {side}×{side}",
                    "rate": rate,
                    "question": "first" if rate == rates[0] else "second",
                    "answer": answer["recommended"] or "none",
                    "state": answer["proof"]["state"],
                    "designs": f"{answer['proof']['searched']['designs']:,}",
                    "simulated": answer["simulated"],
                    "kept": answer["kept"],
                    "s of a core": f"{spent:.1f}",
                }
