"""Images (PGM, PNG and BMP) as integers, and maps from them.

PGM is read here. PNG and BMP are read by Pillow, after their header is checked for an accepted size.
"""

from __future__ import annotations

import io
import math
import os
import re
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import MapError, choose_hint, nearest
from codesign.ground.late import late
from codesign.ground.units import counted
from codesign.maps.grid import OccupancyGrid, check_size
from codesign.maps.text import parse_count, read_bytes, show, write_bytes

if TYPE_CHECKING:
    import yaml
    from PIL import Image
else:
    Image = late("PIL.Image")
    yaml = late("yaml")


_SIGNATURES = {"PNG": b"\x89PNG\r\n\x1a\n", "BMP": b"BM"}
# Possessive: a repetition that may be taken back remembers each comment in a hundred bytes.
_PGM_FIELD = re.compile(rb"(?:\s|#[^\n]*\n)*+([^\s#]+)")
_NOT_DECIMAL = bytes(set(range(256)) - set(b"0123456789 \t\n\r\v\f"))


@dataclass(frozen=True)
class GreyImage:
    """An image as exact integers.

    Attributes:
        level: int64 H×W, sum over the ``channels`` colour channels; 0 is black, ``channels * full`` white.
        full: the value of a channel at full light (255, 65535, ...).
        channels: 1 (grey) or 3 (colour).
        opacity: int64 H×W, 0 transparent to ``full`` opaque; None where the image has no alpha channel.
    """

    level: NDArray[np.int64]
    full: int
    channels: int
    opacity: NDArray[np.int64] | None


def read_image(path: str | os.PathLike[str]) -> OccupancyGrid:
    """A PNG, BMP or PGM as a map. Pixels of at least half light (128 of 255) are free; colours are averaged.

    Pixels that are less than half opaque are unknown, and not free. So are pixels of the grey 205 where the image looks
    like one of map_server: see ``remarks`` of the grid.

    Raises:
        MapError: the file cannot be read, is none of these, is damaged or cut, has no pixel or too many.
    """
    return parse_image(read_bytes(path), str(path))


def parse_image(content: bytes, where: str) -> OccupancyGrid:
    """The grid of ``read_image`` from the content of a file. ``where``: the file, for errors."""
    image = decode_image(content, where)
    # 128 / 255 of full light and of full opacity, compared in whole numbers.
    light = image.level * 255 >= 128 * image.full * image.channels
    opaque = None if image.opacity is None else image.opacity * 255 >= 128 * image.full
    grey = _map_server_unknown(image, opaque)
    if grey is None and opaque is None:
        return OccupancyGrid(light, source=where)
    unknown = np.zeros_like(light) if opaque is None else ~opaque
    remarks: tuple[str, ...] = ()
    if grey is not None:
        unknown |= grey
        pixels = counted(int(grey.sum()), "pixel")
        remarks = (f"it is a bare image with the greys of map_server: {pixels} of grey 205 taken as unknown",)
    return OccupancyGrid(light & ~unknown, source=where, unknown=unknown, remarks=remarks)


def _map_server_unknown(image: GreyImage, opaque: NDArray[np.bool_] | None) -> NDArray[np.bool_] | None:
    """The pixels of grey 205, which map savers write for unknown; None where the image is no map of theirs.

    It is one where 205 is the grey of most opaque pixels that are neither nearly black nor nearly white. So an edited
    map counts, and a photograph does not.
    """
    # Greys as 255ths of white, in whole numbers: 205, and all between 1 and 254.
    white = image.full * image.channels
    unknown = image.level * 255 == 205 * white
    between = (image.level * 255 > white) & (image.level * 255 < 254 * white)
    if opaque is not None:
        unknown, between = unknown & opaque, between & opaque
    return unknown if 2 * int(unknown.sum()) > int(between.sum()) else None


def is_image(content: bytes) -> bool:
    """True if the content begins like a PNG, a BMP or a netpbm image."""
    return content.startswith(tuple(_SIGNATURES.values())) or re.match(rb"P[1-7][\s#]", content) is not None


def decode_image(content: bytes, where: str) -> GreyImage:
    """The pixels of a PNG, BMP or PGM (P5 or P2, 8 or 16 bits).

    Raises:
        MapError: see ``read_image``.
    """
    for kind, signature in _SIGNATURES.items():
        if content.startswith(signature):
            return _decode_by_pillow(content, kind, where)
    if content[:2] in (b"P2", b"P5"):
        return _decode_pgm(content, where)
    what = f"the file begins with {show(content[:8])}: neither PNG, BMP nor PGM (P5, P2)"
    raise MapError(what, where, "convert it to PNG or to PGM")


def write_image(grid: OccupancyGrid, path: str | os.PathLike[str]) -> None:
    """Write a grey image that ``read_image`` reads back: free cells 255, others 0; PNG or PGM by the suffix.

    Raises:
        MapError: the suffix is another one, or the file cannot be written.
    """
    pixels = np.where(grid.free, 255, 0).astype(np.uint8)
    suffix = Path(path).suffix.lower()
    if suffix == ".pgm":
        write_bytes(path, f"P5\n{grid.columns} {grid.rows}\n255\n".encode() + pixels.tobytes())
    elif suffix == ".png":
        buffer = io.BytesIO()
        Image.fromarray(pixels).save(buffer, format="PNG")
        write_bytes(path, buffer.getvalue())
    else:
        raise MapError(f"the suffix {suffix!r:.40} names no image format", str(path), "use .png or .pgm")


def _decode_pgm(content: bytes, where: str) -> GreyImage:
    position, sizes = 2, []
    for name, limit in (("width", None), ("height", None), ("maximum", 65535)):
        field = _PGM_FIELD.match(content, position)
        value = parse_count(field[1]) if field else None
        if field is None or value is None or value < 1 or (limit and value > limit):
            text = show(field[1]) if field else "missing"
            raise MapError(f"the {name} of the PGM header is {text}", where, "the file may be cut")
        position = field.end()
        sizes.append(value)
    width, height, full = sizes
    check_size(height, width, where)
    if content[:2] == b"P5":
        # One blank ends the header. The next byte is a pixel.
        level = _binary_levels(content[position + 1 :], width * height, full, where)
    else:
        level = _text_levels(content[position:], where)
    if level.size != width * height:
        what = f"the image has {counted(level.size, 'pixel')}, its header says {height} × {width} = {width * height}"
        raise MapError(what, where, "the file may be cut, or contain more than one image")
    if int(level.max()) > full:
        raise MapError(f"a pixel of {int(level.max())} is above the image's own maximum {full}", where)
    return GreyImage(level.reshape(height, width), full, 1, None)


def _binary_levels(data: bytes, pixels: int, full: int, where: str) -> NDArray[np.int64]:
    width = 1 if full < 256 else 2
    if not data[pixels * width :].strip():
        data = data[: pixels * width]
    if len(data) % width:
        raise MapError("the image ends in the middle of a pixel", where, "the file may be cut")
    return np.frombuffer(data, dtype=np.uint8 if width == 1 else ">u2").astype(np.int64)


def _text_levels(data: bytes, where: str) -> NDArray[np.int64]:
    if b"#" in data:
        kept = bytearray()
        for line in io.BytesIO(data):
            kept += line.partition(b"#")[0] + b"\n"
        data = bytes(kept)
    if len(data.translate(None, _NOT_DECIMAL)) != len(data):
        raise MapError("a pixel of the plain PGM is not a whole number from 0", where)
    if not data.strip():
        raise MapError("the plain PGM has no pixel", where, "the file may be cut")
    # As a double, a number of a thousand digits is large and does not wrap. A pixel above the maximum is refused
    # later.
    levels = np.fromstring(data.decode("ascii"), dtype=np.float64, sep=" ")
    return np.minimum(levels, 2.0**31, out=levels).astype(np.int64)


def _decode_by_pillow(content: bytes, kind: str, where: str) -> GreyImage:
    check_size(*_declared_size(content, kind, where), where)
    try:
        with Image.open(io.BytesIO(content), formats=[kind]) as image:
            image.load()
            array, full = _pixels(image)
    except Exception as error:  # Pillow raises a dozen kinds, from zlib's to IndexError, on damaged files
        raise MapError(f"the {kind} cannot be decoded: {error!s:.200}", where, "the file may be cut") from None
    if array.ndim == 2:
        array = array[:, :, None]
    # The last of two or of four channels is the opacity.
    alpha = array.shape[2] in (2, 4)
    colours = array[:, :, :-1] if alpha else array
    opacity = array[:, :, -1].astype(np.int64) if alpha else None
    return GreyImage(colours.sum(axis=2, dtype=np.int64), full, colours.shape[2], opacity)


def _declared_size(content: bytes, kind: str, where: str) -> tuple[int, int]:
    """(rows, columns) by the header of a PNG or BMP. A BMP of negative height begins with its top row."""
    if len(content) < 26 or (kind == "PNG" and content[12:16] != b"IHDR"):
        raise MapError(f"the {kind} has no header", where, "the file may be cut or damaged")
    bitmap = "<18xHH" if content[14:18] == b"\x0c\0\0\0" else "<18xii"
    width, height = struct.unpack_from(">16xII" if kind == "PNG" else bitmap, content)
    return abs(height), abs(width)


def _pixels(image: Image.Image) -> tuple[NDArray[np.generic], int]:
    """Pixels H×W or H×W×channels, and the value of full light. Palettes and 1-bit images are expanded."""
    clear = image.info.get("transparency")
    if image.mode.startswith("I"):
        grey, full = np.asarray(image), 65535
        return (grey if clear is None else np.dstack([grey, np.where(grey == clear, 0, full)])), full
    if clear is not None:
        image = image.convert("RGBA")
    elif image.mode == "P":
        image = image.convert("RGB")
    elif image.mode == "1":
        image = image.convert("L")
    if image.mode not in ("L", "LA", "RGB", "RGBA"):
        raise ValueError(f"pixels of mode {image.mode}")
    return np.asarray(image), 255


# Maps of ROS map_server: a YAML file that describes how to read an image.
#
# The rules come from nav2_map_server (map_io.cpp). ROS 1 differs for ``raw`` with ``negate``, and for transparent
# pixels. So do releases of Nav2 up to Jazzy for transparent pixels in ``trinary``: they average alpha with the colours,
# which makes an opaque grey lighter.

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
