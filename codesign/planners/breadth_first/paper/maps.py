"""Families of maps that may stand for those of Vacariu et al. (2008), which are not published.

A family defines how obstacles fall, whether the closed border of the paper's Figure 2 lies inside the N × N cells, and
where start and goal are. Every row of the paper has a path, so maps without a path are thrown away. A family is no
candidate where fewer than one map in a hundred has a path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from codesign import maps
from codesign.planners.breadth_first.plan import search

FILLS = {"thrown with replacement": 1, "exact share": 1, "squares of 2 × 2": 2, "squares of 3 × 3": 3}
"""How obstacles fall, with their side in cells. Thrown with replacement, a share of d covers 1 - exp(-d)."""
PLACES = ("corners", "opposite sides", "anywhere")
FEWEST_WITH_A_PATH = 0.01
PATIENCE = 300
"""The number of maps after which a family is given up, if a smaller share than ``FEWEST_WITH_A_PATH`` had a path."""


Ends = tuple[tuple[int, int], tuple[int, int]]


@dataclass(frozen=True)
class Family:
    """The rule for maps of one share of obstacles. ``bordered``: the outermost of the N × N cells are obstacles."""

    fill: str
    bordered: bool
    place: str

    def __str__(self) -> str:
        border = "border inside" if self.bordered else "border outside"
        return f"{self.fill}, {border}, start and goal {_at(self.place)}"


def _at(place: str) -> str:
    return {"corners": "in corners", "opposite sides": "on opposite sides", "anywhere": "anywhere"}[place]


@dataclass(frozen=True, eq=False)
class Sample:
    """Searches on the maps of a family with a path: ``popped``, ``steps`` and ``spreading``, one entry a map.

    ``tried``: the number of maps drawn. ``filled``: the mean share of obstacles on the maps with a path.
    """

    popped: NDArray[np.int64]
    steps: NDArray[np.int64]
    spreading: NDArray[np.int64]
    tried: int
    filled: float


@cache
def sample(family: Family, side: int, share: float, count: int) -> Sample | None:
    """``count`` searches on maps of ``side`` × ``side`` cells; None where hardly any map has a path."""
    popped: list[int] = []
    steps: list[int] = []
    spreading: list[int] = []
    filled = 0.0
    tried = 0
    while len(popped) < count:
        if tried >= PATIENCE and len(popped) < FEWEST_WITH_A_PATH * tried:
            return None
        free, ends = _map(family, side, share, tried)
        tried += 1
        plan = search(free, *ends) if ends else None
        if plan is not None and plan.path_steps is not None:
            popped.append(plan.popped_cells)
            steps.append(plan.path_steps)
            spreading.append(plan.spreading)
            filled += 1.0 - float(free.sum()) / side**2
    return Sample(np.array(popped), np.array(steps), np.array(spreading), tried, filled / count)


def _map(family: Family, side: int, share: float, seed: int) -> tuple[NDArray[np.bool_], Ends | None]:
    """One map without its border, and its start and goal; None where one of them would lie on an obstacle."""
    inner = side - 2 * family.bordered
    density = 1.0 - math.exp(-share) if family.fill.startswith("thrown") else share
    grid = maps.random_obstacles(inner, inner, density=density, size=FILLS[family.fill], seed=seed)
    free = grid.free.copy()
    first, second = (int(word) for word in np.random.PCG64([seed, side]).random_raw(2))
    if family.place == "corners":
        # The paper draws S and G into the map: their cells are free.
        free[0, 0] = free[-1, -1] = True
        return free, ((0, 0), (inner - 1, inner - 1))
    if family.place == "opposite sides":
        start, goal = (first % inner, 0), (second % inner, inner - 1)
        return free, (start, goal) if free[start] and free[goal] else None
    cells = np.argwhere(free)
    (row, column), (goal_row, goal_column) = cells[[first % len(cells), second % len(cells)]].tolist()
    return free, ((row, column), (goal_row, goal_column))
