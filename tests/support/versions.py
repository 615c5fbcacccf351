"""The tests against the wheel in an empty environment: newest versions on the newest Python, lowest on the oldest.

``python tests/support/versions.py newest | lowest | smoke``. The environments stand below ``out/versions``, where the
sources of the package are on no path. ``smoke``: some commands and tests with the newest. numba says itself which
versions of NumPy it takes, so the newest NumPy is the newest that numba admits.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
WORK = ROOT / "out" / "versions"
EXTRAS = ("frames", "parquet", "search", "ros2")
"""The extras that are installed, and taken at their lowest too."""

TOOLS = (
    "pytest",
    "pytest-xdist",
    "hypothesis",
    "jsonschema",
    "hatchling",
    "desmod",
    "progressbar2",
    "vcdvcd",
    "polars",
    "duckdb",
)
"""What tests need beside the package; the versions of these are no promise."""

SOURCES = (
    *("tests", "docs", "benchmarks", "platforms", "workloads", "pyproject.toml", "constraints.txt"),
    *("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "CITATION.cff", "LICENSE", "Makefile"),
)
SMOKE_TESTS = (
    "tests/views/trace/test_mcap.py",
    "tests/views/trace/test_reader.py",
    "tests/views/trace/test_other_versions.py",
    "tests/views/bags/test_export.py",
)
EXPLORE = "explore virtex4-pci labyrinth --points 4 --set workload.problem.arrive=0 --store s.sqlite -q"
COMMANDS = (
    "--version",
    "check virtex4-pci labyrinth",
    "run virtex4-pci labyrinth --no-levers --trace run.mcap --html run.html --ros2 bag",
    "trace show run.mcap --limit 5",
    "trace stats run.mcap",
    "trace export run.mcap --perfetto run.pftrace --vcd run.vcd",
    f"{EXPLORE} --csv s.csv --html s.html",
    "report s.sqlite --parquet s.parquet",
    "plot schedule virtex2-pci labyrinth -o schedule.pdf",
)


def project() -> dict[str, Any]:
    return dict(tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"])


def requirements(table: dict[str, Any], extras: tuple[str, ...] = EXTRAS) -> list[str]:
    """What the package asks for, with these extras."""
    return [*table["dependencies"], *(each for extra in extras for each in table["optional-dependencies"][extra])]


def floor(requirement: str) -> str:
    """The lowest version that a requirement admits.

    >>> floor("rosbags>=0.11.9,<0.12")
    'rosbags==0.11.9'
    """
    found = re.fullmatch(r"([\w.-]+)>=([\w.]+)(,<[\w.]+)?", requirement)
    if found is None:
        raise ValueError(f"{requirement} has no lowest version: write NAME>=VERSION")
    return f"{found[1]}=={found[2]}"


def pythons() -> dict[tuple[int, int], str]:
    """The interpreters of this machine, by version."""
    folders = [*map(Path, os.environ.get("PATH", "").split(os.pathsep)), *Path.home().glob(".pyenv/versions/*/bin")]
    names = {str(path) for folder in folders for path in folder.glob("python3.*") if path.name[9:].isdigit()}
    found: dict[tuple[int, int], str] = {}
    for name in sorted({sys.executable, *names}):
        ask = [name, "-c", "import sys, venv, ensurepip; print(*sys.version_info[:2])"]
        asked = subprocess.run(ask, capture_output=True, text=True, check=False)
        if asked.returncode == 0:
            major, minor = map(int, asked.stdout.split())
            found[major, minor] = name
    return found


def run(*command: object, cwd: Path = ROOT, answers: tuple[int, ...] = (0,)) -> None:
    print("$", *command, flush=True)
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    code = subprocess.run([str(each) for each in command], cwd=cwd, env=clean, check=False).returncode
    if code not in answers:
        raise SystemExit(f"ended with {code}: {' '.join(map(str, command))}")


def installed(name: str, python: str, *, lowest: bool) -> Path:
    """The interpreter of an empty environment with the wheel, its extras and the tools of tests."""
    folder, wheels = WORK / name, WORK / "wheels"
    for each in (folder, wheels):
        shutil.rmtree(each, ignore_errors=True)
    run(python, "-m", "venv", folder)
    inside = folder / "bin" / "python"
    pip = (inside, "-m", "pip", "--disable-pip-version-check", "--quiet")
    run(*pip, "wheel", "--no-deps", "--wheel-dir", wheels, ROOT)
    (wheel,) = wheels.iterdir()
    constraints = WORK / f"{name}.txt"
    constraints.write_text("".join(f"{floor(each)}\n" for each in requirements(project())) if lowest else "")
    run(*pip, "install", "--constraint", constraints, f"{wheel}[{','.join(EXTRAS)}]", *TOOLS)
    run(*pip, "check")
    return inside


def tests_beside(name: str) -> Path:
    """A folder with the tests and the pages, whose ``codesign`` is the package that the wheel installed."""
    folder = WORK / f"{name}-tests"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for each in SOURCES:
        source = ROOT / each
        copy = shutil.copytree if source.is_dir() else shutil.copy
        copy(source, folder / each)
    (package,) = (WORK / name).glob("lib/python*/site-packages/codesign")
    (folder / "codesign").symlink_to(package)
    return folder


def main(what: str) -> None:
    found = pythons()
    oldest = tuple(map(int, re.findall(r"\d+", project()["requires-python"])))
    version = oldest if what == "lowest" else max(found)
    if version not in found:
        raise SystemExit(f"Python {'.'.join(map(str, version))} is needed, and was not found")
    print(f"{what}: Python {'.'.join(map(str, version))}", flush=True)
    python = installed(what, found[version], lowest=what == "lowest")
    folder = tests_beside(what)
    for command in COMMANDS:
        # Of four points none may be feasible.
        answers = (0, 3) if command.startswith(("explore", "report")) else (0,)
        run(python, "-m", "codesign", *command.split(), cwd=folder, answers=answers)
    which = (*SMOKE_TESTS, "-x") if what == "smoke" else ("-m", "not slow", "-n", "2", "--dist", "worksteal")
    run(python, "-m", "pytest", "-p", "no:cacheprovider", *which, cwd=folder)


if __name__ == "__main__":
    main(sys.argv[1])
