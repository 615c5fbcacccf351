"""Breadth-first search on a grid (Vacariu, Roman, Timar, Stanciu, Banabic and Cret 2008)."""

from codesign.planners.breadth_first.plan.search import (
    EAST,
    NEIGHBOURS,
    NORTH,
    SOUTH,
    UNKNOWN,
    WEST,
    BreadthFirstPlan,
    search,
    search_nearest,
)

__all__ = ["EAST", "NEIGHBOURS", "NORTH", "SOUTH", "UNKNOWN", "WEST", "BreadthFirstPlan", "search", "search_nearest"]
