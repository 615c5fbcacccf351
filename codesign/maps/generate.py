"""Maps generated from a seed, with the same cells on every machine.

Mazes, rooms and the spiral share one construction: a lattice of rooms with walls between, and a choice of the walls
that have a door. Random choices use the raw 64-bit stream of PCG64 alone. numpy keeps this stream from version to
version; it does not keep the streams of ``Generator``'s methods.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError, choose_hint
from codesign.ground.late import late
from codesign.maps.grid import MAX_CELLS, OccupancyGrid, check_size

sparse = late("scipy.sparse")
csgraph = late("scipy.sparse.csgraph")

MAX_OBSTACLE = 256
"""Largest side of a random obstacle, in cells."""

Doors = tuple[NDArray[np.int64], NDArray[np.int64]]
"""Lattice indices (first, second) of the rooms beside each door. The second is right of the first, or below it."""


def empty(rows: int, columns: int) -> OccupancyGrid:
    """All cells free. The border of the map is its only wall."""
    rows, columns = _size(rows, columns)
    return OccupancyGrid(np.ones((rows, columns), dtype=np.bool_), source=f"empty({rows=}, {columns=})")


def corridor(length: int, width: int = 1) -> OccupancyGrid:
    """All cells free, ``width`` rows by ``length`` columns (the harmonic paper, section 3.2.2)."""
    length, width = _integer("length", length, 1, MAX_CELLS), _integer("width", width, 1, MAX_CELLS)
    check_size(width, length)
    return OccupancyGrid(np.ones((width, length), dtype=np.bool_), source=f"corridor({length=}, {width=})")


def maze(
    rows: int, columns: int, *, corridor: int = 1, wall: int = 1, seed: int = 0, loops: float = 0.0
) -> OccupancyGrid:
    """A maze of corridors ``corridor`` cells wide between walls ``wall`` cells thick.

    With ``loops`` 0 the maze is perfect: exactly one path between any two junctions (a random spanning tree, by
    Kruskal). ``loops`` is the share, 0 to 1, of the remaining walls that are opened too. Rows and columns at the bottom
    and at the right that hold no whole corridor are wall.

    Raises:
        MapError: a size, width or share is out of bounds, or the map is too small for one corridor.
    """
    rows, columns = _size(rows, columns)
    corridor, wall, lattice = _winding(rows, columns, corridor, wall)
    seed, loops = _integer("seed", seed, 0, 2**64 - 1), _share("loops", loops)
    free = _carve(lattice, (corridor, corridor), wall, corridor, *_spanning_doors(lattice, _stream(seed), loops))
    source = f"maze({rows=}, {columns=}, {corridor=}, {wall=}, {seed=}, {loops=})"
    return OccupancyGrid(_fill_up(free, rows, columns), source=source)


def spiral(rows: int, columns: int, *, corridor: int = 1, wall: int = 1) -> OccupancyGrid:
    """One corridor, from the top left corner clockwise to the middle: the longest path that a map can hold.

    Raises:
        MapError: a size or width is out of bounds, or the map is too small for one corridor.
    """
    rows, columns = _size(rows, columns)
    corridor, wall, lattice = _winding(rows, columns, corridor, wall)
    # The corridor takes the first row of rooms. A quarter turn of the rest puts the next side on top.
    remaining = np.arange(lattice[0] * lattice[1], dtype=np.int64).reshape(lattice)
    pieces = []
    while remaining.size:
        pieces.append(remaining[0])
        remaining = np.rot90(remaining[1:])
    order = np.concatenate(pieces)
    doors = np.minimum(order[:-1], order[1:]), np.maximum(order[:-1], order[1:])
    free = _carve(lattice, (corridor, corridor), wall, corridor, doors, None)
    source = f"spiral({rows=}, {columns=}, {corridor=}, {wall=})"
    return OccupancyGrid(_fill_up(free, rows, columns), source=source)


def rooms(
    rows: int,
    columns: int,
    *,
    room: int | tuple[int, int] = (16, 16),
    door: int = 2,
    wall: int = 1,
    seed: int = 0,
    extra_doors: float = 0.0,
) -> OccupancyGrid:
    """Rooms of ``room`` (rows, columns) cells between walls ``wall`` thick, with doors ``door`` cells wide.

    Every room can be reached: the doors form a random spanning tree. ``extra_doors`` is the share, 0 to 1, of the
    remaining walls that get a door too. Each door has a random place in its wall. Rooms of the last row and column are
    cut to the size of the map, with their doors.

    Raises:
        MapError: a size, width or share is out of bounds, or a door is wider than a room.
    """
    rows, columns = _size(rows, columns)
    height, width = _sides(room)
    door = _integer("door", door, 1, min(height, width))
    wall = _integer("wall", wall, 1, MAX_CELLS)
    seed, extra_doors = _integer("seed", seed, 0, 2**64 - 1), _share("extra_doors", extra_doors)
    lattice = -(-rows // (height + wall)), -(-columns // (width + wall))
    stream = _stream(seed)
    doors, places = _spanning_doors(lattice, stream, extra_doors)
    free = _carve(lattice, (height, width), wall, door, doors, places, (rows, columns))
    source = f"rooms({rows=}, {columns=}, room=({height}, {width}), {door=}, {wall=}, {seed=}, {extra_doors=})"
    return OccupancyGrid(free, source=source)


def random_obstacles(rows: int, columns: int, *, density: float, seed: int = 0, size: int = 1) -> OccupancyGrid:
    """Square obstacles with a side of ``size`` cells, placed at random until ``density`` of the map is covered.

    They may overlap, and extend over the border. With ``size`` 1 the covered share is ``density`` (0 to 1) rounded to
    whole cells. Otherwise the last obstacle may exceed it by less than its own area. A higher density with the same
    seed adds obstacles and removes none. Free cells need not be connected.

    Raises:
        MapError: a size or share is out of bounds.
    """
    rows, columns = _size(rows, columns)
    density, seed = _share("density", density), _integer("seed", seed, 0, 2**64 - 1)
    size = _integer("size", size, 1, min(rows, columns, MAX_OBSTACLE))
    anchors = rows + size - 1, columns + size - 1
    # Each square draws a number, and a cell keeps the least of all squares over it. Covered are the cells with the
    # least numbers, so a higher density only adds cells.
    thrown = _stream(seed)(anchors[0] * anchors[1]).reshape(anchors)
    covered_at = _sliding_minimum(_sliding_minimum(thrown, size).T, size).T
    covered = round(density * rows * columns)
    free = np.ones((rows, columns), dtype=np.bool_)
    if covered:
        free = covered_at > np.partition(covered_at, covered - 1, axis=None)[covered - 1]
    source = f"random({rows=}, {columns=}, {density=}, {seed=}, {size=})"
    return OccupancyGrid(free, source=source)


GENERATORS: Mapping[str, Callable[..., OccupancyGrid]] = MappingProxyType(
    {"maze": maze, "rooms": rooms, "random": random_obstacles, "spiral": spiral, "corridor": corridor, "empty": empty}
)
"""The generators by their names in YAML."""


def generate(kind: str, **parameters: object) -> OccupancyGrid:
    """The map of the generator named ``kind`` (a key of ``GENERATORS``).

    >>> generate("empty", rows=2, columns=3).shape
    (2, 3)

    Raises:
        MapError: the generator does not exist, or a parameter is unknown, missing or out of bounds. ``where`` is the
            name of the parameter.
    """
    if kind not in GENERATORS:
        raise MapError(f"there is no map generator {kind!r:.80}", "kind", choose_hint(str(kind), GENERATORS))
    accepted = inspect.signature(GENERATORS[kind]).parameters
    for name in parameters:
        if name not in accepted:
            raise MapError(f"{kind} has no parameter {name!r:.80}", name, choose_hint(name, accepted))
    for name, parameter in accepted.items():
        if parameter.default is parameter.empty and name not in parameters:
            raise MapError(f"{kind} needs {name}", name, f"accepted: {', '.join(accepted)}")
    return GENERATORS[kind](**parameters)


def _stream(seed: int) -> Callable[[int], NDArray[np.uint64]]:
    source = np.random.PCG64(seed)

    def draw(count: int) -> NDArray[np.uint64]:
        return np.asarray(source.random_raw(count), dtype=np.uint64)

    return draw


def _spanning_doors(
    lattice: tuple[int, int], draw: Callable[[int], NDArray[np.uint64]], extra: float
) -> tuple[Doors, NDArray[np.uint64]]:
    """Doors of a random spanning tree and of a share of the other walls, with a random place of each."""
    # The walls of the lattice: beside each other first, then one below the other. Then a random order of all.
    index = np.arange(lattice[0] * lattice[1], dtype=np.int32).reshape(lattice)
    first = np.concatenate([index[:, :-1].ravel(), index[:-1].ravel()])
    second = np.concatenate([index[:, 1:].ravel(), index[1:].ravel()])
    order = np.argsort(draw(first.size), kind="stable")
    first, second = first[order], second[order]
    # All weights differ, so the minimum spanning tree is unique, and every version of scipy finds it.
    weights = np.arange(1, first.size + 1, dtype=np.float64)
    tree = csgraph.minimum_spanning_tree(sparse.csr_array((weights, (first, second)), shape=(index.size, index.size)))
    opened = np.zeros(first.size, dtype=np.bool_)
    opened[tree.data.astype(np.int64) - 1] = True
    closed = np.flatnonzero(~opened)
    # The walls are in random order already, so the first of the rest are a random choice.
    opened[closed[: round(extra * closed.size)]] = True
    return (first[opened], second[opened]), draw(int(opened.sum()))


def _carve(
    lattice: tuple[int, int],
    room: tuple[int, int],
    wall: int,
    door: int,
    doors: Doors,
    places: NDArray[np.uint64] | None,
    size: tuple[int, int] | None = None,
) -> NDArray[np.bool_]:
    """Bool array: rooms on a lattice with walls between, and doors ``door`` wide at ``places`` (0 where None).

    ``size``: rows and columns of the map, which cut the last rooms; None if all rooms are whole.
    """
    pitch = room[0] + wall, room[1] + wall
    rows, columns = size or (lattice[0] * pitch[0] - wall, lattice[1] * pitch[1] - wall)
    # A cell is free where its row and its column both cross a room.
    free = np.outer(np.arange(rows) % pitch[0] < room[0], np.arange(columns) % pitch[1] < room[1])
    first, second = doors
    if places is None:
        places = np.zeros(first.size, dtype=np.uint64)
    beside = second == first + 1
    if lattice[1] == 1:
        beside = np.zeros_like(beside)
    # Doors to the right (axis 1), then doors down (axis 0): ``along`` their wall, and ``across`` it.
    for axis, chosen in ((1, beside), (0, ~beside)):
        along, total = 1 - axis, (rows, columns)[1 - axis]
        position = np.stack(np.divmod(first[chosen], lattice[1]))
        begin = position[along] * pitch[along]
        side = np.minimum(room[along], total - begin)
        width = np.minimum(door, side)
        begin = begin + (places[chosen] % (side - width + 1).astype(np.uint64)).astype(np.int64)
        across = position[axis] * pitch[axis] + room[axis]
        step = np.arange(door)
        # A door in a cut room is narrower: the cells beyond its width repeat the last one.
        open_along = begin[:, None, None] + np.minimum(step, width[:, None] - 1)[:, :, None]
        open_across = across[:, None, None] + np.arange(wall)[None, None, :]
        free[(open_along, open_across) if axis == 1 else (open_across, open_along)] = True
    return free


def _sliding_minimum(values: NDArray[np.uint64], size: int) -> NDArray[np.uint64]:
    """Minimum over each window of ``size`` rows. The windows double, so size 256 takes 8 passes."""
    reached = 1
    while reached < size:
        step = min(reached, size - reached)
        values = np.minimum(values[:-step], values[step:])
        reached += step
    return values


def _fill_up(free: NDArray[np.bool_], rows: int, columns: int) -> NDArray[np.bool_]:
    return np.pad(free, ((0, rows - free.shape[0]), (0, columns - free.shape[1])))


def _winding(rows: int, columns: int, corridor: int, wall: int) -> tuple[int, int, tuple[int, int]]:
    """The checked widths, and the numbers of corridors that fit into the rows and columns."""
    corridor = _integer("corridor", corridor, 1, min(rows, columns))
    wall = _integer("wall", wall, 1, MAX_CELLS)
    pitch = corridor + wall
    return corridor, wall, ((rows + wall) // pitch, (columns + wall) // pitch)


def _size(rows: object, columns: object) -> tuple[int, int]:
    checked = _integer("rows", rows, 1, None), _integer("columns", columns, 1, None)
    check_size(*checked)
    return checked


def _sides(room: object) -> tuple[int, int]:
    pair = (room, room) if isinstance(room, int) else room
    if not isinstance(pair, list | tuple) or len(pair) != 2:
        raise MapError(f"room is {room!r:.80}", "room", "give the side of a room in cells, or (rows, columns)")
    return _integer("room", pair[0], 1, MAX_CELLS), _integer("room", pair[1], 1, MAX_CELLS)


def _integer(name: str, value: object, least: int, most: int | None) -> int:
    if isinstance(value, bool) or not isinstance(value, int | np.integer):
        raise MapError(f"{name} is {value!r:.80}", name, "give a whole number, in cells (a seed: any from 0)")
    if value < least or (most is not None and value > most):
        bounds = f"at least {least}" if most is None else f"from {least} to {most}"
        raise MapError(f"{name} is {value}", name, f"it must be {bounds}")
    return int(value)


def _share(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise MapError(f"{name} is {value!r:.80}", name, "give a share from 0 to 1")
    share = float(value)
    if not (math.isfinite(share) and 0.0 <= share <= 1.0):
        raise MapError(f"{name} is {value}", name, "it must be from 0 to 1")
    return share
