"""Imports point one way, module by module: down the levels of the house, and to the left within a planner's room."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import networkx as nx
import pytest
from levels import LEVEL, MAY_USE_TRACE, ROOM_NAMES, ROOM_ORDER, ROOMS
from places import ROOT

PACKAGE = ROOT / "codesign"


def entry_of(module: str) -> str:
    """The name in ``LEVELS`` that a module (without ``codesign.``) belongs to."""
    parts = module.split(".") if module else []
    for length in range(len(parts), -1, -1):
        name = ".".join(parts[:length])
        if name in LEVEL and (name or not parts):
            return name
    raise AssertionError(f"codesign.{module} is on no level: give it one in tests/support/levels.py")


def room_place(module: str) -> int:
    """Where a module stands in its planner's room, counted from the left."""
    parts = module.split(".")
    return ROOM_ORDER.index(parts[2]) if len(parts) > 2 and parts[2] in ROOM_ORDER else len(ROOM_ORDER)


@cache
def modules() -> dict[str, Path]:
    """Every module of the package by its name without ``codesign.``; the package itself is the empty name."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def _absolute(stub: Path) -> str:
    package = ".".join(stub.relative_to(ROOT).parent.parts)
    return re.sub(r"^from \.", f"from {package}.", stub.read_text(encoding="utf-8"), flags=re.MULTILINE)


@cache
def imports(path: Path) -> list[tuple[int, str, bool]]:
    """Every module of the package that a file imports, wherever in the file the import stands; ``late`` counts too.

    With the line, and whether it stands under ``if TYPE_CHECKING``.
    """
    known, found = modules(), []
    tree = ast.parse(path.read_text(encoding="utf-8"))
    stub = path.with_suffix(".pyi")
    if stub.exists():  # what the package loads when it is first asked for
        named = {str(node.module) for node in tree.body if isinstance(node, ast.ImportFrom)}
        assert named == {"__future__", "codesign.ground.late"}
        tree = ast.parse(_absolute(stub))
    guarded = {
        id(inner)
        for node in ast.walk(tree)
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        for inner in ast.walk(node)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno} imports relatively"
            # An imported name may be a module of its own.
            whole = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name.removeprefix("codesign.") in known else node.module or "" for name in whole]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "late":
            names = [str(getattr(node.args[0], "value", ""))]
        else:
            continue
        for name in names:
            if name == "codesign" or name.startswith("codesign."):
                module = name.removeprefix("codesign").removeprefix(".")
                found.append((node.lineno, module, id(node) in guarded))
    return found


def broken_rules(path: Path, module: str) -> list[str]:
    """Each import of a file that points up, with its place."""
    here, faults = entry_of(module), []
    for line, name, _ in imports(path):
        there = entry_of(name)
        place = f"{path.relative_to(ROOT)}:{line} imports codesign.{name}"
        if there == "" and here != "ground.errors":
            continue  # the version of the package
        if here in ROOM_NAMES and there in ROOM_NAMES:
            upward = room_place(name) > room_place(module)
        elif there == "views.trace" and here not in MAY_USE_TRACE:
            upward = True
        else:
            upward = there != here and LEVEL[there] >= LEVEL[here]
        if upward:
            faults.append(place)
    return faults


def test_imports_point_one_way() -> None:
    assert [fault for module, path in modules().items() for fault in broken_rules(path, module)] == []


def test_no_test_module_imports_another() -> None:
    """What tests share stands in tests/support. Scripts that tests run in a process of their own count too."""
    imported = re.compile(r"^\s*(?:from|import) (?:tests\b|test_\w+)", re.MULTILINE)
    faults = {
        str(path.relative_to(ROOT)): lines
        for path in (ROOT / "tests").rglob("*.py")
        if (lines := imported.findall(path.read_text(encoding="utf-8")))
    }
    assert faults == {}


@pytest.mark.parametrize(
    ("module", "line", "fault"),
    [
        (
            "maps.upward",
            "def later():\n    from codesign.system.scenarios import run\n",
            ":2 imports codesign.system.scenarios.run",
        ),
        (
            "planners.harmonic.plan.upward",
            "import codesign.planners.harmonic.styles\n",
            ":1 imports codesign.planners.harmonic.styles",
        ),
    ],
)
def test_the_rule_catches_an_upward_import(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str, line: str, fault: str
) -> None:
    # Not in the package itself: other tests copy it and take the digest of its sources at the same time.
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    upward = tmp_path / "upward.py"
    upward.write_text(line, encoding="utf-8")
    assert broken_rules(upward, module) == [f"upward.py{fault}"]


def test_no_modules_import_each_other_in_a_circle() -> None:
    """Late imports count; what only a type checker imports does not."""
    graph = nx.DiGraph(
        (module, name) for module, path in modules().items() for _line, name, typing in imports(path) if not typing
    )
    graph.remove_edges_from([(module, "") for module in modules()])
    assert [sorted(circle) for circle in nx.strongly_connected_components(graph) if len(circle) > 1] == []


def test_a_machine_is_given_a_system_and_never_the_reverse() -> None:
    """Within system and scenarios, what only a type checker imports counts too."""
    graph = nx.DiGraph(
        (module, name)
        for module, path in modules().items()
        if entry_of(module) in {"system", "system.scenarios"}
        for _line, name, _typing in imports(path)
        if entry_of(name) in {"system", "system.scenarios"} and "." in name
    )
    assert [sorted(circle) for circle in nx.strongly_connected_components(graph) if len(circle) > 1] == []


def test_help_needs_no_heavy_module() -> None:
    heavy = ["numba", "scipy", "matplotlib", "bokeh", "networkx", "simpy", "mcap", "PIL", "pydantic", "numpy"]
    script = (
        "import sys\n"
        "from click.testing import CliRunner\n"
        "from codesign.cli import main\n"
        "result = CliRunner().invoke(main, ['--help'])\n"
        "assert result.exit_code == 0, result.output\n"
        f"print([name for name in {heavy!r} if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("statement", ["import codesign", "import codesign.__main__; codesign.cli.main(['list'])"])
def test_a_list_needs_no_heavy_module(statement: str) -> None:
    heavy = ["numba", "scipy", "matplotlib", "networkx", "simpy", "mcap", "PIL", "pandas", "pyarrow", "rich", "jinja2"]
    models = ["codesign.inputs.platform", "codesign.inputs.workload"]
    script = (
        f"import sys, codesign.cli\ntry:\n    {statement}\nexcept SystemExit:\n    pass\n"
        f"print([name for name in {heavy + models!r} if name in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_no_plan_and_no_style_of_a_planner_knows_of_files() -> None:
    """A planner is usable without anything of YAML: only its reproduction reads platforms and workloads."""
    rooms = {module: path for module, path in modules().items() if entry_of(module) in ROOM_NAMES}
    inner = {module: path for module, path in rooms.items() if module.split(".")[2:3] in (["plan"], ["styles"])}
    assert {module.split(".")[1] for module in inner} == set(ROOMS)
    below = {"planners.interface", "planners.styles", "planners.job"}
    inner |= {module: path for module, path in modules().items() if module in below}
    found = [
        f"{path.relative_to(ROOT)}:{line}"
        for path in inner.values()
        for line, name, typing in imports(path)
        if entry_of(name) == "inputs" and not typing
    ]
    assert found == []


def test_system_and_scenarios_know_no_planner_but_by_the_contract() -> None:
    """What they need of a planner stands in ``planners.interface`` and ``planners.styles``, for every plug-in."""
    faults = [
        f"{path.relative_to(ROOT)}:{line} imports codesign.{name}"
        for module, path in modules().items()
        if entry_of(module) in {"system.results", "system", "system.scenarios", "study"}
        for line, name, _ in imports(path)
        if entry_of(name) in ROOM_NAMES
    ]
    assert faults == []


# A problem and parameters for the planner of each room, as a user of it alone would write them.
WITHOUT_YAML = f"""
import importlib, sys
sys.modules["yaml"] = None
import numpy as np
from codesign.planners.interface import Problem
from codesign.planners.job import Job

for room in {list(ROOMS)!r}:
    plug_in = importlib.import_module(f"codesign.planners.{{room}}.plug_in").PLUG_IN
    planner, samples = plug_in.planner, plug_in.samples
    parameters = planner.tasks[planner.planning_task].model_validate(samples.parameters[0])
    model = planner.problem_model
    if model is None:
        problem = Problem(np.ones((24, 32), bool), ((0, 0),), ((5, 5),))
    else:
        problem = model.model_validate(samples.problems[0]).problem()
    assert planner.plan(Job(problem, parameters)) is not None
    print(room, [name for name in sys.modules if name.startswith("codesign.inputs")])
"""


def test_each_planner_plans_without_yaml() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT_YAML], capture_output=True, text=True, check=False)
    assert (done.stdout.splitlines(), done.stderr) == ([f"{room} []" for room in ROOMS], "")
