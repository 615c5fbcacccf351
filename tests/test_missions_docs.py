"""docs/missions.md: its example drives, its tables name every key."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import Result

from codesign import maps
from codesign.spec.locate import data_folder
from codesign.spec.scenario import Drive, Obstacles, Replan

Run = Callable[..., Result]

PAGE = Path(__file__).resolve().parent.parent / "docs" / "missions.md"
BLOCK = re.compile(r"^```yaml\n# (\S+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def mission(hwsw: Run, platform: object, workload: object, *more: object) -> Any:
    result = hwsw("run", platform, workload, "--json", *more)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)["mission"]


def test_the_example_arrives_past_what_it_did_not_know(hwsw: Run, tmp_path: Path) -> None:
    for name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert hwsw("check", tmp_path / "board.yaml", tmp_path / "rooms.yaml").exit_code == 0
    told = mission(hwsw, tmp_path / "board.yaml", tmp_path / "rooms.yaml")
    assert told["reached"], told["ended"]
    assert told["replans"] > 0
    assert told["contacts"] == 0
    # It drives in any direction and to anywhere in the goal's cell, the shortest way in eight and to its middle.
    assert told["distance_m"] >= told["shortest_m"] * 0.92


def test_the_tables_name_every_key() -> None:
    text = PAGE.read_text(encoding="utf-8")
    keys = re.findall(r"^\| (`[^|]*`) \|", text, re.MULTILINE)
    named = {name for key in keys for name in re.findall(r"`([\w.]+)`", key)}
    wanted = set(Drive.model_fields) - {"obstacles", "replan"}
    wanted |= {f"obstacles.{key}" for key in Obstacles.model_fields}
    wanted |= {f"replan.{key}" for key in Replan.model_fields}
    assert wanted <= named


def test_the_warehouse_is_drawn_as_its_file_says() -> None:
    free = np.ones((50, 84), np.bool_)
    for top in range(6, 43, 6):
        for left in (6, 32, 58):
            free[top : top + 2, left : left + 20] = False
    assert np.array_equal(maps.read_map(data_folder("workloads") / "maps" / "warehouse.txt").free, free)
