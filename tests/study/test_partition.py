"""What is put together computes the same; the shipped studies are priced, but for named reasons."""

from __future__ import annotations

import re
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import codesign
from codesign.ground.errors import CodesignError, SpecError
from codesign.ground.memo import Memo
from codesign.inputs import Workload, load_platform
from codesign.study.evaluation import Pricer, computation_digest
from codesign.study.explored import Explored
from codesign.study.partition import Alone, Together, Turns, parted
from codesign.study.pricing.computation import record
from codesign.study.pricing.price import price
from codesign.study.space import Space
from codesign.system.bind import System
from codesign.system.scenarios import bind

AXES: dict[str, list[Any]] = {
    "fabric.part": ["XC2V6000-4", "XC4VLX160-12", "XC3S500E-4"],
    "fabric.clock": ["10 MHz", "100 MHz", "400 MHz"],
    "host.clock": ["1 GHz", "3 GHz"],
    "pci.clock": ["33 MHz", "66 MHz"],
    "pci.width": [32, 64],
    "pci.power.idle": ["10 mW", "1 W"],
    "relax.block": [[6, 9], [12, 18]],
    "relax.iterations": [2, 4],
    "relax.schedule": [[15, 31], [31]],
    "workload.problem.map.seed": [1, 2],
    "workload.variant": ["base", "on-host"],
}
"""What may be explored, on a map of 12 × 18 cells."""

TEXT = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: rooms, rows: 12, columns: 18, room: [5, 5], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 3, seed: 1}
mapping:
  relax: {component: fabric, block: [6, 9], iterations: 4, schedule: [15, 31]}
variants:
  on-host: {mapping: {relax: {component: host, block: [6, 9], iterations: 4, schedule: [15, 31]}}}
"""


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Workload:
    file = tmp_path_factory.mktemp("partition") / "small.yaml"
    file.write_text(TEXT, encoding="utf-8")
    return codesign.load_workload(file)


@st.composite
def spaces(draw: st.DrawFn) -> tuple[dict[str, tuple[Any, ...]], dict[str, dict[str, tuple[Any, ...]]]]:
    """Some of the axes with some of their values; some of them exist for one variant only."""
    names = draw(st.lists(st.sampled_from(list(AXES)), min_size=1, max_size=5, unique=True))
    axes = {name: tuple(draw(st.lists(st.sampled_from(AXES[name]), min_size=1, unique_by=str))) for name in names}
    variants = axes.get("workload.variant", ())
    depending = draw(st.sets(st.sampled_from(names))) - {"workload.variant"} if variants else set()
    return axes, {name: {"workload.variant": (draw(st.sampled_from(variants)),)} for name in depending}


def system_of(explored: Explored, axes: dict[str, Any]) -> System | None:
    try:
        return bind(*explored.point(axes))
    except CodesignError:
        return None


@settings(max_examples=25)
@given(spaces(), st.data())
def test_every_point_stands_in_one_work_and_those_together_compute_the_same(
    small: Workload, drawn: Any, data: st.DataObject
) -> None:
    axes, when = drawn
    section = codesign.inputs.Exploration(axes=axes, when=when)
    explored = Explored.of(load_platform("virtex2-pci"), small.model_copy(update={"explore": section}))
    space = Space(explored.section.every_axis, "", when=explored.section.when)
    pending = np.flatnonzero([data.draw(st.booleans()) or index < 3 for index in range(min(len(space), 64))])
    works = list(parted(explored, space, pending))
    assert sorted(index for work in works for index in work.indices) == pending.tolist()
    for work in works:
        if not isinstance(work, Together):
            continue
        systems = [system_of(explored, space.values(index)) for index in work.indices]
        bound = [system for system in systems if system is not None]
        assert len({computation_digest(system) for system in bound}) <= 1
        assert work.axes == space.values(work.indices[0])
        for place, system in enumerate(systems):
            if system is None:
                continue
            for name, which in work.specs.which.items():
                model = {**system.platform.components, **system.platform.links}[name]
                assert work.specs.models[name][which[place]] == model, name
        if len(bound) > 1:
            one, other = (record(system, Memo()) for system in (bound[0], bound[-1]))
            assert one.model_dump_json() == other.model_dump_json()


def test_points_that_compute_something_else_are_not_together(small: Workload) -> None:
    axes = {"relax.iterations": (2, 4), "fabric.clock": ("10 MHz", "20 MHz"), "pci.width": (32, 64)}
    section = codesign.inputs.Exploration(axes=axes)
    explored = Explored.of(load_platform("virtex2-pci"), small.model_copy(update={"explore": section}))
    space = Space(axes, "")
    works = list(parted(explored, space, np.arange(len(space))))
    assert [work.indices for work in works] == [(0, 1, 2, 3), (4, 5, 6, 7)]
    keys = [work.key for work in works if isinstance(work, Together)]
    assert len(set(keys)) == 2


def test_a_value_that_its_component_refuses_is_alone(small: Workload) -> None:
    axes = {"fabric.clock": ("10 MHz", "3 parsecs", "20 MHz")}
    section = codesign.inputs.Exploration(axes=axes)
    explored = Explored.of(load_platform("virtex2-pci"), small.model_copy(update={"explore": section}))
    works = list(parted(explored, Space(axes, ""), np.arange(3)))
    assert [(type(work), work.indices) for work in works] == [(Together, (0, 2)), (Alone, (1,))]


NAMED = (
    r"figure \S+ is computed of whole results",
    r"scenario \S+ is simulated event by event",
    r"tasks of the workload's own use the same components and links",
    r"accesses to an external memory depend on its rows",
    r"display \S+ takes cycles of the memory that the design works in",
    r"link \S+ loses messages or is down",
    r"of link \S+ and those beside it each message takes the fastest",
)
"""Why points are not priced, though others compute the same."""

SHIPPED = sorted(
    path.stem
    for path in Path("workloads").glob("*.yaml")
    if re.search(r"^explore:", path.read_text(encoding="utf-8"), re.M)
)
BOARDS = ("virtex4-pci", "nexys2", "arty-a7", "virtex2pro-vga", "nexys2-serial")
WORKS = 3
"""Works of each study that are computed here: the first ones of the order of points."""


def explored_on_a_board(workload: Workload) -> Explored:
    """The exploration on the first board that takes its axes."""
    assert workload.explore is not None
    if "platform" in workload.explore.axes:
        return Explored.of(None, workload)
    for board in BOARDS:
        explored = Explored.of(load_platform(board), workload)
        try:
            explored.check_axes()
        except SpecError:
            continue
        return explored
    raise AssertionError("no board takes the axes")


@pytest.mark.parametrize("name", SHIPPED)
def test_the_shipped_studies_are_priced_but_for_named_reasons(name: str) -> None:
    """``Pricer`` takes points apart where pricing raises: a fault of pricing costs time alone, so none would see it."""
    workload = codesign.load_workload(name)
    explored = explored_on_a_board(workload)
    section = explored.section
    space = Space(section.every_axis, "", when=section.when)
    decisions = Space(section.axes, "", when=section.when)
    works = parted(explored, space, np.arange(len(space)))
    ordered = Turns(decisions, len(space) // len(decisions)).sorted(works)
    together = [work for work in ordered if isinstance(work, Together)]
    assert together, "some points compute the same"
    pricer, priced = Pricer(explored, space), 0
    for work in islice(together, WORKS):
        done = pricer(work)
        priced += done.priced is not None
        assert not done.apart or any(re.fullmatch(why, done.why_apart) for why in NAMED), done.why_apart
    assert priced or any(re.fullmatch(why, done.why_apart) for why in NAMED)


@pytest.mark.parametrize("place", ["price", "bind"])
def test_an_assertion_ends_an_exploration(small: Workload, monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    """It is neither a failed point nor one that is simulated by itself and slower."""

    def broken(*_arguments: Any, **_options: Any) -> Any:
        raise AssertionError("a link has a law that pricing does not know")

    section = codesign.inputs.Exploration(axes={"fabric.clock": ("10 MHz", "20 MHz")})
    platform, workload = load_platform("virtex2-pci"), small.model_copy(update={"explore": section})
    monkeypatch.setattr(f"codesign.study.evaluation.{place}", broken)
    with pytest.raises(AssertionError, match="a law that pricing does not know"):
        codesign.explore(platform, workload, workers=1)


def test_a_fault_of_pricing_is_named_and_costs_no_result(small: Workload, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*arguments: Any) -> Any:
        price(*arguments)
        raise ZeroDivisionError("pricing broke")

    section = codesign.inputs.Exploration(axes={"fabric.clock": ("10 MHz", "20 MHz")})
    platform, workload = load_platform("virtex2-pci"), small.model_copy(update={"explore": section})
    sound = codesign.explore(platform, workload, workers=1)
    monkeypatch.setattr("codesign.study.evaluation.price", broken)
    explored = Explored.of(platform, workload)
    space = Space(explored.section.every_axis, "")
    (work,) = parted(explored, space, np.arange(2))
    assert Pricer(explored, space)(work).why_apart.startswith("ZeroDivisionError: pricing broke (")
    assert codesign.explore(platform, workload, workers=1).to_json() == sound.to_json()
