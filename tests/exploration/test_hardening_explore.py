"""What may go wrong around an exploration: files that change, axes that do not fit, problems without an answer."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

import codesign
from codesign.errors import InputError, RunError, SpecError, StoreError
from codesign.exploration import Entry, FileStore, Progress, Space, State, explore, load_study
from codesign.inputs import override
from codesign.inputs.part_file import parts_folder
from codesign.maps import OccupancyGrid
from codesign.memo import approximate_bytes
from codesign.system import check_files, simulate

Specs = tuple[Path, Path]

AXES = "{relax.iterations: [1, 4]}"
MAP = "......\n.@..@.\n......\n......\n"


def put_map(specs: Specs, text: str = MAP, *, goals: str = "[[0, 0]]", starts: str = "[[3, 5]]") -> Path:
    """The small workload on a map file of its own."""
    file = specs[1].parent / "small.txt"
    file.write_text(text, encoding="utf-8")
    lines = specs[1].read_text(encoding="utf-8").partition("explore:")[0].splitlines()
    new = {
        "map": "{file: small.txt}",
        "goals": goals,
        "starts": starts,
        "relax": "{component: fpga, block: [2, 2], iterations: 4, schedule: [15]}",
    }
    lines = [
        f"  {key}: {new[key]}" if (key := line.strip().partition(":")[0]) in new else line for line in lines
    ]
    specs[1].write_text("\n".join([*lines, f"explore: {{axes: {AXES}}}", ""]), encoding="utf-8")
    return file


def test_a_map_that_changes_meanwhile_leaves_the_points_as_they_were_keyed(specs: Specs) -> None:
    file = put_map(specs)
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    before = explore(platform, workload, workers=1).to_json()
    changed = MAP.replace("@", ".")

    def change(_progress: Progress) -> None:
        file.write_text(changed, encoding="utf-8")

    for workers in (1, 2):
        file.write_text(MAP, encoding="utf-8")
        assert explore(platform, workload, workers=workers, progress=change).to_json() == before
    assert explore(platform, workload, workers=1).to_json() != before


def test_a_part_that_changes_meanwhile_ends_the_run_and_keeps_nothing_of_it(
    specs: Specs, tmp_path: Path
) -> None:
    put_map(specs)
    source = parts_folder() / "XC2V6000.yaml"
    folder = specs[0].parent / "parts"
    folder.mkdir()
    part = folder / "XC2V6000.yaml"
    part.write_bytes(source.read_bytes())
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    store = tmp_path / "points.sqlite"

    def change(_progress: Progress) -> None:
        part.write_bytes(source.read_bytes() + b"# changed\n")

    with pytest.raises(RunError, match="part file changed"):
        explore(platform, workload, workers=1, store=store, progress=change)
    assert len(load_study(store).missing) == 2


def test_faults_of_axes_are_told_at_their_places(specs: Specs) -> None:
    put_map(specs)
    text = specs[1].read_text(encoding="utf-8").replace(AXES, "{fpga.clock: [100 MHz, 3 parsecs]}")
    specs[1].write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=r"rooms\.yaml:\d+:\d+: explore\.axes\.fpga\.clock\[1\]"):
        explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1)


def test_more_points_than_memory_allows_are_refused(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0]
    values = list(range(1, 501))
    text += f"explore: {{axes: {{relax.iterations: {values}, relax.schedule: {[[n] for n in values]}}}}}\n"
    specs[1].write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="250,000 points"):
        explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1)


WALLED_GOAL = ".@....\n@.....\n......\n......\n"
WALLED_START = "......\n......\n....@.\n...@.@\n....@.\n"


def test_a_walled_in_goal_is_told_and_not_praised(specs: Specs) -> None:
    put_map(specs, WALLED_GOAL, starts="{count: 4}")
    with pytest.raises(SpecError, match=r"problem\.goals\[0\]: goal \(0, 0\) is walled in"):
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))


def test_a_start_without_a_way_is_told_with_the_nearest_that_has_one(specs: Specs) -> None:
    put_map(specs, WALLED_START, starts="[[4, 0], [3, 4]]")
    with pytest.raises(SpecError) as caught:
        codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    (fault,) = caught.value.faults
    assert (fault.key, fault.what) == ("problem.starts[1]", "no path leads from start (3, 4) to a goal")
    assert fault.hint is not None
    assert fault.hint.endswith(("(1, 4)", "(2, 3)", "(2, 5)", "(4, 3)"))


def test_a_share_of_no_cells_is_no_success(specs: Specs) -> None:
    put_map(specs, ".@\n@@\n", starts="[[0, 0]]")
    result = codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    assert result.quality.reachable_cells == 0
    assert result.quality.share_reaching_goal is None


def test_what_a_platform_lacks_for_a_workload_is_told_by_check(specs: Specs) -> None:
    put_map(specs)
    platform = specs[0].read_text(encoding="utf-8")
    specs[0].write_text(platform.partition("links:")[0], encoding="utf-8")
    (fault,) = check_files(specs)
    assert fault.file == str(specs[0])
    assert "no link joins host" in fault.what
    assert "between: [host, fpga]" in str(fault.hint)
    specs[0].write_text(platform.replace("costs: {harmonic_node_update: 40 ns}, ", ""), encoding="utf-8")
    text = specs[1].read_text(encoding="utf-8").replace("component: fpga", "component: host")
    specs[1].write_text(text, encoding="utf-8")
    (fault,) = check_files(specs)
    assert fault.line == 5
    assert "harmonic_node_update" in str(fault.hint)


def test_what_is_no_regular_file_is_no_store(tmp_path: Path) -> None:
    fifo = tmp_path / "points.sqlite"
    os.mkfifo(fifo)
    for read_only in (True, False):
        with pytest.raises(StoreError, match="not a regular file"):
            FileStore(fifo, read_only=read_only)


def test_a_host_that_costs_nothing_keeps_nobody_busy(specs: Specs) -> None:
    put_map(specs)
    text = specs[0].read_text(encoding="utf-8").replace("40 ns", "0 ns").partition("links:")[0]
    specs[0].write_text(text.replace("  fpga:", "  # fpga:"), encoding="utf-8")
    text = specs[1].read_text(encoding="utf-8").replace("component: fpga", "component: host")
    specs[1].write_text(text, encoding="utf-8")
    result = codesign.simulate(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]))
    assert result.time.first_plan_s == 0
    assert result.utilisation == {"host": 0.0}


def kept(specs: Specs, tmp_path: Path) -> tuple[Path, str, str]:
    """A file of two points, the definition of its study, and the key of a point."""
    put_map(specs)
    file = tmp_path / "points.sqlite"
    study = explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1, store=file)
    assert len(study.feasible) == 2
    with FileStore(file, read_only=True) as store:
        definition = store.latest()
    assert definition is not None
    known = json.loads(definition)
    return file, definition, Space(known["axes"], known["fingerprint"]).point(0).key


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (
            '"axes": {"relax.iterations": [1, 4]}',
            '"axes": {"relax.iterations": ' + "[" * 9000 + "]" * 9000 + "}",
        ),
        ('"axes": {"relax.iterations": [1, 4]}', '"axes": {"a.b": [1e999]}'),
        ('"axes": {"relax.iterations": [1, 4]}', '"axes": [[1, 2]]'),
        (
            '"axes": {"relax.iterations": [1, 4]}',
            '"axes": ' + json.dumps({f"a.x{axis}": list(range(1000)) for axis in range(9)}),
        ),
        ('"platform": {', '"platform": {}, "other": {'),
        ('"workload": {', '"workload": 7, "others": {'),
        ('"constraints": []', '"constraints": 7'),
    ],
)
def test_a_tampered_study_is_told(specs: Specs, tmp_path: Path, old: str, new: str) -> None:
    file, definition, _ = kept(specs, tmp_path)
    assert old in definition
    with FileStore(file) as store:
        store.begin("tampered", definition.replace(old, new))
    with pytest.raises(StoreError):
        load_study(file)


@pytest.mark.parametrize("number", ["1e999", "Infinity", "NaN", "9" * 400, "[" * 100_000])
def test_a_tampered_result_is_told(specs: Specs, tmp_path: Path, number: str) -> None:
    file, _, key = kept(specs, tmp_path)
    with FileStore(file) as store:
        text = store.find([key])[key].text
        changed = re.sub(r'"energy_j":[^,}]*', f'"energy_j":{number}', text)
        assert changed != text
        store.put([Entry(key, State.DONE, changed)])
    with pytest.raises(StoreError):
        load_study(file)


def test_where_every_point_failed_the_run_failed(
    specs: Specs, hwsw: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    put_map(specs)

    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("broken")

    monkeypatch.setattr("codesign.system.simulate", fail)
    ran = hwsw("explore", *specs, "--workers", 1)
    assert ran.exit_code == 1


def test_a_study_keeps_what_its_points_have_in_common_once(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0]
    text = text.replace("[12, 18]", "[24, 36]")
    text += f"explore: {{axes: {{fpga.part: [XC3S500E-4], relax.iterations: {list(range(1, 201))}}}}}\n"
    specs[1].write_text(text, encoding="utf-8")
    platform, workload = codesign.load_platform(specs[0]), codesign.load_workload(specs[1])
    study = explore(platform, workload, workers=1)
    assert study.feasible == ()
    for point in study.points[::40]:
        assert point.result is not None
        alone = simulate(*override(platform, workload, point.axes))
        assert point.result == alone
        assert point.result.model_dump_json() == alone.model_dump_json()
    assert approximate_bytes(study.points) / len(study.points) < 6000


def test_a_run_that_no_memory_holds_is_refused_with_its_size(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0]
    text = text.replace(
        "generate: rooms, rows: 24, columns: 36, room: [11, 17], door: 2, seed: 3", "file: m.txt"
    )
    text = text.replace("{first: 7, step: 8, last: 63}", "[1023]").replace("{count: 12, seed: 1}", "[[3, 3]]")
    text = text.replace("component: fpga", "component: host").replace("[12, 18]", "[64, 64]")
    specs[1].write_text(text, encoding="utf-8")
    (specs[1].parent / "m.txt").write_text("...\n...\n...\n", encoding="utf-8")
    big = OccupancyGrid(np.ones((4096, 4096), np.bool_))
    with pytest.raises(
        SpecError, match=r"the run would need about \d+\.\d GiB of memory .*, more than 4\.0 GiB"
    ):
        simulate(
            codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), grid=big, memory=4 * 2**30
        )
