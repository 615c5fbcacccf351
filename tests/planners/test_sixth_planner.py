"""A planner inside the tree is a room and one entry point: nothing else is edited."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest
from places import ROOT
from recipes import copy_tree, python_in

BLOCK = re.compile(r"^```(?:yaml|python)\n# (\S+)\n(.*?)^```", re.MULTILINE | re.DOTALL)

PLUG_IN = '''\
"""Everything that this room registers."""

from __future__ import annotations

from dataclasses import replace

from codesign.planners.flood.styles import PLUG_IN as WITHOUT_PAPER
from codesign.plugin import Probe, Reproduction, Status, row


def _probe() -> Probe:
    """A thousand additions."""
    return Probe(1000, lambda: sum(range(1000)))


def _reproduce(quick: bool = False, progress: object = None, settings: object = None) -> Reproduction:
    """One row of a paper that nobody wrote."""
    found = row("Table 1", "steps", 3, 3, status=Status.MEASURED, source="counted")
    return Reproduction("Nobody 2026, Floods", (found,), (), ())


PLUG_IN = replace(
    WITHOUT_PAPER, probes={"flood_cell": _probe, "flood_step": _probe}, reproduce=_reproduce
)
'''

COMMANDS = """
from click.testing import CliRunner
from codesign.hardware.calibrate.host_costs import all_probes
from codesign.cli import main

def printed(*words):
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    return done.output

specs = "field-robot.yaml", "rooms.yaml"
assert "steps to the goal, flooded from it" in printed("list")
printed("check", *specs)
assert '"feasible": true' in printed("run", *specs, "--json", "--no-levers")
assert "Nobody 2026" in printed("reproduce", "flood")
assert all_probes()["flood_cell"]().units == 1000
print("known")
"""


ROW = "a sixth planner"
"""The row of docs/architecture.md that this holds."""


@pytest.fixture(scope="module")
def tree(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the tree with the planner of docs/extending.md as a sixth room, installed as pip would leave it."""
    copy = tmp_path_factory.mktemp("tree")
    copy_tree(copy)
    page = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
    files = {name: text.replace("flood.planner", "codesign.planners.flood.plan") for name, text in BLOCK.findall(page)}
    room = copy / "codesign" / "planners" / "flood"
    room.mkdir()
    (room / "__init__.py").write_text('"""A flood from the goal."""\n')
    (room / "plan.py").write_text(files["flood/planner.py"])
    (room / "styles.py").write_text(files["flood/styles.py"])
    (room / "plug_in.py").write_text(PLUG_IN)
    for name in [name for name in files if name.endswith(".yaml")]:
        (copy / name).parent.mkdir(exist_ok=True)
        (copy / name).write_text(files[name])
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    group = '[project.entry-points."codesign.planners"]\n'
    text = text.replace(group, f'{group}flood = "codesign.planners.flood.plug_in:PLUG_IN"\n')
    (copy / "pyproject.toml").write_text(text)
    information = copy / "hwsw_codesign-0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text("Name: hwsw-codesign\nVersion: 0\n")
    points = tomllib.loads(text)["project"]["entry-points"]["codesign.planners"]
    lines = "".join(f"{name} = {value}\n" for name, value in points.items())
    (information / "entry_points.txt").write_text(f"[codesign.planners]\n{lines}")
    return copy


def test_the_command_line_knows_the_planner(tree: Path) -> None:
    assert python_in(tree, "-c", COMMANDS).splitlines()[-1] == "known"


def test_the_reference_has_its_keys(tree: Path) -> None:
    python_in(tree, "-m", "docs.make_reference")
    page = (tree / "docs" / "reference" / "workload.md").read_text(encoding="utf-8")
    assert "### Task `flood` of planner `flood`" in page


@pytest.mark.slow
def test_the_tests_of_the_house_take_the_room_in(tree: Path) -> None:
    modules = ("tests/test_layers.py", "tests/docs/test_architecture.py", "tests/planners/test_contract.py")
    chosen = "flood or one_way or circle or test_the_room or test_the_picture"
    out = python_in(tree, "-m", "pytest", "-vv", "-p", "no:cacheprovider", *modules, "-k", chosen)
    assert "test_imports_point_one_way PASSED" in out
    assert "test_contract[work_drained_ends_in_the_plan-flood-1] PASSED" in out
