"""What every component promises, whatever it does: a new component adds one entry to ``COMPONENTS``."""

from __future__ import annotations

from dataclasses import fields
from types import NoneType
from typing import Any

import pytest
from component_builds import COMPONENTS, Build, simulate

from codesign.components import Component
from codesign.ground.records import Record


@pytest.mark.parametrize("build", COMPONENTS)
def test_it_is_busy_some_of_the_time_and_never_more(build: Build) -> None:
    component, moments = simulate(build)
    assert component.name == "unit"
    assert 0 < component.busy < component.now
    assert moments == sorted(moments)
    use = component.utilisation()
    assert (use.busy, use.span, use.time) == (component.busy, component.now, component.now)


@pytest.mark.parametrize("build", COMPONENTS)
def test_it_emits_its_utilisation_last_and_its_times_are_integers(build: Build) -> None:
    heard: list[Record] = []
    component, _ = simulate(build, (heard.append,))
    assert heard[-1] == component.utilisation()
    for record in heard:
        assert record.source == "unit"
        assert all(type(getattr(record, field.name)) in (int, str, bool, NoneType) for field in fields(record))
        assert 0 <= record.time <= component.now


@pytest.mark.parametrize("build", COMPONENTS)
def test_it_is_deterministic_and_the_same_with_and_without_listeners(build: Build) -> None:
    first: list[Record] = []
    again: list[Record] = []
    third: list[Record] = []
    watched, moments = simulate(build, (first.append, third.append))
    simulate(build, (again.append,))
    alone, moments_alone = simulate(build)
    assert first == again == third
    assert moments == moments_alone
    assert (watched.busy, watched.now) == (alone.busy, alone.now)


@pytest.mark.parametrize("build", COMPONENTS)
def test_no_record_is_built_when_nobody_listens(build: Build, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("a record was emitted")

    monkeypatch.setattr(Component, "emit", refuse)
    simulate(build)
    with pytest.raises(AssertionError, match="a record was emitted"):
        simulate(build, (lambda _: None,))
