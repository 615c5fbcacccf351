"""Maps of characters: plain text, and the table of cells that MovingAI maps share."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError, RunError, reason_of
from codesign.ground.files import write_atomically
from codesign.ground.units import counted
from codesign.maps.grid import OccupancyGrid, check_size

MAX_FILE_BYTES = 64 * 2**20
"""The largest map file that is read. A 16-bit image of ``MAX_CELLS`` pixels takes half of it."""

_COUNT = re.compile(rb"[0-9]{1,9}")


def read_bytes(path: str | os.PathLike[str], limit: int = MAX_FILE_BYTES) -> bytes:
    """The content of a regular file of at most ``limit`` bytes.

    Raises:
        MapError: the file does not exist, is a directory or device, cannot be read, is empty or too large.
    """
    where = str(path)
    try:
        # A pipe or a device is refused before it is opened, because opening it may block for ever.
        status = os.stat(path)
        if not stat.S_ISREG(status.st_mode):
            raise MapError("this is a directory or a device, not a file", where, "name the map file itself")
        with open(path, "rb") as file:
            # Python allocates as many bytes as it is asked to read, so no more than the file has.
            content = file.read(min(status.st_size, limit) + 1)
    except FileNotFoundError:
        raise MapError("the file does not exist", where, "check the path") from None
    except (OSError, ValueError) as error:
        raise MapError(f"the file cannot be read: {reason_of(error)}", where) from None
    if len(content) > limit:
        raise MapError(f"the file is above the limit of {limit} bytes", where, "crop or split it")
    if not content:
        raise MapError("the file is empty", where)
    return content


def write_bytes(path: str | os.PathLike[str], content: bytes) -> None:
    """Write the file as a whole, or leave the old file.

    Raises:
        MapError: the file cannot be written.
    """
    try:
        write_atomically(Path(path), content)
    except RunError as error:
        raise MapError(error.what, str(path), error.hint) from None


def parse_count(text: bytes) -> int | None:
    """A whole number of at most nine ASCII digits, without sign or underscore; None otherwise."""
    return int(text) if _COUNT.fullmatch(text) else None


def show(content: bytes) -> str:
    """Bytes of a file as printable ASCII, cut to a length that fits a message."""
    return ascii(content[:40].decode("latin-1")) + ("..." if len(content) > 40 else "")


FREE = b". 0GS"
OBSTACLE = b"#@X1"
_UTF16 = (b"\xff\xfe", b"\xfe\xff")
MAX_LINES = 2**20
"""Most lines of a text file. Each split line takes tens of bytes, even a short one."""


def read_text(path: str | os.PathLike[str]) -> OccupancyGrid:
    """A plain text map: one line per row, one character per cell, the first line on top.

    ``.``, space and ``0`` are free; ``G`` and ``S`` (marks of goals and starts) too. ``#``, ``@``, ``X`` and ``1`` are
    obstacles. Empty lines at the end are ignored.

    Raises:
        MapError: the file cannot be read, has lines of different lengths, another character, no cell or too many.
    """
    return parse_text(read_bytes(path), str(path))


def parse_text(content: bytes, where: str) -> OccupancyGrid:
    """The grid of ``read_text`` from the content of a file. ``where``: the file, for errors."""
    if content.startswith(_UTF16) or b"\0" in content[:64]:
        what = "this is not plain text of one byte a cell, but UTF-16 or a binary file"
        raise MapError(what, where, "save it as UTF-8 (or ASCII) text")
    lines = split_lines(content.removeprefix(b"\xef\xbb\xbf"), where)
    return OccupancyGrid(parse_cells(lines, FREE, OBSTACLE, where), source=where)


def to_text(grid: OccupancyGrid) -> str:
    """The map in the characters ``.`` and ``#`` of ``read_text``, with a newline after each row.

    >>> to_text(OccupancyGrid(np.array([[True, False], [True, True]])))
    '.#\\n..\\n'
    """
    cells = np.where(grid.free, ord("."), ord("#")).astype(np.uint8)
    newlines = np.full((grid.rows, 1), ord("\n"), dtype=np.uint8)
    return np.hstack([cells, newlines]).tobytes().decode("ascii")


def write_text(grid: OccupancyGrid, path: str | os.PathLike[str]) -> None:
    """Write ``to_text(grid)``. Unknown cells that are not free become obstacles.

    Raises:
        MapError: the file cannot be written.
    """
    write_bytes(path, to_text(grid).encode("ascii"))


def split_lines(content: bytes, where: str) -> list[bytes]:
    """Lines without their ends (LF or CR LF), and without empty lines at the end of the file.

    Raises:
        MapError: more than ``MAX_LINES`` lines. ``where``: the file, for the error.
    """
    if content.count(b"\n") > MAX_LINES:
        raise MapError(f"the file is above the limit of {MAX_LINES} lines", where, "crop the map")
    return content.replace(b"\r\n", b"\n").rstrip(b"\n").split(b"\n")


def parse_cells(
    lines: Sequence[bytes], free: bytes, obstacle: bytes, where: str, *, first_line: int = 1
) -> NDArray[np.bool_]:
    """Bool H×W from one line per row, all of one length.

    Args:
        lines: the rows.
        free: the characters of free cells.
        obstacle: the characters of obstacles.
        where: the file, for messages.
        first_line: number of the first of these lines in the file, for messages.

    Raises:
        MapError: lines of different lengths or another character (with FILE:LINE:COLUMN); no cell or too many.
    """
    columns = len(lines[0])
    check_size(len(lines), columns, where)
    for number, line in enumerate(lines, first_line):
        if len(line) != columns:
            column = min(len(line), columns) + 1
            what = f"this row has {counted(len(line), 'cell')}, the first has {columns}"
            hint = "give all rows the same length (blanks at the end of a line count)"
            raise MapError(what, f"{where}:{number}:{column}", hint)
    # One look-up for the whole map: 0 obstacle, 1 free, 2 any other character.
    kinds = np.full(256, 2, dtype=np.uint8)
    kinds[np.frombuffer(obstacle, dtype=np.uint8)] = 0
    kinds[np.frombuffer(free, dtype=np.uint8)] = 1
    cells = kinds[np.frombuffer(b"".join(lines), dtype=np.uint8).reshape(len(lines), columns)]
    unknown = np.argwhere(cells == 2)
    if unknown.size:
        row, column = (int(index) for index in unknown[0])
        what = f"{show(lines[row][column : column + 1])} is not a cell"
        hint = f"free: {_listed(free)}; obstacle: {_listed(obstacle)}"
        raise MapError(what, f"{where}:{first_line + row}:{column + 1}", hint)
    return cells.astype(np.bool_)


def _listed(characters: bytes) -> str:
    return " ".join("space" if character == " " else character for character in characters.decode("ascii"))
