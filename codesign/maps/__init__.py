"""Occupancy grids: read from files, generated from seeds, and measured (reach, distance, clearance)."""

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
from codesign.maps.images import read_image, write_image
from codesign.maps.movingai import MovingAiScenario, read_movingai, read_scenarios
from codesign.maps.reach import (
    check_cells,
    clearance,
    distance_octile,
    distance_steps,
    least_distance,
    nearest_free,
    reachable,
)
from codesign.maps.read import map_files, map_stamp, read_map
from codesign.maps.ros import read_ros
from codesign.maps.text import read_text, to_text, write_text

__all__ = [
    "GENERATORS",
    "MAX_CELLS",
    "Cell",
    "MovingAiScenario",
    "OccupancyGrid",
    "check_cells",
    "clearance",
    "corridor",
    "distance_octile",
    "distance_steps",
    "empty",
    "generate",
    "least_distance",
    "map_files",
    "map_stamp",
    "maze",
    "nearest_free",
    "random_obstacles",
    "reachable",
    "read_image",
    "read_map",
    "read_movingai",
    "read_ros",
    "read_scenarios",
    "read_text",
    "rooms",
    "spiral",
    "to_text",
    "write_image",
    "write_text",
]
