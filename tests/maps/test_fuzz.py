"""Whatever bytes a file holds, a reader gives a grid or a MapError, and nothing else."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from examples import examples
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from PIL import Image

from codesign import maps
from codesign.ground.errors import MapError


def image(mode: str, kind: str = "PNG") -> bytes:
    pixels = np.random.default_rng(5).integers(0, 256, (6, 9), dtype=np.uint8)
    buffer = io.BytesIO()
    Image.fromarray(pixels).convert(mode).save(buffer, format=kind)
    return buffer.getvalue()


YAML = (
    b"image: map.pgm\nresolution: 0.05\norigin: [0.0, -1, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    b"free_thresh: 0.196\nmode: scale\n"
)
SEEDS = {
    "a.map": [b"type octile\nheight 2\nwidth 3\nmap\n.@T\nGSW\n"],
    "a.scen": [b"version 1\n0\ta.map\t3\t2\t0\t0\t2\t1\t2.41\n1\ta.map\t3\t2\t0\t0\t2\t1\t2.41\n"],
    "a.txt": [b"..#\n#.G\n"],
    "a.pgm": [b"P5 3 2 255\nabcdef", b"P2\n# c\n3 2 9\n1 2 3 4 5 6\n", b"P5 1 2 32000 abcd"],
    "a.png": [image("L"), image("RGBA"), image("P"), image("1"), image("I;16")],
    "a.bmp": [image("L", "BMP"), image("RGB", "BMP"), image("1", "BMP")],
    "a.yaml": [YAML],
}
FIRST_PIECES = [b"", b"\x00", b"\xff", b"\n", b"-1", b"99999999999", b"NaN", b"1e400", b"1_0", b"[", b"&a *a"]


@st.composite
def damaged(draw: st.DrawFn, originals: list[bytes]) -> bytes:
    """A good file with some stretches replaced, doubled or cut out, or bytes of no meaning at all."""
    content = draw(st.sampled_from([*originals, b""]))
    if not content:
        return draw(st.binary(max_size=200))
    for _ in range(draw(st.integers(0, 3))):
        begin = draw(st.integers(0, len(content)))
        end = min(len(content), begin + draw(st.integers(0, 12)))
        piece = draw(st.one_of(st.sampled_from([*FIRST_PIECES, content[begin:end] * 2]), st.binary(max_size=6)))
        content = content[:begin] + piece + content[end:]
    return content[: draw(st.integers(0, len(content)))] if draw(st.booleans()) else content


@pytest.mark.parametrize("name", SEEDS)
def test_only_map_errors_come_out(name: str, tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(SEEDS["a.pgm"][0])
    path = tmp_path / name
    read = maps.read_scenarios if name.endswith(".scen") else maps.read_map

    @given(damaged(SEEDS[name]))
    @example(b"\x89PNG\r\n\x1a\n")
    @settings(max_examples=examples(300), suppress_health_check=list(HealthCheck))
    def attempt(content: bytes) -> None:
        path.write_bytes(content)
        try:
            read(path)
        except MapError as error:
            fault = error
        else:
            return
        assert fault.where is not None
        assert fault.where.startswith(str(tmp_path))
        assert len(str(fault)) < 1000

    attempt()


@pytest.mark.parametrize("name", SEEDS)
def test_the_files_before_the_damage_are_good(name: str, tmp_path: Path) -> None:
    (tmp_path / "map.pgm").write_bytes(SEEDS["a.pgm"][0])
    for content in SEEDS[name]:
        (tmp_path / name).write_bytes(content)
        if name.endswith(".scen"):
            assert len(maps.read_scenarios(tmp_path / name)) == 2
        else:
            assert maps.read_map(tmp_path / name).rows in (2, 6)
