"""Design points: what an axis value changes, what it cannot, and how a platform and a workload go together."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from spec_texts import PLATFORM, TASKS, WORKLOAD, Relax, assert_axes_are_sound

from codesign.ground.errors import SpecError
from codesign.ground.figures import Status
from codesign.inputs import Platform, Workload, cross_check, design_point, fault, load_platform, load_workload
from codesign.inputs.components import FpgaComponent, ProcessorComponent


def load(folder: Path, *changes: tuple[str, str]) -> tuple[Platform, Workload]:
    platform, workload = PLATFORM, WORKLOAD
    for old, new in changes:
        assert old in platform + workload
        platform, workload = platform.replace(old, new), workload.replace(old, new)
    (folder / "p.yaml").write_text(platform)
    (folder / "w.yaml").write_text(workload)
    return load_platform(folder / "p.yaml"), load_workload(folder / "w.yaml", TASKS)


def relax_of(workload: Workload) -> Relax:
    parameters = workload.mapping["relax"].parameters
    assert isinstance(parameters, Relax)
    return parameters


def told(platform: Platform, workload: Workload, values: dict[str, Any]) -> str:
    with pytest.raises(SpecError) as caught:
        design_point(platform, workload, values)
    return str(caught.value)


def test_an_override_equals_the_file_written_that_way(tmp_path: Path) -> None:
    made = design_point(
        *load(tmp_path),
        {
            "relax.block": [10, 15],
            "relax.iterations": 16,
            "relax.schedule.last": 127,
            "fpga.part": "XC2V6000-4",
            "fpga.clock": "100 MHz",
        },
    )
    written = load(
        tmp_path,
        ("block: [20, 30]", "block: [10, 15]"),
        ("iterations: 6", "iterations: 16"),
        ("last: 63}", "last: 127}"),
        ("XC4VLX160-12", "XC2V6000-4"),
        ("clock: 150 MHz", "clock: 100 MHz"),
    )
    assert [spec.digest() for spec in made] == [spec.digest() for spec in written]
    assert made[1].mapping == written[1].mapping
    fpga = made[0].components["fpga"]
    assert isinstance(fpga, FpgaComponent)
    assert (fpga.chip.full_name, fpga.clock.source) == ("XC2V6000-4", "chosen for this design point")
    assert fpga.clock.status is Status.ASSUMED


def test_the_specs_themselves_do_not_change(tmp_path: Path) -> None:
    specs = load(tmp_path)
    before = [spec.digest() for spec in specs]
    design_point(*specs, {"relax.iterations": 16, "relax.schedule.last": 127, "fpga.clock": "100 MHz"})
    assert [spec.digest() for spec in specs] == before
    assert specs[1].document.tree["mapping"]["relax"]["schedule"]["last"] == 63
    platform, workload = design_point(*specs, {})
    assert (platform, workload.digest(), workload.explore) == (specs[0], before[1], None)


def test_overrides_add_up(tmp_path: Path) -> None:
    specs = design_point(*load(tmp_path), {"relax.iterations": 16, "fpga.clock": "100 MHz"})
    platform, workload = design_point(*specs, {"relax.schedule": [7, 9], "fpga.part": "XC2V6000-4"})
    assert (relax_of(workload).iterations, relax_of(workload).schedule) == (16, (7, 9))
    assert platform.components["fpga"].clock.value == 100_000_000


def test_an_alternative_drives_out_what_it_replaces(tmp_path: Path) -> None:
    specs = design_point(*load(tmp_path), {"relax.blocks": [2, 2]})
    assert (relax_of(specs[1]).block, relax_of(specs[1]).blocks) == (None, (2, 2))
    assert relax_of(design_point(*specs, {"relax.block": [5, 5]})[1]).block == (5, 5)


def test_component_and_style_of_a_task_are_axes_too(tmp_path: Path) -> None:
    _, workload = design_point(*load(tmp_path), {"relax.component": "host", "relax.style": "software"})
    assert (workload.mapping["relax"].component, workload.mapping["relax"].style) == ("host", "software")


def test_any_figure_of_a_component_is_an_axis(tmp_path: Path) -> None:
    platform, _ = design_point(*load(tmp_path), {"host.costs.harmonic_node_update": "80 ns", "host.power.idle": "5 W"})
    host = platform.components["host"]
    assert isinstance(host, ProcessorComponent)
    assert (host.costs["harmonic_node_update"].value, host.power.idle.value) == (80_000, 5.0)
    assert host.power.idle.source == "chosen for this design point"
    # What the point leaves alone is still what the file declares.
    assert host.power.busy.source == "declared in p.yaml:10"
    assert host.clock.source == "declared in p.yaml:7"


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"relax.block": [0.5, 1]}, "point: relax.block[0]: 0.5 is not a whole number"),
        ({"relax.iterations": 0}, "point: relax.iterations: 0 is out of bounds\n  hint: it must be at least 1"),
        ({"relax.iterations": "6"}, "point: relax.iterations: '6' is not a whole number\n  hint: write 6"),
        (
            {"relax.iteratons": 1},
            "point: relax.iteratons: unknown key\n  hint: did you mean iterations? "
            "accepted: block, blocks, component, exact, external_memory, iterations, schedule, share, style",
        ),
        ({"relax.schedule.last": 6}, "point: relax.schedule.last: last 6 is below first 7\n  hint: raise last"),
        ({"relax.schedule": {"first": 7, "last": 9}}, "point: relax.schedule.step: missing"),
        (
            {"relax.iterations.x": 1},
            "point: relax.iterations.x: mapping.relax.iterations is not a mapping\n  hint: set the whole of it",
        ),
        ({"relax.block": "72x66"}, "point: relax.block: '72x66' is not a list\n  hint: write [72, 66]"),
        ({"relax.block": "72 × 66"}, "point: relax.block: '72 × 66' is not a list\n  hint: write [72, 66]"),
        (
            {"relax.block": 72},
            "point: relax.block: 72 is not a list\n  hint: write the entries in brackets: [first, second]",
        ),
        (
            {"relx.block": 1},
            "point: relx.block: there is no task, component or link 'relx'\n"
            "  hint: did you mean relax? accepted: command, decide, fpga, host, load, pci, relax, workload.problem,"
            " workload.scenario, workload.variant",
        ),
        ({"relax": {}}, "point: relax: no axis: write TASK.PARAMETER, COMPONENT.FIELD or LINK.FIELD"),
        (
            {"fpga.clock": "600 MHz"},
            "point: fpga.clock: 600 MHz is above the 500 MHz limit of part XC4VLX160-12\n"
            "  hint: lower the clock, or choose a faster part",
        ),
        ({"fpga.clock": 100}, "point: fpga.clock: 100 has no unit"),
        ({"fpga.part": "XC2V6000"}, "point: fpga.part: part XC2V6000 has several speed grades"),
        ({"fpga.colour": "red"}, "point: fpga.colour: unknown key\n  hint: accepted: calibration, clock, part"),
    ],
)
def test_bad_points(tmp_path: Path, values: dict[str, Any], expected: str) -> None:
    assert told(*load(tmp_path), values).startswith(expected)


def test_all_faults_of_a_point_come_at_once(tmp_path: Path) -> None:
    text = told(*load(tmp_path), {"relax.iterations": 0, "fpga.clock": "1 THz", "relax.exact": 3, "x.y": 1})
    assert [line.split(": ")[1] for line in text.splitlines() if line.startswith("point: ")] == [
        "fpga.clock",
        "relax.exact",
        "relax.iterations",
        "x.y",
    ]


def test_a_clash_with_what_the_files_declare_is_told_of_what_was_chosen(tmp_path: Path) -> None:
    platform, workload = load(tmp_path, ("clock: 150 MHz", "clock: 450 MHz"))
    assert told(platform, workload, {"fpga.part": "XC2V6000-4"}).startswith(
        "point: fpga.part: fpga.clock: 450 MHz is above the 300 MHz limit of part XC2V6000-4"
    )


def test_what_is_found_out_later_is_told_of_the_setting_too(tmp_path: Path) -> None:
    _, workload = design_point(*load(tmp_path), {"relax.schedule.last": 127, "relax.iterations": 7}, "--set ")
    _, workload = design_point(load_platform(tmp_path / "p.yaml"), workload, {"relax.blocks": [2, 2]}, "--set ")

    def at(*path: str | int) -> str:
        return str(fault(workload, ("mapping", "relax", *path), "is wrong")).replace(f"{tmp_path}/", "")

    assert at("iterations") == "--set relax.iterations: is wrong"
    assert at("schedule", "last") == "--set relax.schedule.last: is wrong"
    assert at("blocks", 1) == "--set relax.blocks[1]: is wrong"
    # Driven out by blocks, where a planner still speaks of the block that they make.
    assert at("block") == "--set relax.blocks: is wrong"
    assert at("component") == "w.yaml:9:16: mapping.relax.component: is wrong"
    assert at("schedule", "first") == "w.yaml:12:23: mapping.relax.schedule.first: is wrong"
    _, workload = design_point(load_platform(tmp_path / "p.yaml"), workload, {"relax.schedule": [7, 9]})
    assert at("schedule", "last") == "point: relax.schedule.last: is wrong"


def cross_faults(folder: Path, *changes: tuple[str, str]) -> str:
    with pytest.raises(SpecError) as caught:
        cross_check(*load(folder, *changes))
    return str(caught.value).replace(f"{folder}/", "")


def test_platform_and_workload_that_go_together(tmp_path: Path) -> None:
    on_either = ("fpga.clock: [100 MHz", "relax.component: [fpga, host]\n    fpga.clock: [100 MHz")
    for changes in ((), (on_either,)):
        assert_axes_are_sound(*load(tmp_path, *changes))


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            ("    component: fpga", "    component: fgpa"),
            "w.yaml:9:16: mapping.relax.component: platform mine has no component 'fgpa'\n"
            "  hint: did you mean fpga? accepted: fpga, host",
        ),
        (
            ("    fpga.clock: [", "    fgpa.clock: ["),
            "w.yaml:17:5: explore.axes.fgpa.clock: there is no task, component or link 'fgpa'\n"
            "  hint: did you mean fpga? accepted: command, decide, fpga, host, load, pci, relax, workload.problem,"
            " workload.scenario, workload.variant",
        ),
        (
            ("    fpga.clock: [", "    fpga.clok: ["),
            "w.yaml:17:5: explore.axes.fpga.clok: unknown key\n"
            "  hint: did you mean clock? accepted: calibration, clock, part",
        ),
        (
            ("[100 MHz, 150 MHz]", "[100, 600 MHz]"),
            "w.yaml:17:18: explore.axes.fpga.clock[0]: 100 has no unit\n"
            "  hint: write a number and a unit, such as 150 MHz\n"
            "w.yaml:17:23: explore.axes.fpga.clock[1]: 600 MHz is above the 500 MHz limit of part XC4VLX160-12\n"
            "  hint: lower the clock, or choose a faster part",
        ),
        (
            ("fpga.clock: [100 MHz, 150 MHz]", "relax.component: [fpga, gpu]"),
            "w.yaml:17:29: explore.axes.relax.component[1]: platform mine has no component 'gpu'\n"
            "  hint: accepted: fpga, host",
        ),
    ],
)
def test_platform_and_workload_that_do_not(tmp_path: Path, change: tuple[str, str], expected: str) -> None:
    assert cross_faults(tmp_path, change) == expected


def test_values_that_clash_only_with_another_axis_are_left_to_the_points(tmp_path: Path) -> None:
    # 280 MHz is beyond the declared XC2V6000-4 in some points, and within the XC4VLX160-12 in others.
    changes = (
        ("XC4VLX160-12, clock", "XC2V6000-4, clock"),
        ("fpga.clock: [100 MHz, 150 MHz]", "fpga.clock: [450 MHz]\n    fpga.part: [XC2V6000-4, XC4VLX160-12]"),
    )
    platform, workload = load(tmp_path, *changes)
    cross_check(platform, workload)
    design_point(platform, workload, {"fpga.clock": "450 MHz", "fpga.part": "XC4VLX160-12"})
    assert "is above the" in told(platform, workload, {"fpga.clock": "450 MHz", "fpga.part": "XC2V6000-4"})
    # schedule.last 5 is below the declared first, but an axis moves that too.
    axes = ("relax.schedule.last: [63, 127]", "relax.schedule.last: [5]\n    relax.schedule.first: [1]")
    design_point(*load(tmp_path, axes), {"relax.schedule.last": 5, "relax.schedule.first": 1})


def test_a_value_that_clashes_with_the_file_is_told_on_loading(tmp_path: Path) -> None:
    only = ("relax.block: [[20, 30], [10, 15]]\n    ", "")
    with pytest.raises(SpecError) as caught:
        load(tmp_path, only, ("last: [63, 127]", "last: [63, 5]"))
    assert str(caught.value).endswith(
        "w.yaml:15:31: explore.axes.relax.schedule.last[1]: last 5 is below first 7\n  hint: raise last"
    )


def test_a_task_at_its_default_place_is_moved_by_an_axis(tmp_path: Path) -> None:
    specs = load(tmp_path)
    assert "decide" not in specs[1].mapping
    _, made = design_point(*specs, {"decide.component": "host", "decide.style": "software", "load.component": "host"})
    written = load(
        tmp_path, ("explore:", "  decide: {component: host, style: software}\n  load: {component: host}\nexplore:")
    )[1]
    assert made.mapping == written.mapping
    assert made.digest() == written.digest()
    assert str(fault(made, ("mapping", "decide", "style"), "is wrong")) == "point: decide.style: is wrong"
    assert not specs[1].document.tree["mapping"].keys() & {"decide", "load"}
    # An axis over it is sound too, in every place of the platform.
    cross_check(*load(tmp_path, ("fpga.clock: [", "decide.component: [fpga, host]\n    fpga.clock: [")))


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        (
            {"decide.style": "software"},
            "point: decide.style: the mapping does not place task decide\n  hint: set decide.component too",
        ),
        (
            {"decide.place": "host"},
            "point: decide.place: unknown key\n  hint: accepted: component, external_memory, style",
        ),
        (
            {"decide.component": "host", "decide.speed": 3},
            "point: decide.speed: unknown key\n  hint: accepted: component, external_memory, style",
        ),
        ({"load": "host"}, "point: load: no axis: write TASK.PARAMETER, COMPONENT.FIELD or LINK.FIELD\n"
         "  hint: name what to set of load: load.component, load.style, load.external_memory"),
        ({"sense.component": "host"}, "point: sense.component: there is no task, component or link 'sense'"),
    ],
)  # fmt: skip
def test_bad_points_of_tasks_that_the_mapping_leaves_out(tmp_path: Path, values: dict[str, Any], expected: str) -> None:
    assert told(*load(tmp_path), values).startswith(expected)


@pytest.mark.parametrize(
    ("axis", "expected"),
    [
        (
            "decide.component: [fpga, hots]",
            "w.yaml:17:30: explore.axes.decide.component[1]: platform mine has no component 'hots'\n"
            "  hint: did you mean host? accepted: fpga, host",
        ),
        (
            "decide.style: [software]",
            "w.yaml:17:5: explore.axes.decide.style: the mapping does not place task decide\n"
            "  hint: set decide.component too",
        ),
        (
            "load.compnent: [fpga]",
            "w.yaml:17:5: explore.axes.load.compnent: unknown key\n"
            "  hint: did you mean component? accepted: component, external_memory, style",
        ),
    ],
)
def test_axes_over_tasks_that_the_mapping_leaves_out(tmp_path: Path, axis: str, expected: str) -> None:
    assert cross_faults(tmp_path, ("fpga.clock: [100 MHz, 150 MHz]", axis)) == expected
