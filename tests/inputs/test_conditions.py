"""Conditions and rules of a workload: what is accepted, and each fault at its place with its remedy."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import PLATFORM, WORKLOAD

from codesign import load_platform, load_workload
from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES
from codesign.inputs import Constraint, Exploration, Workload, cross_check, pin
from codesign.inputs.aggregate import Quantile, Share
from codesign.study import explore

CONDITIONS = "  conditions:\n    workload.problem.map.seed: [1, 2, 3]\n"


def workload(tmp_path: Path, more: str) -> Workload:
    (tmp_path / "w.yaml").write_text(WORKLOAD + more, encoding="utf-8")
    return load_workload(tmp_path / "w.yaml")


def faults(tmp_path: Path, more: str) -> str:
    with pytest.raises(SpecError) as caught:
        workload(tmp_path, more)
    return str(caught.value).replace(str(tmp_path), "")


def test_conditions_and_rules_are_read(tmp_path: Path) -> None:
    text = CONDITIONS + (
        "  aggregate:\n    default: mean\n    energy_j: {quantile: 0.9}\n"
        "    first_plan_s: {share: {at_most: 100 ms}, required: 0.5}\n"
    )
    explore = workload(tmp_path, text).explore
    assert explore is not None
    assert (explore.points, dict(explore.conditions)) == (24, {"workload.problem.map.seed": (1, 2, 3)})
    limit = Constraint(figure=FIGURES["first_plan_s"], at_most=0.1)
    assert dict(explore.aggregate) == {
        "default": "mean",
        "energy_j": Quantile(quantile=0.9),
        "first_plan_s": Share(share=limit, required=0.5),
    }


LINE = WORKLOAD.count("\n") + 1
RULE = "  aggregate:\n    "


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (f"{RULE}energy: mean\n", ("'energy' is no figure", "write energy_j: energy is its short name")),
        (f"{RULE}slice: mean\n", ("'slice' is no figure", "did you mean slices?")),
        (f"{RULE}defaul: mean\n", ("'defaul' is no figure", "did you mean default?")),
        (f"{RULE}slices: meen\n", ("'meen' is no rule", "did you mean mean? accepted: worst, best, mean, median")),
        (f"{RULE}slices: {{quantil: 0.9}}\n", ("a mapping is no rule", "{quantile: 0.9}")),
        (f"{RULE}slices: {{quantile: 1}}\n", ("quantile", "must be below 1")),
        (f"{RULE}slices: {{quantile: 0.5, of: 3}}\n", ("unknown key", "accepted: quantile")),
        (f"{RULE}first_plan_s: {{share: {{at_most: 100}}}}\n", ("100 has no unit", "write a number and a unit")),
        (f"{RULE}first_plan_s: {{share: {{}}}}\n", ("bounds nothing", "give at_least, at_most, or both")),
        (f"{RULE}first_plan_s: {{share: 100 ms}}\n", ("'100 ms' is no limit", 'write {share: "< LIMIT"}')),
        (f"{RULE}first_plan_s: {{share: < 100}}\n", ("'100' has no unit", "write a number and a unit")),
        (f"{RULE}first_plan_s: {{share: energy < 1 J}}\n", ("another figure", "it is first_plan_s")),
        (f"{RULE}slices: {{share: < 0.8}}\n", ("a count is a whole number", "write 80 % for a share of the part's")),
        (f"{RULE}default: {{share: {{at_most: 1}}}}\n", ("share needs a figure", "to a figure by its name")),
        (f"{RULE}first_plan_s: {{share: {{figure: slices, at_most: 1 s}}}}\n", ("another figure", "leave figure out")),
        (f"{RULE}slices: {{share: {{at_most: 9}}, required: 2}}\n", ("required", "must be at most 1")),
        ("  aggregate: mean\n", ("'mean' is not a mapping of rules", "write {default: mean}")),
        (
            f"{RULE}slices: {{share: {{at_most: 9}}}}\n  constraints: [{{figure: slices, at_most: 8}}]\n",
            ("slices is aggregated by share", "required: 0.9"),
        ),
        ("  conditions:\n    fpga.clock: [50 MHz]\n", ("sets the same thing as axis fpga.clock", "keep one of them")),
        ("  conditions:\n    relax.schedule: [[63]]\n", ("same thing as axis relax.schedule.last", "keep one")),
        ("  conditions:\n    relax.iterations: [6, six]\n", ("'six'", "")),
        ("  conditions:\n    relax.iteration: [6]\n", ("unknown key", "did you mean iterations?")),
        ("  conditions:\n    seed: [1]\n", ("'seed' is no axis", "write TASK.PARAMETER")),
        ("  conditions:\n    workload.problem.map.seed: [1, 1]\n", ("1 is listed twice", "list it once")),
        ("  conditions:\n    workload.variant: [base]\n", ("a variant is a decision", "list it in axes")),
    ],
)  # fmt: skip
def test_a_fault_has_its_place_and_its_remedy(tmp_path: Path, text: str, told: tuple[str, str]) -> None:
    message = faults(tmp_path, text)
    for part in told:
        assert part in message
    first = int(message.partition("w.yaml:")[2].partition(":")[0])
    assert first >= LINE, message
    assert message.count("w.yaml:") == 1, "one mistake is one fault"


def test_a_problem_in_axes_and_a_key_of_it_in_conditions_overlap(tmp_path: Path) -> None:
    text = WORKLOAD.replace("    fpga.clock: [100 MHz, 150 MHz]\n", "    workload.problem.map.seed: [1, 2]\n")
    problem = "{map: {generate: rooms, rows: 40, columns: 60}, goals: [[4, 10]]}"
    text += f"  conditions:\n    workload.problem:\n      - {problem}\n"
    (tmp_path / "w.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=r"sets the same thing as axis workload\.problem\.map\.seed"):
        load_workload(tmp_path / "w.yaml")


def test_sizes_and_seeds_are_two_conditions_of_one_problem(tmp_path: Path) -> None:
    text = (
        "  conditions:\n    workload.problem:\n"
        "      - {map: {generate: rooms, rows: 40, columns: 60, room: [8, 8]}, goals: [[4, 10]]}\n"
        "      - {map: {generate: rooms, rows: 20, columns: 30, room: [8, 8]}, goals: [[4, 10]]}\n"
        "    workload.problem.map.seed: [1, 2]\n"
    )
    (tmp_path / "p.yaml").write_text(PLATFORM, encoding="utf-8")
    platform, read = load_platform(tmp_path / "p.yaml"), workload(tmp_path, text)
    cross_check(platform, read, explored=True)
    values = {"relax.block": [10, 15], "relax.schedule.last": 63, "fpga.clock": "100 MHz"}
    study = explore(*pin(platform, read, values), workers=1)
    assert [point.state for point in study.points] == ["done"] * 4
    assert len({point.figure(FIGURES["first_plan_s"]) for point in study.points}) == 4


def test_a_value_of_a_condition_that_does_not_fit_the_platform_is_a_fault_at_its_place(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(PLATFORM, encoding="utf-8")
    read = workload(tmp_path, "  conditions:\n    pci.clocks: [33 MHz]\n")
    with pytest.raises(SpecError, match=r"w\.yaml:\d+:5: explore\.conditions\.pci\.clocks") as caught:
        cross_check(load_platform(tmp_path / "p.yaml"), read)
    assert "clock" in str(caught.value)


def test_together_no_more_axes_and_points_than_axes_alone_may_have() -> None:
    many = {f"relax.a{number}": [1] for number in range(9)}
    with pytest.raises(ValueError, match="9 axes and 9 conditions are too many"):
        Exploration.model_validate({"axes": many, "conditions": {name + "x": [1] for name in many}})
    thousand = list(range(1000))
    with pytest.raises(ValueError, match=r"(1000 x ){5}1000 = 1,000,000,000,000,000,000 points are too many"):
        Exploration.model_validate(
            {"axes": {f"a.{name}": thousand for name in "bcd"}, "conditions": {f"a.{name}": thousand for name in "efg"}}
        )


def test_a_pinned_condition_is_one_no_longer(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(PLATFORM, encoding="utf-8")
    read = workload(tmp_path, CONDITIONS)
    _, pinned = pin(load_platform(tmp_path / "p.yaml"), read, {"workload.problem.map.seed": 7})
    assert pinned.explore is not None
    assert dict(pinned.explore.conditions) == {}
