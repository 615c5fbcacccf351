"""Loading: every shipped file, figures and their sources, digests, pickling, schemas."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml
from spec_texts import PLATFORM, TASKS, WORKLOAD

from codesign import maps
from codesign.ground.errors import InputError, SpecError
from codesign.ground.figures import FIGURES, Status
from codesign.ground.models import SpecModel, TaskParameters
from codesign.inputs import (
    Platform,
    Workload,
    cross_check,
    fault,
    list_parts,
    list_platforms,
    list_workloads,
    load_part,
    load_platform,
    load_workload,
    parse_value,
    starting_files,
)
from codesign.inputs.components import FpgaComponent, ProcessorComponent
from codesign.inputs.files import data_folder, shipped_names
from codesign.inputs.library import PARTS
from codesign.inputs.links import BusLink
from codesign.inputs.map_spec import MAPS, PreparedMap
from codesign.inputs.problem import SampledStarts
from codesign.maps import Steps
from codesign.system import catalog

SHIPPED_TASKS = catalog.task_models()


@pytest.fixture
def platform(tmp_path: Path) -> Platform:
    (tmp_path / "p.yaml").write_text(PLATFORM)
    return load_platform(tmp_path / "p.yaml")


@pytest.fixture
def workload(tmp_path: Path) -> Workload:
    (tmp_path / "w.yaml").write_text(WORKLOAD)
    return load_workload(tmp_path / "w.yaml", TASKS)


@pytest.mark.parametrize("name", list_platforms())
def test_the_links_and_memories_of_shipped_platforms_declare_their_power(name: str) -> None:
    """As intervals, since none of them is published."""
    platform = load_platform(name)
    memories = [one for one in platform.components.values() if one.type == "memory"]
    for one in (*platform.links.values(), *memories):
        assert one.power is not None
        for figure in (one.power.busy, one.power.idle):
            assert 0.0 < figure.interval[0] < figure.value < figure.interval[1]
        assert one.power.idle.value < one.power.busy.value


@pytest.mark.parametrize("name", list_platforms())
def test_every_shipped_platform_loads(name: str) -> None:
    assert load_platform(name).name == name


@pytest.mark.parametrize("name", list_workloads())
def test_every_shipped_workload_loads_and_fits_some_platform(name: str) -> None:
    workload = catalog.load_workload(name)
    assert workload.name == name
    misfits = 0
    for platform in list_platforms():
        try:
            cross_check(load_platform(platform), workload)
        except SpecError:
            misfits += 1
    assert misfits < len(list_platforms())


@pytest.mark.parametrize("path", sorted((data_folder("platforms") / "parts").glob("*.yaml")), ids=lambda p: p.stem)
def test_every_shipped_part_loads_and_cites_its_numbers(path: Path) -> None:
    part_file = PARTS.load(path)
    for grade in part_file.speed_grades:
        part = load_part(f"{path.stem}{grade}")
        assert part.full_name == f"{path.stem}{grade}"
        assert set(part.resources) == {"slices", "lut4", "flip_flops", "block_rams", "multipliers"}
        figures = [*part.resources.values(), part.block_ram_clock, part.static_power, part.dynamic_power]
        assert all(len(figure.source) > 3 and "declared" not in figure.source for figure in figures)
        # The same capacity in every shape, or 8/9 or 4/5 of it without the parity bits.
        bits = [depth * width for depth, width in part.block_ram_shapes]
        assert max(bits) in {4096, 18432, 20480}
        assert min(bits) >= 0.8 * max(bits)
        assert 10e6 < part.block_ram_clock.value < 1e9
        assert 1e-5 < part.static_power.value < 10
        # Of one counted slice: uW at 1 MHz, in W at 1 Hz.
        assert 1e-14 < part.dynamic_power.value < 1e-10
        assert part.dynamic_power.unit == "W/(slice Hz)"


def test_the_boards_of_the_paper() -> None:
    for name, part in (("virtex2-pci", "XC2V6000-4"), ("virtex4-pci", "XC4VLX160-12")):
        platform = load_platform(name)
        fpga, host, pci = platform.components["fpga"], platform.components["host"], platform.links["pci"]
        assert isinstance(fpga, FpgaComponent)
        assert isinstance(host, ProcessorComponent)
        assert isinstance(pci, BusLink)
        assert (fpga.part, fpga.chip) == (part, load_part(part))
        assert fpga.clock.value == 150_000_000
        # 100 us an iteration of a block of 36 x 66 nodes.
        assert host.costs["harmonic_node_update"].value == round(100e6 / (36 * 66)) == 42_088
        assert pci.width.value * pci.clock.value == 32 * 33_000_000


def test_figures_say_where_they_come_from(platform: Platform) -> None:
    fpga, host = platform.components["fpga"], platform.components["host"]
    assert isinstance(host, ProcessorComponent)
    assert (fpga.clock.value, fpga.clock.unit) == (150_000_000, "Hz")
    assert (fpga.clock.status, fpga.clock.source) == (Status.ASSUMED, "declared in p.yaml:4")
    assert host.power.busy.source == "declared in p.yaml:10"
    assert platform.links["pci"].burst_words.source == "declared in p.yaml:12"
    cost = host.costs["harmonic_node_update"]
    assert (cost.value, cost.unit, cost.status, cost.source) == (40_000, "ps", Status.MEASURED, "own run")
    assert cost.interval == (35_000, 50_000)
    assert type(cost.value) is int


def test_a_workload_as_loaded(workload: Workload) -> None:
    assert workload.planner == "harmonic"
    assert workload.problem.goals == ((4, 10),)
    assert workload.problem.starts == SampledStarts(count=64, seed=0)
    assert workload.problem.map.generate == "rooms"
    assert workload.problem.map.steps == Steps()
    assert workload.problem.map.parameters == {
        "rows": 40,
        "columns": 60,
        "room": (8, 8),
        "door": 2,
        "wall": 1,
        "seed": 0,
        "extra_doors": 0.0,
    }
    assert workload.map_file is None
    assert workload.scenario.type == "plan_once"
    relax = workload.mapping["relax"]
    assert (relax.component, relax.style, relax.parameters.iterations) == ("fpga", None, 6)  # type: ignore[attr-defined]
    assert workload.explore is not None
    assert workload.explore.points == 8
    assert list(workload.explore.axes) == ["relax.block", "relax.schedule.last", "fpga.clock"]
    assert [str(figure) for figure in workload.explore.objectives] == [
        "plan_time_worst_s",
        "slices",
        "block_rams",
        "energy_j",
        "share_reaching_goal",
    ]


def test_constraints_are_held_in_base_units(tmp_path: Path) -> None:
    limits = (
        "[{figure: first_plan_s, at_most: 5 ms}, {figure: power, at_least: 200 mW}, {figure: slices, at_most: 1e4}]"
    )
    (tmp_path / "w.yaml").write_text(f"{WORKLOAD}  constraints: {limits}\n")
    explore = load_workload(tmp_path / "w.yaml", TASKS).explore
    assert explore is not None
    assert [limit.at_most for limit in explore.constraints] == [0.005, None, 10_000]
    assert explore.constraints[1].at_least == 0.2
    assert type(explore).model_validate(explore.model_dump(mode="json")) == explore


def test_result_figures_have_unit_and_direction() -> None:
    assert (FIGURES["first_plan_s"].unit, FIGURES["first_plan_s"].direction) == ("s", "minimise")
    assert (FIGURES["slices"].unit, FIGURES["slices"].maximise) == ("1", False)
    assert {figure.name for figure in FIGURES.values() if figure.maximise} == {
        "arrive",
        "share_reaching_goal",
        "clearance_mean",
        "closest_approach",
        "clearance_least_m",
        "known_share",
    }


def test_without_models_parameters_stay_as_they_are(tmp_path: Path) -> None:
    (tmp_path / "w.yaml").write_text(WORKLOAD.replace("iterations: 6", "anything: [six]"))
    relax = load_workload(tmp_path / "w.yaml").mapping["relax"]
    assert relax.parameters.model_dump() == {
        "block": [20, 30],
        "anything": ["six"],
        "schedule": {"first": 7, "step": 8, "last": 63},
    }


def test_later_faults_find_their_place(workload: Workload) -> None:
    assert str(fault(workload, ("problem", "goals", 0), "[4, 10] is an obstacle", "move it")).endswith(
        "w.yaml:6:11: problem.goals[0]: [4, 10] is an obstacle\n  hint: move it"
    )
    # What is not written out is reported where it would stand.
    assert fault(workload, ("problem", "starts", "count"), "too many").line == 5


def test_specs_pickle_compare_and_are_frozen(platform: Platform, workload: Workload) -> None:
    for spec in (platform, workload):
        again = pickle.loads(pickle.dumps(spec))
        assert again == spec
        assert again.digest() == spec.digest()
        assert again.document == spec.document
        with pytest.raises(ValueError, match="frozen"):
            spec.name = "other"  # type: ignore[misc]
    assert load_platform("virtex2-pci") != load_platform("virtex4-pci")


def test_digests_name_what_changes_results_and_nothing_else(tmp_path: Path) -> None:
    def digest(text: str) -> str:
        folder = tmp_path / "elsewhere" if "# moved" in text else tmp_path
        folder.mkdir(exist_ok=True)
        file = folder / "spec.yaml"
        file.write_text(text)
        if text.startswith("kind: platform"):
            return load_platform(file).digest()
        return load_workload(file, TASKS).digest()

    assert re.fullmatch("[0-9a-f]{64}", digest(PLATFORM))
    for same in (
        PLATFORM + "# a comment\n",
        PLATFORM + "# moved\n",
        PLATFORM.replace("source: own run", "source: a better run"),
        PLATFORM.replace("name: mine\n", "name: mine\ndescription: nice\n"),
        PLATFORM.replace("150 MHz", "0.15 GHz"),
    ):
        assert digest(same) == digest(PLATFORM)
    for other in (
        PLATFORM.replace("150 MHz", "151 MHz"),
        PLATFORM.replace("high: 50 ns", "high: 51 ns"),
        PLATFORM.replace("XC4VLX160-12", "XC4VLX160-11"),
        PLATFORM.replace("burst_words: 16", "burst_words: 17"),
    ):
        assert digest(other) != digest(PLATFORM)
    assert digest(WORKLOAD[: WORKLOAD.index("explore:")]) == digest(WORKLOAD)
    assert digest(WORKLOAD.replace("[[4, 10]]", "[[4, 11]]")) != digest(WORKLOAD)
    assert digest(WORKLOAD.replace("iterations: 6", "iterations: 7")) != digest(WORKLOAD)
    assert digest(WORKLOAD.replace("room: [8, 8]", "room: [8, 8], seed: 1")) != digest(WORKLOAD)


def test_digests_are_the_same_in_every_process() -> None:
    code = "from codesign.inputs import load_platform; print(load_platform('virtex4-pci').digest())"
    told = {
        subprocess.run(
            [sys.executable, "-c", code], env={"PYTHONHASHSEED": seed}, capture_output=True, text=True, check=True
        ).stdout.strip()
        for seed in ("1", "2")
    }
    assert told == {load_platform("virtex4-pci").digest()}


def test_a_part_of_ones_own_lies_beside_the_platform(tmp_path: Path) -> None:
    own = (data_folder("platforms") / "parts" / "XC3S500E.yaml").read_text()
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "MYPART.yaml").write_text(own.replace("name: XC3S500E", "name: MYPART"))
    (tmp_path / "p.yaml").write_text(PLATFORM.replace("XC4VLX160-12", "MYPART-4"))
    fpga = load_platform(tmp_path / "p.yaml").components["fpga"]
    assert isinstance(fpga, FpgaComponent)
    assert fpga.chip.full_name == "MYPART-4"
    assert "MYPART-4" in list_parts((tmp_path / "parts",))
    assert "MYPART-4" not in list_parts()
    (tmp_path / "parts" / "MYPART.yaml").write_text(own)
    with pytest.raises(SpecError, match="'XC3S500E' in file MYPART"):
        load_platform(tmp_path / "p.yaml")
    renamed = own.replace("name: XC3S500E", "name: MYPART").replace('"-4":', '"4":')
    (tmp_path / "parts" / "MYPART.yaml").write_text(renamed)
    with pytest.raises(SpecError, match=r"speed_grades\.4: '4' is not a name\n  hint: a dash and letters"):
        load_platform(tmp_path / "p.yaml")


@pytest.mark.parametrize("name", ["", "-12", "../parts/XC4VLX160-12", "XC4VLX160-", "XC4VLX160-12-12", "x" * 10_000])
def test_names_that_are_no_part(name: str) -> None:
    with pytest.raises(InputError) as caught:
        load_part(name)
    assert len(str(caught.value)) < 400


def test_map_generators_agree_with_the_maps_package() -> None:
    import inspect

    assert set(MAPS) == set(maps.GENERATORS)
    for name, model in MAPS.items():
        parameters = inspect.signature(maps.GENERATORS[name]).parameters
        fields = {field: info for field, info in model.model_fields.items() if field != "generate"}
        fields = {field: info for field, info in fields.items() if field not in PreparedMap.model_fields}
        assert set(fields) == set(parameters)
        for field, info in fields.items():
            default = parameters[field].default
            # The reader of YAML asks for what the generator gives a default where a default would surprise.
            assert info.is_required() if default is inspect.Parameter.empty else info.default == default


def test_values_of_the_command_line() -> None:
    assert parse_value("[36, 66]", "--set") == [36, 66]
    assert parse_value("100 MHz", "--set") == "100 MHz"
    assert parse_value("{first: 7}", "--set") == {"first": 7}
    for bad in ("010", "[1", "&a x", "", "  ", ".nan", "\udc80"):
        with pytest.raises(InputError) as caught:
            parse_value(bad, "--set a.b")
        assert caught.value.where == "--set a.b"


def test_starting_files_load(tmp_path: Path) -> None:
    for name, text in starting_files().items():
        (tmp_path / name).write_text(text)
    platform = load_platform(tmp_path / "my-platform.yaml")
    workload = load_workload(tmp_path / "my-workload.yaml", SHIPPED_TASKS)
    assert (platform.name, workload.name) == ("my-platform", "my-workload")
    cross_check(platform, workload)


def test_scalars_are_strict_however_a_field_is_annotated(tmp_path: Path) -> None:
    class Inner(SpecModel):
        type: int = 0
        default: bool = False

    class Parameters(TaskParameters):
        inner: Inner | None = None
        number: float = 0.0
        words: tuple[str, ...] = ()
        either: int | str | None = None

    def load(parameters: str) -> object:
        text = f"{WORKLOAD[: WORKLOAD.index('mapping:')]}mapping:\n  t: {{component: fpga, {parameters}}}\n"
        (tmp_path / "w.yaml").write_text(text)
        return load_workload(tmp_path / "w.yaml", {"harmonic": {"t": Parameters}}).mapping["t"].parameters

    made = load("inner: {type: 3, default: true}, number: 2, words: [a], either: 'x'")
    assert made == Parameters(inner=Inner(type=3, default=True), number=2.0, words=("a",), either="x")
    for lax in (
        "inner: {type: true}",
        "inner: {type: '3'}",
        "inner: {type: 3.0}",
        "inner: {default: 1}",
        "inner: {default: 'False'}",
        "number: '1'",
        "number: true",
        "words: [1]",
        "words: a",
        "either: true",
    ):
        with pytest.raises(SpecError):
            load(lax)


def test_data_lie_beside_the_package_in_a_checkout_and_inside_it_in_a_wheel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wheel, checkout = tmp_path / "wheel", tmp_path / "checkout"
    checkout.mkdir()
    (checkout / "pyproject.toml").touch()
    for folder, expected in ((wheel, wheel / "codesign"), (checkout, checkout)):
        monkeypatch.setattr("codesign.inputs.files.__file__", str(folder / "codesign" / "inputs" / "files.py"))
        assert data_folder("platforms") == expected / "platforms"


@pytest.mark.parametrize(
    ("load", "folder", "words"),
    [
        (load_platform, "workloads", "a workload, and a platform"),
        (load_workload, "platforms", "a platform, and a workload"),
    ],
)
def test_a_file_of_the_other_kind_is_one_fault(
    load: Callable[[Any], Any], folder: str, words: str, tmp_path: Path
) -> None:
    for name in shipped_names(folder):
        path = data_folder(folder) / f"{name}.yaml"
        text = path.read_text(encoding="utf-8")
        for source in (name, path, str(path), text, yaml.safe_load(text)):
            with pytest.raises((SpecError, InputError)) as refused:
                load(source)
            lines = str(refused.value).splitlines()
            assert len(lines) == 2
            assert f"{words} is asked for" in lines[0]
            assert "are the two files swapped?" in lines[1]
