"""Axes of a file: ranges, and axes that exist for some points only."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import codesign
from codesign.ground.errors import SpecError
from codesign.inputs import Workload, held, pin
from codesign.inputs.axes import MAX_VALUES, with_listed_axes
from codesign.inputs.exploration import Exploration
from codesign.inputs.exploring import exploring
from codesign.inputs.files import kept_document, read_kept
from codesign.inputs.yaml_tree import parse_document
from codesign.study.explored import Explored
from codesign.study.space import Space

WORKLOAD = """kind: workload
name: mine
planner: harmonic
problem:
  map: {generate: empty, rows: 16, columns: 24}
  goals: [[1, 1]]
  starts: [[14, 22]]
mapping:
  relax: {component: fpga, block: [8, 12], iterations: 6, schedule: [7, 15, 31]}
  decide: {component: fpga}
variants:
  on-host:
    planner: relaxation
    mapping: {relax: {component: host, method: sor, omega: 1.8}}
explore:
  axes:
"""


def load(folder: Path, axes: str) -> Workload:
    lines = "".join(f"    {line}\n" for line in axes.strip().splitlines())
    (folder / "w.yaml").write_text(WORKLOAD + lines, encoding="utf-8")
    return codesign.load_workload(folder / "w.yaml")


def explore(workload: Workload) -> Exploration:
    assert workload.explore is not None
    return workload.explore


@pytest.mark.parametrize(
    ("written", "values"),
    [
        ("{from: 1, to: 4}", [1, 2, 3, 4]),
        ("{from: 50 MHz, to: 80 MHz, step: 10 MHz}", ["50 MHz", "60 MHz", "70 MHz", "80 MHz"]),
        ("{from: 1, to: 64, factor: 4}", [1, 4, 16, 64]),
        ("{from: 10 MHz, to: 1 GHz, count: 3, scale: log}", ["10 MHz", "100 MHz", "1 GHz"]),
        ("{from: 1, to: 10, count: 4}", [1, 4, 7, 10]),
        ("{from: 0.1, to: 0.4, step: 0.1}", [0.1, 0.2, 0.3, 0.4]),
        ("{from: 1 s, to: 2 s, count: 3, scale: linear}", ["1 s", "1.5 s", "2 s"]),
        ("{values: [3, 1]}", [3, 1]),
    ],
)
def test_an_axis_is_a_list_or_a_range(written: str, values: list[Any]) -> None:
    text = f"explore: {{axes: {{a.b: {written}}}}}"
    listed = with_listed_axes(parse_document(text.encode(), "w.yaml", Path()))
    assert listed.faults == ()
    assert listed.tree["explore"]["axes"]["a.b"] == values


@pytest.mark.parametrize(
    ("written", "told"),
    [
        (
            "{from: 1, to: 4, stp: 2}",
            "17:40: explore.axes.relax.iterations.stp: unknown key\n  hint: did you mean step?",
        ),
        ("{from: 1}", "17:23: explore.axes.relax.iterations: to is missing"),
        ("{}", "from is missing"),
        ("{from: 8, to: 1}", "from 8 to 1 has no value: the first is above the last"),
        ("{from: 1, to: 2, step: 0}", "does not end: a step is above 0"),
        ("{from: 1, to: 9, factor: 1}", "does not end: a factor is above 1"),
        ("{from: 1, to: 9, step: 1, factor: 2}", "step and factor together"),
        ("{from: 1, to: 9, scale: log}", "scale without count"),
        ("{from: 1, to: 9, count: 3, scale: cubic}", "there is no scale 'cubic'"),
        ("{from: 0, to: 9, count: 3, scale: log}", "needs two different ends above 0"),
        ("{from: 0 MHz, to: 9 MHz, count: 3, scale: log}", "'0 MHz' is zero\n  hint: a frequency is above 0"),
        ("{from: 1, to: " + "9" * 5000 + "}", "999... is too long or too large for a number"),
        ("{from: 1, to: 9e99, factor: 1.001}", "from 1 to 9e99 has too many values"),
        ("{from: .nan, to: 9}", "17:30: explore.axes.relax.iterations.from: .nan is not a finite number"),
        ("{from: 1 MHz, to: .inf, step: 1 MHz}", "17:41: explore.axes.relax.iterations.to: .inf is not a finite"),
        ("{from: 1, to: 9, count: 1000000000}", "from 1 to 9 has 1,000,000,000 values\n  hint: at most 1,000"),
        ("{from: 1, to: 9, count: 1}", "a count of at least 2"),
        ("{from: 1, to: 9, count: 2.5}", "'2.5' is no number of values"),
        ("{from: 1, to: 900000, step: 1}", f"has 900,000 values\n  hint: at most {MAX_VALUES:,}"),
        ("{from: 1 MHz, to: 9 s, step: 1 MHz}", "'9 s' has no unit of frequency"),
        ("{from: 1 MHz, to: 9 MHz}", "has no step"),
        ("{from: [1], to: 9}", "is no number and no quantity"),
        ("{from: true, to: 9}", "true is no number and no quantity"),
        ("{values: [1], to: 9}", "values and to together"),
        ("{values: 3}", "explore.axes.relax.iterations.values: is not a list"),
        ("{values: [1, 1]}", "17:36: explore.axes.relax.iterations.values[1]: 1 is listed twice"),
        ("{values: [1, two]}", "17:36: explore.axes.relax.iterations.values[1]: 'two' is not a whole number"),
        ("{from: 0, to: 1, step: 1}", "17:23: explore.axes.relax.iterations[0]: 0 is out of bounds"),
        ("{values: [1], when: {}}", "explore.axes.relax.iterations.when: names no axis"),
        ("{values: [1], when: 3}", "explore.axes.relax.iterations.when: is not a mapping"),
        ("{values: [1], when: {relax.blocks: 1}}", "there is no such axis among the decisions"),
        ("{values: [1], when: {relax.iterations: 1}}", "an axis does not depend on itself"),
    ],
)
def test_faults_of_an_axis_have_a_place(tmp_path: Path, written: str, told: str) -> None:
    with pytest.raises(SpecError) as caught:
        load(tmp_path, f"relax.iterations: {written}")
    message = str(caught.value)
    assert told in message
    assert f"{tmp_path / 'w.yaml'}:17:" in message
    assert message.count("w.yaml:") == 1, message


CONDITIONAL = """
relax.iterations: {values: [4, 6], when: {workload.variant: base}}
workload.variant: [base, on-host]
relax.omega: {from: 1.5, to: 1.9, step: 0.2, when: {workload.variant: [on-host]}}
pci.clock: [33 MHz, 66 MHz]
"""


def test_axes_of_a_variant_multiply_only_its_own_points(tmp_path: Path) -> None:
    section = explore(load(tmp_path, CONDITIONAL))
    assert section.points == 2 * 2 + 3 * 2
    assert list(section.axes) == ["workload.variant", "relax.iterations", "relax.omega", "pci.clock"]
    again = Exploration.model_validate(section.model_dump(mode="json"))
    assert (again.axes, again.points) == (section.axes, section.points)
    points = [point.axes for point in Space(section.every_axis, "", when=section.when).points()]
    assert points[0] == {"workload.variant": "base", "relax.iterations": 4, "pci.clock": "33 MHz"}
    assert points[-1] == {"workload.variant": "on-host", "relax.omega": 1.9, "pci.clock": "66 MHz"}


def test_every_point_that_exists_can_be_made(tmp_path: Path) -> None:
    explored = Explored.of(codesign.load_platform("virtex4-pci"), load(tmp_path, CONDITIONAL))
    explored.check_axes()
    section = explored.section
    made = [explored.point(point.axes)[1] for point in Space(section.every_axis, "", when=section.when).points()]
    assert [workload.planner for workload in made] == ["harmonic"] * 4 + ["relaxation"] * 6


@pytest.mark.parametrize(
    ("axes", "told"),
    [
        (
            "workload.variant: [base, on-host]\nrelax.iterations: {values: [4], when: {workload.variant: bse}}",
            "18:62: explore.axes.relax.iterations.when.workload.variant: 'bse' is no value of axis workload.variant\n"
            "  hint: did you mean base?",
        ),
        (
            "relax.iterations: {values: [4], when: {workload.varian: base}}\nworkload.variant: [base, on-host]",
            "explore.axes.relax.iterations.when.workload.varian: there is no such axis among the decisions\n"
            "  hint: did you mean workload.variant?",
        ),
        (
            "relax.iterations: {values: [4], when: {relax.block: [[8, 12]]}}\n"
            "relax.block: {values: [[8, 12]], when: {relax.iterations: 4}}",
            "relax.iterations depends on an axis that depends on it",
        ),
        (
            "workload.variant: [base, on-host]\nrelax.iterations: {values: [4], when: {workload.variant: null}}",
            "18:62: explore.axes.relax.iterations.when.workload.variant: an empty value is no value of axis",
        ),
        (
            "workload.variant: [base, on-host]\nrelax.iterations: {values: [4], when: {workload.variant: base}}\n"
            "relax.omega: {values: [1.5], when: {workload.variant: on-host, relax.iterations: 4}}",
            "no point has axis relax.omega: its conditions contradict each other",
        ),
    ],
)
def test_what_axes_depend_on_is_checked(tmp_path: Path, axes: str, told: str) -> None:
    with pytest.raises(SpecError) as caught:
        load(tmp_path, axes)
    assert told in str(caught.value)
    # That an axis does not fit where it should not exist is no fault beside this one.
    assert str(caught.value).count("w.yaml:") == 1


def test_a_condition_depends_on_nothing(tmp_path: Path) -> None:
    seed = "workload.problem.map.seed: {values: [1], when: {relax.iterations: 4}}"
    text = f"{WORKLOAD}    relax.iterations: [4]\n  conditions:\n    {seed}\n"
    (tmp_path / "w.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=r"19:46: .*seed\.when: a condition is met by every design"):
        codesign.load_workload(tmp_path / "w.yaml")


def test_an_axis_is_checked_only_where_it_exists(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"when: {workload.variant: \[...\]}"):
        load(tmp_path, "workload.variant: [base, on-host]\ndecide.style: [x]")
    with pytest.raises(SpecError, match=r"relax\.iterations"):
        load(tmp_path, "workload.variant: [base, on-host]\nrelax.iterations: [4, 6]")
    load(tmp_path, CONDITIONAL)


def test_settled_axes_settle_what_depends_on_them(tmp_path: Path) -> None:
    workload, platform = load(tmp_path, CONDITIONAL), codesign.load_platform("virtex4-pci")
    for name, axes in (("base", ["relax.iterations", "pci.clock"]), ("on-host", ["relax.omega", "pci.clock"])):
        _, pinned = pin(platform, workload, {"workload.variant": name})
        assert list(explore(pinned).axes) == axes
        assert explore(pinned).when == {}
        assert Explored.of(platform, pinned).section.points == explore(pinned).points
    _, pinned = pin(platform, workload, {"relax.iterations": 6})
    assert explore(pinned).points == 1 * 2 + 3 * 2
    assert explore(held(workload, {"workload.variant": "base"})).points == 4


def test_other_values_on_the_command_line_keep_what_an_axis_depends_on(tmp_path: Path) -> None:
    workload = load(tmp_path, CONDITIONAL)
    assert explore(exploring(workload, {"relax.iterations": [1, 2, 3]}, {})).points == 3 * 2 + 3 * 2


def test_an_axis_of_one_platform(tmp_path: Path) -> None:
    axes = "platform: [virtex4-pci, zynq]\npci.clock: {values: [33 MHz, 66 MHz], when: {platform: virtex4-pci}}"
    workload = load(tmp_path, axes)
    assert explore(workload).points == 3
    assert Explored.of(codesign.load_platform("virtex4-pci"), workload).section.points == 2
    alone = Explored.of(codesign.load_platform("zynq"), workload).section
    assert (alone.points, dict(alone.axes)) == (1, {})


def test_a_kept_document_has_the_same_space(tmp_path: Path) -> None:
    workload = load(tmp_path, CONDITIONAL)
    again = codesign.load_workload(read_kept(json.loads(json.dumps(kept_document(workload.document)))))
    assert explore(again).axes == explore(workload).axes
    assert explore(again).when == explore(workload).when
    explored = Explored.of(codesign.load_platform("virtex4-pci"), pin_variant(workload))
    again = codesign.load_workload(read_kept(json.loads(json.dumps(kept_document(explored.workload.document)))))
    assert explore(again).points == explored.section.points == 4


def pin_variant(workload: Workload) -> Workload:
    return pin(codesign.load_platform("virtex4-pci"), workload, {"workload.variant": "base"})[1]


def test_an_axis_is_checked_with_the_values_for_which_it_exists(tmp_path: Path) -> None:
    rooms = "{generate: rooms, rows: 32, columns: 48}"
    map_axes = f"workload.problem.map: [{{generate: empty, rows: 16, columns: 24}}, {rooms}]"
    seed = f"{{values: [1, 2], when: {{workload.problem.map: {rooms}}}}}"
    workload = load(tmp_path, f"{map_axes}\nworkload.problem.map.seed: {seed}")
    assert explore(workload).points == 3
    Explored.of(codesign.load_platform("virtex4-pci"), workload).check_axes()
