"""Explanations of designs and runs, and points that are made again from what a study holds."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest
from explore_fakes import result
from small_maps import put_map

import codesign
from codesign.ground.errors import InputError, SpecError
from codesign.ground.figures import FIGURES
from codesign.study import Outcomes, Study, load_study
from codesign.study.designs import explain_run, neighbours_of
from codesign.system.explanation import why_energy, why_time

Specs = tuple[Path, Path]
TIME, SLICES = FIGURES["first_plan_s"], FIGURES["slices"]

SMALL = """\
kind: workload
name: small
planner: harmonic
problem:
  map: {generate: rooms, rows: 24, columns: 36, room: [11, 17], door: 2, seed: 3}
  goals: [[2, 2]]
  starts: {count: 12, seed: 1}
mapping:
  relax: {component: fabric, block: [12, 18], iterations: 4, schedule: {first: 7, step: 8, last: 63}}
explore:
  axes:
    relax.block: [[12, 18], [24, 36]]
    relax.iterations: [1, 4]
    fabric.clock: [50 MHz, 100 MHz, 200 MHz]
"""


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> tuple[Study, Path]:
    """A study of twelve points, and its file."""
    file = tmp_path_factory.mktemp("study") / "small.sqlite"
    return codesign.explore("virtex4-pci", SMALL, store=file), file


def synthetic(values: dict[tuple[int, int], tuple[float, int]]) -> Study:
    """A study of two axes with these seconds and slices; more than 100 slices do not fit."""
    axes = {"a.x": (0, 1, 2), "a.y": (0, 1)}
    results = [
        result(seconds=values[x, y][0], slices=values[x, y][1], fits=values[x, y][1] <= 100)
        for x, y in itertools.product(*axes.values())
    ]
    return Study("bench", "maze", axes, (TIME, SLICES), (), Outcomes.of(results))


def test_neighbours_differ_in_one_axis_and_say_what_gains() -> None:
    study = synthetic(
        {(0, 0): (5, 50), (0, 1): (4, 50), (1, 0): (3, 60), (2, 0): (1, 200), (1, 1): (1, 10), (2, 1): (9, 90)}
    )
    dominating, trading, out = neighbours_of(study, study.designs[0])
    assert (dominating.index, dominating.what, dominating.before, dominating.after) == (1, "a.y", 0, 1)
    assert dominating.dominates
    assert (dominating.better, dominating.worse) == (("first_plan_s",), ())
    assert (trading.index, trading.better, trading.worse) == (2, ("first_plan_s",), ("slices",))
    assert not trading.dominates
    assert (out.index, out.feasible, out.out, out.better) == (4, False, ("slices",), ())


def test_a_study_put_together_by_hand_is_explained_without_its_levers() -> None:
    study = synthetic(dict.fromkeys(itertools.product(range(3), range(2)), (1.0, 200)))
    explanation = study.points[3].explain()
    assert not explanation.feasible
    (reason,) = explanation.out
    assert [(lever.what, lever.feasible) for lever in reason.levers] == [("shrink", None)]
    assert "nothing is known of its specs" in explanation.notes[0]
    with pytest.raises(InputError, match="of no exploration"):
        study.points[0].run()


@pytest.mark.parametrize(("index", "nearest"), [(-1, "0"), (6, "5"), (10**30, "5")])
def test_an_index_out_of_range_names_the_range_and_the_nearest(index: int, nearest: str) -> None:
    study = synthetic(dict.fromkeys(itertools.product(range(3), range(2)), (1.0, 10)))
    for asked in (study.explain, study.point):
        with pytest.raises(InputError, match="there is no point") as caught:
            asked(index)
        assert caught.value.hint == f"the study has points 0 to 5; the nearest is {nearest}"


def test_points_without_a_result_are_refused_with_the_remedy() -> None:
    study = Study("bench", "maze", {"a.x": (0, 1)}, (TIME,), (), Outcomes.of([None, "why"]))
    with pytest.raises(InputError, match="point 0 was not computed"):
        study.explain(0)
    with pytest.raises(InputError, match="point 1 failed: why") as caught:
        study.explain(1)
    assert "run --point 1" in str(caught.value.hint)


def test_points_are_run_again_from_the_study_and_from_its_file(stored: tuple[Study, Path]) -> None:
    study, file = stored
    for source in (study, load_study(file)):
        for index in (0, 6, 11):
            assert source.points[index].run() == study.points[index].result
    again = codesign.simulate(*load_study(file).points[0].specs())
    assert again.model_copy(update={"provenance": None}) == study.points[0].result


def test_the_parts_of_time_and_energy_add_up(stored: tuple[Study, Path]) -> None:
    study, _ = stored
    for point in study.points:
        if point.result is None or not point.feasible:
            continue
        for why, figure in ((why_time(point.result), "plan_time_worst_s"), (why_energy(point.result), "energy_j")):
            assert why is not None
            assert why.figure == figure
            assert math.fsum(each.amount for each in why.parts) == pytest.approx(why.value)
            assert why.value == pytest.approx(point.figure(FIGURES[figure]), rel=1e-6)
            assert sum(each.share for each in why.parts) == pytest.approx(1)
            assert [each.amount for each in why.parts] == sorted((each.amount for each in why.parts), reverse=True)
            assert all(each.figures for each in why.parts if each.share > 0.001)


def test_a_lever_of_the_clock_is_run_for_the_whole_design(stored: tuple[Study, Path]) -> None:
    study = stored[0]
    out = next(point for point in study.points if any(reason.kind == "clock" for reason in point.reasons))
    explanation = out.explain()
    (why,) = explanation.out
    lever = why.levers[0]
    assert (lever.goes, lever.feasible, lever.out) == (True, True, ())
    moved = codesign.load_platform("virtex4-pci")
    platform, workload = out.specs()
    assert platform.name == moved.name
    again = explain_run(platform, workload)
    assert again.out[0].levers[0] == lever
    from codesign.inputs import design_point

    alone = codesign.simulate(*design_point(platform, workload, {"fpga.clock": lever.after}))
    assert lever.figures["plan_time_worst_s"] == alone.figure(FIGURES["plan_time_worst_s"])


def test_each_lever_of_a_bound_ends_its_reason_or_says_what_is_left() -> None:
    explanation = codesign.explain("virtex4-pci", "labyrinth", {"relax.schedule": [7, 15, 511]})
    (why,) = explanation.out
    tried = [lever for lever in why.levers if lever.feasible is not None]
    assert tried
    assert tried[0].feasible
    assert tried[0].after == {"relax.schedule": [7, 15, 255]} or tried[0].after[-1] <= 255
    for lever in tried:
        assert lever.goes or why.reason.name.replace("_", " ") in lever.out
        assert lever.feasible is (not lever.out)


def test_a_constraint_is_tried_with_each_step() -> None:
    limited = SMALL + "  constraints: [{figure: plan_time_worst_s, at_most: 2 ms}]\n"
    explanation = codesign.explain("virtex4-pci", limited, {"relax.iterations": 1, "fabric.clock": "50 MHz"})
    (why,) = explanation.out
    assert why.reason.name == "plan_time_worst_s at most"
    helps = {lever.what for lever in why.levers if lever.goes and lever.feasible}
    assert "fpga.clock" in helps
    assert all(lever.figures["plan_time_worst_s"] <= 2e-3 for lever in why.levers if lever.feasible)  # type: ignore[operator]


def test_a_map_that_changed_is_said_and_one_that_is_gone_too(specs: Specs, tmp_path: Path) -> None:
    put_map(specs)
    study = codesign.explore(specs[0], specs[1], store=tmp_path / "p.sqlite")
    file = codesign.load_workload(specs[1]).map_file
    assert file is not None
    assert load_study(tmp_path / "p.sqlite").points[0].run() == study.points[0].result
    file.write_text("......\n.@@.@.\n......\n......\n", encoding="utf-8")
    with pytest.raises(InputError, match="the map changed since the study was computed"):
        load_study(tmp_path / "p.sqlite").points[0].run()
    file.unlink()
    with pytest.raises(SpecError):
        load_study(tmp_path / "p.sqlite").points[0].run()


def test_a_design_over_conditions_is_explained_where_it_is_worst() -> None:
    text = SMALL.replace("    fabric.clock: [50 MHz, 100 MHz, 200 MHz]\n", "") + (
        "  conditions: {workload.problem.map.seed: [3, 4]}\n"
    )
    study = codesign.explore("virtex4-pci", text)
    design = study.designs[1]
    explanation = design.explain()
    assert explanation.condition.startswith("workload.problem.map.seed ")
    worst = max(point.figure(FIGURES["plan_time_worst_s"]) or 0 for point in design.points)
    assert explanation.time is not None
    assert explanation.time.value == pytest.approx(worst)
    assert explanation.objectives["plan_time_worst_s"] == design.figure(FIGURES["plan_time_worst_s"])
    assert {each.index for each in explanation.neighbours} == {0, 3}
    alone = study.points[3].explain()
    assert alone.index == 1
    assert alone.condition == ""
    assert alone.time == why_time(study.points[3].run())
