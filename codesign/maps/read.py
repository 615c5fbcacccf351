"""Read a map of any format."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from codesign.ground.errors import MapError
from codesign.maps.files import read_bytes
from codesign.maps.grid import OccupancyGrid
from codesign.maps.images import is_image, parse_image
from codesign.maps.movingai import parse_movingai
from codesign.maps.ros import image_of, read_ros
from codesign.maps.text import parse_text

_ROS = (".yaml", ".yml")


def read_map(path: str | os.PathLike[str], *, unknown_is_free: bool = False) -> OccupancyGrid:
    """A map of any format: ROS YAML by its suffix, the others by their content.

    PNG, BMP and PGM are recognised by their first bytes, MovingAI by ``type`` (or the suffix ``.map``). All other files
    are plain text. ``unknown_is_free`` affects ROS maps alone.

    Raises:
        MapError: see the reader of the format.
    """
    suffix = Path(path).suffix.lower()
    if suffix in _ROS:
        return read_ros(path, unknown_is_free=unknown_is_free)
    where = str(path)
    content = read_bytes(path)
    if is_image(content) or suffix in (".png", ".bmp", ".pgm"):
        return parse_image(content, where)
    if content.startswith(b"type ") or suffix == ".map":
        return parse_movingai(content, where)
    if suffix == ".scen":
        raise MapError("this is a file of scenarios, not a map", where, "name the .map file that belongs to it")
    return parse_text(content, where)


def map_files(path: str | os.PathLike[str]) -> tuple[Path, ...]:
    """The files that ``read_map`` reads: the file itself and, for a ROS map, its image.

    A YAML file that cannot be read is listed alone. ``read_map`` reports its fault.
    """
    file = Path(path)
    if file.suffix.lower() not in _ROS:
        return (file,)
    try:
        return file, image_of(file)
    except MapError:
        return (file,)


def yaml_beside(path: str | os.PathLike[str]) -> Path | None:
    """The YAML of map_server that describes a bare image: of the same name, or one beside it that names the image."""
    file = Path(path)
    try:
        beside = [each for each in sorted(file.parent.iterdir())[:1000] if each.suffix.lower() in _ROS]
    except OSError:
        return None
    for each in sorted(beside, key=lambda each: each.stem != file.stem):
        with suppress(MapError):
            if image_of(each).name == file.name:
                return each
    return None


def map_stamp(path: str | os.PathLike[str]) -> tuple[tuple[str, int, int], ...]:
    """Name, modification time (ns) and size (bytes) of each of ``map_files``. The stamp changes with the map.

    A file that does not exist has time and size -1.
    """
    stamps = []
    for file in map_files(path):
        try:
            status = file.stat()
            stamps.append((str(file), status.st_mtime_ns, status.st_size))
        except (OSError, ValueError):
            stamps.append((str(file), -1, -1))
    return tuple(stamps)
