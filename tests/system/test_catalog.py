"""A plug-in that cannot be loaded disables itself, and nothing else."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from click.testing import Result
from mission_specs import Ground

from codesign.ground.errors import InputError, SpecError
from codesign.inputs import list_workloads
from codesign.planners import registered
from codesign.planners.job import Flow, Job
from codesign.plugin import PlugIn
from codesign.system import at_hand, catalog
from codesign.system.place import sound_flows
from codesign.system.scenarios import check_files


@contextmanager
def registering(monkeypatch: pytest.MonkeyPatch, *others: tuple[str, str]) -> Iterator[None]:
    """Plug-ins registered before our own, each by the name and the value of its entry point."""
    points = [EntryPoint(name, value, "codesign.planners") for name, value in others]

    def installed(group: str) -> list[Any]:
        return [*(point for point in points if point.group == group), *entry_points(group=group)]

    caches = (catalog._points, catalog.planners, catalog.architectures, catalog.task_styles, catalog._loaded)
    monkeypatch.setattr(registered, "entry_points", installed)
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


def test_a_plug_in_of_ours_is_named_as_its_planner_and_has_no_styles_of_another() -> None:
    """A planner is found by the name of its entry point, so that no other is loaded."""
    ours = [point for point in registered.registered() if point.value.startswith("codesign.")]
    for point, plug_in in zip(ours, catalog.plug_ins(), strict=False):
        assert plug_in.planner is not None
        assert {plug_in.planner.name, *(style.planner for style in (*plug_in.styles, *plug_in.task_styles))} == {
            point.name
        }


@pytest.fixture
def with_broken(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Two plug-ins beside our own: no such module, and a number."""
    with registering(monkeypatch, ("absent", "no_such_module_anywhere:PLANNER"), ("number", "math:pi")):
        yield


@pytest.mark.parametrize(
    ("name", "value", "why"),
    [
        ("again", "codesign_elsewhere:PLUG_IN", "a planner harmonic is registered already"),
        ("harmonic", "codesign_elsewhere:PLUG_IN", "an entry point harmonic is registered already"),
    ],
)
def test_no_plug_in_takes_the_name_of_another(monkeypatch: pytest.MonkeyPatch, name: str, value: str, why: str) -> None:
    """Ours stay, whatever stands before them in the order of installation."""
    elsewhere = ModuleType("codesign_elsewhere")
    elsewhere.PLUG_IN = PlugIn(planner=catalog.planner("harmonic"))  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "codesign_elsewhere", elsewhere)
    with registering(monkeypatch, (name, value)):
        assert [each.why for each in catalog.broken()] == [f"ValueError: {why}"]
        assert catalog.styles_of("harmonic")


@pytest.mark.usefixtures("with_broken")
def test_what_is_sound_goes_on_working(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        assert not check_files(list_workloads()[:1])
        assert "harmonic" in catalog.planners()
        assert catalog.styles_of("harmonic")
    assert sum("no_such_module_anywhere" in line for line in caplog.messages) == 1
    assert {(each.name, each.why.split(":")[0]) for each in catalog.broken()} == {
        ("absent", "ModuleNotFoundError"),
        ("number", "TypeError"),
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
    assert "absent (no_such_module_anywhere:PLANNER)" in at_hand()["broken plug-ins"]


LIES: list[tuple[Any, str]] = [
    ([Flow("load", "serch", "map", 8)], "names 'serch', which is no task: accepted are load, search, track, command"),
    ([Flow("load", "sense", "map", 8)], "names 'sense', which is no task"),
    ([Flow("load", "search", "map", 0)], "has 0 bits: give an integer above 0"),
    ([Flow("load", "search", "map", -3)], "has -3 bits"),
    ([Flow("load", "search", "map", 1.5)], "has 1.5 bits"),  # type: ignore[arg-type]
    ([Flow("load", "search", "map", True)], "has True bits"),
    ([Flow("load", "search", "map", None)], "has None bits"),  # type: ignore[arg-type]
    ([Flow("load", "search", "map", 8), Flow("load", "search", "map", 9)], "is listed twice"),
    ([Flow("search", "track", "one", 8), Flow("track", "search", "other", 8)], "in a circle"),
    (None, "flows gives NoneType, not a tuple of Flow"),
    ([("load", "search", "map", 8)], "flows gives list, not a tuple of Flow"),
]


@pytest.mark.parametrize(("told", "said"), LIES)
@pytest.mark.parametrize("scenario", ["plan_once", "drive"])
def test_flows_that_cannot_be_are_the_fault_of_the_plug_in(
    hwsw: Callable[..., Result], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, told: Any, said: str, scenario: str
) -> None:
    """Told when the workload is bound, before a trace is begun."""
    once = {"scenario": {"=": {"type": "plan_once"}}}
    files = Ground(tmp_path).files(workload=once if scenario == "plan_once" else {})
    monkeypatch.setattr(type(catalog.planner("breadth_first")), "flows", lambda *_: told)
    done = hwsw("run", *files, "--trace", tmp_path / "none.mcap")
    assert done.exit_code == 2
    assert "planner plug-in breadth_first: " in done.output
    assert "BreadthFirst.flows" in done.output
    assert said in done.output
    assert not (tmp_path / "none.mcap").exists()


def test_flows_of_several_names_between_two_tasks_are_sound(monkeypatch: pytest.MonkeyPatch) -> None:
    both = Flow("load", "search", "map", 8), Flow("load", "search", "more", 8)

    planner = catalog.planner("breadth_first")
    monkeypatch.setattr(type(planner), "flows", lambda *_: both)
    assert sound_flows(planner, Job(None, None)) == both


def test_without_broken_plug_ins_the_list_has_no_such_kind() -> None:
    assert "broken plug-ins" not in at_hand()
