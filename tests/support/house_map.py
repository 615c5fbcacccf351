"""The map ``house`` that ships: drawn, in the form in which a map saver writes a scan.

The map is a square of 384 × 384 cells of 5 cm. The robot has seen one floor of it, inside 102 × 109 cells: rooms with
walls of one cell, and cupboards that are seen from the outside. Everything else is unknown.

``python tests/support/house_map.py`` writes both files into ``workloads/maps``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign import maps

SIDE, TOP, LEFT = 384, 133, 144
ROWS, COLUMNS = 102, 109
FREE, OCCUPIED, UNKNOWN = 254, 0, 205
ROOM, DOOR, SEED = (34, 36), 10, 5
SEEN_FROM = (2, 60)
"""The robot has seen what is joined to this cell of the floor."""
CUPBOARDS = 64
"""As many as leave about 7,900 free cells."""

DESCRIPTION = """\
# Drawn by tests/support/house_map.py, in the form in which a map saver writes a scan.
image: house.pgm
mode: trinary
resolution: 0.05
origin: [-10.0, -10.0, 0]
negate: 0
occupied_thresh: 0.65
free_thresh: 0.196
"""

FOLDER = Path(__file__).resolve().parents[2] / "workloads" / "maps"


def pixels() -> NDArray[np.uint8]:
    """The greys of the image, uint8, SIDE × SIDE."""
    rooms = maps.generate("rooms", rows=ROWS, columns=COLUMNS, room=ROOM, door=DOOR, seed=SEED, extra_doors=0.5)
    floor = np.where(rooms.free, FREE, OCCUPIED).astype(np.uint8)
    stream = np.random.PCG64(SEED)
    for _ in range(CUPBOARDS):
        high, wide, row, column = (int(word) for word in stream.random_raw(4) >> np.uint64(40))
        rows, columns = 5 + high % 6, 5 + wide % 6
        row, column = row % (ROWS - rows), column % (COLUMNS - columns)
        floor[row : row + rows, column : column + columns] = OCCUPIED
        floor[row + 1 : row + rows - 1, column + 1 : column + columns - 1] = UNKNOWN
    joined = maps.distance_steps(floor == FREE, [SEEN_FROM]) >= 0
    floor[(floor == FREE) & ~joined] = UNKNOWN
    image = np.full((SIDE, SIDE), UNKNOWN, np.uint8)
    image[TOP - 1 : TOP + ROWS + 1, LEFT - 1 : LEFT + COLUMNS + 1] = OCCUPIED
    image[TOP : TOP + ROWS, LEFT : LEFT + COLUMNS] = floor
    return image


def image() -> bytes:
    """The file ``house.pgm``."""
    return f"P5\n{SIDE} {SIDE}\n255\n".encode() + pixels().tobytes()


if __name__ == "__main__":
    (FOLDER / "house.pgm").write_bytes(image())
    (FOLDER / "house.yaml").write_text(DESCRIPTION, encoding="utf-8")
