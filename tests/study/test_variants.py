"""Variants as points of an exploration: from the file to the table, and in the store."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from explore_fakes import Fake, computed

import codesign
from codesign.ground.errors import SpecError
from codesign.inputs import Workload
from codesign.study import FileStore, Space, Study, explore, load_study
from codesign.study.explored import Explored
from codesign.study.identity import contents_of
from codesign.study.space import canonical

Run = Callable[..., Result]

WORKLOAD = """\
kind: workload
name: who
planner: harmonic
problem: {map: {generate: empty, rows: 8, columns: 8}, goals: [[6, 6]], starts: [[1, 1]]}
mapping:
  relax: {component: fpga, block: [8, 8], iterations: 6, schedule: [15]}
  decide: {component: fpga}
variants:
  on-host:
    planner: relaxation
    mapping: {relax: {component: host, method: sor}}
  large-blocks:
    mapping:
      relax: {component: fpga, block: [8, 8], iterations: 32, schedule: [15]}
      decide: {component: fpga}
explore:
  axes:
    workload.variant: [base, on-host]
    pci.clock: [33 MHz, 66 MHz]
  objectives: [first_plan_s, slices]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    made = tmp_path / "who.yaml"
    made.write_text(WORKLOAD, encoding="utf-8")
    return made


def changed(file: Path, *changes: tuple[str, str]) -> Workload:
    text = WORKLOAD
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    file.write_text(text, encoding="utf-8")
    return codesign.load_workload(file)


def test_host_and_fpga_are_points_of_one_exploration(hwsw: Run, file: Path, tmp_path: Path) -> None:
    store = tmp_path / "points.sqlite"
    done = hwsw("explore", "virtex4-pci", file, "--store", store, "--workers", 1, "--json")
    assert done.exit_code == 0, done.output
    points = json.loads(done.stdout)["points"]
    assert [point["axes"]["workload.variant"] for point in points] == ["base", "base", "on-host", "on-host"]
    assert [point["result"]["planner"] for point in points] == ["harmonic"] * 2 + ["relaxation"] * 2
    assert points[2]["figures"]["slices"] == 0
    assert points[0]["figures"]["slices"] > 0
    # A faster link helps the design that sends something over it, and only that.
    times = [point["figures"]["first_plan_s"] for point in points]
    assert times[1] < times[0]
    assert times[2] == times[3]
    # Each point is what a run of it gives.
    for point in (points[1], points[2]):
        settings = [f"{axis}={value}" for axis, value in point["axes"].items()]
        run = hwsw("run", "virtex4-pci", file, "--json", *(part for each in settings for part in ("--set", each)))
        alone = json.loads(run.stdout)
        assert {key: alone[key] for key in point["result"] if key != "provenance"} == {
            key: value for key, value in point["result"].items() if key != "provenance"
        }
    # And the table says who wins.
    text = hwsw("explore", "virtex4-pci", file, "--store", store, "--workers", 1).stdout
    assert "Best variant by setting: least first plan time" in text
    assert "least first plan time, of 2 settings: base in 2" in text
    assert "Best variant by setting: least first plan time" in hwsw("report", store).stdout


def test_a_setting_settles_an_axis_for_all_points(hwsw: Run, file: Path, tmp_path: Path) -> None:
    store = tmp_path / "points.sqlite"
    done = hwsw(
        "explore", "virtex4-pci", file, "--store", store, "--workers", 1, "--json",
        "--set", "workload.variant=on-host", "--set", "host.clock=3 GHz",
    )  # fmt: skip
    study = json.loads(done.stdout)
    assert list(study["axes"]) == ["pci.clock"]
    assert [point["result"]["planner"] for point in study["points"]] == ["relaxation"] * 2
    again = hwsw("explore", "virtex4-pci", file, "--store", store, "--set", "workload.variant=none")
    assert (again.exit_code, "there is no variant 'none'" in again.stderr) == (2, True)


def test_a_setting_holds_in_variants_that_say_otherwise(hwsw: Run, file: Path, tmp_path: Path) -> None:
    changed(file, ("[base, on-host]", "[base, large-blocks]"), ("[33 MHz, 66 MHz]", "[33 MHz]"))
    done = hwsw(
        "explore", "virtex4-pci", file, "--store", tmp_path / "points.sqlite", "--workers", 1, "--json",
        "--set", "relax.iterations=16",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    points = json.loads(done.stdout)["points"]
    assert [point["axes"]["workload.variant"] for point in points] == ["base", "large-blocks"]
    assert [point["result"]["parameters"]["relax"]["iterations"] for point in points] == [16, 16]


def test_compare_takes_variants(hwsw: Run, file: Path) -> None:
    design = f"virtex4-pci:{file}"
    told = json.loads(hwsw("compare", design, "--on", file, "--set", "workload.variant=on-host", "--json").stdout)
    assert told[design]["planner"] == "relaxation"
    refused = hwsw("compare", "virtex4-pci:labyrinth", "--set", "workload.variant=on-host")
    assert (refused.exit_code, "none of the designs has this" in refused.stderr) == (2, True)


def test_check_holds_every_variant_against_the_platform(hwsw: Run, file: Path) -> None:
    assert hwsw("check", "virtex4-pci", file).exit_code == 0
    changed(file, ("relax: {component: host, method: sor}", "relax: {component: fpga, method: sor}"))
    done = hwsw("check", "virtex4-pci", file)
    assert done.exit_code == 2
    assert f"{file}:11:" in done.stderr
    assert ": variants.on-host.mapping.relax" in done.stderr
    assert hwsw("check", "virtex4-pci", file, "--set", "workload.variant=base").exit_code == 0
    lone = hwsw("check", file, "--set", "workload.variant=base")
    assert (lone.exit_code, "name one of each" in lone.stderr) == (2, True)


def explored(workload: Workload, store: Path, log: Path) -> Study:
    platform = codesign.load_platform("virtex4-pci")
    return explore(platform, workload, workers=1, store=store, evaluate=Fake(log))


def test_a_change_in_one_variant_costs_only_its_own_points(file: Path, tmp_path: Path) -> None:
    store, log = tmp_path / "points.sqlite", tmp_path / "log"
    explored(changed(file), store, log)
    assert computed(log) == [0, 1, 2, 3]
    log.unlink()
    # Another variant and another value, and none of those there are is computed again.
    three = ("[base, on-host]", "[large-blocks, base, on-host]")
    study = explored(changed(file, three), store, log)
    assert computed(log) == [0, 1]
    assert load_study(store).to_json() == study.to_json()
    log.unlink()
    explored(changed(file, three, ("method: sor", "method: sor, omega: 1.5")), store, log)
    assert sorted(computed(log)) == [4, 5]
    log.unlink()
    # Prose changes no point, and a variant that is not explored none at all.
    explored(
        changed(file, ("iterations: 32", "iterations: 33"), ("  on-host:", "  on-host:\n    description: PC")),
        store,
        log,
    )
    assert computed(log) == []
    explored(changed(file, ("name: who", "name: whom")), store, log)
    assert computed(log) == [0, 1, 2, 3]


def test_keys_of_points_tell_variants_apart() -> None:
    axes: dict[str, Any] = {"workload.variant": ["base", "b", 3], "x.y": [1]}

    def keys(variants: dict[str, str]) -> list[str]:
        contents = {"workload.variant": {canonical(name): digest for name, digest in variants.items()}}
        return [point.key for point in Space(axes, "same", contents).points()]

    assert len(set(keys({"b": "one"}))) == 3
    changes = [one == other for one, other in zip(keys({"b": "one"}), keys({"b": "two"}), strict=True)]
    assert changes == [True, False, True]
    # Without variants a key is what it was before there were any.
    assert keys({})[0] == keys({"b": "one"})[0]


def test_only_the_variants_explored_are_digested(file: Path) -> None:
    platform = codesign.load_platform("virtex4-pci")
    contents = contents_of(Explored.of(platform, codesign.load_workload(file)))
    assert {axis: list(digests) for axis, digests in contents.items()} == {"workload.variant": ['"on-host"']}
    assert contents_of(Explored.of(platform, codesign.load_workload("labyrinth"))) == {}


def test_where_no_variant_can_be_built_the_first_says_so(file: Path) -> None:
    workload = changed(file, ("[base, on-host]", "[on-host]"), ("component: host, method", "component: fpga, method"))
    with pytest.raises(SpecError, match=r"variants\.on-host\.mapping\.relax"):
        explore(codesign.load_platform("virtex4-pci"), workload, workers=1)


def test_workers_choose_the_same_variants(file: Path, tmp_path: Path) -> None:
    platform, workload = codesign.load_platform("virtex4-pci"), codesign.load_workload(file)
    one = explore(platform, workload, workers=1)
    assert explore(platform, workload, workers=2).to_json() == one.to_json()
    with FileStore(tmp_path / "a.sqlite") as store:
        assert explore(platform, workload, workers=1, store=store).to_json() == one.to_json()
