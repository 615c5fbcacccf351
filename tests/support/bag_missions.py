"""A small mission on a map of map_server with unknown cells, an origin and a yaw, and its bag."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

BOARD = """\
kind: platform
name: board
components:
  fabric: {type: fpga, part: XC7A100T-1, clock: 100 MHz}
  host:
    type: processor
    clock: 1 GHz
    costs: {occupancy_cell: 0 s, way_following: 0 s}
    power: {busy: 4 W, idle: 2 W}
  robot:
    type: robot
    radius: 0.05 m
    kinematics: {type: differential, speed: 0.4 m/s, acceleration: 1 m/s^2, turn_rate: 2 rad/s}
    sensor: {type: rays, range: 2 m, rays: 120}
    power: {moving: 10 W, standing: 3 W}
links:
  uart: {type: serial, between: [host, fabric], baud: 2000000, fifo_depth: 512}
  body: {type: serial, between: [host, robot], baud: 460800, fifo_depth: 64}
"""

MISSION = """\
kind: workload
name: yard
planner: breadth_first
problem:
  map: {file: yard-map.yaml}
  goals: [[3, 26]]
  starts: [[3, 3]]
scenario:
  type: drive
  known: all
  tour: [[16, 26], [16, 3]]
  hidden: [{row: 15, column: 20, rows: 3}]
  obstacles:
    appearing: [{at: 4 s, row: 2, column: 15, rows: 3, columns: 2, until: 60 s}]
  limit: 5 min
mapping:
  search: {component: fabric, style: state_machine, micro_architecture: three_cycles, memory: block_ram, display: none}
  track: {component: fabric}
"""

ORIGIN = (-1.5, 2.25, 0.3)


def yard() -> np.ndarray:
    """The map as map_server has it: int8, the highest row first."""
    cells = np.zeros((20, 30), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = 100, 100
    cells[7:12, 8:22] = 100
    cells[8:11, 9:21] = -1
    return cells


def write_mission(folder: Path) -> tuple[Path, Path]:
    """The files of the mission: its platform and its workload."""
    pixels = np.full(yard().shape, 205, np.uint8)
    pixels[yard() == 0], pixels[yard() == 100] = 254, 0
    rows, columns = pixels.shape
    (folder / "yard.pgm").write_bytes(f"P5\n{columns} {rows}\n255\n".encode() + pixels.tobytes())
    (folder / "yard-map.yaml").write_text(
        f"image: yard.pgm\nresolution: 0.1\norigin: {list(ORIGIN)}\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    platform, workload = folder / "board.yaml", folder / "yard.yaml"
    platform.write_text(BOARD)
    workload.write_text(MISSION)
    return platform, workload


def messages_of(bag: Path, topics: Sequence[str] = ()) -> dict[str, list[tuple[int, Any]]]:
    """(time, message) of each topic, read with the library alone."""
    from rosbags.rosbag2 import Reader
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    found: dict[str, list[tuple[int, Any]]] = defaultdict(list)
    with Reader(bag) as reader:
        for connection, time, data in reader.messages():
            if not topics or connection.topic in topics:
                found[connection.topic].append((time, store.deserialize_cdr(data, connection.msgtype)))
    return found


def cells_of(grid: Any) -> np.ndarray:
    """The cells of an OccupancyGrid, the highest row first."""
    return np.asarray(grid.data).reshape(grid.info.height, grid.info.width)[::-1]
