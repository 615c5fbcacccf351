"""Occupancy grids: read from files, made from seeds, and measured (reach, distance, clearance)."""

from codesign.maps.generate import (
    GENERATORS,
    corridor,
    empty,
    generate,
    maze,
    random_obstacles,
    rooms,
    spiral,
)
from codesign.maps.grid import MAX_CELLS, Cell, OccupancyGrid
from codesign.maps.reach import (
    check_cells,
    clearance,
    distance_octile,
    distance_steps,
    nearest_free,
    reachable,
)

__all__ = [
    "GENERATORS",
    "MAX_CELLS",
    "Cell",
    "OccupancyGrid",
    "check_cells",
    "clearance",
    "corridor",
    "distance_octile",
    "distance_steps",
    "empty",
    "generate",
    "maze",
    "nearest_free",
    "random_obstacles",
    "reachable",
    "rooms",
    "spiral",
]
