"""Imports point one way: each package imports only from its own level's allowance, and nothing imports the cli."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "codesign"

# Lowest first. A module may import what stands on a strictly lower level, and its own package.
LEVELS: list[set[str]] = [
    {"errors", "units", "figures", "memo", "files", "interrupts", "kernel_cache"},
    {"records"},
    {"spec", "maps", "trace"},
    {"task_graph"},
    {"planners"},
    {"architectures"},
    {"components"},
    {"mission"},
    {"system"},
    {"explore"},
    {"report", "reproduce"},
    {"__init__"},
    {"cli"},
    {"__main__"},
]
# trace hangs on records alone: nothing of the simulation below the cli and the notebook face may know it.
MAY_USE_TRACE = {"trace", "__init__", "cli", "__main__"}
# The lowest level is one level: its modules may use each other in this order only.
LOWEST = ["errors", "units", "figures", "memo", "files", "interrupts", "kernel_cache"]


def level_of(unit: str) -> int:
    for level, units in enumerate(LEVELS):
        if unit in units:
            return level
    raise AssertionError(f"codesign/{unit} stands on no level: give it one in {Path(__file__).name}")


def unit_of(path: Path) -> str:
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imports(path: Path) -> list[tuple[int, str]]:
    """Every codesign unit that the file imports, with its line, wherever the import stands."""
    found: list[tuple[int, str]] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno} imports relatively"
            module = node.module or ""
            names = [f"codesign.{alias.name}" for alias in node.names] if module == "codesign" else [module]
        else:
            continue
        for name in names:
            parts = name.split(".")
            if parts[0] == "codesign":
                unit = parts[1] if len(parts) > 1 else "__init__"
                known = (PACKAGE / unit).is_dir() or (PACKAGE / f"{unit}.py").is_file()
                found.append((node.lineno, unit if known else "__init__"))
    return found


def broken_rules(path: Path) -> list[str]:
    here = unit_of(path)
    faults = []
    for line, unit in imports(path):
        if unit == here:
            continue
        place = f"{path.relative_to(ROOT)}:{line} imports {unit}"
        if unit == "__init__" and here in {"cli", "__main__", "explore", "report", "trace", "reproduce"}:
            continue  # the package's version
        if unit == "trace" and here not in MAY_USE_TRACE:
            faults.append(place)
        elif here in LOWEST and unit in LOWEST:
            if LOWEST.index(unit) >= LOWEST.index(here):
                faults.append(place)
        elif level_of(unit) >= level_of(here):
            faults.append(place)
    return faults


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_one_way(path: Path) -> None:
    assert not broken_rules(path)


def test_the_rule_catches_an_upward_import() -> None:
    upward = PACKAGE / "maps" / "upward_import_for_this_test.py"
    upward.write_text("def later():\n    from codesign.system import run\n", encoding="utf-8")
    try:
        assert broken_rules(upward) == ["codesign/maps/upward_import_for_this_test.py:2 imports system"]
    finally:
        upward.unlink()


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
