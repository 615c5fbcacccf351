"""Axes of a workload with variants: what they accept, and which of them a setting settles."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import Relax, assert_axes_are_sound
from variant_texts import VARIANT_AXIS, VARIANTS, faults, load

from codesign.ground.errors import SpecError
from codesign.inputs import design_point, has_axis, pin
from codesign.inputs.scenario import Drive


@pytest.mark.parametrize(
    ("axes", "expected"),
    [
        ("workload.variant: [base, corse]", "workload.variant[1]: there is no variant 'corse'\n  hint: did you mean"),
        ("workload.variant: [[coarse]]", "workload.variant[0]: a list names no variant"),
        ("workload.variant: [base, base]", 'workload.variant[1]: "base" is listed twice'),
        (
            "workload.variant: [base, on-host]\n    relax.iterations: [1]",
            "relax.iterations: variant on-host maps no task relax\n  hint: give the axis the variants that have relax",
        ),
        ("workload.variant: [coarse]\n    relax.dept: [1]", "relax.dept: unknown key in variant coarse"),
        (
            "workload.variant: [base, coarse]\n    relax.schedule.last: [63]",
            "relax.schedule.last: mapping.relax.schedule is not a mapping in variant coarse",
        ),
        ("workload.scenario.control_period: [10]", "workload.scenario.control_period[0]: 10 has no unit"),
        ("workload.scenario.control_period: [0 ms]", "workload.scenario.control_period[0]: a control period below"),
        (
            "workload.scenario.control_period: [100 ms, 0.1 s]",
            "workload.scenario.control_period[1]: '0.1 s' says the same as a value before it",
        ),
        (
            "workload.scenario.replan.polcy: [restart]",
            "workload.scenario.replan.polcy: unknown key\n  hint: did you mean policy? accepted: ",
        ),
        ("workload.scenario.replan.policy: [restrat]", "workload.scenario.replan.policy[0]: 'restrat' is not accepted"),
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
        ("pic.clock: [33 MHz]", "pic.clock: there is no task, component or link 'pic'\n  hint: did you mean pci?"),
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
    assert_axes_are_sound(*load(tmp_path, ("    fpga.clock: [100 MHz, 150 MHz]\n", f"    {axes}\n")))


def test_axes_need_variants_to_choose_from(tmp_path: Path) -> None:
    told = faults(tmp_path, (VARIANTS, ""), ("  axes:\n", "  axes:\n    workload.variant: [base]\n"))
    assert "explore.axes.workload.variant: the workload has no variants\n  hint: add variants:" in told


def test_links_move_as_components_do(tmp_path: Path) -> None:
    specs = load(tmp_path)
    platform, _ = design_point(*specs, {"pci.clock": "66 MHz", "pci.errors.bit_error_rate": 1e-6, "pci.width": 64})
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
        ({"pci": 3}, "--set pci: no axis: write TASK.PARAMETER, COMPONENT.FIELD or LINK.FIELD\n  hint: name what"),
        ({"pci.between": ["host", "fpga"]}, "--set pci.between: between of pci is no axis"),
        ({"fpga.type": "processor"}, "--set fpga.type: type of fpga is no axis"),
        ({"sense.dept": 1, "workload.variant": "coarse"}, "--set sense.dept: unknown key"),
        ({"workload.scenario.control_period": "0 ms"}, "--set workload.scenario.control_period: a control period"),
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
