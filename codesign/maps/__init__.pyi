from .generate import GENERATORS, corridor, empty, generate, maze, random_obstacles, rooms, spiral
from .grid import MAX_CELLS, Cell, OccupancyGrid
from .images import read_image, write_image
from .movingai import MovingAiScenario, choose_scenarios, read_movingai, read_scenarios
from .prepare import Crop, Radius, Steps, Unknown, Window, cropped, downsample, inflate, prepare, read_prepared, window
from .reach import (
    check_cells,
    clearance,
    distance_octile,
    distance_steps,
    largest_component,
    least_distance,
    nearest_free,
    reachable,
)
from .read import map_files, map_stamp, read_map, yaml_beside
from .ros import read_ros
from .text import read_text, to_text, write_text

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
