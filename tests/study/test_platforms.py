"""Explorations over platforms: roles in place of names, what a platform cannot take, and what is computed again."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result

import codesign
from codesign.ground.errors import InputError, SpecError
from codesign.ground.memo import Memo
from codesign.inputs import design_point, load_platforms
from codesign.study import Progress, Study, explore, load_study
from codesign.study.evaluation import computation_digest
from codesign.study.pricing.computation import Computation, record
from codesign.system.bind import System
from codesign.system.scenarios import simulate
from codesign.views.report import front_table, reasons_table, render_text
from codesign.views.report.study_page import study_html

TEXT = """\
kind: workload
name: boards
planner: harmonic
problem: {map: {file: a.txt}, goals: [[1, 1]], starts: [[8, 9]]}
mapping:
  relax: {component: fabric, block: [5, 6], iterations: 6, schedule: [7, 15]}
  decide: {component: fabric}
variants:
  on-host:
    planner: relaxation
    mapping: {relax: {component: host, method: sor, omega: 1.8}}
explore:
  axes:
    platform: [zynq, arty-a7, pc-epyc]
    workload.problem.map.file: [a.txt, b.txt]
    workload.variant: [base, on-host]
    fabric.clock: [50 MHz, 100 MHz]
  objectives: [first_plan_s, slices, energy_j]
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "a.txt").write_text("............\n" * 10, encoding="utf-8")
    (tmp_path / "b.txt").write_text("............\n" * 4 + ".....#......\n" * 6, encoding="utf-8")
    return written(tmp_path, TEXT)


def written(folder: Path, text: str) -> Path:
    file = folder / "boards.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def over(file: Path, platform: Any = None, **options: Any) -> Study:
    return explore(platform, codesign.load_workload(file), workers=options.pop("workers", 1), **options)


def without(file: Path, *axes: str) -> Path:
    lines = [line for line in TEXT.splitlines(keepends=True) if not line.strip().startswith(axes)]
    return written(file.parent, "".join(lines))


def test_one_workload_on_three_boards_and_two_maps(file: Path) -> None:
    store = file.with_suffix(".sqlite")
    study = over(file, store=store)
    assert over(file, workers=2).to_json() == study.to_json() == load_study(store).to_json()
    assert (study.platform, len(study.points), study.failed) == ("3 platforms", 24, ())
    workload = codesign.load_workload(file)
    for point in study.points:
        result = point.result
        assert result is not None
        assert result.platform == point.axes["platform"]
        if not result.feasible:
            continue
        platform = codesign.load_platform(result.platform)
        axes = {axis: value for axis, value in point.axes.items() if axis != "platform"}
        if "fabric" not in platform.filled:
            del axes["fabric.clock"]
        assert json.loads(simulate(*design_point(platform, workload, axes)).model_dump_json()) == json.loads(
            result.model_dump_json()
        )
        role = "fabric" if point.axes["workload.variant"] == "base" else "host"
        assert result.component == result.places["relax"] == result.roles[role] == platform.filled[role]


def test_a_platform_without_a_fabric_is_infeasible_where_a_task_is_placed_on_it(file: Path) -> None:
    study = over(file)
    on_pc = [point for point in study.points if point.axes["platform"] == "pc-epyc"]
    assert [point.feasible for point in on_pc] == [point.axes["workload.variant"] == "on-host" for point in on_pc]
    (reason,) = study.reasons
    assert (reason.kind, reason.name, reason.designs) == ("mapping", "platform pc-epyc has no fabric", 4)
    assert reason.levers[0].startswith("give it roles: {fabric: NAME}, a component of type fpga; or take arty-a7, ")
    shown = render_text(reasons_table(study))
    assert "mapping   platform pc-epyc has no fabric" in shown
    # It takes no slices because it is not there: no design is better for that.
    assert on_pc[0].result is not None
    assert on_pc[0].figure(study.objectives[1]) is None


def test_tables_and_page_show_platform_and_part(file: Path) -> None:
    study = over(without(file, "workload.variant"))
    assert "zynq (XC7Z020-1)" in render_text(front_table(study))
    page = study_html(study)
    assert "boards on 3 platforms" in page
    assert "hwsw explore boards --html" in page
    for text in ("zynq (XC7Z020-1)", "arty-a7 (XC7A35T-1)", "pc-epyc"):
        assert text in page


def test_a_value_that_one_platform_refuses_leaves_out_its_points_alone(file: Path) -> None:
    text = TEXT.replace("    fabric.clock: [50 MHz, 100 MHz]\n", "    link.baud: [9600, 115200]\n")
    study = over(written(file.parent, text))
    by_platform = {name: [p for p in study.points if p.axes["platform"] == name] for name in study.axes["platform"]}
    assert all(point.feasible for point in by_platform["arty-a7"])
    assert not any(point.feasible for point in by_platform["zynq"])
    names = {reason.name for point in by_platform["zynq"] if point.result for reason in point.result.reasons}
    assert names == {"link.baud: unknown key"}


def test_a_value_that_no_platform_takes_is_a_fault_at_its_place(file: Path) -> None:
    written(file.parent, TEXT.replace("50 MHz, 100 MHz", "50 MHz, 3 parsecs"))
    with pytest.raises(SpecError, match=r"boards\.yaml:17:28: explore\.axes\.fabric\.clock\[1\]: '3 parsecs'"):
        over(file)


def test_where_no_platform_takes_the_workload_the_first_says_so(file: Path) -> None:
    without(file, "workload.variant", "fabric.clock")
    with pytest.raises(SpecError, match=r"relax\.component: platform pc-epyc has no fabric"):
        over(file, load_platforms(["pc-epyc", "pc-3400mhz"]))


def test_one_platform_without_the_role_of_an_axis_is_a_fault(file: Path) -> None:
    with pytest.raises(SpecError, match=r"explore\.axes\.fabric\.clock: platform pc-epyc has no fabric"):
        over(file, codesign.load_platform("pc-epyc"))


def cached(file: Path, store: Path) -> int:
    states: list[Progress] = []
    over(file, store=store, progress=states.append)
    return states[-1].cached


def test_only_what_changed_is_computed_again(file: Path, tmp_path: Path) -> None:
    store = tmp_path / "points.sqlite"
    own = tmp_path / "own.yaml"
    own.write_text(Path("platforms/zynq.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    two = TEXT.replace("[zynq, arty-a7, pc-epyc]", "[arty-a7, ./own.yaml]")
    assert (cached(written(tmp_path, two), store), cached(file, store)) == (0, 16)
    written(tmp_path, two.replace("[arty-a7, ", "[pc-epyc, arty-a7, "))
    assert cached(file, store) == 16
    own.write_text(own.read_text(encoding="utf-8").replace("value: 100 MHz", "value: 90 MHz", 1), encoding="utf-8")
    assert cached(file, store) == 16


def test_an_interrupted_exploration_goes_on(file: Path, tmp_path: Path) -> None:
    def stop(progress: Progress) -> None:
        if progress.done >= 10:
            raise KeyboardInterrupt

    store = tmp_path / "points.sqlite"
    with pytest.raises(KeyboardInterrupt):
        over(file, store=store, progress=stop)
    assert load_study(store).missing
    assert 10 <= cached(file, store) < 24
    assert load_study(store).to_json() == over(file).to_json()


def test_platforms_share_their_functional_work(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorded: list[str] = []
    memos: list[Memo] = []

    def counted(system: System, memo: Memo) -> Computation:
        recorded.append(computation_digest(system))
        return record(system, memo)

    def remembered() -> Memo:
        memos.append(Memo())
        return memos[-1]

    monkeypatch.setattr("codesign.study.evaluation.record", counted)
    monkeypatch.setattr("codesign.study.evaluation.Memo", remembered)
    without(file, "workload.variant", "fabric.clock")
    boards = load_platforms(["zynq", "arty-a7", "virtex2-pci"])
    over(file, boards[0])
    single, recorded[:] = list(recorded), []
    over(file, boards)
    assert single
    assert sorted(set(recorded)) == sorted(recorded), "none is computed twice"
    assert set(single) <= set(recorded)
    # Components have other names on other boards, so a computation is one of its board. The plans are not.
    assert len(recorded) == 3 * len(single)
    one, three = memos
    assert three.misses == one.misses > 0
    assert three.hits > one.hits


def test_platforms_from_python(file: Path) -> None:
    zynq, arty = load_platforms(["zynq", "arty-a7"])
    study = codesign.explore([arty, zynq], codesign.load_workload(file))
    assert study.axes["platform"] == ("arty-a7", "zynq")
    alone = codesign.explore(zynq, codesign.load_workload(file))
    assert "platform" not in alone.axes
    assert alone.platform == "zynq"
    labyrinth = codesign.load_workload("labyrinth").model_copy(update={"explore": None})
    only = explore([zynq, arty], labyrinth, workers=1, evaluate=_refused)
    assert dict(only.axes) == {"platform": ("zynq", "arty-a7")}
    with pytest.raises(InputError, match="two platforms have the name zynq"):
        explore([zynq, zynq], labyrinth)
    with pytest.raises(InputError, match="no platform to explore"):
        explore([], labyrinth)
    with pytest.raises(InputError, match="labyrinth is explored on no platform"):
        explore(None, codesign.load_workload("labyrinth"))


def _refused(_point: Any) -> Any:
    raise InputError("not computed here")


def test_the_command_takes_platforms_from_the_axis_or_from_set(hwsw: Callable[..., Result], file: Path) -> None:
    without(file, "workload.variant")
    store = file.with_suffix(".sqlite")
    ran = hwsw("explore", file, "--store", store, "--json", "--workers", 1)
    assert ran.exit_code == 0, ran.output
    assert json.loads(ran.stdout)["axes"]["platform"] == ["zynq", "arty-a7", "pc-epyc"]
    ran = hwsw(
        "explore", file, "--store", store, "--json", "--workers", 1,
        "--set", "platform=[arty-a7, virtex2-pci]", "--set", "fabric.clock=40 MHz",
    )  # fmt: skip
    assert ran.exit_code == 0, ran.output
    axes = json.loads(ran.stdout)["axes"]
    assert (axes["platform"], axes["fabric.clock"]) == (["arty-a7", "virtex2-pci"], ["40 MHz"])
    ran = hwsw("explore", "zynq", file, "--store", store, "--json", "--workers", 1)
    assert "platform" not in json.loads(ran.stdout)["axes"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("labyrinth",), "workload labyrinth is explored on no platform"),
        (("zynq", "labyrinth", "--set", "platform=zynq"), "--set platform: PLATFORM is named too"),
        (("labyrinth", "--set", "platform=7"), "--set platform: 7 names no platform"),
        (("labyrinth", "--set", "platform=[zynq, zinq]"), "--set platform: there is no shipped platform 'zinq'"),
        (("a", "b", "c"), "3 arguments"),
        (
            ("labyrinth", "--set", "platform=[zynq, arty-a7]", "--set", "fabric.clock=9 THz"),
            "--set fabric.clock: '9 THz' has no unit of frequency",
        ),
    ],
)
def test_mistakes_on_the_command_line(
    hwsw: Callable[..., Result], tmp_path: Path, arguments: tuple[str, ...], message: str
) -> None:
    ran = hwsw("explore", *arguments, "--store", tmp_path / "points.sqlite")
    assert ran.exit_code == 2, ran.output
    assert message in ran.stderr


@pytest.mark.parametrize(
    ("value", "fault"),
    [
        ("zinq", "axes.platform[1]: there is no shipped platform 'zinq'\n  hint: did you mean zynq?"),
        ("./gone.yaml", "boards.yaml:14:25: explore.axes.platform[1]: there is no file './gone.yaml'"),
        ("7", "boards.yaml:14:25: explore.axes.platform[1]: 7 names no platform"),
        ("arty-a7", "boards.yaml:14:25: explore.axes.platform[1]: \"arty-a7\" is listed twice"),
    ],
)  # fmt: skip
def test_values_that_name_no_platform(file: Path, value: str, fault: str) -> None:
    written(file.parent, TEXT.replace("[zynq, arty-a7, pc-epyc]", f"[arty-a7, {value}]"))
    with pytest.raises(SpecError) as error:
        codesign.load_workload(file)
    assert fault in str(error.value)


def test_faults_of_platform_files_are_reported_at_their_places(hwsw: Callable[..., Result], file: Path) -> None:
    for name, clock in (("one", "1 parsec"), ("two", "100")):
        text = f"kind: platform\nname: {name}\ncomponents:\n  pc: {{type: processor, clock: {clock}}}\n"
        (file.parent / f"{name}.yaml").write_text(text, encoding="utf-8")
    written(file.parent, TEXT.replace("[zynq, arty-a7, pc-epyc]", "[./one.yaml, zynq, ./two.yaml]"))
    for command in (("explore",), ("check",)):
        ran = hwsw(*command, file)
        assert ran.exit_code == 2
        assert "one.yaml:4:32: components.pc.clock: '1 parsec'" in ran.stderr
        assert "two.yaml:4:32: components.pc.clock: 100 has no unit" in ran.stderr


def test_a_role_and_the_name_that_fills_it_are_one_axis(file: Path) -> None:
    written(file.parent, TEXT.replace("    fabric.clock", "    fpga.clock: [10 MHz]\n    fabric.clock"))
    with pytest.raises(SpecError, match=r"fabric\.clock: sets the same thing as axis fpga\.clock\n  hint: keep one"):
        over(file, codesign.load_platform("zynq"))
