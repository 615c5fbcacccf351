"""The examples and the figures of docs/schedules.md."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result
from places import ROOT

PAGE = ROOT / "docs" / "schedules.md"


def test_labyrinth_schedules_of_the_page() -> None:
    import codesign
    from codesign.planners.harmonic.plan.best_schedule import optimise_schedule
    from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
    from codesign.system.scenarios import bind

    problem = bind(codesign.load_platform("virtex4-pci"), codesign.load_workload("labyrinth")).problem
    parameters = RelaxParameters(block=(36, 66), iterations=6, schedule=(63,), stop=Stop.SCHEDULE_END)
    best = optimise_schedule(problem, parameters, candidates=range(7, 63, 8))
    listed = f"{best.cost:,}: {', '.join(map(str, best.precisions))}"
    assert listed in PAGE.read_text(encoding="utf-8")


def test_the_run_of_the_page(hwsw: Callable[..., Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = PAGE.read_text(encoding="utf-8")
    (text,) = re.findall(r"```yaml\n(# best\.yaml\n.*?)```", page, re.S)
    (tmp_path / "best.yaml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    done = hwsw("run", "virtex4-pci", "best.yaml")
    (note,) = re.findall(r"^note: (relax\.schedule: .*)$", page, re.M)
    assert " ".join(note.split()) in " ".join(done.output.split())


@pytest.mark.parametrize("number", [1, 12])
def test_rows_of_the_study_are_as_the_page_says(number: int) -> None:
    from benchmarks import bench_schedules as study

    outcome = study.outcome_of(study.case_of(*study.MAPS[number]))
    row = "| " + " | ".join(map(str, study.rows_of(outcome).values())) + " |"
    assert row in PAGE.read_text(encoding="utf-8")
