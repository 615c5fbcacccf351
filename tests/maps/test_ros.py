"""Maps of ROS map_server: the rules of its pixels, faults of its YAML, and real ones."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from places import SHARED

from codesign import maps
from codesign.ground.errors import MapError
from codesign.maps import OccupancyGrid

REAL_MAPS = SHARED / "maps"
YAML = {
    "image": "map.pgm",
    "resolution": "0.05",
    "origin": "[-10.0, 2, 0.5]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


def write_ros(folder: Path, pixels: np.ndarray | None = None, **changes: str | None) -> Path:
    """A map_server map; a change to None leaves the key out."""
    if pixels is None:
        pixels = np.array([[255, 205, 0]], dtype=np.uint8)
    (folder / "map.pgm").write_bytes(b"P5\n%d %d\n255\n" % pixels.shape[::-1] + pixels.tobytes())
    path = folder / "map.yaml"
    fields = {**YAML, **changes}
    path.write_text("".join(f"{key}: {value}\n" for key, value in fields.items() if value is not None))
    return path


def drawn(grid: OccupancyGrid) -> list[str]:
    return maps.to_text(grid).split()


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
@pytest.mark.parametrize("negate", ["0", "1"])
@pytest.mark.parametrize("free_thresh", ["0.196", "0.2", "0"])
def test_ros_rules_pixel_by_pixel(tmp_path: Path, mode: str, negate: str, free_thresh: str) -> None:
    """Both thresholds fall on a pixel: 0.2 is 51/255 and 0.6 is 153/255, also as doubles."""
    pixels = np.arange(256, dtype=np.uint8).reshape(16, 16)
    path = write_ros(tmp_path, pixels, mode=mode, negate=negate, free_thresh=free_thresh, occupied_thresh="0.6")
    grid = maps.read_map(path)
    assert grid.unknown is not None
    for x in range(256):
        if mode == "raw":
            occupancy, told = Fraction(x, 100), x <= 100
        else:
            occupancy, told = Fraction(x if negate == "1" else 255 - x, 255), True
        free = told and occupancy < Fraction(free_thresh)
        between = Fraction(free_thresh) <= occupancy <= Fraction("0.6")
        assert grid.free[x // 16, x % 16] == free
        assert grid.unknown[x // 16, x % 16] == (between if mode == "trinary" else not told)


def test_gmappings_grey_is_unknown_or_free_by_the_threshold(tmp_path: Path) -> None:
    grid = maps.read_map(write_ros(tmp_path))
    assert (grid.resolution, grid.origin) == (0.05, (-10.0, 2.0, 0.5))
    assert drawn(grid) == [".##"]
    assert grid.unknown is not None
    assert grid.unknown.tolist() == [[False, True, False]]
    assert drawn(maps.read_map(tmp_path / "map.yaml", unknown_is_free=True)) == ["..#"]
    assert drawn(maps.read_map(write_ros(tmp_path, free_thresh="0.25"))) == ["..#"]


@pytest.mark.parametrize(
    ("changes", "where", "message"),
    [
        ({"resolution": "0"}, ":2:13", "resolution is 0.0"),
        ({"resolution": "-0.05"}, ":2:13", "resolution is -0.05"),
        ({"resolution": ".nan"}, ":2:13", "resolution is '.nan'"),
        ({"resolution": ".inf"}, ":2:13", "resolution is '.inf'"),
        ({"resolution": "1e999"}, ":2:13", "resolution is '1e999'"),
        ({"resolution": "12:30:00"}, ":2:13", "resolution is '12:30:00'"),
        ({"resolution": "[1]"}, ":2:13", "resolution is empty or not a single value"),
        ({"resolution": ""}, ":2:12", "resolution is empty"),
        ({"origin": "[1, 2]"}, ":3:9", "origin is not a list of three"),
        ({"origin": "{a: 1, b: 2, c: 3}"}, ":3:9", "origin is not a list of three"),
        ({"origin": "[1, 2, nan]"}, ":3:16", "origin is 'nan'"),
        ({"negate": "2"}, ":4:9", "negate is '2'"),
        ({"occupied_thresh": "1.5"}, ":5:18", "occupied_thresh is 1.5"),
        ({"free_thresh": "0.7"}, ":6:14", "free_thresh 0.7 is above occupied_thresh 0.65"),
        ({"free_thresh": None}, "", "the key free_thresh is missing"),
        ({"mode": "trinarry"}, ":7:7", "mode is 'trinarry'"),
        ({"mod": "raw"}, ":7:1", "unknown key mod"),
        ({"negate ": "1"}, ":7:1", "the key negate is given twice"),
        ({"extra": "&a [x]", "more": "*a"}, ":8:7", "aliases are not accepted"),
        ({"extra": "[" * 60000}, ":7:15", "nested too deeply"),
        ({"extra": "]"}, ":7:8", "cannot be read"),
        ({"extra": "\x01"}, "", "cannot be read"),
        ({"extra": "x" * 70000}, "", "above the limit of 65536 bytes"),
    ],
)
def test_ros_faults(tmp_path: Path, changes: dict[str, str | None], where: str, message: str) -> None:
    path = write_ros(tmp_path, **changes)
    with pytest.raises(MapError) as caught:
        maps.read_map(path)
    assert caught.value.where == f"{path}{where}"
    assert message in caught.value.what


def test_ros_takes_foreign_keys_and_old_numbers(tmp_path: Path) -> None:
    grid = maps.read_map(write_ros(tmp_path, map_author="x", resolution="5e-2", negate="false", mode="Trinary"))
    assert grid.resolution == 0.05


@pytest.mark.parametrize("image", ["none.pgm", ".", "map.yaml", '"a\\0b"', "/dev/zero"])
def test_ros_image_that_is_none_is_named(tmp_path: Path, image: str) -> None:
    with pytest.raises(MapError) as caught:
        maps.read_map(write_ros(tmp_path, image=image))
    assert caught.value.where is not None
    assert not caught.value.where.endswith("map.yaml") or image == "map.yaml"


@pytest.mark.parametrize("content", [b"x", b"- 1\n", b"\xff\xfe\xff", b"{", b"\x80", b"# nothing\n"])
def test_ros_yaml_that_is_no_mapping(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.yml").write_bytes(content)
    with pytest.raises(MapError, match=r"this is not a map_server file|cannot be read"):
        maps.read_map(tmp_path / "a.yml")


@pytest.mark.parametrize(
    ("name", "shape", "free", "unknown"),
    [
        ("turtlebot3/map.yaml", (384, 384), 7939, 138722),
        ("nav2/depot.yaml", (307, 604), 179481, 0),
        ("willow/lse_arena.yaml", (60, 80), 4455, 0),
    ],
)
def test_real_ros_maps(name: str, shape: tuple[int, int], free: int, unknown: int) -> None:
    """Counts by map_server's rule from the histogram of the pixels; depot's 205 is free with its 0.25."""
    path = REAL_MAPS / "ros" / name
    if not path.exists():
        pytest.skip("the ROS maps do not lie beside the repository")
    grid = maps.read_map(path)
    pixels = np.asarray(Image.open(next(path.parent.glob("*.pgm"))))
    occupancy = (255 - pixels.astype(float)) / 255
    free_below = 0.25 if "depot" in name else 0.196
    assert grid.shape == shape == pixels.shape
    assert grid.unknown is not None
    assert int(grid.free.sum()) == free == int((occupancy < free_below).sum())
    assert int(grid.unknown.sum()) == unknown == int(((occupancy >= free_below) & (occupancy <= 0.65)).sum())


@pytest.mark.parametrize("image", [r'"a\0b"', r'"a\ud800b"', r'"a\nb"'])
def test_an_image_name_that_no_file_has_is_refused_at_its_place(tmp_path: Path, image: str) -> None:
    with pytest.raises(MapError, match="characters that do not print") as caught:
        maps.read_map(write_ros(tmp_path, image=image))
    assert str(caught.value.where).endswith("map.yaml:1:8")
