"""A plug-in that cannot be loaded disables itself, and nothing else."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

import pytest

from codesign.errors import InputError, SpecError
from codesign.spec import list_workloads
from codesign.system import at_hand, catalog, check_files


@pytest.fixture
def with_broken(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Three plug-ins beside our own: no such module, no planner, and styles that are none."""
    others = [
        EntryPoint("absent", "no_such_module_anywhere:PLANNER", "codesign.planners"),
        EntryPoint("number", "math:pi", "codesign.planners"),
        EntryPoint("number", "math:pi", "codesign.architectures"),
    ]

    def found(group: str) -> list[Any]:
        return [*(point for point in others if point.group == group), *entry_points(group=group)]

    caches = (catalog.planners, catalog.architectures, catalog._loaded)
    monkeypatch.setattr(catalog, "entry_points", found)
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


@pytest.mark.usefixtures("with_broken")
def test_what_is_sound_goes_on_working(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        assert not check_files(list_workloads()[:1])
        assert "harmonic" in catalog.planners()
        assert catalog.styles_of("harmonic")
    assert sum("no_such_module_anywhere" in line for line in caplog.messages) == 1
    assert {(each.name, each.group) for each in catalog.broken()} == {
        ("absent", "codesign.planners"),
        ("number", "codesign.planners"),
        ("number", "codesign.architectures"),
    }


@pytest.mark.usefixtures("with_broken")
def test_a_broken_planner_is_refused_with_the_reason_where_it_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"plug-in absent .* cannot be loaded: ModuleNotFoundError"):
        catalog.planner("absent")
    with pytest.raises(InputError, match="plug-in number"):
        catalog.styles_of("number")
    (tmp_path / "w.yaml").write_text("kind: workload\nname: w\nplanner: absent\n")
    with pytest.raises(SpecError, match=r"w.yaml:3:10: planner: plug-in absent .* cannot be loaded"):
        catalog.load_workload(tmp_path / "w.yaml")


@pytest.mark.usefixtures("with_broken")
def test_the_list_shows_what_is_broken() -> None:
    assert "absent (codesign.planners)" in at_hand()["broken plug-ins"]


def test_without_broken_plug_ins_the_list_has_no_such_kind() -> None:
    assert "broken plug-ins" not in at_hand()
