"""Icarus and Verilator on the bench of an exported folder. A warning fails the test."""

from __future__ import annotations

import atexit
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

BENCH = "hwsw_bench"
LEVELS = ("OPT_FAST=-O0", "OPT_SLOW=-O0", "OPT_GLOBAL=-O0")
"""Verilator's makefile puts its own levels behind those of -CFLAGS."""


def output_of(folder: Path, *command: str) -> str:
    """What a tool prints. It must succeed, and warn of nothing."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=900)
    output = done.stdout + done.stderr
    assert done.returncode == 0, output
    assert "warning" not in output.lower(), output
    return done.stdout


def in_icarus(folder: Path, files: Sequence[str]) -> Callable[[], str]:
    """Build the bench; the result runs it and returns what it prints."""
    output_of(folder, "iverilog", "-g2005", "-Wall", "-s", BENCH, "-o", "bench.vvp", *files)
    # A whole frame of a display takes Icarus a minute: Verilator and CXXRTL compare it.
    return lambda: output_of(folder, "vvp", "-n", "bench.vvp", "+pins=20000")


def in_verilator(folder: Path, files: Sequence[str]) -> Callable[[], str]:
    """As ``in_icarus``. Verilator's own library is compiled once for all benches: it takes most of the time."""
    output_of(folder, "verilator", "--cc", "--exe", "--main", "--timing", "--top-module", BENCH, *files)
    library, build = _library(), folder / "obj_dir"
    for part in library.glob("*.o"):
        shutil.copy(part, build)
    output_of(folder, "make", "-C", "obj_dir", "-f", f"V{BENCH}.mk", *LEVELS)
    for part in build.glob("verilated*.o"):
        shutil.copy(part, library)
    return lambda: output_of(folder, f"./obj_dir/V{BENCH}")


@cache
def _library() -> Path:
    """The folder of the compiled library, of this process."""
    folder = Path(tempfile.mkdtemp(prefix="verilated-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


SIMULATORS = {"icarus": in_icarus, "verilator": in_verilator}

YOSYS = "import sys; from pyosys import libyosys as ys; ys.run_pass('script ' + sys.argv[2], ys.Design())"
NEXTPNR = "import sys; from yowasp_nextpnr_{0} import run_nextpnr_{0} as run; sys.exit(run(sys.argv[1:]))"
OPEN_TOOLS = {
    "yosys": (sys.executable, "-c", YOSYS),
    "python3": (sys.executable, "-I", "-S"),
    "nextpnr-ecp5": (sys.executable, "-c", NEXTPNR.format("ecp5")),
    "nextpnr-himbaechel": (sys.executable, "-c", NEXTPNR.format("himbaechel_gowin")),
}
"""What stands for the open tools where only their packages are installed; Python without any package."""


def run_readme(folder: Path, *tools: str) -> None:
    """Run the commands of an exported README that begin so, but none that names what only a board knows."""
    readme = (folder / "README.md").read_text(encoding="utf-8").partition("### With the open tools")[2]
    for line in readme.splitlines():
        if line.startswith(tools) and "PACKAGE" not in line and "DEVICE" not in line:
            tool, *words = shlex.split(line)
            command = [*OPEN_TOOLS[tool], *words]
            done = subprocess.run(command, cwd=folder, check=False, capture_output=True, text=True, timeout=900)
            assert done.returncode == 0, (line, done.stdout[-2000:], done.stderr[-2000:])
