"""The shipped study ``million``, computed, resumed, asked and written: processor seconds of one process, memory, bytes.

``python -m benchmarks million``. Beside it the study ``labyrinth`` is computed in two ways: what computes the same is
simulated once, and each point is simulated by itself.
"""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import codesign
from codesign.ground.figures import FIGURES
from codesign.study import evaluation, explore, load_study
from codesign.study.check import check_points
from codesign.study.explored import Explored
from codesign.study.simulator import Simulator
from codesign.study.study import Study
from codesign.views.report.study_page import study_page
from codesign.views.report.study_tables import write_study_csv

CHECKED = 100

Row = dict[str, str]


class Simulated:
    """The processor seconds of simulations while it is in use."""

    def __init__(self) -> None:
        self.seconds, self._record = 0.0, evaluation.record

    def __enter__(self) -> Simulated:
        def timed(*arguments: Any) -> Any:
            begin = time.process_time()
            try:
                return self._record(*arguments)
            finally:
                self.seconds += time.process_time() - begin

        evaluation.record = timed
        return self

    def __exit__(self, *_: object) -> None:
        evaluation.record = self._record


def filtered(study: Study) -> int:
    """The feasible designs of one part, by rising energy: the first."""
    part = study.decisions.levels(np.arange(len(study.designs)))["fabric.part"]
    chosen = np.flatnonzero(study.judged.feasible & (part == 1))
    energy = study.judged.figure(FIGURES["energy_j"])[chosen]
    return int(chosen[np.argsort(energy, kind="stable")][0])


def explored(store: Path, workload: str) -> Study:
    """A shipped study, computed or resumed in this process."""
    return codesign.explore(
        codesign.load_platform("virtex4-pci"), codesign.load_workload(workload), store=store, workers=1
    )


def run() -> list[Row]:
    """The rows of the table."""
    codesign.simulate("virtex4-pci", "labyrinth")
    with tempfile.TemporaryDirectory() as folder:
        return rows(Path(folder))


def rows(folder: Path) -> list[Row]:
    """The rows, with files in a folder."""
    table: list[Row] = []
    store = folder / "million.sqlite"

    def step(case: str, of: Callable[[], Any], shown: Callable[[Any], object] = lambda _: "") -> Any:
        begin = time.process_time()
        outcome = of()
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        seconds = time.process_time() - begin
        table.append({"case": case, "outcome": str(shown(outcome)), "s": f"{seconds:.2f}", "peak MiB": f"{peak:,.0f}"})
        return outcome

    with Simulated() as simulated:
        study = step(
            "a million points", lambda: explored(store, "million"), lambda made: f"{made.simulations} simulations"
        )
    whole = float(table[-1]["s"])
    table.append(
        {
            "case": "of that, beside the simulations",
            "outcome": "",
            "s": f"{whole - simulated.seconds:.2f}",
            "peak MiB": "",
        }
    )
    table.append({"case": "the store", "outcome": f"{store.stat().st_size / 1e6:.1f} MB", "s": "", "peak MiB": ""})
    del study
    step("the same command again", lambda: explored(store, "million"), lambda _: "nothing computed")
    table[-1]["outcome"] += f": {float(table[-1]['s']) / whole:.1%} of the first"
    study = step("read from the store", lambda: load_study(store), lambda read: f"{len(read.points):,} points")
    step(
        "front of five objectives",
        lambda: study.front,
        lambda front: f"{len(front)} of {len(study.feasible):,} feasible",
    )
    step("filter and sort", lambda: filtered(study), lambda design: f"design {design}")
    step("full result of a point", lambda: study.points[study.front[0]].result, lambda result: result.precision)
    files = {
        "Parquet": study.to_parquet,
        "CSV": lambda path: write_study_csv(study, path),
        "page": lambda path: study_page(study, path),
    }
    for name, write in files.items():
        path = folder / name.lower()
        step(
            name, lambda write=write, path=path: write(path), lambda _, path=path: f"{path.stat().st_size / 1e6:.1f} MB"
        )
    step(f"{CHECKED} random points alone", lambda: check_points(study, CHECKED), lambda check: check.sentence)
    table += labyrinth(folder)
    return table


def labyrinth(folder: Path) -> list[Row]:
    """The study ``labyrinth`` with what computes the same simulated once, and with each point simulated by itself."""
    platform, workload = codesign.load_platform("virtex4-pci"), codesign.load_workload("labyrinth")
    alone = Simulator(Explored.of(platform, workload))
    seconds, texts = [], []
    for number, evaluate in enumerate((None, alone)):
        begin = time.process_time()
        study = explore(platform, workload, workers=1, evaluate=evaluate)
        seconds.append(time.process_time() - begin)
        path = folder / f"{number}.csv"
        write_study_csv(study, path)
        texts.append(path.read_bytes())
        shown = study.simulations
    equal = "the same table" if texts[0] == texts[1] else "ANOTHER TABLE"
    ratio = f"{seconds[1] / seconds[0]:.1f} times the time, {equal}"
    outcomes = ("what computes the same, once", f"{shown} simulations: {ratio}")
    return [
        {"case": f"labyrinth{each}", "outcome": outcome, "s": f"{taken:.2f}", "peak MiB": ""}
        for each, outcome, taken in zip(("", ", point by point"), outcomes, seconds, strict=True)
    ]
