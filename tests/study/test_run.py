from __future__ import annotations

import json
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result
from explore_fakes import AXES, OBJECTIVES, Fake, computed, exploring
from places import ROOT
from small_maps import AXES_TEXT, Specs, put_map

import codesign
from codesign.ground.errors import InputError, SpecError, StoreError
from codesign.ground.figures import FIGURES
from codesign.ground.memo import Memo
from codesign.inputs import Constraint, Platform, Workload, design_point, pin
from codesign.study import EntryState, FileStore, MemoryStore, Progress, Space, explore, load_study
from codesign.study.evaluation import computation_digest
from codesign.study.identity import canonical_digest, fingerprint
from codesign.study.pricing.computation import Computation, record
from codesign.study.space import canonical
from codesign.study.store import Batch, Entry, Store
from codesign.system.bind import System
from codesign.system.scenarios import simulate


@pytest.fixture(scope="module")
def platform() -> Platform:
    return codesign.load_platform("virtex4-pci")


@pytest.fixture(scope="module")
def labyrinth() -> Workload:
    return codesign.load_workload("labyrinth")


@pytest.fixture(scope="module")
def workload(labyrinth: Workload) -> Workload:
    return exploring(labyrinth, AXES)


def test_every_point_in_the_order_of_enumeration(platform: Platform, workload: Workload) -> None:
    study = explore(platform, workload, workers=1, evaluate=Fake())
    assert [point.index for point in study.points] == list(range(12))
    assert [point.axes["bench.seconds"] for point in study.points] == [1.0, 1e-3] * 6
    assert (study.platform, study.workload, study.objectives) == ("virtex4-pci", "labyrinth", OBJECTIVES)
    assert study.feasible == tuple(range(8))
    assert study.front == (1, 3)
    assert pickle.loads(pickle.dumps(study)) == study


def test_the_same_bytes_at_any_worker_count_and_from_a_store(
    platform: Platform, workload: Workload, tmp_path: Path
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    one = explore(platform, workload, workers=1, evaluate=Fake()).to_json()
    assert explore(platform, workload, workers=2, store=file, evaluate=Fake(log)).to_json() == one
    assert explore(platform, workload, workers=2, store=str(file), evaluate=Fake(log)).to_json() == one
    assert load_study(file).to_json() == one
    assert sorted(computed(log)) == list(range(12))


@pytest.mark.parametrize("last", [0, 5, 11])
def test_after_an_interrupt_the_next_run_goes_on(
    platform: Platform, workload: Workload, tmp_path: Path, last: int
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    with pytest.raises(KeyboardInterrupt):
        explore(platform, workload, workers=1, store=file, evaluate=Fake(log, {last: "interrupt"}))
    part = load_study(file)
    finished = [point.index for point in part.points if point.state == "done"]
    assert set(finished) == set(computed(log)) - {last}
    assert len(part.missing) == 12 - len(finished)
    log.unlink()
    whole = explore(platform, workload, workers=1, store=file, evaluate=Fake(log))
    assert sorted([*computed(log), *finished]) == list(range(12))
    assert whole.to_json() == explore(platform, workload, workers=1, evaluate=Fake()).to_json()


SCRIPT = """
import sys
from pathlib import Path
import codesign
from codesign.study import explore
from explore_fakes import AXES, Fake, exploring

workload = exploring(codesign.load_workload("labyrinth"), AXES)
platform = codesign.load_platform("virtex4-pci")
explore(platform, workload, workers=1, store=sys.argv[1], evaluate=Fake(Path(sys.argv[2]), {7: "die"}))
"""


def test_after_a_crash_the_next_run_goes_on(platform: Platform, workload: Workload, tmp_path: Path) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    places = [str(ROOT / "tests" / "support"), str(ROOT)]
    command = [sys.executable, "-c", f"import sys; sys.path[:0] = {places!r}\n{SCRIPT}", str(file), str(log)]
    assert subprocess.run(command, check=False, cwd=ROOT).returncode == 9
    finished = set(computed(log)) - {7}
    assert finished
    log.unlink()
    whole = explore(platform, workload, workers=2, store=file, evaluate=Fake(log))
    assert set(computed(log)) == set(range(12)) - finished
    assert whole.to_json() == explore(platform, workload, workers=1, evaluate=Fake()).to_json()


def test_failed_points_are_tried_again_and_kept_for_the_report(
    platform: Platform, workload: Workload, tmp_path: Path
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    study = explore(platform, workload, workers=1, store=file, evaluate=Fake(at={3: "fail", 4: "refuse"}))
    assert study.failed == (3, 4)
    assert load_study(file).to_json() == study.to_json()
    assert explore(platform, workload, workers=1, store=file, evaluate=Fake(log)).failed == ()
    assert sorted(computed(log)) == [3, 4]


def test_more_values_on_an_axis_cost_only_the_new_points(
    platform: Platform, labyrinth: Workload, tmp_path: Path
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    few, more = {"a.slices": [1, 2]}, {"a.slices": [3, 2, 1]}
    explore(platform, exploring(labyrinth, few), workers=1, store=file, evaluate=Fake())
    limits = (Constraint(figure=FIGURES["slices"], at_most=2),)
    study = explore(platform, exploring(labyrinth, more, constraints=limits), workers=1, store=file, evaluate=Fake(log))
    assert computed(log) == [0]
    assert study.feasible == (1, 2)
    assert load_study(file).to_json() == study.to_json()


def test_progress(platform: Platform, workload: Workload) -> None:
    store = MemoryStore()
    told: list[Progress] = []
    explore(platform, workload, workers=1, store=store, evaluate=Fake(at={2: "fail"}), progress=told.append)
    first, last = told[0], told[-1]
    assert (first.done, first.total, first.cached, first.left_s) == (0, 12, 0, None)
    assert (last.done, last.cached, last.feasible, last.failed, last.left_s) == (12, 0, 7, 1, 0.0)
    assert [progress.done for progress in told] == sorted(progress.done for progress in told)
    assert all(progress.left_s is not None for progress in told[2:])
    assert all(progress.elapsed_s >= 0 for progress in told)

    told.clear()
    explore(platform, workload, workers=1, store=store, evaluate=Fake(), progress=told.append)
    assert [(progress.done, progress.cached, progress.feasible) for progress in told] == [(11, 11, 7), (12, 11, 8)]


def test_a_listener_that_stops_the_run_loses_nothing(platform: Platform, workload: Workload, tmp_path: Path) -> None:
    def stop(progress: Progress) -> None:
        if progress.done >= 6:
            raise KeyboardInterrupt

    file = tmp_path / "points.sqlite"
    with pytest.raises(KeyboardInterrupt):
        explore(platform, workload, workers=2, store=file, evaluate=Fake(), progress=stop)
    assert sum(point.state == "done" for point in load_study(file).points) >= 6


def test_what_a_key_stands_for(platform: Platform, labyrinth: Workload) -> None:
    def changed(axes: dict[str, Any]) -> str:
        return fingerprint(*design_point(platform, labyrinth, axes))

    here = fingerprint(platform, labyrinth)
    assert fingerprint(platform, exploring(labyrinth, AXES)) == here
    assert fingerprint(platform, labyrinth.model_copy(update={"description": "other words"})) == here
    assert changed({"relax.iterations": 7}) != here
    assert changed({"fpga.clock": "101 MHz"}) != here


def test_a_map_that_changes_in_its_file_is_another_map(platform: Platform, tmp_path: Path) -> None:
    source = tmp_path / "mine.yaml"
    source.write_text(
        "kind: workload\nname: mine\nplanner: harmonic\n"
        "problem: {map: {file: room.txt}, goals: [[1, 1]]}\n"
        "mapping: {relax: {component: fpga, block: [3, 4], iterations: 6, schedule: [7]}, decide: {component: fpga}}\n"
    )
    prints = []
    for text in ("......\n......\n......\n", "......\n....#.\n......\n"):
        (tmp_path / "room.txt").write_text(text)
        prints.append(fingerprint(platform, codesign.load_workload(source)))
    assert prints[0] != prints[1]


def test_without_anything_to_explore(platform: Platform, labyrinth: Workload) -> None:
    with pytest.raises(InputError, match="nothing to explore"):
        explore(platform, labyrinth.model_copy(update={"explore": None}))


def test_without_a_worker(platform: Platform, workload: Workload) -> None:
    with pytest.raises(InputError, match="0 workers"):
        explore(platform, workload, workers=0)


def test_where_no_point_can_be_built_the_fault_is_told_at_once(platform: Platform, labyrinth: Workload) -> None:
    too_many = exploring(labyrinth, {"relax.blocks": [[71, 1], [70, 1]]})
    with pytest.raises(SpecError, match="71 × 1 equal blocks do not part a map"):
        explore(platform, too_many, workers=1)


def test_a_file_without_a_study(tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"
    FileStore(file).close()
    with pytest.raises(StoreError, match="holds no study"):
        load_study(file)


def latest(store: Store) -> tuple[str, bytes]:
    study = store.latest()
    assert study is not None
    return study


@pytest.mark.parametrize("change", [{"objectives": ["beauty"]}, {"constraints": [{"beauty": 1}]}, {"axes": 7}])
def test_a_study_of_another_version(
    platform: Platform, workload: Workload, tmp_path: Path, change: dict[str, Any]
) -> None:
    file = tmp_path / "points.sqlite"
    explore(platform, workload, workers=1, store=file, evaluate=Fake())
    with FileStore(file) as store:
        text, plan = latest(store)
        store.begin("changed", json.dumps(json.loads(text) | change), plan)
    with pytest.raises(StoreError, match="this version cannot read"):
        load_study(file)


def test_a_result_of_another_version(platform: Platform, workload: Workload, tmp_path: Path) -> None:
    file = tmp_path / "points.sqlite"
    explore(platform, workload, workers=1, store=file, evaluate=Fake())
    with FileStore(file) as store:
        key = canonical_digest(json.loads(latest(store)[0])["identity"])
        point = Space(AXES, key).point(0)
        store.put(Batch([Entry(point.key, EntryState.DONE, '{"schema_version": 99}')]))
    with pytest.raises(StoreError, match="this version cannot read"):
        load_study(file)
    with pytest.raises(StoreError, match="this version cannot read"):
        explore(platform, workload, workers=1, store=file, evaluate=Fake())


SMALL = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: maze, rows: 13, columns: 17, seed: 3}
  goals: [[0, 1]]
  starts: {count: 5, seed: 0}
  arrive: 0 # few bits, so that many points take little time
mapping:
  relax: {component: fpga, block: [6, 8], iterations: 6, schedule: [7]}
  decide: {component: fpga}
explore:
  axes:
    relax.block: [[6, 8], [4, 5], [13, 17]]
    relax.schedule: [[8], {first: 4, step: 4, last: 12}]
    relax.termination: [sound, published]
    fpga.part: [XC2V6000-4, XC4VLX160-12]
    fpga.clock: [100 MHz, 150 MHz]
  objectives: [first_plan_s, slices, energy_j]
"""


@pytest.fixture
def small(tmp_path: Path) -> Workload:
    source = tmp_path / "small.yaml"
    source.write_text(SMALL)
    return codesign.load_workload(source)


def test_simulated_points_do_not_depend_on_workers_memo_or_store(
    platform: Platform, small: Workload, tmp_path: Path
) -> None:

    file = tmp_path / "points.sqlite"
    study = explore(platform, small, workers=2, store=file)
    assert explore(platform, small, workers=1).to_json() == study.to_json() == load_study(file).to_json()
    assert study.feasible
    assert study.failed == ()
    for point in study.points[::5]:
        alone = simulate(*design_point(platform, small, point.axes), memo=None)
        assert point.result is not None
        assert json.loads(point.result.model_dump_json()) == json.loads(alone.model_dump_json())


def test_points_that_share_their_functional_work_do_it_once(
    platform: Platform, small: Workload, monkeypatch: pytest.MonkeyPatch
) -> None:
    digests: list[str] = []

    def recorded(system: System, memo: Memo) -> Computation:
        digests.append(computation_digest(system))
        return record(system, memo)

    monkeypatch.setattr("codesign.study.evaluation.record", recorded)
    store = MemoryStore()
    study = explore(platform, small, workers=1, store=store)
    names = ("relax.block", "relax.schedule", "relax.termination")
    functional = {canonical([study.points[index].axes[name] for name in names]) for index in study.feasible}
    assert study.failed == ()
    assert len(digests) == len(set(digests)) <= len(functional) < len(study.feasible)
    assert store.computations().keys() == set(digests)
    slower = pin(platform, small, {"pci.clock": "16 MHz"}, "")
    digests.clear()
    assert explore(*slower, workers=1, store=store).failed == ()
    assert digests == [], "another price asks for no other computation"


def test_faults_of_axes_are_told_at_their_places(specs: Specs) -> None:
    put_map(specs)
    text = specs[1].read_text(encoding="utf-8").replace(AXES_TEXT, "{fpga.clock: [100 MHz, 3 parsecs]}")
    specs[1].write_text(text, encoding="utf-8")
    with pytest.raises(SpecError, match=r"rooms\.yaml:\d+:\d+: explore\.axes\.fpga\.clock\[1\]"):
        explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1)


def test_more_points_than_memory_allows_are_refused(specs: Specs) -> None:
    text = specs[1].read_text(encoding="utf-8").partition("explore:")[0]
    values, clocks = list(range(1, 501)), "{from: 1 MHz, to: 17 MHz, step: 1 MHz}"
    text += (
        f"explore: {{axes: {{fpga.clock: {clocks},"
        f" relax.iterations: {values}, relax.schedule: {[[n] for n in values]}}}}}\n"
    )
    specs[1].write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="4,250,000 points"):
        explore(codesign.load_platform(specs[0]), codesign.load_workload(specs[1]), workers=1)


def test_where_every_point_failed_the_run_failed(
    specs: Specs, hwsw: Callable[..., Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    put_map(specs)

    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("broken")

    monkeypatch.setattr("codesign.study.simulator.simulate", fail)
    monkeypatch.setattr("codesign.study.evaluation.record", fail)
    ran = hwsw("explore", *specs, "--workers", 1)
    assert ran.exit_code == 1
