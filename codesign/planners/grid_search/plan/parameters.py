"""The parameters of grid search in the mapping of a workload."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from codesign.ground.models import TaskParameters


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

    method: Annotated[
        Method,
        Field(
            description="astar, jump_point (the same lengths, fewer entries of the heap), theta_star (paths at any"
            " angle), or navfn (the potential of Nav2's default planner)"
        ),
    ] = Method.ASTAR
    heuristic: Annotated[
        Heuristic,
        Field(description="of astar and jump_point: octile, euclidean, or none, which is Dijkstra's algorithm"),
    ] = Heuristic.OCTILE
    corner_cutting: Annotated[
        bool,
        Field(
            description="of astar and jump_point: whether a diagonal step may pass the corner of an obstacle; a drive"
            " needs false"
        ),
    ] = False

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
