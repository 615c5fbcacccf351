"""docs/missions.md: its example drives, its tables name every key."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from click.testing import Result
from doc_tables import in_flow, rows, says_default
from places import ROOT

from codesign import maps
from codesign.inputs.files import data_folder
from codesign.inputs.scenario import (
    AppearingObstacle,
    Drive,
    MovingObstacle,
    Obstacles,
    RandomObstacles,
    Rectangle,
    Replan,
)

Run = Callable[..., Result]

PAGE = ROOT / "docs" / "missions.md"
BLOCK = re.compile(r"^```yaml\n# (\S+)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def mission(hwsw: Run, platform: object, workload: object, *more: object) -> Any:
    result = hwsw("run", platform, workload, "--json", "--no-levers", *more)
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
    assert told["distance_m"] >= told["shortest_m"]


def test_a_mission_that_ends_without_its_goal_is_a_result(hwsw: Run, tmp_path: Path) -> None:
    """Its table begins with why it ended."""
    for name, text in BLOCK.findall(PAGE.read_text(encoding="utf-8")):
        (tmp_path / name).write_text(text, encoding="utf-8")
    point = (tmp_path / "board.yaml", tmp_path / "rooms.yaml", "--set", "workload.scenario.limit=1 s")
    assert not mission(hwsw, *point)["reached"]
    done = hwsw("run", *point, "--no-levers", "-v")
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert lines[lines.index("Mission") + 3].startswith("ended ")


def test_the_table_has_every_key_with_its_default() -> None:
    text = PAGE.read_text(encoding="utf-8")
    begin = text.index("| key of `scenario` |")
    table = rows(text[begin : text.index("\n\n", begin)])
    wanted = {key: info for key, info in Drive.model_fields.items() if key not in {"obstacles", "replan"}}
    wanted |= {f"obstacles.{key}": info for key, info in Obstacles.model_fields.items()}
    wanted |= {f"replan.{key}": info for key, info in Replan.model_fields.items()}
    assert set(table) == set(wanted)
    for key, info in wanted.items():
        assert says_default(info, table[key][0]), key
    for key, model in (
        ("hidden", Rectangle),
        ("obstacles.appearing", AppearingObstacle),
        ("obstacles.moving", MovingObstacle),
        ("obstacles.random", RandomObstacles),
    ):
        for name, info in model.model_fields.items():
            assert re.search(rf"\b{re.escape(in_flow(info, name))}(?!\w)", table[key][1]), (key, name)


def says(text: str, value: float | None) -> bool:
    """Whether a figure of the page is that value, rounded to as many places as the page gives."""
    assert value is not None
    figure = text.replace(",", "").replace("*", "")
    return f"{value:.{len(figure.partition('.')[2])}f}" == figure


def cells_below(head: str) -> list[list[str]]:
    """The cells of each row of the table that begins with that text."""
    page = PAGE.read_text(encoding="utf-8")
    begin = page.index(head)
    lines = page[begin : page.index("\n\n", begin)].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


SHIPPED = {row[0].strip("`"): row[1:] for row in cells_below("| workload | platform | ended after |")}


def test_each_shipped_mission_has_its_row() -> None:
    drives = {
        path.stem
        for path in data_folder("workloads").glob("*.yaml")
        if re.search(r"^  type: drive$", path.read_text(encoding="utf-8"), re.MULTILINE)
    }
    assert set(SHIPPED) == drives - {"office-partition"}


@pytest.mark.slow
@pytest.mark.parametrize("workload", SHIPPED)
def test_the_row_of_a_shipped_mission_holds(hwsw: Run, workload: str) -> None:
    """Each of its figures but the lever's, and no contact or missed deadline."""
    platform, ended, replans, latency, driven, _ = SHIPPED[workload]
    told = mission(hwsw, platform.strip("`"), workload)
    assert told["reached"]
    assert says(ended.split(" s, ")[0], told["mission_time_s"])
    assert int(replans) == told["replans"]
    median, worst = latency.removesuffix(" ms").split(", ")
    assert says(median, told["replan_latency_median_s"] * 1e3)
    assert says(worst, told["replan_latency_worst_s"] * 1e3)
    length, _, ratio = driven.partition(" m")
    assert says(length, told["distance_m"])
    assert says(ratio.removeprefix(", "), told["distance_ratio"]) if ratio else told["distance_ratio"] is None
    assert (told["contacts"], told["missed_deadlines"]) == (0, 0)


@pytest.mark.slow
def test_the_partition_of_the_small_office_holds(hwsw: Run) -> None:
    """Its three rows of latencies, and its row of times and energies over AXI as it is."""
    file = yaml.safe_load((data_folder("workloads") / "office-partition.yaml").read_text(encoding="utf-8"))
    axes = file["explore"]["axes"]
    offices = file["explore"]["conditions"]["workload.problem"]
    office = f"workload.problem={json.dumps(offices[0])}"
    latencies = cells_below("| office | AXI |")[: len(axes["link.clock"])]
    wholes = cells_below("| office, AXI at 100 MHz |")[0][1:]
    for clock, (_, stated, *cells) in zip(axes["link.clock"], latencies, strict=True):
        assert stated == clock
        for variant, cell, whole in zip(axes["workload.variant"], cells, wholes, strict=True):
            values = ("--set", office, "--set", f"link.clock={clock}", "--set", f"workload.variant={variant}")
            told = mission(hwsw, "zynq", "office-partition", *values)
            assert says(cell, told["replan_latency_95_s"] * 1e3), (clock, variant)
            if clock == "100 MHz":
                time, energy = whole.replace("*", "").removesuffix(" J").split(" s, ")
                assert says(time, told["mission_time_s"]), variant
                assert says(energy, told["energy"]["mission_energy_j"]), variant


def test_the_front_of_the_partition_is_that_of_its_tables() -> None:
    """The worst, the least and the greatest over the offices of both designs of the front, at AXI as it is."""
    table = cells_below("| office | AXI |")
    latencies = [row[2:] for row in table if row[1] == "100 MHz"]
    wholes = [row[1:] for row in cells_below("| office, AXI at 100 MHz |")]
    wave, relaxation = 4, 3
    designs = {wave: "wave in fabric, track on host", relaxation: "relaxation on host"}
    rows = cells_below("| on the front |")
    assert len(rows) == len(designs)
    for (column, name), (told, *cells) in zip(designs.items(), rows, strict=False):
        assert told.startswith(name)
        of_offices = [row[column].replace("*", "").removesuffix(" J").split(" s, ") for row in wholes]
        values = [[row[column].strip("*") for row in latencies], *map(list, zip(*of_offices, strict=True))]
        for stated, listed in zip(cells, values, strict=False):
            worst, least, greatest = re.findall(r"\d(?:[\d.,]*\d)?", stated.replace("*", ""))
            numbers = [float(each.replace(",", "")) for each in listed]
            assert worst == greatest
            assert float(worst.replace(",", "")) == max(numbers)
            assert float(least) == pytest.approx(min(numbers), abs=0.5 if min(numbers) > 100 else 0)


def test_the_warehouse_is_drawn_as_its_file_says() -> None:
    free = np.ones((50, 84), np.bool_)
    for top in range(6, 43, 6):
        for left in (6, 32, 58):
            free[top : top + 2, left : left + 20] = False
    assert np.array_equal(maps.read_map(data_folder("workloads") / "maps" / "warehouse.txt").free, free)
