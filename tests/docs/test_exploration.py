"""The examples in the docstrings and in docs/exploration.md are run."""

from __future__ import annotations

import doctest
import importlib

import pytest
from places import ROOT

MODULES = [
    "codesign.memo",
    *(f"codesign.exploration.{name}" for name in ("executor", "front", "space")),
    "codesign.planners.harmonic.plan.best_schedule",
]
PAGE = ROOT / "docs" / "exploration.md"


@pytest.mark.parametrize("name", MODULES)
def test_docstrings(name: str) -> None:
    found = doctest.testmod(importlib.import_module(name))
    assert found.attempted > 0
    assert found.failed == 0


def test_page() -> None:
    names: dict[str, object] = {}
    found = doctest.testfile(str(PAGE), module_relative=False, extraglobs=names)
    assert found.attempted > 5
    assert found.failed == 0


def test_labyrinth_schedules_of_the_page() -> None:
    import codesign
    from codesign.planners.harmonic.plan.best_schedule import optimise_schedule
    from codesign.planners.harmonic.plan.parameters import RelaxParameters, Stop
    from codesign.scenarios import bind

    problem = bind(codesign.load_platform("virtex4-pci"), codesign.load_workload("labyrinth")).problem
    parameters = RelaxParameters(block=(36, 66), iterations=6, schedule=(63,), stop=Stop.SCHEDULE_END)
    best = optimise_schedule(problem, parameters, candidates=range(7, 63, 8))
    listed = f"{best.cost:,}: {', '.join(map(str, best.precisions))}"
    assert listed in PAGE.read_text(encoding="utf-8")
