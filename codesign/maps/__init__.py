"""Occupancy grids: read from files, generated from seeds, and measured (reach, distance, clearance)."""

from codesign.maps.generate import GENERATORS, corridor, empty, generate, maze, random_obstacles, rooms, spiral
from codesign.maps.grid import MAX_CELLS, Cell, OccupancyGrid
from codesign.maps.images import read_image, write_image
from codesign.maps.movingai import MovingAiScenario, choose_scenarios, read_movingai, read_scenarios
from codesign.maps.prepare import (
    Crop,
    Radius,
    Steps,
    Unknown,
    Window,
    cropped,
    downsample,
    inflate,
    prepare,
    read_prepared,
    window,
)
from codesign.maps.reach import (
    check_cells,
    clearance,
    distance_octile,
    distance_steps,
    largest_component,
    least_distance,
    nearest_free,
    reachable,
)
from codesign.maps.read import map_files, map_stamp, read_map, yaml_beside
from codesign.maps.ros import read_ros
from codesign.maps.text import read_text, to_text, write_text

__all__ = [
    "GENERATORS",
    "MAX_CELLS",
    "Cell",
    "Crop",
    "MovingAiScenario",
    "OccupancyGrid",
    "Radius",
    "Steps",
    "Unknown",
    "Window",
    "check_cells",
    "choose_scenarios",
    "clearance",
    "corridor",
    "cropped",
    "distance_octile",
    "distance_steps",
    "downsample",
    "empty",
    "generate",
    "inflate",
    "largest_component",
    "least_distance",
    "map_files",
    "map_stamp",
    "maze",
    "nearest_free",
    "prepare",
    "random_obstacles",
    "reachable",
    "read_image",
    "read_map",
    "read_movingai",
    "read_prepared",
    "read_ros",
    "read_scenarios",
    "read_text",
    "rooms",
    "spiral",
    "to_text",
    "window",
    "write_image",
    "write_text",
    "yaml_beside",
]
