"""Variants of a workload: what each one is, and what is wrong with one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from input_fuzz import replaced
from spec_texts import WORKLOAD, Relax
from variant_texts import ALL_TASKS, PROBLEMS, TREE, VARIANT_AXIS, VARIANTS, WITH, faults, load

from codesign.ground.errors import SpecError
from codesign.inputs import Workload, cross_check, design_point, fault, json_schema
from codesign.inputs.scenario import Drive, ReplanPolicy


def chosen(folder: Path, name: str, *changes: tuple[str, str]) -> Workload:
    return design_point(*load(folder, *changes), {"workload.variant": name})[1]


def test_a_variant_equals_the_file_written_that_way(tmp_path: Path) -> None:
    made = chosen(tmp_path, "on-host")
    mapping = WORKLOAD[WORKLOAD.index("mapping:") : WORKLOAD.index("explore:")]
    other = mapping.replace(mapping, "mapping:\n  find: {component: host, depth: 3}\n")
    written = load(tmp_path, (mapping, other), ("planner: harmonic\n", "planner: search\n"), (VARIANTS, ""))[1]
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
    assert chosen(tmp_path, "patient", ("{replan: {policy: continue}}", "{type: plan_once}")).scenario.type == (
        "plan_once"
    )


def test_variants_that_are_not_chosen_change_no_digest_and_no_run(tmp_path: Path) -> None:
    specs = load(tmp_path)
    without = load(tmp_path, (VARIANTS, ""))
    assert specs[1].digest() == without[1].digest() == design_point(*specs, {"workload.variant": "base"})[1].digest()
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
    assert at(patient, "scenario", "replan", "policy").endswith("variants.patient.scenario.replan.policy: is wrong")
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
def test_faults_of_variants_are_told_at_their_place(tmp_path: Path, change: tuple[str, str], expected: str) -> None:
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
    assert "variants.patient.scenario: scenario plan_once has no task 'sense', which the mapping places" in told


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


def test_no_variant_is_checked_once_there_are_more_faults_than_are_shown(tmp_path: Path) -> None:
    """Sixty variants with hundreds of faults each would take half a minute, and none of it would be shown."""
    unknown = ", ".join(f"task{index}: {{component: host}}" for index in range(120))
    many = "\n".join(f"  wrong{index}: {{mapping: {{{unknown}}}}}" for index in range(30))
    text = faults(tmp_path, (VARIANTS, f"variants:\n{many}\n"))
    assert "variants.wrong0.mapping.task99: harmonic has no task 'task99'" in text
    assert text.endswith("and at least 20 more faults")
