"""The occupancy grid that every reader and generator returns, and the limit of its size."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError
from codesign.ground.models import Frame

MAX_CELLS = 2**24
"""The largest map, 4096 × 4096 cells. Fields of 64-bit values over it fit in a laptop's memory."""

Cell = tuple[int, int]
"""(row, column), both counted from 0 at the top left."""


def check_size(rows: int, columns: int, where: str | None = None) -> None:
    """Refuse a map without cells or with more than ``MAX_CELLS``, before memory is allocated for it."""
    if rows < 1 or columns < 1:
        raise MapError(f"the map is empty: {rows} × {columns} cells", where, "a map needs at least one cell")
    if rows * columns > MAX_CELLS:
        what = f"{rows} × {columns} = {rows * columns} cells is above the limit of {MAX_CELLS}"
        raise MapError(what, where, "crop the map or lower its resolution")


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """The cells that a robot may enter. Row 0 is the top row of the file. All cells outside are obstacles.

    Two grids are equal where they have the same free cells (compare ``digest``), for any source.

    Attributes:
        free: bool H×W, read-only; true where the robot may be.
        resolution: metres per cell, or None where the source gives none.
        origin: (x, y, yaw) in metres and radians of the lower left corner (ROS), or None.
        source: the file, or the generator with its parameters.
        unknown: bool H×W, read-only, true where the source says unknown; None for a source without unknown cells.
        remarks: what was assumed of the source, each a sentence.

    Raises:
        MapError: not a bool H×W array, no cell, or more than ``MAX_CELLS``.
    """

    free: NDArray[np.bool_]
    resolution: float | None = None
    origin: tuple[float, float, float] | None = None
    source: str = ""
    unknown: NDArray[np.bool_] | None = None
    remarks: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "free", _read_only(self.free, self.source))
        if self.unknown is not None:
            unknown = _read_only(self.unknown, self.source)
            if unknown.shape != self.free.shape:
                raise MapError(f"unknown has shape {unknown.shape}, free has {self.free.shape}", self.source or None)
            object.__setattr__(self, "unknown", unknown)

    def __reduce__(self) -> tuple[type[OccupancyGrid], tuple[object, ...]]:
        # Pickling loses numpy's read-only flag. The constructor sets it again in a worker process.
        return type(self), (self.free, self.resolution, self.origin, self.source, self.unknown, self.remarks)

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, OccupancyGrid) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, columns)."""
        return self.rows, self.columns

    @property
    def rows(self) -> int:
        """Height in cells."""
        return int(self.free.shape[0])

    @property
    def columns(self) -> int:
        """Width in cells."""
        return int(self.free.shape[1])

    @property
    def frame(self) -> Frame | None:
        """The place of the cells in metres; None without a resolution. Without an origin, the lower left is (0, 0)."""
        if self.resolution is None:
            return None
        return Frame(self.rows, self.resolution, self.origin or (0.0, 0.0, 0.0))

    @cached_property
    def digest(self) -> str:
        """SHA-256 (hex) of the shape and the free cells, the same on every machine."""
        header = f"{self.rows}x{self.columns}:".encode()
        return hashlib.sha256(header + np.packbits(self.free).tobytes()).hexdigest()


def as_free(free: NDArray[np.bool_], where: str | None = None) -> NDArray[np.bool_]:
    """The argument as it is, once checked to be a bool H×W array of an accepted size.

    Raises:
        MapError: otherwise.
    """
    array = np.asarray(free)
    if array.ndim != 2 or array.dtype != np.bool_:
        raise MapError(f"free must be a bool array of rows × columns, not {array.dtype} of shape {array.shape}", where)
    check_size(int(array.shape[0]), int(array.shape[1]), where)
    return array


def _read_only(array: NDArray[np.bool_], source: str) -> NDArray[np.bool_]:
    copy = np.array(as_free(array, source or None), order="C")
    copy.flags.writeable = False
    return copy
