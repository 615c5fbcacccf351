"""Limits on stored results: strict bounds, shares of a part, and a study that is judged anew."""

from __future__ import annotations

import json

import pytest
from explore_fakes import result

from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES
from codesign.inputs.aggregate import Share
from codesign.inputs.constraint import constraint_of
from codesign.study.constraints import with_constraints
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.system.results.result import Reason, Result

TIME, SLICES = FIGURES["first_plan_s"], FIGURES["slices"]


def reasons(of: Result, *limits: str) -> list[Reason]:
    return list(with_constraints(of, tuple(map(constraint_of, limits))).reasons)


def test_a_strict_bound_leaves_the_limit_itself_out() -> None:
    at_limit = result(seconds=2.0)
    assert reasons(at_limit, "first_plan <= 2 s", "first_plan >= 2 s", "first_plan < 2001 ms") == []
    below, above = reasons(at_limit, "first_plan < 2 s", "first_plan > 2 s")
    assert (below.name, below.demand, below.limit, below.gap) == ("first_plan_s below", 2, 2, 0)
    assert above.name == "first_plan_s above"
    assert not with_constraints(at_limit, (constraint_of("first_plan < 2 s"),)).feasible


def test_a_share_of_a_resource_is_held_against_the_part() -> None:
    # The part of these results has 100 slices.
    used = result(slices=80)
    assert reasons(used, "slices <= 80 %", "slices < 81 %", "slices >= 80 %", "slices <= 80") == []
    strict, far = reasons(used, "slices < 80 %", "slices <= 50 %")
    assert (strict.name, strict.demand, strict.limit, strict.gap) == ("slices below 80 %", 80, 80, 0)
    assert (far.name, far.demand, far.limit, far.gap, far.unit) == ("slices at most 50 %", 80, 50, 30, "1")


def test_a_design_without_a_part_has_a_share_of_nothing() -> None:
    host = result().model_copy(update={"part": None, "resources": ()})
    assert reasons(host, "slices < 80 %", "slices <= 0 %") == []
    assert [reason.name for reason in reasons(host, "slices >= 10 %")] == ["slices at least 10 %"]


def study(**changes: object) -> Study:
    outcomes = Outcomes.of([result(seconds=seconds, slices=slices) for seconds, slices in [(1, 90), (2, 60), (3, 30)]])
    fields = {"axes": {"a.b": (0, 1, 2)}, "objectives": (TIME, SLICES), "constraints": (), "outcomes": outcomes}
    return Study("bench", "maze", **(fields | changes))  # type: ignore[arg-type]


def test_a_stored_study_is_judged_by_further_needs() -> None:
    before = study()
    after = before.needing(["first_plan < 3 s", "slices < 80 %"])
    assert (before.feasible, after.feasible, after.front) == ((0, 1, 2), (1,), (1,))
    assert [reason.name for reason in after.points[0].reasons] == ["slices below 80 %"]
    assert json.loads(after.to_json())["constraints"][1] == {
        "figure": "slices",
        "at_least": None,
        "at_most": None,
        "above": None,
        "below": 0.8,
        "of_part": True,
    }
    assert before.needing([]).feasible == before.feasible


def test_a_need_that_the_study_has_changes_nothing() -> None:
    once = study().needing(["first_plan < 3 s", "slices * first_plan < 150 s"])
    again = once.needing(["slices * first_plan < 150 s", "first_plan < 3 s", "first_plan < 3 s"])
    assert again.constraints == once.constraints
    assert once.needing(["slices < 70", "first_plan < 3 s"]).constraints[2:] == (constraint_of("slices < 70"),)
    with pytest.raises(SpecError, match="--need 'first_plan > 5 s': nothing"):
        once.needing(["first_plan < 3 s", "first_plan > 5 s"])


def test_over_conditions_a_need_bounds_what_they_come_to() -> None:
    mean = study(axes={}, conditions={"a.b": (0, 1, 2)}, aggregate={"default": "mean"})
    assert mean.needing(["first_plan <= 2 s", "slices <= 60 %"]).feasible == (0,)
    assert mean.needing(["slices < 60 %"]).feasible == ()
    met = Share(share=constraint_of("slices <= 60 %"))
    assert study(axes={}, conditions={"a.b": (0, 1, 2)}, aggregate={"slices": met}).designs[0].figure(
        SLICES
    ) == pytest.approx(2 / 3)


def test_a_need_that_cannot_be_kept_is_a_fault() -> None:
    with pytest.raises(SpecError, match="--need 'first_plan > 5 s': nothing is within this and"):
        study().needing(["first_plan < 3 s"]).needing(["first_plan > 5 s"])
    met = Share(share=constraint_of("slices <= 60 %"))
    with pytest.raises(SpecError, match="--need 'slices < 5': slices is aggregated by share"):
        study(axes={}, conditions={"a.b": (0, 1, 2)}, aggregate={"slices": met}).needing(["slices < 5"])
