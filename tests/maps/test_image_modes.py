"""Every kind of image in every mode of map_server: what a pixel means depends on its light and its alpha alone."""

from __future__ import annotations

import io
import struct
import tracemalloc
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from codesign import maps
from codesign.ground.errors import MapError

GREYS = np.array([[0, 40, 89, 90, 128, 205, 206, 254, 255], [255, 254, 206, 205, 128, 90, 89, 40, 0]], np.uint8)
"""Around the thresholds 0.196 and 0.65 there are grey levels on both sides."""

ALPHAS = np.array([[255] * 9, [255, 254, 200, 128, 127, 50, 1, 0, 0]], np.uint8)
CLEAR = 205
"""The grey that an image without an alpha channel declares transparent."""


def saved(image: Image.Image, kind: str = "PNG", **options: object) -> bytes:
    buffer = io.BytesIO()
    image.save(buffer, format=kind, **options)
    return buffer.getvalue()


def palette(grey: np.ndarray) -> Image.Image:
    """A palette in another order than that of its greys."""
    image = Image.fromarray(255 - grey, "P")
    image.putpalette([255 - entry // 3 for entry in range(768)])
    return image


def bits_32(grey: np.ndarray, alpha: np.ndarray) -> bytes:
    """A BMP with a mask of alpha, its top row first, as GraphicsMagick writes maps with alpha."""
    rows, columns = grey.shape
    pixels = np.dstack([grey, grey, grey, alpha]).tobytes()
    masks = struct.pack("<4I", 0xFF0000, 0xFF00, 0xFF, 0xFF000000)
    head = struct.pack("<IiiHHIIiiII", 108, columns, -rows, 1, 32, 3, len(pixels), 0, 0, 0, 0) + masks
    head += bytes(108 - len(head))
    return b"BM" + struct.pack("<IHHI", 14 + len(head) + len(pixels), 0, 0, 14 + len(head)) + head + pixels


def core_header(grey: np.ndarray) -> bytes:
    """A BMP of 24 bits a pixel with the header of OS/2, its bottom row first."""
    rows, columns = grey.shape
    lines = [np.repeat(line, 3).tobytes() + bytes(-3 * columns % 4) for line in grey[::-1]]
    return b"BM" + struct.pack("<IHHIIHHHH", 26, 0, 0, 26, 12, columns, rows, 1, 24) + b"".join(lines)


def plain(head: bytes, pixels: bytes) -> bytes:
    return head + b" %d %d " % GREYS.shape[::-1] + pixels


FINE = GREYS.astype(np.uint16) * 257
SOLID = np.full_like(ALPHAS, 255)
CLEARED = np.where(GREYS == CLEAR, 0, 255).astype(np.uint8)
BLACK_WHITE = np.where(GREYS > 127, 255, 0).astype(np.uint8)
COLOURS = np.dstack([GREYS, GREYS, GREYS])

IMAGES: dict[str, tuple[bytes, np.ndarray, np.ndarray]] = {
    "PNG 1": (saved(Image.fromarray(GREYS > 127)), BLACK_WHITE, SOLID),
    "PNG L": (saved(Image.fromarray(GREYS)), GREYS, SOLID),
    "PNG P": (saved(palette(GREYS)), GREYS, SOLID),
    "PNG I;16": (saved(Image.fromarray(FINE)), GREYS, SOLID),
    "PNG LA": (saved(Image.fromarray(np.dstack([GREYS, ALPHAS]), "LA")), GREYS, ALPHAS),
    "PNG RGB": (saved(Image.fromarray(COLOURS)), GREYS, SOLID),
    "PNG RGBA": (saved(Image.fromarray(np.dstack([COLOURS, ALPHAS]))), GREYS, ALPHAS),
    "PNG 1 with tRNS": (
        saved(Image.fromarray(GREYS > 127), transparency=0), BLACK_WHITE, BLACK_WHITE,
    ),
    "PNG L with tRNS": (saved(Image.fromarray(GREYS), transparency=CLEAR), GREYS, CLEARED),
    "PNG P with tRNS": (saved(palette(GREYS), transparency=255 - CLEAR), GREYS, CLEARED),
    "PNG I;16 with tRNS": (saved(Image.fromarray(FINE), transparency=CLEAR * 257), GREYS, CLEARED),
    "PNG RGB with tRNS": (saved(Image.fromarray(COLOURS), transparency=(CLEAR,) * 3), GREYS, CLEARED),
    "BMP 1": (saved(Image.fromarray(GREYS > 127), "BMP"), BLACK_WHITE, SOLID),
    "BMP L": (saved(Image.fromarray(GREYS), "BMP"), GREYS, SOLID),
    "BMP P": (saved(palette(GREYS), "BMP"), GREYS, SOLID),
    "BMP RGB": (saved(Image.fromarray(COLOURS), "BMP"), GREYS, SOLID),
    "BMP RGBA": (bits_32(GREYS, ALPHAS), GREYS, ALPHAS),
    "BMP of OS/2": (core_header(GREYS), GREYS, SOLID),
    "PGM P5": (plain(b"P5", b"255\n" + GREYS.tobytes()), GREYS, SOLID),
    "PGM P5 of 16 bits": (plain(b"P5", b"65535\n" + FINE.astype(">u2").tobytes()), GREYS, SOLID),
    "PGM P2": (plain(b"P2", b"255 " + b" ".join(b"%d" % grey for grey in GREYS.flat)), GREYS, SOLID),
}  # fmt: skip


def meaning(grey: int, alpha: int, mode: str, negate: bool) -> str:
    """The rule of nav2_map_server, which takes alpha apart, for one pixel."""
    if mode == "raw":
        return "unknown" if grey > 100 else "free" if Fraction(grey, 100) < Fraction("0.196") else "other"
    if alpha < 255:
        return "unknown"
    occupancy = Fraction(grey if negate else 255 - grey, 255)
    if occupancy < Fraction("0.196"):
        return "free"
    return "unknown" if mode == "trinary" and occupancy <= Fraction("0.65") else "other"


@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("kind", IMAGES)
def test_every_image_mode_in_every_map_mode(tmp_path: Path, kind: str, mode: str, negate: bool) -> None:
    content, greys, alphas = IMAGES[kind]
    (tmp_path / "map.image").write_bytes(content)
    (tmp_path / "map.yaml").write_text(
        f"image: map.image\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: {int(negate)}\n"
        f"occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: {mode}\n"
    )
    expected = [meaning(int(g), int(a), mode, negate) for g, a in zip(greys.flat, alphas.flat, strict=True)]
    for blocked in (True, False):
        grid = maps.read_ros(tmp_path / "map.yaml", unknown_is_free=not blocked)
        free = [each == "free" or (each == "unknown" and not blocked) for each in expected]
        assert grid.free.ravel().tolist() == free
        assert grid.unknown is not None
        assert grid.unknown.ravel().tolist() == [each == "unknown" for each in expected]


@pytest.mark.parametrize("kind", IMAGES)
def test_a_bare_image_of_every_mode(tmp_path: Path, kind: str) -> None:
    """Less than half opaque is unknown, and so is an opaque grey of map_server; the rest is a matter of light."""
    content, greys, alphas = IMAGES[kind]
    (tmp_path / "map").write_bytes(content)
    grid = maps.read_map(tmp_path / "map")
    assert grid.free.tolist() == ((greys >= 128) & (alphas >= 128)).tolist()
    saver = np.where(greys >= 128, np.where(greys > 250, 254, CLEAR), 0).astype(np.uint8)
    if kind in ("PNG LA", "PNG RGBA", "BMP RGBA"):
        depth = 1 if kind == "PNG LA" else 3
        image = (
            bits_32(saver, alphas)
            if kind.startswith("BMP")
            else saved(Image.fromarray(np.dstack([saver] * depth + [alphas])))
        )
        (tmp_path / "map").write_bytes(image)
        grid = maps.read_map(tmp_path / "map")
        assert grid.unknown is not None
        assert grid.unknown.tolist() == ((saver == CLEAR) | (alphas < 128)).tolist()
        assert grid.free.tolist() == ((saver == 254) & (alphas >= 128)).tolist()
        assert "205" in grid.remarks[0]


MANY = 400_000
HOSTILE: dict[str, bytes] = {
    "comments in the header": b"P5\n" + b"#\n" * MANY + b"1 1\n255\n\0",
    "a comment without an end": b"P5\n" + b"#" * MANY,
    "comments and blanks": b"P5 " + b" # \n" * MANY + b"1 1 255 0",
    "blanks in the header": b"P5" + b" " * MANY + b"1 1\n255\n\0",
    "nothing but blanks": b"P2" + b"\n" * MANY,
    "a long number": b"P5\n" + b"1" * MANY,
    "comments among the pixels": b"P2\n1 1\n255\n" + b"#\n" * MANY + b"0",
    "blanks among the pixels": b"P2\n1 1\n255\n" + b" \n" * MANY + b"0",
    "too many pixels": b"P2\n1 1\n255\n" + b"1 " * MANY,
    "a long pixel": b"P2\n1 1\n255\n" + b"1" * MANY,
    "bytes behind the pixels": b"P5\n1 1\n255\n" + b"\n" * MANY,
    "lines of a MovingAI header": b"type octile\n" + b"\n" * MANY,
    "a MovingAI row": b"type octile\nheight 1\nwidth %d\nmap\n" % MANY + b"." * MANY,
    "a BMP cut off": IMAGES["BMP L"][0][:60] + b"\0" * MANY,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_map_file_takes_a_bounded_multiple_of_its_size(tmp_path: Path, name: str) -> None:
    content = HOSTILE[name]
    (tmp_path / "a").write_bytes(IMAGES["BMP L"][0])
    maps.read_map(tmp_path / "a")
    (tmp_path / "a").write_bytes(content)
    tracemalloc.start()
    try:
        with suppress(MapError):
            maps.read_map(tmp_path / "a")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2**20 + 20 * len(content), f"{peak / len(content):.0f} times its size"


@pytest.mark.parametrize("form", ["PNG", "BMP"])
def test_a_promise_of_a_billion_cells_costs_nothing(tmp_path: Path, form: str) -> None:
    content = bytearray(IMAGES[f"{form} L"][0])
    at, order = (16, ">II") if form == "PNG" else (18, "<II")
    struct.pack_into(order, content, at, 40000, 25000)
    (tmp_path / "a").write_bytes(content)
    with pytest.raises(MapError, match="1000000000 cells is above the limit"):
        maps.read_map(tmp_path / "a")


@given(
    st.integers(1, 12), st.integers(1, 12), st.integers(1, 5), st.data(),
    st.sampled_from([None, (0.0, 0.0, 0.0), (-3.0, 2.5, 0.0), (1.0, -2.0, 0.7)]),
)  # fmt: skip
@settings(max_examples=examples(100))
def test_no_step_moves_a_cell_in_metres(
    rows: int, columns: int, factor: int, data: st.DataObject, origin: tuple[float, float, float] | None
) -> None:
    """A point of the floor lies in the same cell before and after cropping, and in its coarse cell."""
    grid = maps.OccupancyGrid(np.ones((rows, columns), bool), resolution=0.05, origin=origin)
    row, column = data.draw(st.integers(0, rows - 1)), data.draw(st.integers(0, columns - 1))
    first = data.draw(st.integers(0, row)), data.draw(st.integers(0, column))
    size = (
        data.draw(st.integers(row - first[0] + 1, rows - first[0])),
        data.draw(st.integers(column - first[1] + 1, columns - first[1])),
    )
    part = maps.cropped(grid, maps.Window(*first, *size))
    coarse = maps.downsample(grid, factor)
    assert grid.frame is not None
    assert part.frame is not None
    assert coarse.frame is not None
    place = grid.frame.point(row, column)
    assert part.frame.cell(*place) == (row - first[0], column - first[1])
    assert coarse.frame.cell(*place) == (row // factor, column // factor)
