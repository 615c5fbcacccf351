"""Maps of ROS map_server: a YAML file that describes how to read an image.

The rules come from nav2_map_server (map_io.cpp). ROS 1 differs for ``raw`` with ``negate``, and for transparent
pixels. So do releases of Nav2 up to Jazzy for transparent pixels in ``trinary``: they average alpha with the colours,
which makes an opaque grey lighter.
"""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError, choose_hint, nearest
from codesign.ground.late import late
from codesign.maps.files import read_bytes
from codesign.maps.grid import OccupancyGrid
from codesign.maps.images import GreyImage, decode_image

if TYPE_CHECKING:
    import yaml
else:
    yaml = late("yaml")

MAX_YAML_BYTES = 64 * 2**10
MAX_DEPTH = 8
_REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
_ACCEPTED = (*_REQUIRED, "mode")
_MODES = ("trinary", "scale", "raw")
_NUMBER = re.compile(r"[+-]?([0-9]{1,20}(\.[0-9]{0,30})?|\.[0-9]{1,30})([eE][+-]?[0-9]{1,3})?")
_TRUE = ("1", "true", "yes", "on")
_FALSE = ("0", "false", "no", "off")


@dataclass(frozen=True)
class _Description:
    image: Path
    resolution: float
    origin: tuple[float, float, float]
    negate: bool
    occupied_thresh: float
    free_thresh: float
    mode: str


def read_ros(path: str | os.PathLike[str], *, unknown_is_free: bool = False) -> OccupancyGrid:
    """The map of a map_server YAML file. Row 0 is the top of the image, ``origin`` its lower left corner.

    With x the pixel (0 to 255), p = (255 − x)/255, or x/255 with ``negate``. Above ``occupied_thresh`` p is occupied,
    below ``free_thresh`` free. Between them it is unknown (``trinary``), or neither free nor unknown (``scale``).
    ``raw`` takes x as per cent of occupancy, and values above 100 as unknown. The pixel 205 of gmapping has p =
    0.19608: unknown with a ``free_thresh`` of 0.196, free with one of 0.25. Colours are averaged. In
    ``trinary`` and ``scale`` a pixel that is not opaque is unknown, and alpha changes nothing else.

    Args:
        path: the YAML file; the path of its image is relative to it.
        unknown_is_free: let the robot enter unknown cells.

    Raises:
        MapError: a file cannot be read, or a key is missing or has a wrong value (with FILE:LINE:COLUMN).
    """
    description = _parse_yaml(read_bytes(path, MAX_YAML_BYTES), Path(path))
    image = decode_image(read_bytes(description.image), str(description.image))
    free, unknown = _classify(image, description)
    return OccupancyGrid(
        free | unknown if unknown_is_free else free,
        resolution=description.resolution,
        origin=description.origin,
        source=str(path),
        unknown=unknown,
    )


def image_of(path: str | os.PathLike[str]) -> Path:
    """The path of the image in a map_server YAML file.

    Raises:
        MapError: see ``read_ros``.
    """
    return _parse_yaml(read_bytes(path, MAX_YAML_BYTES), Path(path)).image


def _classify(image: GreyImage, description: _Description) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(free, unknown), by the rules in ``read_ros``."""
    white = image.full * image.channels
    if description.mode == "raw":
        # In mode raw a pixel is the occupancy in per cent itself.
        per_cent = np.rint(image.level * (255 / white))
        unknown = per_cent > 100
        return (per_cent / 100 < description.free_thresh) & ~unknown, unknown
    occupancy = (image.level if description.negate else white - image.level) / white
    free = occupancy < description.free_thresh
    unknown = np.zeros_like(free) if image.opacity is None else image.opacity < image.full
    if description.mode == "trinary":
        unknown |= ~free & ~(occupancy > description.occupied_thresh)
    return free & ~unknown, unknown


def _parse_yaml(content: bytes, path: Path) -> _Description:
    fields = _fields(content, str(path))
    for name in _REQUIRED:
        if name not in fields:
            raise MapError(f"the key {name} is missing", str(path), f"required: {', '.join(_REQUIRED)}")
    image = _text(fields["image"], "image", path)
    if not image.isprintable():
        what = f"image is {image!a:.60}, with characters that do not print"
        raise _fault(fields["image"], path, what, "give the path of the image file in printable characters")
    resolution = _number(fields["resolution"], "resolution", path)
    if resolution <= 0.0:
        raise _fault(fields["resolution"], path, f"resolution is {resolution}", "metres per cell, above 0")
    thresholds = []
    for name in ("free_thresh", "occupied_thresh"):
        value = _number(fields[name], name, path)
        if not 0.0 <= value <= 1.0:
            raise _fault(fields[name], path, f"{name} is {value}", "it must be from 0 to 1")
        thresholds.append(value)
    if thresholds[0] > thresholds[1]:
        what = f"free_thresh {thresholds[0]} is above occupied_thresh {thresholds[1]}"
        raise _fault(fields["free_thresh"], path, what, "lower free_thresh")
    return _Description(
        image=path.parent / image,
        resolution=resolution,
        origin=_origin(fields["origin"], path),
        negate=_choice(fields["negate"], "negate", (*_FALSE, *_TRUE), path) in _TRUE,
        occupied_thresh=thresholds[1],
        free_thresh=thresholds[0],
        mode=_choice(fields["mode"], "mode", _MODES, path) if "mode" in fields else "trinary",
    )


def _fields(content: bytes, where: str) -> dict[str, yaml.Node]:
    """Keys and value nodes of the top mapping, composed but not constructed.

    The scalars are parsed here, so that no rule of YAML 1.1 (sexagesimal, octal, dates) changes a number.
    """

    class Loader(yaml.SafeLoader):
        depth = 0

        def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
            mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
            if self.check_event(yaml.AliasEvent):
                raise yaml.MarkedYAMLError(problem="aliases are not accepted", problem_mark=mark)
            if self.depth == MAX_DEPTH:
                raise yaml.MarkedYAMLError(problem="it is nested too deeply", problem_mark=mark)
            self.depth += 1
            node = super().compose_node(parent, index)
            self.depth -= 1
            return node

    try:
        top = yaml.compose(content, Loader=Loader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = f"{where}:{mark.line + 1}:{mark.column + 1}" if mark else where
        raise MapError(f"the YAML cannot be read: {error.problem or error.context}", place) from None
    except (yaml.YAMLError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise MapError(f"the YAML cannot be read: {reason:.200}", where) from None
    if not isinstance(top, yaml.MappingNode):
        raise MapError("this is not a map_server file", where, f"required keys: {', '.join(_REQUIRED)}")
    fields: dict[str, yaml.Node] = {}
    for key, value in top.value:
        if not isinstance(key, yaml.ScalarNode):
            raise _fault(key, Path(where), "this key is not a single word")
        name = str(key.value)
        if name in fields:
            raise _fault(key, Path(where), f"the key {name:.40} is given twice", "keep one of them")
        # Mapping tools add their own keys, so only a key that looks like a misspelling is refused.
        if name not in _ACCEPTED and nearest(name, _ACCEPTED):
            raise _fault(key, Path(where), f"unknown key {name:.40}", choose_hint(name, _ACCEPTED))
        fields[name] = value
    return fields


def _fault(node: yaml.Node, path: Path, what: str, hint: str | None = None) -> MapError:
    mark = node.start_mark
    return MapError(what, f"{path}:{mark.line + 1}:{mark.column + 1}" if mark else str(path), hint)


def _text(node: yaml.Node, name: str, path: Path) -> str:
    if not isinstance(node.value, str) or not node.value:
        raise _fault(node, path, f"{name} is empty or not a single value")
    return node.value


def _number(node: yaml.Node, name: str, path: Path) -> float:
    text = _text(node, name, path)
    value = float(text) if _NUMBER.fullmatch(text) else math.nan
    if not math.isfinite(value):
        raise _fault(node, path, f"{name} is {text!r:.40}", "give a finite decimal number")
    return value


def _choice(node: yaml.Node, name: str, accepted: tuple[str, ...], path: Path) -> str:
    text = _text(node, name, path).lower()
    if text not in accepted:
        raise _fault(node, path, f"{name} is {text!r:.40}", choose_hint(text, accepted))
    return text


def _origin(node: yaml.Node, path: Path) -> tuple[float, float, float]:
    if not isinstance(node, yaml.SequenceNode) or len(node.value) != 3:
        raise _fault(node, path, "origin is not a list of three numbers", "give [x, y, yaw], in metres and rad")
    x, y, yaw = (_number(entry, "origin", path) for entry in node.value)
    return x, y, yaw
