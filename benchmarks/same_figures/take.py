"""Results of every shipped platform with every shipped workload, their traces and the tables of papers, as digests.

    python compare_results.py take FOLDER           writes one file for each pair, and the tables

Used while the package is rebuilt: no figure may move.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

TIMEOUT = 400


def run(arguments: list[str], out: Path) -> None:
    try:
        done = subprocess.run(
            [sys.executable, "-m", "codesign", *arguments], capture_output=True, text=True, timeout=TIMEOUT
        )
        text = f"exit {done.returncode}\n{done.stdout}\n{done.stderr if done.returncode in (1, 2) else ''}"
    except subprocess.TimeoutExpired:
        text = "timeout\n"
    out.write_text(text)


def pair(folder: Path, platform: str, workload: str) -> None:
    name = f"{platform}--{workload}"
    trace = folder / f"{name}.mcap"
    out = folder / f"{name}.json"
    if out.exists():
        return
    run(["run", platform, workload, "--json", "--no-levers", "--trace", str(trace)], out)
    if trace.exists():
        digest = hashlib.sha256(trace.read_bytes()).hexdigest()
        (folder / f"{name}.trace").write_text(f"{trace.stat().st_size} {digest}\n")
        shown = subprocess.run(
            [sys.executable, "-m", "codesign", "trace", "info", str(trace)], capture_output=True, text=True
        )
        (folder / f"{name}.traceinfo").write_text(shown.stdout)
        trace.unlink()


def take(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    platforms = sorted(path.stem for path in Path("platforms").glob("*.yaml"))
    workloads = sorted(path.stem for path in Path("workloads").glob("*.yaml"))
    pairs = [(p, w) for w in workloads for p in platforms]
    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda pw: pair(folder, *pw), pairs))
    for p, w in EXPLORED:
        out = folder / f"explore-{p}--{w}.txt"
        csv = folder / f"explore-{p}--{w}.csv"
        if not out.exists():
            run(["explore", p, w, "--csv", str(csv)], out)
    if not (folder / "reproduce.txt").exists():
        run(["reproduce"], folder / "reproduce.txt")


EXPLORED = [("virtex4-pci", "labyrinth"), ("zynq", "office-partition"), ("virtex2pro", "breadth-first")]


if __name__ == "__main__":
    take(Path(sys.argv[2]))
