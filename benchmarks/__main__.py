"""Run every benchmark and print one table: ``python -m benchmarks [NAME ...]``."""

from __future__ import annotations

import importlib
import platform
import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table


def machine() -> str:
    """The processor, the Python and the libraries that the figures were made with."""
    import llvmlite
    import numba
    import numpy

    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.is_file():
        names = [line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if "model name" in line]
        processor = f"{names[0]}, {len(names)} cores" if names else processor
    versions = f"numpy {numpy.__version__}, numba {numba.__version__}, llvmlite {llvmlite.__version__}"
    return f"{processor}; Python {platform.python_version()}, {versions}"


def main(names: list[str]) -> None:
    """Run the benchmarks of those names, or all."""
    found = sorted(path.stem for path in Path(__file__).parent.glob("bench_*.py"))
    chosen = [name for name in found if not names or name.removeprefix("bench_") in names]
    console = Console(width=150)
    console.print(machine(), highlight=False)
    for name in chosen:
        rows = []
        for row in importlib.import_module(f"benchmarks.{name}").run():
            rows.append(row)
            print(", ".join(map(str, row.values())), file=sys.stderr, flush=True)
        table = Table(title=name.removeprefix("bench_"), title_justify="left")
        for column in rows[0]:
            table.add_column(column)
        for row in rows:
            table.add_row(*(str(value) for value in row.values()))
        console.print(table)


main(sys.argv[1:])
