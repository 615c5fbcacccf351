"""What a study computes in arrays equals what follows point by point from the definitions."""

from __future__ import annotations

import numpy as np
from drawn_studies import MISFIT, TEMPLATES, outcomes_of, studies
from examples import examples
from explore_fakes import result
from hypothesis import given, settings
from plain_study import Plain, PlainStudy

from codesign.ground.figures import FIGURES
from codesign.inputs.aggregate import Share
from codesign.inputs.constraint import constraint_of
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study


@settings(max_examples=examples(400), deadline=None)
@given(studies())
def test_arrays_equal_the_definitions(drawn: tuple[Study, list[Plain]]) -> None:
    study, points = drawn
    plain = PlainStudy(study, points)
    for point, its in zip(study.points, points, strict=True):
        assert (point.state, point.feasible, point.unreached) == (its.state, its.feasible, its.unreached)
        assert (point.failure, list(point.reasons)) == (its.failure, its.reasons)
        assert [point.figure(each) for each in FIGURES.values()] == [its.figure(each) for each in FIGURES.values()]
    for design, each in zip(study.designs, plain.designs, strict=True):
        assert (design.state, design.feasible, design.ended) == (each.state, each.feasible, each.ended)
        assert [(out.reason, out.condition) for out in design.out] == each.out
        figures = (*study.objectives, FIGURES["energy_j"], FIGURES["slices"])
        assert [design.figure(figure) for figure in figures] == [each.figure(figure) for figure in figures]
    assert dict(study.same) == plain.same
    assert list(study.distinct) == [each.index for each in plain.distinct]
    assert list(study.feasible) == [each.index for each in plain.distinct if each.feasible]
    assert list(study.unreached) == [each.index for each in plain.distinct if each.feasible and each.ended]
    for state, indices in (("failed", study.failed), ("missing", study.missing)):
        assert list(indices) == [each.index for each in plain.distinct if each.state == state]
    assert list(study.front) == plain.front
    assert list(study.nearest()) == plain.nearest()
    counts = [
        (each.kind, each.name, each.unit, each.designs, each.nearest, each.least_gap, each.levers)
        for each in study.reasons
    ]
    assert counts == plain.reasons


@settings(max_examples=examples(100), deadline=None)
@given(studies())
def test_one_condition_by_itself_has_its_own_points(drawn: tuple[Study, list[Plain]]) -> None:
    study, points = drawn
    for number, condition in enumerate(study.world.each if study.conditions else ()):
        alone = study.at(condition)
        plain = PlainStudy(alone, points[number :: len(study.world.each)])
        assert list(alone.front) == plain.front
        assert [each.axes for each in alone.designs] == [each.points[number].axes for each in study.designs]
        assert [each.feasible for each in alone.points] == [each.feasible for each in plain.points]


def test_outcomes_are_equal_however_their_templates_are_numbered() -> None:
    results = [result(), result(slices=20), None, "why"]
    one, other = Outcomes.of(results), Outcomes.empty(4)
    other.join(np.array([1, 3]), Outcomes.of([results[1], "why"]))
    other.put(0, result())
    assert one == other
    assert one.chosen(np.array([3, 1])) == Outcomes.of(["why", results[1]])
    other.put(0, result(slices=11))
    assert one != other


def test_by_share_a_mission_counts_as_unreached_where_no_condition_that_fits_reached_it() -> None:
    stuck, driven, misfit = Plain(TEMPLATES[6]), Plain(TEMPLATES[5]), Plain(MISFIT)
    rows = [[stuck, misfit], [stuck, driven], [misfit, stuck], [stuck, stuck], [misfit, misfit]]
    points = [point for row in rows for point in row]
    share = Share(share=constraint_of("first_plan_s < 2 s"))
    axes, conditions = {"relax.block": tuple(range(len(rows)))}, {"a.b": (0, 1)}
    study = Study(
        "bench", "maze", axes, (FIGURES["first_plan_s"],), (), outcomes_of(points), conditions, {"first_plan_s": share}
    )
    assert [design.ended is not None for design in study.designs] == [True, False, True, True, False]
    plain = PlainStudy(study, points).designs
    assert [design.ended for design in study.designs] == [each.ended for each in plain]
