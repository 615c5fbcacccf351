"""docs/architecture.md against the tree: its files exist, names stand in them, the picture is that of the levels."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest
from levels import LEVEL, ROOM_ORDER, ROOMS
from places import ROOT

PACKAGE = ROOT / "codesign"
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")

OUTSIDE = ("codesign/", "docs/", "tests/", "platforms/", "workloads/", "benchmarks/", "pyproject.toml")
"""What the page names from the root of the repository; all else is below the package."""

TOKENS = re.compile(r"`([^`\n]+)`")
ROWS = [
    tuple(cell.strip() for cell in line.strip("|").split(" | "))
    for line in PAGE.split("## Where do I change")[1].splitlines()
    if line.startswith("| ") and not line.startswith("| to add")
]
STEPS = re.findall(r"^\d\. (.+)$", PAGE, re.MULTILINE)
NEEDED = (
    "a part",
    "a sixth planner",
    "a law for a clock",
    "an objective or a constraint",
    "a figure in a result",
    "a column in the report",
    "a kind of link",
    "a key of a platform",
    "a key of a workload",
    "a map format",
    "a record in the trace",
    "a CLI option",
)


def is_path(token: str) -> bool:
    return bool(re.fullmatch(r"[\w./]+(\.py|\.md|\.toml|/|/\w+\.yaml)", token))


def files_of(token: str) -> list[Path]:
    """The files or folders that a path of the page stands for: of ``ROOM`` those of every room that has it."""
    base = ROOT if token.startswith(OUTSIDE) else PACKAGE
    named = [token.replace("ROOM", room) for room in ROOMS] if "ROOM" in token else [token]
    return [base / name for name in named if (base / name).exists()]


def unfounded(text: str) -> list[str]:
    """Paths of a text that lead nowhere, and names that stand in none of its files."""
    tokens = TOKENS.findall(text)
    paths = [token for token in tokens if is_path(token)]
    lost = [path for path in paths if not files_of(path)]
    code = "\n".join(file.read_text(encoding="utf-8") for path in paths for file in files_of(path) if file.is_file())
    names = [token for token in tokens if re.fullmatch(r"[A-Za-z_][\w.]*", token) and not is_path(token)]
    last_words = [name.rpartition(".")[2] for name in names]
    return lost + [name for name in last_words if not re.search(rf"\b{re.escape(name)}\b", code)]


def picture() -> list[list[str]]:
    """The names of each line of the picture, the lowest line first."""
    (drawn,) = re.findall(r"^```picture\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    return [line.split("│")[0].split() for line in reversed(drawn.splitlines())]


@pytest.mark.parametrize("token", sorted({token for token in TOKENS.findall(PAGE) if is_path(token)}))
def test_every_file_of_the_page_exists(token: str) -> None:
    assert files_of(token)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_every_row_names_files_and_what_stands_in_them(row: tuple[str, ...]) -> None:
    _change, files, _what = row
    assert all(is_path(token) for token in TOKENS.findall(files))
    assert unfounded(" ".join(row[1:])) == []


@pytest.mark.parametrize("step", STEPS)
def test_every_step_of_a_way_names_what_stands_in_its_files(step: str) -> None:
    keys = ("map", "fpga.clock", "clock")  # keys of YAML files, beside names of code
    assert [name for name in unfounded(step) if name not in keys] == []


def test_ways_have_seven_steps_and_the_table_answers_what_is_asked() -> None:
    assert len(STEPS) == 14
    assert set(NEEDED) <= {row[0] for row in ROWS}


def test_every_row_has_a_toy_and_every_toy_a_row() -> None:
    places = [*(ROOT / "tests" / "recipes").glob("*.py"), ROOT / "tests" / "planners" / "test_sixth_planner.py"]
    written = "\n".join(path.read_text(encoding="utf-8") for path in places)
    toys = re.findall(r'(?:Toy\(\s*|Recipe\(.*, |ROW = )"([^"]+)"', written)
    assert sorted({row[0] for row in ROWS}) == sorted(set(toys))


def test_the_page_can_be_read_at_once() -> None:
    assert len(PAGE.encode()) < 12_000


def test_the_picture_names_every_package_and_module_of_the_house() -> None:
    named = {name.split(".")[0] for line in picture() for name in line}
    there = {path.stem for path in PACKAGE.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    assert named == there - {"__init__"} | {"codesign"}


def test_the_picture_stands_in_the_order_of_the_levels() -> None:
    def levels(line: list[str]) -> list[int]:
        own = [name.replace("ROOM", ROOMS[0]).replace("codesign", "") for name in line]
        return [LEVEL[name] for name in own]

    for lower, upper in pairwise(picture()):
        assert max(levels(lower)) <= min(levels(upper)), f"{upper} below {lower}"


def test_the_room_stands_in_its_order() -> None:
    (drawn,) = re.findall(r"^```room\n(.*?)\n```", PAGE, re.MULTILINE | re.DOTALL)
    order = drawn.split(" → ")
    assert order[:-1] == [name for name in ROOM_ORDER if name in order]
    for room in ROOMS:
        parts = {path.stem for path in (PACKAGE / "planners" / room).iterdir()} - {"__init__", "__pycache__"}
        assert {"plan", "styles", "plug_in"} <= parts <= {*order}, "a room without a paper has no published rows"


@pytest.mark.parametrize("text", ["`maps/no_such_file.py`", "`maps/prepare.py` has `no_such_name`"])
def test_a_name_without_ground_is_found(text: str) -> None:
    assert len(unfounded(text)) == 1
