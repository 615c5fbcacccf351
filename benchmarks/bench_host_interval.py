"""Direct timings of planners against the interval that ``hwsw calibrate host`` states, on maps that it did not fit.

A trial is one run of a plan: its program, a map, a goal and a start are drawn. The interval is the sum of units times
costs at both ends, for the processor's time; for the time on the wall it is divided by the pace, as a platform of this
host prints it. Each run is the second of two, as in the calibration.
"""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from codesign import maps
from codesign.hardware.calibrate.host_costs import MeasuredHost, measure_host
from codesign.hardware.calibrate.host_fit import Question, asked_on, plans_on, questions, time_plans
from codesign.laws.acts import UNDISTURBED, pace_of

REAL = Path(__file__).parents[1].parent / "shared" / "maps" / "movingai"
REAL_MAPS = ("cities/Berlin_0_256.map", "dao/arena.map", "mazes/maze512-32-0.map", "rooms/16room_000.map")
DRAWN: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("rooms", {"rows": 250, "columns": 260, "room": (24, 20), "door": 4, "seed": 21}),
    ("random", {"rows": 220, "columns": 240, "density": 0.25, "seed": 22}),
    ("maze", {"rows": 301, "columns": 351, "corridor": 3, "seed": 23}),
    ("empty", {"rows": 330, "columns": 310}),
    ("random", {"rows": 600, "columns": 500, "density": 0.2, "size": 3, "seed": 24}),
    ("rooms", {"rows": 130, "columns": 150, "room": (30, 30), "door": 5, "seed": 25}),
    ("maze", {"rows": 120, "columns": 130, "corridor": 5, "seed": 26}),
    ("empty", {"rows": 160, "columns": 140}),
)
TRIALS, MAPS, SECONDS = 200, 8, 30.0


def asked() -> Iterator[Question]:
    """Questions on eight maps: the real ones that are there, and drawn ones."""
    there = [file for file in REAL_MAPS if (REAL / file).is_file()]
    for number, file in enumerate(there):
        yield from asked_on(file, maps.read_map(REAL / file).free, 100 + number, 6)
    yield from questions(DRAWN[: MAPS - len(there)], 6)


def ends(host: MeasuredHost, units: Mapping[str, int]) -> tuple[float, float]:
    """The interval of the processor's time of a plan, s."""
    low, high = (sum(count * host.costs[name].interval[end] for name, count in units.items()) for end in (0, 1))
    return low, high


def run() -> list[dict[str, str]]:
    """A row for each program: trials, and the shares inside, on the processor and on the wall."""
    host = measure_host(SECONDS)
    pace = pace_of(host.disturbance.load, host.disturbance.median, host.disturbance.p99)
    assert pace is not None, "load and jitter were measured"
    quick, slow = (UNDISTURBED / end for end in reversed(pace.interval))
    plans, random = [*plans_on([*asked()], [*host.costs])], np.random.default_rng(5)
    groups: dict[tuple[str, str], list[Any]] = defaultdict(list)
    for plan in plans:
        groups[plan.program, plan.map].append(plan)
    counts: dict[str, list[tuple[bool, bool, float]]] = defaultdict(list)
    missed: dict[str, Counter[str]] = defaultdict(Counter)
    begin, programs = time.perf_counter(), sorted({program for program, _ in groups})
    for number in range(TRIALS * len(programs)):
        program = programs[number % len(programs)]
        on = sorted(name for each, name in groups if each == program)
        plan = random.choice(groups[program, on[number // len(programs) % len(on)]])
        (timing,) = time_plans([plan], 0.0, rounds=1)
        low, high = ends(host, plan.units)
        processor, wall = timing.processor[0], timing.wall[0]
        counts[program].append((low <= processor <= high, low * quick <= wall <= high * slow, high / low))
        if not counts[program][-1][1]:
            missed[program][f"{plan.map} {'below' if wall < low * quick else 'above'}"] += 1
    print(f"load {host.disturbance.load.value:.0%}, jitter to {host.disturbance.p99.value:.2f};"
          f" trials took {time.perf_counter() - begin:.0f} s")  # fmt: skip
    return [
        {
            "program": program,
            "trials": str(len(each)),
            "inside, processor": f"{np.mean([one for one, _, _ in each]):.1%}",
            "inside, wall": f"{np.mean([one for _, one, _ in each]):.1%}",
            "interval, high over low": f"{np.median([one for _, _, one in each]):.1f}",
            "missed on the wall": ", ".join(f"{name} {count}" for name, count in missed[program].items()),
        }
        for program, each in sorted(counts.items())
    ]
