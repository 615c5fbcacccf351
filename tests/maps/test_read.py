"""Readers: what each character and pixel means, where a fault lies, and bounds before memory."""

from __future__ import annotations

import os
import struct
import tracemalloc
import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from PIL import Image

from codesign import maps
from codesign.ground.errors import MapError
from codesign.maps import OccupancyGrid


def drawn(grid: OccupancyGrid) -> list[str]:
    return maps.to_text(grid).split()


def test_movingai_characters(tmp_path: Path) -> None:
    path = tmp_path / "a.map"
    path.write_bytes(b"type octile\r\nheight 2\r\nwidth 4\r\nmap\r\n.GS@\r\nOTW.\r\n\r\n")
    for grid in (maps.read_map(path), maps.read_movingai(path)):
        assert drawn(grid) == ["...#", "###."]
        assert grid.source == str(path)
        assert grid.resolution is None
        assert grid.unknown is None


@pytest.mark.parametrize(
    ("content", "where", "message"),
    [
        (b"type tile\nheight 1\nwidth 1\nmap\n.\n", ":1:1", "not 'type octile'"),
        (b"type octile\nheight x\nwidth 1\nmap\n.\n", ":2:1", "neither height nor width"),
        (b"type octile\nheight 1\nheight 1\nmap\n.\n", ":3:1", "neither height nor width"),
        (b"type octile\nheight -1\nwidth 1\nmap\n.\n", ":2:1", "neither height nor width"),
        (b"type octile\nheight 1\nwidth 1\n.\n", ":4", "without the line 'map'"),
        (b"type octile\nheight 1\nwidth 1\nmap\n", ":4", "without the line 'map'"),
        (b"type octile", ":1", "without the line 'map'"),
        (b"type octile\nheight 0\nwidth 1\nmap\n.\n", "", "the map is empty"),
        (b"type octile\nheight 100000\nwidth 10000\nmap\n.\n", "", "1000000000 cells is above the limit"),
        (b"type octile\nheight 3\nwidth 2\nmap\n..\n..\n", ":6", "2 rows, its header says height 3"),
        (b"type octile\nheight 1\nwidth 2\nmap\n..\n..\n", ":6", "2 rows, its header says height 1"),
        (b"type octile\nheight 1\nwidth 3\nmap\n..\n", ":5:1", "2 cells, the header says width 3"),
        (b"type octile\nheight 2\nwidth 2\nmap\n..\n...\n", ":6:3", "3 cells, the first has 2"),
        (b"type octile\nheight 2\nwidth 2\nmap\n..\n.\n", ":6:2", "1 cell, the first has 2"),
        (b"type octile\nheight 2\nwidth 2\nmap\n..\n.x\n", ":6:2", "'x' is not a cell"),
    ],
)
def test_movingai_faults(tmp_path: Path, content: bytes, where: str, message: str) -> None:
    check_fault(tmp_path / "a.map", content, where, message)


def check_fault(path: Path, content: bytes, where: str, message: str) -> None:
    path.write_bytes(content)
    with pytest.raises(MapError) as caught:
        maps.read_map(path)
    assert caught.value.where == f"{path}{where}"
    assert message in caught.value.what


def test_scenarios(tmp_path: Path) -> None:
    path = tmp_path / "a.map.scen"
    path.write_bytes(b"version 1\r\n3\tmy maps/a.map\t5\t4\t1\t2\t4\t3\t3.41421356\r\n0 b.map 5 4 0 0 0 0 0\r\n\r\n")
    first, second = maps.read_scenarios(path)
    assert first == maps.MovingAiScenario(3, "my maps/a.map", (4, 5), (2, 1), (3, 4), 3.41421356, 2)
    assert second.map_name == "b.map"
    with pytest.raises(MapError, match="scenarios, not a map"):
        maps.read_map(path)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (b"3\ta.map\t5\t4\t1\t2\t4\t3", "is not a scenario"),
        (b"3\ta.map\t5\t4\t1\t2\t4\t3\t1.0\t9", "is not a scenario"),
        (b"3\ta.map\t5\t4\t1\t-2\t4\t3\t1.0", "is not a scenario"),
        (b"3\ta.map\t5\t4\t5\t2\t4\t3\t1.0", "outside of the map of 4 × 5"),
        (b"3\ta.map\t5\t4\t1\t2\t4\t4\t1.0", "outside of the map of 4 × 5"),
        (b"3\ta.map\t5\t4\t1\t2\t4\t3\tnan", "not a number"),
        (b"3\ta.map\t5\t4\t1\t2\t4\t3\t-1", "not a number"),
        (b"3\ta.map\t5\t4\t1\t2\t4\t3\t" + b"9" * 400, "not a number"),
    ],
)
def test_scenario_faults_name_the_line(tmp_path: Path, line: bytes, message: str) -> None:
    path = tmp_path / "a.scen"
    path.write_bytes(b"version 1\n0\tb.map\t5\t4\t0\t0\t0\t0\t0\n" + line)
    with pytest.raises(MapError, match=message) as caught:
        maps.read_scenarios(path)
    assert caught.value.where == f"{path}:3"
    path.write_bytes(b"type octile\n")
    with pytest.raises(MapError, match="not 'version 1'"):
        maps.read_scenarios(path)


def test_text_characters(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"\xef\xbb\xbf. 0GS\n#@X1.\n")
    assert drawn(maps.read_map(path)) == [".....", "####."]


@pytest.mark.parametrize(
    ("content", "where", "message"),
    [
        (b"", "", "the file is empty"),
        (b"\n\n\n", "", "the map is empty"),
        (b"...\n..\n...\n", ":2:3", "2 cells, the first has 3"),
        (b"..\n\n..\n", ":2:1", "0 cells, the first has 2"),
        (b"..\n.?\n", ":2:2", "'?' is not a cell"),
        (b"..\n.\xff\n", ":2:2", r"'\xff' is not a cell"),
        (b".\n" * (2**20 + 2), "", "above the limit of 1048576 lines"),
        (b"." * (2**24 + 1), "", "above the limit of 16777216"),
    ],
)
def test_text_faults(tmp_path: Path, content: bytes, where: str, message: str) -> None:
    check_fault(tmp_path / "a.txt", content, where, message)


@given(arrays.arrays(bool, st.tuples(st.integers(1, 20), st.integers(1, 20))))
@settings(max_examples=40)
def test_what_is_written_is_read_back(tmp_path_factory: pytest.TempPathFactory, free: np.ndarray) -> None:
    grid = OccupancyGrid(free)
    folder = tmp_path_factory.getbasetemp()
    for suffix, write in ((".txt", maps.write_text), (".pgm", maps.write_image), (".png", maps.write_image)):
        path = folder / f"round-trip{suffix}"
        write(grid, path)
        assert maps.read_map(path) == grid
    assert not list(folder.glob("*.partial"))


def test_a_failed_write_leaves_what_was_there(tmp_path: Path) -> None:
    grid = maps.empty(2, 2)
    with pytest.raises(MapError, match=r"use \.png or \.pgm"):
        maps.write_image(grid, tmp_path / "a.bmp")
    for path in (tmp_path / "none" / "a.txt", tmp_path, "a\0.txt"):
        with pytest.raises(MapError, match="cannot write"):
            maps.write_text(grid, path)
    assert not list(tmp_path.iterdir())


def test_files_that_are_none(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.map")
    for path, message in (
        (tmp_path, "directory"),
        (tmp_path / "none.map", "does not exist"),
        (tmp_path / "pipe.map", "directory or a device"),
        ("nul\0.map", "cannot be read"),
        (tmp_path / ("n" * 300), "cannot be read"),
    ):
        with pytest.raises(MapError, match=message) as caught:
            maps.read_map(path)
        assert caught.value.where == str(path)


def test_a_file_above_the_limit_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "big.map"
    with path.open("wb") as file:
        file.truncate(2**26 + 1)
    with pytest.raises(MapError, match="above the limit of 67108864 bytes"):
        maps.read_map(path)


def png_chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def test_a_header_that_promises_too_much_costs_no_memory(tmp_path: Path) -> None:
    header = png_chunk(b"IHDR", struct.pack(">IIBBBBB", 40000, 25000, 8, 0, 0, 0, 0))
    bomb = b"\x89PNG\r\n\x1a\n" + header + png_chunk(b"IDAT", zlib.compress(bytes(1000)))
    promises = {
        "a.png": bomb + png_chunk(b"IEND", b""),
        "a.pgm": b"P5 40000 25000 255\n123",
        "b.pgm": b"P2 40000 25000 255\n1 2 3",
        "a.map": b"type octile\nheight 40000\nwidth 25000\nmap\n....\n",
    }
    maps.read_map(image_file(tmp_path / "warm.png", np.zeros((2, 2), dtype=np.uint8)))
    for name, content in promises.items():
        (tmp_path / name).write_bytes(content)
        tracemalloc.start()
        with pytest.raises(MapError, match="1000000000 cells is above the limit"):
            maps.read_map(tmp_path / name)
        assert tracemalloc.get_traced_memory()[1] < 2**20
        tracemalloc.stop()


def image_file(path: Path, pixels: np.ndarray, mode: str | None = None) -> Path:
    image = Image.fromarray(pixels)
    (image.convert(mode) if mode else image).save(path)
    return path


LEVELS = np.array([[0, 127, 128, 255]], dtype=np.uint8)
FINE_LEVELS = np.array([[0, 0x7FFF, 0x8081, 0xFF00]], dtype=np.uint16)


@pytest.mark.parametrize("mode", ["L", "RGB", "RGBA", "LA", "P", "16", "P5", "P5-16", "P2", "1"])
def test_light_pixels_are_free_in_every_kind_of_image(tmp_path: Path, mode: str) -> None:
    path = tmp_path / ("a.pgm" if mode.startswith("P") and mode != "P" else "a.png")
    if mode == "P5":
        path.write_bytes(b"P5#made\n# by hand\n4\t1 255\n" + LEVELS.tobytes())
    elif mode == "P5-16":
        path.write_bytes(b"P5 4 1 65535 " + FINE_LEVELS.astype(">u2").tobytes() + b"\n")
    elif mode == "P2":
        path.write_bytes(b"P2 4 1 255\n0 127 # dark\n 128\r\n255")
    elif mode == "16":
        image_file(path, FINE_LEVELS)
    elif mode == "1":
        Image.fromarray(LEVELS >= 128).save(path)
    else:
        image_file(path, LEVELS, mode)
    assert drawn(maps.read_map(path)) == ["##.."]


def test_transparent_pixels_are_unknown(tmp_path: Path) -> None:
    pixels = np.array([[[255, 255, 255, 255], [255, 255, 255, 100], [0, 0, 0, 255]]], dtype=np.uint8)
    grid = maps.read_image(image_file(tmp_path / "a.png", pixels))
    assert drawn(grid) == [".##"]
    assert grid.unknown is not None
    assert grid.unknown.tolist() == [[False, True, False]]
    # A palette or a grey level may be marked transparent without an alpha channel.
    Image.fromarray(LEVELS).save(tmp_path / "b.png", transparency=255)
    assert drawn(maps.read_image(tmp_path / "b.png")) == ["##.#"]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"P5 2 2 255\nabc", "has 3 pixels"),
        (b"P5 2 2 255\nabcdef", "has 6 pixels"),
        (b"P5 1 1 65535\na", "middle of a pixel"),
        (b"P5 1 1 70000\na", "maximum of the PGM header is '70000'"),
        (b"P5 1 1 0\na", "maximum of the PGM header is '0'"),
        (b"P5 0 1 255\na", "width of the PGM header is '0'"),
        (b"P5 2", "height of the PGM header is missing"),
        (b"P5 1_0 1 255\na", "width of the PGM header"),
        (b"P5 1 1 10\n\x0b", "a pixel of 11 is above"),
        (b"P2 2 1 255\n1 x", "not a whole number"),
        (b"P2 2 1 255\n1 -1", "not a whole number"),
        (b"P2 2 1 255\n1 256", "a pixel of 256 is above"),
        (b"P2 2 1 255\n1 " + b"9" * 400, "is above"),
        (b"P2 2 1 255\n1", "has 1 pixel,"),
        (b"P2 2 1 255\n#1 2", "has no pixel"),
        (b"P6 1 1 255\nabc", "neither PNG, BMP nor PGM"),
        (b"\x89PNG\r\n\x1a\n", "no header"),
        (b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 2, 8, 0, 0, 0, 0)), "decoded"),
        (b"GIF89a", "neither PNG, BMP nor PGM"),
    ],
)
def test_image_faults(tmp_path: Path, content: bytes, message: str) -> None:
    check_fault(tmp_path / "a.pgm", content, "", message)


def test_a_cut_png_is_refused(tmp_path: Path) -> None:
    pixels = np.random.default_rng(1).integers(0, 255, (50, 50), dtype=np.uint8)
    content = image_file(tmp_path / "whole.png", pixels).read_bytes()
    check_fault(tmp_path / "a.png", content[: len(content) // 2], "", "cannot be decoded")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le"])
def test_a_text_map_in_utf_16_is_told_to_be_one(tmp_path: Path, encoding: str) -> None:
    (tmp_path / "map.txt").write_bytes("..#\n...\n".encode(encoding))
    with pytest.raises(MapError, match="UTF-16"):
        maps.read_map(tmp_path / "map.txt")
