"""A* and jump points on MovingAI maps against the fastest searches of the package index with the same path lengths.

nano-astar (C++, a heap of four children) and semita (C, jump point search; Python 3.12) take diagonal steps of √2 and
cut no corner. Each is timed where it is installed: ``pip install nano-astar semita``. The same scenarios are asked one
after the other in rounds, ours and theirs in turn; the row has the least time of a round. Times hold everything from
the map as an array to the cells of the path. Maps are read from ``shared/maps`` beside the repository.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from itertools import pairwise
from math import dist
from pathlib import Path
from typing import Any

import numpy as np

from codesign import maps
from codesign.maps.prepare import read_scenarios
from codesign.planners.grid_search.plan import Method, SearchParameters, search

REAL = Path(__file__).parents[1].parent / "shared" / "maps" / "movingai"
MAPS = ("cities/Berlin_0_256", "mazes/maze512-32-0", "rooms/16room_000", "dao/arena")
ROUNDS, QUESTIONS, BOUND = 7, 120, 1.5

Cell = tuple[int, int]
Search = Callable[[Cell, Cell], Any]


def length(path: Any) -> float:
    """The length of a path along its points, cells."""
    return sum(dist(one, other) for one, other in pairwise(np.asarray(path).tolist()))


def ours(free: Any, method: Method) -> Search:
    """A search of this package: its path."""
    parameters = SearchParameters(method=method)
    return lambda start, goal: search(free, start, [goal], parameters).path


def rivals(free: Any) -> Iterator[tuple[str, Search]]:
    """The searches of other packages that are installed."""
    if find_spec("nano_astar"):
        nano, blocked = import_module("nano_astar"), np.ascontiguousarray(~free).view(np.uint8)
        yield "nano-astar, A*", lambda start, goal: nano.astar(blocked, start, goal)[0]
    if find_spec("semita"):
        semita = import_module("semita")
        yield "semita, jump points", lambda start, goal: semita.cheapest_path(free, start, goal).tiles


def seconds(run: Search, questions: list[tuple[Cell, Cell, float]]) -> float:
    """Processor time a question."""
    begin = time.thread_time()
    for start, goal, _ in questions:
        run(start, goal)
    return (time.thread_time() - begin) / len(questions)


def run() -> Iterator[dict[str, str]]:
    """A row for each map."""
    if not REAL.is_dir():
        yield {"map": "skipped", "why": "no maps beside the repository"}
        return
    for name in MAPS:
        free = np.ascontiguousarray(maps.read_map(REAL / f"{name}.map").free)
        scenarios = read_scenarios(REAL / f"{name}.map.scen")
        chosen = scenarios[:: max(1, len(scenarios) // QUESTIONS)]
        questions = [(each.start, each.goal, each.optimal_length) for each in chosen]
        runs = {"A*": ours(free, Method.ASTAR), "jump points": ours(free, Method.JUMP_POINT), **dict(rivals(free))}
        for what, each in runs.items():
            wrong = max(abs(length(each(start, goal)) - best) / max(best, 1.0) for start, goal, best in questions)
            assert wrong < 1e-4, f"{what}: lengths differ by {wrong:.2g}"
        times = {
            what: min(column)
            for what, column in zip(
                runs,
                zip(*([seconds(each, questions) for each in runs.values()] for _ in range(ROUNDS)), strict=True),
                strict=True,
            )
        }
        row = {"map": name, "questions": str(len(questions))}
        row |= {what: f"{1e6 * value:,.0f} us" for what, value in times.items()}
        for own, other in (("A*", "nano-astar, A*"), ("jump points", "semita, jump points")):
            ratio = times[own] / times[other] if other in times else None
            text = "skipped" if ratio is None else f"{ratio:.2f} {'met' if ratio <= BOUND else 'missed'}"
            row[f"{own} / {other.split(',')[0]} (at most {BOUND})"] = text
        yield row
