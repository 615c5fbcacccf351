from __future__ import annotations

import json
from dataclasses import replace

import pytest
from explore_fakes import result

from codesign.ground.figures import FIGURES
from codesign.inputs import Constraint
from codesign.study.constraints import with_constraints
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.system.results.result import Reason, Result

OBJECTIVES = (FIGURES["first_plan_s"], FIGURES["slices"], FIGURES["share_reaching_goal"])
SHARE_AND_TIME = (
    Constraint(figure=FIGURES["share_reaching_goal"], at_least=0.9),
    Constraint(figure=FIGURES["first_plan_s"], at_most=2.0),
)


def study(*outcomes: Result | str | None, constraints: tuple[Constraint, ...] = ()) -> Study:
    axes = {"relax.iterations": tuple(range(len(outcomes)))}
    return Study("bench", "maze", axes, OBJECTIVES, constraints, Outcomes.of(outcomes))


def test_front_is_of_the_feasible_points_in_each_objectives_direction() -> None:
    made = study(
        result(seconds=1, slices=50, share=0.5),
        result(seconds=1, slices=50, share=0.9),
        result(seconds=9, slices=10, share=0.1),
        result(slices=110, fits=False),
        "failed",
        None,
        result(seconds=1, slices=50, share=0.9),
    )
    assert made.feasible == (0, 1, 2, 6)
    assert made.front == (1, 2, 6)
    assert (made.failed, made.missing) == ((4,), (5,))
    assert [point.state for point in made.points] == ["done"] * 4 + ["failed", "missing", "done"]


def test_a_feasible_point_without_an_objective_is_not_on_the_front() -> None:
    outcomes = Outcomes.of([result(path=None), result(path=1.3)])
    made = Study("bench", "maze", {"a.b": (0, 1)}, (FIGURES["path_length_ratio_mean"],), (), outcomes)
    assert (made.feasible, made.front) == ((0, 1), (1,))


def test_a_constraint_that_holds_changes_nothing() -> None:
    kept = result(seconds=2.0, share=0.9)
    assert with_constraints(kept, SHARE_AND_TIME) is kept


def test_a_constraint_that_does_not_hold_is_a_reason() -> None:
    out = with_constraints(result(seconds=3.5, share=0.8), SHARE_AND_TIME)
    assert not out.feasible
    assert out.time is not None
    share, time = out.reasons
    assert (share.kind, share.name, share.demand, share.limit, share.unit) == (
        "constraint",
        "share_reaching_goal at least",
        0.8,
        0.9,
        "1",
    )
    assert share.gap == pytest.approx(0.1)
    assert (time.name, time.gap, time.unit) == ("first_plan_s at most", 1.5, "s")


def test_a_point_that_was_not_run_is_held_to_what_it_has() -> None:
    limits = (*SHARE_AND_TIME, Constraint(figure=FIGURES["slices"], at_most=50))
    out = with_constraints(result(slices=110, fits=False), limits)
    assert [reason.kind for reason in out.reasons] == ["resource", "constraint"]
    assert out.reasons[1].name == "slices at most"


def test_a_figure_that_does_not_exist_satisfies_no_constraint() -> None:
    out = with_constraints(result(path=None), (Constraint(figure=FIGURES["path_length_ratio_mean"], at_most=1.2),))
    assert [reason.name for reason in out.reasons] == ["path_length_ratio_mean at most: no such figure"]


def test_where_nothing_is_feasible_reasons_and_nearest_points_say_why() -> None:
    made = study(
        result(share=0.2),
        result(slices=130, fits=False),
        result(share=0.85),
        result(slices=101, fits=False),
        result(share=0.85, seconds=80),
        "relax.block: too large\n  hint: make it smaller",
        constraints=SHARE_AND_TIME,
    )
    assert (made.feasible, made.front) == ((), ())
    assert made.nearest(3) == (3, 2, 1)
    counts = [(count.kind, count.name, count.designs) for count in made.reasons]
    assert counts == [
        ("constraint", "share_reaching_goal at least", 3),
        ("resource", "slices", 2),
        ("constraint", "first_plan_s at most", 1),
        ("failure", "relax.block: too large", 1),
    ]
    assert (made.reasons[1].least_gap, made.reasons[1].nearest, made.reasons[1].levers) == (1, 3, ("shrink",))
    assert [count.nearest for count in made.reasons] == [2, 3, 4, 5]


def test_a_limit_of_zero_is_far_away_rather_than_a_division_by_it() -> None:
    none_left = Reason(kind="resource", name="multipliers", demand=3, limit=0, gap=3, unit="")
    out = result(fits=False, slices=101).model_copy(update={"reasons": (none_left,)})
    assert study(out, result(slices=900, fits=False)).nearest() == (1, 0)


def test_counts_are_integers_in_json_wherever_they_stand() -> None:
    """A constraint is read as a double and a figure handed over as one; both count slices."""
    limits = (Constraint(figure=FIGURES["slices"], at_most=50.0), *SHARE_AND_TIME)
    made = study(result(slices=60, share=0.8), constraints=limits)
    (point,) = made.to_dict()["points"]
    slices, share = point["result"]["reasons"]
    assert [slices[name] for name in ("demand", "limit", "gap")] == [60, 50, 10]
    assert all(type(slices[name]) is int for name in ("demand", "limit", "gap"))
    assert (share["demand"], share["limit"]) == (0.8, 0.9)
    types = {name: type(value) for name, value in point["figures"].items() if value is not None}
    assert {name for name, kind in types.items() if kind is int} == {
        "slices", "local_maxima", "wrong_cells", "precision",
    }  # fmt: skip
    assert types["first_plan_s"] is types["share_reaching_goal"] is float


def test_json_has_every_point_with_all_figures() -> None:
    made = study(result(seconds=0.5), result(slices=110, fits=False), "no way", constraints=SHARE_AND_TIME)
    made = replace(made, axes={"relax.block": ([36, 66], [12, 22], [6, 11])})
    text = json.loads(made.to_json())
    assert text["schema_version"] == 3
    assert (text["platform"], text["workload"], text["front"]) == ("bench", "maze", [0])
    assert text["counts"] == {
        "points": 3,
        "designs": 3,
        "distinct": 3,
        "feasible": 1,
        "unreached": 0,
        "failed": 1,
        "missing": 0,
        "front": 1,
    }
    assert text["objectives"][2] == {"figure": "share_reaching_goal", "unit": "1", "direction": "maximise"}
    none = {"at_least": None, "above": None, "below": None, "of_part": False}
    assert text["constraints"][1] == {"figure": "first_plan_s", **none, "at_most": 2.0}
    assert set(text["units"]) == set(text["points"][0]["figures"])
    assert (text["units"]["first_plan_s"], text["units"]["slices"]) == ("s", "1")
    first, second, third = text["points"]
    assert set(first["figures"]) == {figure.name for figure in FIGURES.values()}
    assert (first["figures"]["first_plan_s"], first["on_front"], first["axes"]) == (
        0.5,
        True,
        {"relax.block": [36, 66]},
    )
    assert (second["figures"]["first_plan_s"], second["figures"]["slices"]) == (None, 110)
    assert second["result"]["reasons"][0]["levers"] == ["shrink"]
    assert (third["state"], third["failure"], third["result"]) == ("failed", "no way", None)


def test_sharing_keeps_words_of_enumerations_what_they_are(recwarn: pytest.WarningsRecorder) -> None:
    from report_samples import a_result

    from codesign.ground.figures import Status
    from codesign.study.shared import Shared

    shared = Shared()
    plain = a_result().model_copy(update={"workload": "published"})
    for each in (plain, a_result()):
        made = shared.result(each)
        assert all(type(item.figure.status) is Status for use in made.resources for item in use.items)
        made.model_dump_json()
    assert not recwarn.list
