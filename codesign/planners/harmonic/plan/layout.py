"""The places of the bit planes of the kernels in memory.

Numba's cache does not see edits in this file: ``kernels`` names the remedy.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from codesign.ground.errors import RunError

# One plane of a block, every box 8 words or more. Zeros lie in all boxes but R:
#
#   |<--- margin --->|<--- stride --->|<--- stride --->|<--- margin --->|
#   +----------------+-----+----------+-----+----------+----------------+-----
#   |                | gap | R R R R  | gap | R R R R  |                | pad
#   +----------------+-----+----------+-----+----------+----------------+-----
#                          ^ first          ^ first + stride    ^ end
#
# R: the rows of up to 64 columns, one after another. More columns make more *word columns* of one word a row; the
# margins are those west of the first and east of the last. Rows of fewer columns take as few bytes (``pitch``) as they
# and one idle column need, which is the eastern neighbour of the last column and the western of the first:
#
#   byte   0        1        2        3        4        5
#          00000000 11111111 22222222 33333333 3333.... 00000000 ..      36 columns, 5 bytes a row; '.' is idle
#
# The gap of 8 words is the row above the first and below the last. So every node has four neighbours in memory, and
# none is tested for a border.
#
# This halo may be 0 because it stands for *steps*: while a block is visited no other one steps, and what their steps
# were before has been added to r already (``kernels.push_all``).
WORD_BITS = 64
WORD_BYTES = 8
LANES = 8
# The steps of this many iterations, a *turn*, are summed at once. The ring holds a slot less, and one that stays zero.
SLOTS = 6
# Most groups that are counted as one, at the start of a stage of few bits.
SEGMENT_GROUPS, NARROW = 6, 12
# Where gains come from, as seen by the visited block: from inside, or across one of its borders.
WEST, EAST, NORTH, SOUTH, INSIDE = range(5)


class Layout(NamedTuple):
    """The places of blocks, planes and words.

    ``block_rows``, ``block_columns``: nodes of a full block. ``down``, ``across``: number of blocks. ``planes``: how
    many planes of a block there is room for; plane i of block b begins at word (b * planes + i) * plane.
    Within a plane: ``first`` is the word of row 0 in the first word column, ``words`` how many it has, a multiple of 8,
    ``pitch`` the bytes from row to row, ``stride`` leads to the next word column, ``end`` is behind the last;
    ``plane`` counts its words with all margins. ``beside``: how many words off a row goes on in another word; 0 where
    none does.
    ``each``: the segments of a word column, of ``segment`` words each, the last perhaps of fewer; ``segments``: of all.
    ``transposed``: rows and columns of the map are exchanged, so that raster order runs down the columns.
    """

    block_rows: int
    block_columns: int
    down: int
    across: int
    planes: int
    columns: int
    words: int
    pitch: int
    beside: int
    stride: int
    first: int
    end: int
    plane: int
    segment: int
    each: int
    segments: int
    transposed: bool


class State(NamedTuple):
    """The memory of the kernel: flat arrays, uint64 planes and int64 widths; in the kernel, their addresses.

    ``mask``: ones where a node is computed, one plane a block. ``residual``: r. ``odometer``: d. ``ring``: r of the
    visited block in the middle of a turn, ``SLOTS`` - 1 slots, and one slot that stays zero. ``visit``: the sums that
    the current visit adds to d.
    ``sides``: the nodes of a block that gains of a neighbour go to, a plane for each side of that neighbour.
    ``begin``, ``end``: the words of each segment of a plane.
    ``width``: planes of the step t of each segment (r has two more), and ``active`` the most of any segment of a block:
    0 where it is settled. ``odometer_width``, ``visit_width``, ``deepest``: likewise for d. Planes above a width are
    undefined, and mean zero, or the sign; where r has a sign, all segments of a block have one width.
    ``turn_width``: planes of t that a turn computes. ``read_width``: planes of t that it reads.
    ``snapshot``, ``snapshot_active``: r and its widths at an earlier sweep, to notice a start that never settles.
    """

    mask: np.ndarray
    residual: np.ndarray
    odometer: np.ndarray
    ring: np.ndarray
    visit: np.ndarray
    sides: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    width: np.ndarray
    turn_width: np.ndarray
    read_width: np.ndarray
    active: np.ndarray
    odometer_width: np.ndarray
    visit_width: np.ndarray
    deepest: np.ndarray
    snapshot: np.ndarray
    snapshot_active: np.ndarray


def make_layout(shape: tuple[int, int], block: tuple[int, int], planes: int, transposed: bool = False) -> Layout:
    """The layout of a map of ``shape`` in blocks of ``block``, with room for ``planes`` planes."""
    pitch, words = _packed(block)
    columns = -(-block[1] // WORD_BITS)
    stride = words + LANES
    # With one word column no word of the west or east is read (``planes._around``).
    margin = stride if columns > 1 else 0
    beside = stride if columns > 1 else int(WORD_BYTES % pitch > 0)
    first, end = margin + LANES, margin + columns * stride
    # An odd number of cache lines, so that planes do not fall on each other in the cache. Behind the last row there is
    # always a gap.
    groups = (end + margin) // LANES + 1 | 1
    down, across = -(-shape[0] // block[0]), -(-shape[1] // block[1])
    layout = Layout(
        *block,
        down,
        across,
        planes,
        columns,
        words,
        pitch,
        beside,
        stride,
        first,
        end,
        groups * LANES,
        0,
        0,
        0,
        transposed,
    )
    return segmented(layout, 0)


def segmented(layout: Layout, shift: int) -> Layout:
    """The layout for a stage of ``shift`` more bits: segments as long as their groups take about as many planes."""
    # Values fall by two bits from row to row, at the most and where a goal is far away: by 16 from group to group. So
    # where steps take many planes, one group takes many more than the next.
    most = SEGMENT_GROUPS if shift <= NARROW else 1
    each = -(-layout.words // (most * LANES))
    segment = -(-layout.words // (each * LANES)) * LANES
    each = -(-layout.words // segment)
    return layout._replace(segment=segment, each=each, segments=layout.columns * each)


def _packed(block: tuple[int, int]) -> tuple[int, int]:
    """The bytes from row to row, and the words of a word column.

    >>> _packed((66, 36)), _packed((96, 48)), _packed((24, 12))
    ((5, 48), (8, 96), (2, 8))
    """
    rows, columns = block
    # Without an idle column where the columns fill the word: a shift brings in zeros.
    least = min(columns // 8 + 1, WORD_BYTES)
    whole = next(pitch for pitch in (1, 2, 4, 8) if pitch >= least)
    groups = {pitch: -(-rows * pitch // (LANES * WORD_BYTES)) for pitch in (least, whole)}
    # Rows that go on in another word take two loads more, about a tenth of the time.
    pitch = least if 1.1 * groups[least] < groups[whole] else whole
    return pitch, groups[pitch] * LANES


def segment_words(layout: Layout) -> tuple[np.ndarray, np.ndarray]:
    """The first word of each segment of a plane, and the word behind its last: int64 arrays."""
    tops = layout.first + layout.stride * np.arange(layout.columns)[:, None]
    below = layout.segment * np.arange(layout.each + 1)
    begin, end = tops + below[:-1], tops + np.minimum(below[1:], layout.words)
    return begin.ravel().astype(np.int64), end.ravel().astype(np.int64)


@lru_cache(maxsize=64)
def _fixed(layout: Layout) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The arrays that every state of a layout shares, whatever its planes: ``sides``, ``begin`` and ``end``."""
    return _side_planes(layout), *segment_words(layout)


def _side_planes(layout: Layout) -> np.ndarray:
    """The nodes that gains go to: gains of the west to the last column, of the north to the last row."""
    planes = _aligned(4 * layout.plane)
    rows, columns = layout.block_rows, layout.block_columns
    bits = planes.view(np.uint8).reshape(4, -1)
    every_row, every_column = np.arange(rows), np.arange(columns)
    for side, row, column in (
        (WEST, every_row, columns - 1),
        (EAST, every_row, 0),
        (NORTH, rows - 1, every_column),
        (SOUTH, 0, every_column),
    ):
        words = layout.first + column // WORD_BITS * layout.stride
        places = words * WORD_BYTES + row * layout.pitch + column % WORD_BITS // 8
        np.bitwise_or.at(bits[side], places, (1 << column % 8) * np.ones(1, np.uint8))
    return planes


def better_transposed(block: tuple[int, int]) -> bool:
    """True if a block takes fewer vectors with its rows along the words.

    >>> better_transposed((36, 66)), better_transposed((96, 48))
    (True, False)
    """
    # The vectors of a block, either way round.
    height, width = block
    return -(-height // WORD_BITS) * _packed((width, height))[1] < -(-width // WORD_BITS) * _packed(block)[1]


def plane_bytes(shape: tuple[int, int], block: tuple[int, int]) -> int:
    """Bytes of one bit of all that is kept as planes: r and d of all blocks; the ring and d of the visited one."""
    transposed = better_transposed(block)
    if transposed:
        shape, block = shape[::-1], block[::-1]
    layout = make_layout(shape, block, 1, transposed)
    # One slot of the ring stays zero, and is never touched.
    return 8 * layout.plane * (2 * layout.down * layout.across + SLOTS)


def make_state(layout: Layout, signed: bool) -> State:
    """A state of zeros. Memory of planes that no value reaches is never touched.

    Raises RunError where the machine cannot even reserve the addresses.
    """
    blocks = layout.down * layout.across
    room = blocks * layout.planes * layout.plane
    try:
        return _zero_state(layout, blocks, room, signed)
    except MemoryError as error:
        what = f"{blocks} blocks in {layout.planes} planes take {room * 16 >> 30} GiB, more than there is"
        raise RunError(what, "block", "use larger blocks, a smaller map, or smaller steps of precision") from error


def _zero_state(layout: Layout, blocks: int, room: int, signed: bool) -> State:
    segments = layout.segments
    sides, begin, end = _fixed(layout._replace(planes=0))
    return State(
        mask=_aligned(blocks * layout.plane),
        residual=_aligned(room),
        odometer=_aligned(room),
        ring=_aligned(SLOTS * layout.planes * layout.plane),
        visit=_aligned(layout.planes * layout.plane),
        sides=sides,
        begin=begin,
        end=end,
        width=np.zeros(blocks * segments, np.int64),
        turn_width=np.zeros(segments, np.int64),
        read_width=np.zeros(segments, np.int64),
        active=np.zeros(blocks, np.int64),
        odometer_width=np.zeros(blocks * segments, np.int64),
        visit_width=np.zeros(segments, np.int64),
        deepest=np.zeros(blocks, np.int64),
        snapshot=_aligned(room if signed else 0),
        snapshot_active=np.full(blocks, -1, np.int64),
    )


def addresses(state: State) -> State:
    """The addresses of the arrays: arrays inside the kernel would have their references counted at every use."""
    return State(*(array.__array_interface__["data"][0] for array in state))


def _aligned(words: int) -> np.ndarray:
    # To cache lines: a vector across two of them takes two accesses.
    room = np.zeros(words + LANES, np.uint64)
    skip = -room.ctypes.data // 8 % LANES
    return room[skip : skip + words]
