"""The parameters of grid search in the mapping of a workload."""

from __future__ import annotations

from enum import StrEnum

from pydantic import Field

from codesign.ground.models import TaskParameters

STRAIGHT, DIAGONAL = 15_994_428, 22_619_537
"""The integer lengths of a straight and of a diagonal step: their ratio is a convergent of √2 from above.

A fraction between it and √2 has a larger denominator than ``STRAIGHT``. So two paths with fewer diagonal steps than
that compare as their true lengths a + b √2 do, and equal integers are equal lengths.
"""

STEPS = ((-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (-1, 1), (1, -1), (1, 1))
"""(row, column) of a step to each side: north, south, west, east, then the diagonals. Bit n of a mask is side n."""

ANY = 8
"""The side of arrival of a source: none."""

OCTILE, EUCLIDEAN, NONE = range(3)

FREE, OPEN, CLOSED = 1, 2, 3
"""States of a free cell in ``kernels``: not seen, in the heap, expanded."""

TIE_BITS, TIE_SHIFT = 13, 26
"""A key of the heap is the length through a cell, then the estimate in these bits of these units; then the cell."""


class Method(StrEnum):
    """The search.

    - ``astar``: A* with a binary heap.
    - ``jump_point``: A* that goes from one jump point to the next: the same lengths.
    - ``theta_star``: lazy theta*: cells in sight of each other are joined by a straight piece.
    - ``navfn``: the potential that Nav2's NavFn computes, and the path down its gradient.
    """

    ASTAR = "astar"
    JUMP_POINT = "jump_point"
    THETA_STAR = "theta_star"
    NAVFN = "navfn"


class Heuristic(StrEnum):
    """The estimate of what is left, never above it: octile, Euclidean, or 0 (Dijkstra's algorithm)."""

    OCTILE = "octile"
    EUCLIDEAN = "euclidean"
    NONE = "none"


class SearchParameters(TaskParameters):
    """The search and its rules."""

    method: Method = Field(
        default=Method.ASTAR,
        description="astar, jump_point (the same lengths, fewer entries of the heap), theta_star (paths at any"
        " angle), or navfn (the potential of Nav2's default planner)",
    )
    heuristic: Heuristic = Field(
        default=Heuristic.OCTILE,
        description="of astar and jump_point: octile, euclidean, or none, which is Dijkstra's algorithm",
    )
    corner_cutting: bool = Field(
        default=False,
        description="of astar and jump_point: whether a diagonal step may pass the corner of an obstacle; a drive"
        " needs false",
    )

    @property
    def exact(self) -> bool:
        """True if the path is a shortest one of steps to the eight neighbours."""
        return self.method in {Method.ASTAR, Method.JUMP_POINT}

    @property
    def cuts(self) -> bool:
        """True if a path may pass between two obstacles that touch at a corner."""
        return self.corner_cutting and self.exact

    def unused(self, _external_memory: bool, /) -> tuple[str, ...]:
        """``theta_star`` and ``navfn`` have rules of their own."""
        return () if self.exact else ("heuristic", "corner_cutting")
