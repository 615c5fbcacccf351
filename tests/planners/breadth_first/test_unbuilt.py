"""Design points of the search that no circuit has are refused: with the key, and what to do instead."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Run = Callable[..., Result]

TRACK_ALONE = """\
kind: workload
name: alone
planner: breadth_first
problem:
  map: {generate: empty, rows: 8, columns: 8}
  goals: [[7, 7]]
  starts: [[0, 0]]
mapping:
  search: {component: host, style: software}
  track: {component: fpga}
"""


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        (("search.external_memory=dimm", "search.display=none"), "search.external_memory"),
        (("search.memory=external", "search.external_cycles=3", "search.display=none"), "search.memory"),
    ],
)
def test_memories_outside_are_not_built(tmp_path: Path, hwsw: Run, settings: tuple[str, ...], key: str) -> None:
    words = [word for setting in settings for word in ("--set", setting)]
    done = hwsw("rtl", "virtex2pro-dimm", "breadth-first", *words, "-o", tmp_path / "design")
    assert done.exit_code == 2, done.output
    assert f"{key}: the Verilog has all memories in block RAM" in done.stderr
    assert "hint: leave external_memory out and set search.memory=block_ram" in done.stderr
    assert not (tmp_path / "design").exists()
    done = hwsw("verify", "virtex2pro-dimm", "breadth-first", *words)
    assert done.exit_code == 1
    assert "its port to a memory outside is not built" in done.output


def test_tracking_alone_is_not_built(tmp_path: Path, hwsw: Run) -> None:
    (tmp_path / "alone.yaml").write_text(TRACK_ALONE, encoding="utf-8")
    done = hwsw("rtl", "ulx3s-85f", tmp_path / "alone.yaml", "-o", tmp_path / "design")
    assert done.exit_code == 2, done.output
    assert "style 'state_machine' of task track has no circuit in Verilog" in done.stderr
    assert "task track alone is not built: place search on the FPGA too, whose circuit does both" in done.stderr
