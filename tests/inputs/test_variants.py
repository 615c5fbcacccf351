"""Variants of a workload: what they replace, where their faults are told, and axes that choose among them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from input_fuzz import faults_of, paths, quietly, replaced, trees
from spec_texts import PLATFORM, TASKS, WORKLOAD, Decide, Relax

from codesign.errors import SpecError
from codesign.inputs import (
    Platform,
    Workload,
    cross_check,
    design_point,
    fault,
    has_axis,
    json_schema,
    load_platform,
    load_workload,
    pin,
)
from codesign.inputs.scenario import Drive, ReplanPolicy
from codesign.inputs.workload import TaskModels
from codesign.inputs.yaml_tree import parse_document
from codesign.models import TaskParameters


class Search(TaskParameters):
    depth: int = 1


class Elsewhere(TaskParameters):
    robots: int


ALL_TASKS: TaskModels = {**TASKS, "search": {"find": Search, "decide": Decide}, "crowd": {"steer": Search}}
PROBLEMS = {"crowd": Elsewhere}

DRIVE = """\
scenario:
  type: drive
  control_period: 50 ms
  replan: {policy: restart, trigger: change}
"""
VARIANTS = """\
variants:
  on-host:
    description: the host searches
    planner: search
    mapping:
      find: {component: host, depth: 3}
  coarse:
    mapping:
      relax: {component: fpga, block: [10, 10], iterations: 2, schedule: [7]}
      sense: {component: host}
  patient:
    scenario: {replan: {policy: continue}}
"""
WITH = WORKLOAD.replace("explore:\n", f"{DRIVE}{VARIANTS}explore:\n").replace(
    "    relax.block: [[20, 30], [10, 15]]\n    relax.schedule.last: [63, 127]\n", ""
)
VARIANT_AXIS = "  axes:\n    workload.variant: [base, coarse]\n"


def load(folder: Path, *changes: tuple[str, str], text: str = WITH) -> tuple[Platform, Workload]:
    platform = PLATFORM
    for old, new in changes:
        assert old in platform + text, old
        platform, text = platform.replace(old, new), text.replace(old, new)
    (folder / "p.yaml").write_text(platform)
    (folder / "w.yaml").write_text(text)
    return load_platform(folder / "p.yaml"), load_workload(folder / "w.yaml", ALL_TASKS, PROBLEMS)


def faults(folder: Path, *changes: tuple[str, str], text: str = WITH) -> str:
    with pytest.raises(SpecError) as caught:
        cross_check(*load(folder, *changes, text=text))
    return str(caught.value).replace(f"{folder}/", "")


def chosen(folder: Path, name: str, *changes: tuple[str, str]) -> Workload:
    return design_point(*load(folder, *changes), {"workload.variant": name})[1]


def test_a_variant_equals_the_file_written_that_way(tmp_path: Path) -> None:
    made = chosen(tmp_path, "on-host")
    mapping = WORKLOAD[WORKLOAD.index("mapping:") : WORKLOAD.index("explore:")]
    other = mapping.replace(mapping, "mapping:\n  find: {component: host, depth: 3}\n")
    written = load(tmp_path, (mapping, other), ("planner: harmonic\n", "planner: search\n"), (VARIANTS, ""))[
        1
    ]
    assert (made.planner, made.mapping, made.scenario) == (written.planner, written.mapping, written.scenario)
    assert made.digest() == written.digest()
    assert set(made.task_models or {}) >= {"find", "decide", "sense"}
    assert made.variants == {}


def test_what_a_variant_leaves_out_is_the_workloads_own(tmp_path: Path) -> None:
    made = chosen(tmp_path, "patient")
    assert isinstance(made.scenario, Drive)
    assert made.scenario.replan.policy is ReplanPolicy.CONTINUE
    assert (made.scenario.replan.trigger, made.scenario.control_period) == ("change", 50 * 10**9)
    base = chosen(tmp_path, "base")
    assert isinstance(base.scenario, Drive)
    assert base.scenario.replan.policy is ReplanPolicy.RESTART
    assert (made.planner, made.mapping) == (base.planner, base.mapping)


def test_a_scenario_of_another_type_takes_nothing_over(tmp_path: Path) -> None:
    assert chosen(
        tmp_path, "patient", ("{replan: {policy: continue}}", "{type: plan_once}")
    ).scenario.type == ("plan_once")


def test_variants_that_are_not_chosen_change_no_digest_and_no_run(tmp_path: Path) -> None:
    specs = load(tmp_path)
    without = load(tmp_path, (VARIANTS, ""))
    assert (
        specs[1].digest()
        == without[1].digest()
        == design_point(*specs, {"workload.variant": "base"})[1].digest()
    )
    assert len({chosen(tmp_path, name).digest() for name in ("base", "on-host", "coarse", "patient")}) == 4


def test_parameters_and_scenario_move_in_the_chosen_variant(tmp_path: Path) -> None:
    specs = load(tmp_path)
    values: dict[str, Any] = {"relax.iterations": 9, "workload.variant": "coarse"}
    _, made = design_point(*specs, values | {"workload.scenario.replan.policy": "lower_bound"})
    relax = made.mapping["relax"].parameters
    assert isinstance(relax, Relax)
    assert (relax.block, relax.iterations) == ((10, 10), 9)
    assert isinstance(made.scenario, Drive)
    assert made.scenario.replan.policy is ReplanPolicy.LOWER_BOUND
    # An axis beats the variant, whichever is put in first, and only what is named moves.
    _, patient = design_point(
        *design_point(*specs, {"workload.scenario.control_period": "70 ms"}), {"workload.variant": "patient"}
    )
    assert isinstance(patient.scenario, Drive)
    assert (patient.scenario.control_period, patient.scenario.replan.policy) == (70 * 10**9, "continue")


def test_a_variant_is_chosen_once(tmp_path: Path) -> None:
    specs = design_point(*load(tmp_path), {"workload.variant": "coarse"})
    with pytest.raises(SpecError, match="has no variants"):
        design_point(*specs, {"workload.variant": "base"})


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("corse", "--set workload.variant: there is no variant 'corse'\n  hint: did you mean coarse? accepted: "
                  "base, coarse, on-host, patient"),
        (3, "--set workload.variant: 3 names no variant"),
    ],
)  # fmt: skip
def test_a_variant_that_is_none(tmp_path: Path, name: Any, expected: str) -> None:
    with pytest.raises(SpecError) as caught:
        design_point(*load(tmp_path), {"workload.variant": name}, "--set ")
    assert str(caught.value).startswith(expected)


def test_what_is_found_out_later_is_told_where_the_variant_says_it(tmp_path: Path) -> None:
    def at(workload: Workload, *path: str) -> str:
        return str(fault(workload, path, "is wrong")).replace(f"{tmp_path}/", "")

    coarse, patient = chosen(tmp_path, "coarse"), chosen(tmp_path, "patient")
    line = 1 + WITH[: WITH.index("block: [10, 10]")].count("\n")
    assert at(coarse, "mapping", "relax", "block") == (
        f"w.yaml:{line}:39: variants.coarse.mapping.relax.block: is wrong"
    )
    assert at(patient, "mapping", "relax", "block").endswith(" mapping.relax.block: is wrong")
    assert at(patient, "scenario", "replan", "policy").endswith(
        "variants.patient.scenario.replan.policy: is wrong"
    )
    assert at(patient, "scenario", "replan", "trigger").endswith(" scenario.replan.trigger: is wrong")
    moved = design_point(*load(tmp_path), {"workload.variant": "coarse", "relax.iterations": 4})[1]
    assert at(moved, "mapping", "relax", "iterations") == "point: relax.iterations: is wrong"


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (("  patient:\n", "  base:\n"), "variants.base: base is what the workload itself does\n  hint: give the"),
        (("planner: search", "planner: serch"), "variants.on-host.planner: there is no planner 'serch'\n  hint: did"),
        (("planner: search", "planner: crowd"), "variants.on-host.planner: the problem of crowd is of another kind"),
        (("depth: 3", "depth: deep"), "variants.on-host.mapping.find.depth: 'deep' is not a whole number"),
        (("depth: 3", "dept: 3"), "variants.on-host.mapping.find.dept: unknown key\n  hint: did you mean depth?"),
        (("      find:", "      relax:"), "variants.on-host.mapping.relax: search has no task 'relax'"),
        (("iterations: 2", "iterations: 0"), "variants.coarse.mapping.relax.iterations: 0 is out of bounds"),
        (("policy: continue", "policy: kontinue"), "variants.patient.scenario.replan.policy: 'kontinue' is not"),
        (("{replan: {policy: continue}}", "{replay: 1}"), "variants.patient.scenario.replay: unknown key"),
        (("{replan: {policy: continue}}", "often"), "variants.patient.scenario: 'often' is not a mapping"),
        (("    description: the host searches", "    color: red"), "variants.on-host.color: unknown key\n  hint: "
         "accepted: description, mapping, planner, scenario"),
        (("    scenario: {replan: {policy: continue}}", "    planner: search"),
         "variants.patient.planner: the workload maps the tasks of harmonic, not those of search"),
        (("variants:\n", "variants: 3\nother:\n"), "variants: 3 is not a mapping"),
        (("  patient:\n    scenario: {replan: {policy: continue}}", "  patient: 7"), "variants.patient: 7 is not a"),
    ],
)  # fmt: skip
def test_faults_of_variants_are_told_at_their_place(
    tmp_path: Path, change: tuple[str, str], expected: str
) -> None:
    told = faults(tmp_path, change)
    place, _, text = told.partition(": ")
    line, word = int(place.split(":")[1]), expected.partition(":")[0].rpartition(".")[2]
    assert text.startswith(expected), told
    assert word in (tmp_path / "w.yaml").read_text().splitlines()[line - 1]


def test_a_key_of_the_workload_that_clashes_is_told_of_the_variant(tmp_path: Path) -> None:
    # The base's obstacle goes at 30 s; the variant lets it appear later than that.
    obstacle = "  obstacles: {random: {count: 3, begin: 0 s, end: 30 s}}\n"
    told = faults(
        tmp_path,
        ("  control_period: 50 ms\n", f"  control_period: 50 ms\n{obstacle}"),
        ("{replan: {policy: continue}}", "{obstacles: {random: {begin: 40 s}}}"),
    )
    assert "variants.patient.scenario.obstacles.random.end: the end lies before the begin" in told


def test_a_variant_without_a_mapping_keeps_no_task_that_its_scenario_lacks(tmp_path: Path) -> None:
    told = faults(
        tmp_path,
        ("    schedule: {first: 7, step: 8, last: 63}\n", "    schedule: [7]\n  sense: {component: host}\n"),
        ("{replan: {policy: continue}}", "{type: plan_once}"),
    )
    assert (
        "variants.patient.scenario: scenario plan_once has no task 'sense', which the mapping places" in told
    )


def test_mapped_components_of_the_variants_explored_are_checked(tmp_path: Path) -> None:
    wrong = ("find: {component: host", "find: {component: hots")
    cross_check(*load(tmp_path, wrong))
    told = faults(tmp_path, wrong, ("  axes:\n", "  axes:\n    workload.variant: [on-host, coarse]\n"))
    assert "variants.on-host.mapping.find.component: platform mine has no component 'hots'" in told
    # What the exploration does not run is no fault of it.
    nowhere = ("    component: fpga\n    block: [20", "    component: gone\n    block: [20")
    only = ("  axes:\n", "  axes:\n    workload.variant: [on-host, coarse]\n")
    cross_check(*load(tmp_path, nowhere, only), explored=True)
    with pytest.raises(SpecError, match="no component 'gone'"):
        cross_check(*load(tmp_path, nowhere, only))
    with pytest.raises(SpecError, match="no component 'gone'"):
        cross_check(*load(tmp_path, nowhere, ("  axes:\n", VARIANT_AXIS)), explored=True)


@pytest.mark.parametrize(
    ("axes", "expected"),
    [
        (
            "workload.variant: [base, corse]",
            "workload.variant[1]: there is no variant 'corse'\n  hint: did you mean",
        ),
        ("workload.variant: [[coarse]]", "workload.variant[0]: a list names no variant"),
        ("workload.variant: [base, base]", 'workload.variant[1]: "base" is listed twice'),
        (
            "workload.variant: [base, on-host]\n    relax.iterations: [1]",
            "relax.iterations: variant on-host maps no task relax\n  hint: explore relax in a workload without",
        ),
        (
            "workload.variant: [coarse]\n    relax.dept: [1]",
            "relax.dept: unknown key in variant coarse",
        ),
        (
            "workload.variant: [base, coarse]\n    relax.schedule.last: [63]",
            "relax.schedule.last: mapping.relax.schedule is not a mapping in variant coarse",
        ),
        ("workload.scenario.control_period: [10]", "workload.scenario.control_period[0]: 10 has no unit"),
        (
            "workload.scenario.control_period: [0 ms]",
            "workload.scenario.control_period[0]: a control period below",
        ),
        (
            "workload.scenario.control_period: [100 ms, 0.1 s]",
            "workload.scenario.control_period[1]: '0.1 s' says the same as a value before it",
        ),
        (
            "workload.scenario.replan.polcy: [restart]",
            "workload.scenario.replan.polcy: unknown key\n  hint: did you mean policy? accepted: ",
        ),
        (
            "workload.scenario.replan.policy: [restrat]",
            "workload.scenario.replan.policy[0]: 'restrat' is not accepted",
        ),
        ("workload.scenario.known.all: [1]", "workload.scenario.known.all[0]: "),
        (
            "workload.variant: [base, patient]\n    workload.scenario.replan.policy: [restart]",
            "workload.scenario.replan.policy: variant patient sets scenario.replan.policy itself",
        ),
        (
            "workload.scenario.replan.policy: [restart]\n    workload.scenario.replan: [{policy: continue}]",
            "workload.scenario.replan: sets the same thing as axis workload.scenario.replan.policy",
        ),
        (
            "workload.speed: [1]",
            "workload.speed: an axis moves no 'workload.speed'\n  hint: did you mean workload.problem? accepted: ",
        ),
        ("pci.clok: [33 MHz]", "pci.clok: unknown key\n  hint: did you mean clock? accepted: "),
        ("pci.between: [[host, fpga]]", "pci.between: between of pci is no axis: it stands in the platform"),
        ("pci.clock: [33]", "pci.clock[0]: 33 has no unit"),
        ("pci.clock: [33 MHz, 33000 kHz]", "pci.clock[1]: '33000 kHz' says the same as a value before it"),
        ("pci.errors.drop: [2]", "pci.errors.drop[0]: 2 is out of bounds"),
        (
            "pic.clock: [33 MHz]",
            "pic.clock: there is no task, component or link 'pic'\n  hint: did you mean pci?",
        ),
    ],
)
def test_faults_of_axes(tmp_path: Path, axes: str, expected: str) -> None:
    told = faults(tmp_path, ("    fpga.clock: [100 MHz, 150 MHz]\n", f"    {axes}\n"))
    assert f"explore.axes.{expected}" in told


@pytest.mark.parametrize(
    "axes",
    [
        "workload.variant: [base, coarse]\n    relax.iterations: [1, 6]",
        "workload.variant: [on-host, patient]\n    workload.scenario.known: [all, none]",
        "workload.variant: [coarse]\n    sense.component: [host, fpga]",
        "pci.clock: [33 MHz, 66 MHz]\n    pci.errors.drop: [0.0, 0.1]",
        "workload.scenario.obstacles.appearing: [[], [{at: 1 s, row: 3, column: 3}]]",
    ],
)
def test_sound_axes(tmp_path: Path, axes: str) -> None:
    cross_check(*load(tmp_path, ("    fpga.clock: [100 MHz, 150 MHz]\n", f"    {axes}\n")))


def test_axes_need_variants_to_choose_from(tmp_path: Path) -> None:
    told = faults(tmp_path, (VARIANTS, ""), ("  axes:\n", "  axes:\n    workload.variant: [base]\n"))
    assert "explore.axes.workload.variant: the workload has no variants\n  hint: add variants:" in told


def test_links_move_as_components_do(tmp_path: Path) -> None:
    specs = load(tmp_path)
    platform, _ = design_point(
        *specs, {"pci.clock": "66 MHz", "pci.errors.bit_error_rate": 1e-6, "pci.width": 64}
    )
    pci = platform.links["pci"]
    assert (pci.clock.value, pci.width.value) == (66_000_000, 64)  # type: ignore[union-attr]
    assert pci.clock.source == "chosen for this design point"  # type: ignore[union-attr]
    assert pci.burst_words.source == "declared in p.yaml:12"  # type: ignore[union-attr]
    assert pci.errors is not None
    assert (pci.errors.bit_error_rate, pci.errors.retries) == (1e-6, 3)
    assert platform.digest() != specs[0].digest()
    assert specs[0].links["pci"].errors is None
    written = load(
        tmp_path,
        ("width: 32, clock: 33 MHz", "width: 64, clock: 66 MHz"),
        ("burst_words: 16}", "burst_words: 16, errors: {bit_error_rate: 1e-6}}"),
    )[0]
    assert platform.digest() == written.digest()


def test_a_setting_that_is_no_axis(tmp_path: Path) -> None:
    for values, expected in (
        (
            {"pci": 3},
            "--set pci: no axis: write TASK.PARAMETER, COMPONENT.FIELD or LINK.FIELD\n  hint: name what",
        ),
        ({"pci.between": ["host", "fpga"]}, "--set pci.between: between of pci is no axis"),
        ({"fpga.type": "processor"}, "--set fpga.type: type of fpga is no axis"),
        ({"sense.dept": 1, "workload.variant": "coarse"}, "--set sense.dept: unknown key"),
        (
            {"workload.scenario.control_period": "0 ms"},
            "--set workload.scenario.control_period: a control period",
        ),
        (
            {"workload.scenario.known.all": 1},
            "--set workload.scenario.known.all: scenario.known: a mapping is not accepted",
        ),
        (
            {"workload.variant": "coarse", "workload.scenario.type": "plan_once"},
            "--set workload.scenario.type: scenario.control_period: unknown key",
        ),
    ):
        with pytest.raises(SpecError) as caught:
            design_point(*load(tmp_path), values, "--set ")
        assert str(caught.value).startswith(expected)


def test_a_mapping_keeps_no_task_that_a_moved_scenario_lacks(tmp_path: Path) -> None:
    values = {"workload.variant": "coarse", "workload.scenario": {"type": "plan_once"}}
    with pytest.raises(SpecError, match="scenario plan_once has no task 'sense'"):
        design_point(*load(tmp_path), values)


def test_pinned_axes_leave_the_exploration(tmp_path: Path) -> None:
    specs = load(tmp_path, ("  axes:\n", VARIANT_AXIS + "    relax.iterations: [1, 6]\n"))
    _, made = pin(*specs, {"workload.variant": "coarse"})
    assert made.explore is not None
    assert list(made.explore.axes) == ["relax.iterations", "fpga.clock"]
    _, made = pin(*specs, {"pci.clock": "66 MHz"})
    assert made.explore is not None
    assert list(made.explore.axes) == ["workload.variant", "relax.iterations", "fpga.clock"]
    assert made.variants


def test_what_is_pinned_holds_in_every_variant_explored(tmp_path: Path) -> None:
    specs = load(tmp_path, ("  axes:\n", "  axes:\n    workload.variant: [base, coarse, patient]\n"))
    platform, made = pin(*specs, {"relax.iterations": 9, "workload.scenario.replan.policy": "lower_bound"})
    assert made.explore is not None
    axes = made.explore.axes
    assert list(axes) == [
        "relax.iterations", "workload.scenario.replan.policy", "workload.variant", "fpga.clock",
    ]  # fmt: skip
    for name in axes["workload.variant"]:
        point = {axis: values[0] for axis, values in axes.items()} | {"workload.variant": name}
        _, one = design_point(platform, made, point)
        relax = one.mapping["relax"].parameters
        assert isinstance(relax, Relax)
        assert isinstance(one.scenario, Drive)
        assert (relax.iterations, one.scenario.replan.policy) == (9, "lower_bound")
        # The rest is as each variant has it.
        assert (relax.block == (10, 10)) == (name == "coarse")


def test_what_is_pinned_stands_before_an_axis_inside_of_it(tmp_path: Path) -> None:
    axes = "    workload.variant: [base, patient]\n    relax.schedule.last: [23, 31]\n"
    specs = load(tmp_path, ("  axes:\n", f"  axes:\n{axes}"))
    platform, made = pin(*specs, {"relax.schedule": {"first": 15, "step": 8, "last": 63}})
    assert made.explore is not None
    point = {axis: values[0] for axis, values in made.explore.axes.items()}
    relax = design_point(platform, made, point)[1].mapping["relax"].parameters
    assert isinstance(relax, Relax)
    assert relax.schedule.model_dump() == {"first": 15, "step": 8, "last": 23}  # type: ignore[union-attr]


def test_nothing_is_pinned_that_a_variant_explored_does_not_have(tmp_path: Path) -> None:
    specs = load(tmp_path, ("  axes:\n", "  axes:\n    workload.variant: [base, on-host]\n"))
    with pytest.raises(SpecError) as caught:
        pin(*specs, {"relax.iterations": 9}, "--set ")
    assert str(caught.value).startswith(
        "variant on-host: --set relax.iterations: there is no task, component or link 'relax'"
    )


def test_what_counts_as_an_axis(tmp_path: Path) -> None:
    specs = load(tmp_path)
    there = ["workload.variant", "workload.scenario.known", "workload.problem.map.rows", "workload.problem",
             "relax.block", "relax.component", "pci.clock", "fpga.clock"]  # fmt: skip
    assert [has_axis(*specs, axis) for axis in there] == [True] * len(there)
    absent = ["find.depth", "pci.between", "pci.baud", "workload.scenario.robots", "workload", "usb.clock"]
    assert [has_axis(*specs, axis) for axis in absent] == [False] * len(absent)
    assert not has_axis(*load(tmp_path, (VARIANTS, "")), "workload.variant")


TREE = parse_document(
    WITH.replace(
        "  axes:\n",
        "  axes:\n    workload.variant: [base, coarse]\n    relax.iterations: [1, 6]\n    pci.clock: [33 MHz]\n"
        "    workload.scenario.control_period: [50 ms, 70 ms]\n",
    ).encode(),
    "w",
    Path(),
).tree


def test_the_tree_of_the_fuzz_is_sound(tmp_path: Path) -> None:
    cross_check(*load(tmp_path, text=json.dumps(TREE)))


@settings(quietly, max_examples=60)
@given(st.data())
def test_one_wrong_value_anywhere(tmp_path: Path, data: st.DataObject) -> None:
    path = data.draw(st.sampled_from([each for each in paths(TREE) if each]))
    text = json.dumps(replaced(TREE, path, data.draw(trees)))
    made: list[Workload] = []

    def loaded() -> None:
        platform, workload = load(tmp_path, text=text)
        made.append(workload)
        cross_check(platform, workload)

    for each in faults_of(loaded):
        assert len(str(each)) < 1000
    for workload in made:
        # What was accepted on loading is there to be chosen.
        for name in workload.variants:
            assert design_point(load_platform(tmp_path / "p.yaml"), workload, {"workload.variant": name})


@settings(quietly, max_examples=60)
@given(
    st.sampled_from(
        [
            "workload.variant", "workload.variant.x", "workload.scenario", "workload.scenario.replan",
            "workload.scenario.replan.policy", "workload.scenario.obstacles.random.count", "workload.scenario.type",
            "workload.x", "workload", "pci", "pci.clock", "pci.errors", "pci.errors.late.share", "pci.between",
        ]
    ),
    trees,
)  # fmt: skip
def test_any_value_of_an_axis(tmp_path: Path, axis: str, value: Any) -> None:
    specs = load(tmp_path)
    faults_of(lambda: design_point(*specs, {axis: value}))
    faults_of(lambda: design_point(*specs, {axis: value, "workload.variant": "patient"}))
    text = json.dumps({**TREE, "explore": {"axes": {axis: [value], "relax.iterations": [1]}}})
    faults_of(lambda: cross_check(*load(tmp_path, text=text)))


def test_the_schema_knows_variants() -> None:
    import jsonschema

    schema = json_schema("workload", ALL_TASKS, PROBLEMS)
    validator = jsonschema.Draft202012Validator(schema)
    assert list(validator.iter_errors(TREE)) == []
    for path, value in (
        (("variants", "on-host", "planner"), "serch"),
        (("variants", "on-host", "mapping", "find", "dept"), 3),
        (("variants", "coarse", "mapping", "relax", "iterations"), "6"),
        (("variants", "coarse", "mapping", "sense", "depth"), 1),
        (("variants", "patient", "colour"), "red"),
        (("variants", "patient", "scenario"), 3),
    ):
        inner = replaced(TREE, path[:-1], {**_at(TREE, path[:-1]), path[-1]: value})
        assert not validator.is_valid(inner), path


def _at(tree: Any, path: tuple[str, ...]) -> Any:
    for step in path:
        tree = tree[step]
    return tree
