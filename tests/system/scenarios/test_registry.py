"""Every scenario that a workload may name has one room, and a room refuses what it cannot run when it is bound."""

from __future__ import annotations

import pkgutil

import pytest

from codesign import inputs, load_platform, load_workload
from codesign.ground.errors import SpecError
from codesign.system.scenarios import SCENARIOS, bind, scenario_of
from codesign.system.scenarios.scenario import Scenario


def test_each_model_has_a_room_and_each_room_a_model() -> None:
    assert list(SCENARIOS) == list(inputs.scenario.SCENARIOS)


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_scenario_has_the_type_that_it_is_registered_by(name: str) -> None:
    kind = pkgutil.resolve_name(SCENARIOS[name])
    assert issubclass(kind, Scenario)
    assert kind.type == name


def test_a_system_holds_the_scenario_of_its_workload() -> None:
    platform, workload = load_platform("nexys2-serial"), load_workload("robots-4-fleet")
    assert bind(platform, workload).scenario is scenario_of(workload)


def test_a_style_of_one_robot_cannot_fly_a_fleet(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check needs no machine: it is a fault at the task that has the style."""
    platform, workload = load_platform("nexys2-serial"), load_workload("robots-4-fleet")
    style = bind(platform, workload).architecture
    monkeypatch.setattr(type(style), "updates", lambda *_arguments: None)
    with pytest.raises(SpecError) as refused:
        bind(platform, workload)
    [fault] = refused.value.faults
    assert fault.key.startswith("mapping.avoid")
    assert fault.what == f"style {style.style} does not say what each robot takes for an update"
    assert "plan_once" in fault.hint
