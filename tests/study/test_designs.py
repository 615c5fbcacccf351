"""Designs over conditions: what is aggregated, what is out and where, the front, and one condition by itself."""

from __future__ import annotations

import itertools
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from explore_fakes import Fake, computed, exploring, mission, result
from hypothesis import given
from hypothesis import strategies as st

import codesign
from codesign.cli.specs import settings_of
from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES
from codesign.inputs import Constraint, Exploration, Platform, Workload
from codesign.inputs.aggregate import Quantile, Rule, Share
from codesign.study import Study, explore, load_study
from codesign.study.conditions import Conditions
from codesign.study.outcomes import Outcomes
from codesign.system.results.mission import LinkUse
from codesign.system.results.result import Result

TIME, SLICES, SHARE = FIGURES["first_plan_s"], FIGURES["slices"], FIGURES["share_reaching_goal"]
SIZE, SEED = "workload.problem.map.rows", "workload.problem.map.seed"
Rows = Sequence[Sequence[Result | str | None]]
WITHIN_2_S = Share(share=Constraint(figure=TIME, at_most=2.0))


def study(rows: Rows, condition: str = SIZE, **changes: Any) -> Study:
    """A study with a design for each row and a condition for each column; a text is a failure."""
    axes, count = {"relax.iterations": tuple(range(len(rows)))}, len(rows[0])
    fields: dict[str, Any] = {
        "objectives": (TIME, SLICES), "constraints": (), "conditions": {condition: tuple(range(count))},
        "aggregate": {},
    }  # fmt: skip
    fields |= changes
    if not fields["conditions"]:
        axes[condition] = tuple(range(count))
    return Study("bench", "maze", axes, outcomes=Outcomes.of([*itertools.chain(*rows)]), **fields)


def timed(*seconds: float, slices: int = 10, share: float = 1.0) -> list[Result | str]:
    return [result(seconds=each, slices=slices, share=share) for each in seconds]


ROWS = [timed(1, 2, 9), timed(4, 4, 4), timed(3, 3, 8), timed(5, 5, 5)]


@pytest.mark.parametrize(
    ("rule", "figures", "front"),
    [
        ("worst", [9, 4, 8, 5], (1,)),
        ("best", [1, 4, 3, 5], (0,)),
        ("mean", [4, 4, 14 / 3, 5], (0, 1)),
        ("median", [2, 4, 3, 5], (0,)),
        (Quantile(quantile=0.6), [2, 4, 3, 5], (0,)),
        (Quantile(quantile=0.7), [9, 4, 8, 5], (1,)),
        (WITHIN_2_S, [2 / 3, 0, 0, 0], (0,)),
    ],
)
def test_figures_and_front_by_rule(rule: Rule, figures: list[float], front: tuple[int, ...]) -> None:
    made = study(ROWS, aggregate={"first_plan_s": rule})
    assert [design.figure(TIME) for design in made.designs] == pytest.approx(figures)
    assert made.front == front


def test_the_default_rule_holds_for_all_figures_but_those_with_their_own() -> None:
    rows = [[result(seconds=1, share=0.2), result(seconds=3, share=0.6)]]
    made = study(rows, aggregate={"default": "mean", "share_reaching_goal": "worst"})
    assert (made.designs[0].figure(TIME), made.designs[0].figure(SHARE)) == (2.0, 0.2)
    assert study(rows).designs[0].figure(SHARE) == 0.2, "the worst of a share is the least"


TABLES = st.integers(1, 3).flatmap(
    lambda columns: st.lists(
        st.lists(st.tuples(st.integers(1, 4), st.integers(1, 4)), min_size=columns, max_size=columns),
        min_size=1,
        max_size=7,
    )
)


def results(table: list[list[tuple[int, int]]]) -> list[list[Result | str]]:
    return [[result(seconds=seconds, slices=slices) for seconds, slices in row] for row in table]


@given(TABLES)
def test_with_one_condition_the_front_is_that_of_the_points(table: list[list[tuple[int, int]]]) -> None:
    rows = [row[:1] for row in results(table)]
    made = study(rows)
    plain = study(rows, conditions={})
    assert made.front == plain.front == made.at({SIZE: 0}).front
    assert [design.figure(TIME) for design in made.designs] == [point.figure(TIME) for point in plain.points]


@given(TABLES, st.sampled_from(["worst", "best", "mean", "median"]))
def test_what_is_dominated_in_every_condition_is_not_on_the_front(
    table: list[list[tuple[int, int]]], rule: Rule
) -> None:
    """Whatever the rule, as each is monotone; and to take such a design away leaves the front as it is."""
    better = [[(seconds + 1, slices + 1) for seconds, slices in row] for row in table]
    made = study(results(table + better), aggregate={"default": rule})
    assert set(made.front) <= set(range(len(table)))
    assert made.front == study(results(table), aggregate={"default": rule}).front


@given(TABLES)
def test_one_condition_by_itself_is_the_study_of_it(table: list[list[tuple[int, int]]]) -> None:
    made, rows = study(results(table)), results(table)
    for number in range(len(rows[0])):
        alone = study([[row[number]] for row in rows], conditions={})
        assert made.at({SIZE: number}).front == alone.front


OUT = result(slices=120, fits=False)


def test_a_design_that_is_infeasible_in_a_condition_is_out_and_the_condition_is_named() -> None:
    made = study([[result(), OUT, result()], timed(9, 9, 9)])
    assert (made.feasible, made.front) == ((1,), (1,))
    ((reason, condition),) = [(out.reason, out.condition) for out in made.designs[0].out]
    assert (reason.name, condition) == ("slices", 1)
    (count,) = made.reasons
    assert (count.name, count.designs, count.nearest) == ("slices", 1, 0)
    assert made.nearest() == (0,)


def test_by_share_an_infeasible_condition_is_one_that_does_not_meet_the_limit() -> None:
    rules = {"first_plan_s": WITHIN_2_S}
    made = study([[result(), OUT, result()], timed(9, 9, 1), [OUT, OUT, OUT]], aggregate=rules)
    assert [design.figure(TIME) for design in made.designs] == pytest.approx([2 / 3, 1 / 3, 0])
    # Slices are known without a run, so they do not need one; a share is of no use where nothing fits.
    assert made.feasible == (0, 1)
    assert made.designs[0].figure(SLICES) == 120
    # The worst of another figure of a run has no value where there was no run.
    assert study([[result(), OUT], timed(1, 1)], aggregate=rules, objectives=(TIME, SHARE)).feasible == (1,)


def test_a_share_that_is_required() -> None:
    rule = WITHIN_2_S.model_copy(update={"required": 0.5})
    made = study([timed(1, 1, 9), timed(9, 9, 1)], aggregate={"first_plan_s": rule})
    assert made.feasible == (0,)
    ((reason, condition),) = [(out.reason, out.condition) for out in made.designs[1].out]
    assert (reason.kind, reason.demand, reason.limit, condition) == ("constraint", 1 / 3, 0.5, None)


def test_a_constraint_bounds_what_all_conditions_come_to() -> None:
    limit = (Constraint(figure=TIME, at_most=4.5),)
    assert study(ROWS, constraints=limit).feasible == (1,)
    assert study(ROWS, constraints=limit, aggregate={"default": "mean"}).feasible == (0, 1)
    # In one condition by itself it bounds the figure there.
    assert study(ROWS, constraints=limit, aggregate={"default": "mean"}).at({SIZE: 2}).feasible == (1,)


def test_a_failure_in_a_condition_is_a_failure_of_the_design_and_missing_points_of_it_are_missing() -> None:
    made = study([[result(), "no block fits", result()], timed(1, 1, 1)], aggregate={"default": WITHIN_2_S})
    assert (made.failed, made.designs[0].failure, made.feasible) == ((0,), "no block fits", (1,))
    part = study([timed(1, 1), [result(seconds=1), None]])
    assert (part.missing, part.feasible) == ((1,), (0,))


def test_a_mission_that_ended_before_its_goals_in_a_condition_keeps_its_design_off_the_front() -> None:
    driven = result().model_copy(update={"mission": mission()})
    stuck = result().model_copy(update={"mission": mission(reached=False)})
    made = study([[driven, stuck], [driven, driven]])
    assert (made.feasible, made.unreached, made.front) == ((0, 1), (0,), (1,))
    assert made.designs[0].ended == ("no way for 30 s", 1)


def test_seeds_give_an_interval_and_sizes_do_not() -> None:
    rows = [timed(1, 2, 3, 4, 5)]
    told = study(rows, SEED, aggregate={"default": "mean"}).designs[0].spread(TIME)
    assert told is not None
    # Student's t of four degrees of freedom, 2.776, times the standard error.
    half = 2.7764451 * (2.5 / 5) ** 0.5
    assert told.interval == (pytest.approx(3 - half), pytest.approx(3 + half))
    assert (told.least, told.greatest, told.deviation) == (1, 5, pytest.approx(2.5**0.5))
    sized = study(rows, SIZE, aggregate={"default": "mean"}).designs[0].spread(TIME)
    assert sized is not None
    assert sized.interval is None


def test_what_the_conditions_do_not_tell_apart() -> None:
    rows = [timed(1, 2, 9), timed(2, 1, 9.5), timed(10, 20, 90)]
    made = study(rows, objectives=(TIME,))
    assert (made.front, dict(made.alike)) == ((0,), {0: (1,)})
    cheaper = study([timed(1, 2, 9), timed(2, 1, 9.5, slices=9), timed(10, 20, 90)])
    assert dict(cheaper.alike) == {}, "slices tell them apart"
    assert cheaper.alike_in(0, (TIME,)) == (1,)
    assert dict(study(rows, conditions={}, objectives=(TIME,)).alike) == {}


def run(clock: str, seconds: float, *, over_link: int) -> Result:
    link = LinkUse(
        sent=over_link, delivered=over_link, in_flight=0, retransmissions=0, undetected=0, late=0, bits=0,
        utilisation=0.1 * over_link, queued_s=0,
    )  # fmt: skip
    fields = {
        "places": {"relax": "fpga" if over_link else "host"}, "links": {"axi": link},
        "utilisation": {"axi": 0.1 * over_link, "fpga": 0.5 * over_link, "host": 0.5},
    }  # fmt: skip
    return result(seconds=seconds).model_copy(update=fields)


FABRIC = [("fabric", "1 MHz", 2.0, 1), ("fabric", "2 MHz", 2.0, 1)]


def linked(cells: list[tuple[str, str, float, int]], **changes: Any) -> Study:
    axes = {"workload.variant": ("host", "fabric"), "axi.clock": ("1 MHz", "2 MHz")}
    results = [run(clock, seconds, over_link=used) for _, clock, seconds, used in cells]
    return Study("bench", "maze", axes, (TIME, SLICES), (), Outcomes.of(results), **changes)


def test_designs_that_differ_in_what_neither_uses_count_once() -> None:
    made = linked(
        [("host", "1 MHz", 1, 0), ("host", "2 MHz", 1, 0), ("fabric", "1 MHz", 2, 1), ("fabric", "2 MHz", 2, 1)]
    )
    # The fabric's two are equal in every figure, but they use the link in which they differ.
    assert dict(made.same) == {0: (1,)}
    assert (made.distinct, made.feasible, made.front) == ((0, 2, 3), (0, 2, 3), (0,))
    document = made.to_dict()
    assert [design["same_as"] for design in document["designs"]] == [None, 0, None, None]
    assert [point["on_front"] for point in document["points"]] == [True, True, False, False]
    assert (document["counts"]["designs"], document["counts"]["distinct"]) == (4, 3)


def test_designs_that_do_not_use_an_axis_but_differ_are_not_the_same() -> None:
    made = linked(
        [("host", "1 MHz", 1, 0), ("host", "2 MHz", 1.5, 0), ("fabric", "1 MHz", 2, 1), ("fabric", "2 MHz", 2, 1)]
    )
    assert dict(made.same) == {}


# ---- explored ----

AXES = {"bench.seconds": [1.0, 0.5], "bench.slices": [20, 120]}
CONDITIONS = {"bench.share": [1.0, 0.9, 0.8], "bench.seed": [1, 2]}


@pytest.fixture(scope="module")
def platform() -> Platform:
    return codesign.load_platform("virtex4-pci")


@pytest.fixture(scope="module")
def workload() -> Workload:
    plain = exploring(codesign.load_workload("labyrinth"), AXES)
    assert plain.explore is not None
    fields = plain.explore.model_dump() | {"conditions": CONDITIONS, "aggregate": {"share_reaching_goal": "mean"}}
    fields["objectives"] = ["first_plan_s", "share_reaching_goal"]
    return plain.model_copy(update={"explore": Exploration.model_validate(fields)})


def test_conditions_move_fastest(platform: Platform, workload: Workload) -> None:
    made = explore(platform, workload, workers=1, evaluate=Fake())
    assert (len(made.points), len(made.designs), len(made.world.each)) == (24, 4, 6)
    assert [point.axes["bench.seed"] for point in made.points[:6]] == [1, 2] * 3
    assert {point.axes["bench.slices"] for point in made.points[6:12]} == {120}
    assert [design.axes for design in made.designs] == [
        {"bench.seconds": seconds, "bench.slices": slices} for seconds in (1.0, 0.5) for slices in (20, 120)
    ]
    assert (made.feasible, made.front) == ((0, 2), (2,))
    assert made.designs[2].figure(SHARE) == pytest.approx(0.9)


def test_the_same_bytes_at_any_worker_count_from_a_store_and_after_an_interrupt(
    platform: Platform, workload: Workload, tmp_path: Path
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    one = explore(platform, workload, workers=1, evaluate=Fake()).to_json()
    with pytest.raises(KeyboardInterrupt):
        explore(platform, workload, workers=1, store=file, evaluate=Fake(log, {13: "interrupt"}))
    part = load_study(file)
    assert part.missing
    assert {design.state for design in part.designs} == {"done", "missing"}
    assert explore(platform, workload, workers=2, store=file, evaluate=Fake(log)).to_json() == one
    assert load_study(file).to_json() == one
    assert sorted(computed(log)) == sorted([*range(24), 13])


def test_points_that_were_kept_before_a_decision_became_a_condition_are_found(
    platform: Platform, workload: Workload, tmp_path: Path
) -> None:
    log, file = tmp_path / "log", tmp_path / "points.sqlite"
    explore(platform, exploring(workload, AXES | CONDITIONS), workers=1, store=file, evaluate=Fake(log))
    explore(platform, workload, workers=1, store=file, evaluate=Fake(log))
    assert len(computed(log)) == 24


def test_json_has_designs_with_their_spread(platform: Platform, workload: Workload) -> None:
    document = json.loads(explore(platform, workload, workers=1, evaluate=Fake()).to_json())
    assert (document["conditions"], document["aggregate"]) == (CONDITIONS, {"share_reaching_goal": "mean"})
    first = document["designs"][0]
    spread = first["spread"]["share_reaching_goal"]
    assert (spread["least"], spread["greatest"]) == (0.8, 1.0)
    # Both seeds have the same values, so the mean over the seeds does not vary.
    assert spread["interval"] == pytest.approx([0.9, 0.9])
    assert first["spread"]["first_plan_s"]["interval"] is None
    assert document["designs"][1]["out"][0]["condition"] == 0
    assert [point["design"] for point in document["points"][5:7]] == [0, 1]


def test_some_conditions_by_themselves_by_value(platform: Platform, workload: Workload) -> None:
    made = explore(platform, workload, workers=1, evaluate=Fake())
    half = made.at({"bench.share": 0.9})
    assert (len(half.points), list(half.conditions), half.axes["bench.share"]) == (8, ["bench.seed"], (0.9,))
    assert made.at({"bench.seed": 1}).points[0].axes["bench.seed"] == 1
    assert made.at({}) is made
    with pytest.raises(InputError, match=r"no condition bench\.sed") as caught:
        made.at({"bench.sed": 1})
    assert "did you mean bench.seed?" in str(caught.value)
    for seed, near in ((0, 1), (7, 2), (1.6, 2)):
        with pytest.raises(InputError, match=f"bench.seed has no value {seed}") as caught:
            half.at({"bench.seed": seed})
        assert f"did you mean {near}? accepted: 1, 2" in str(caught.value)


SPELT: list[tuple[Sequence[Any], str, Any]] = [
    ([1.0, 0.9, 0.8], "0.8", 0.8),
    ([1.0, 0.9, 0.8], ".80", 0.8),
    ([1.0, 0.9, 0.8], "8e-1", 0.8),
    ([1.0, 0.9, 0.8], "80 %", 0.8),
    ([1.0, 0.9, 0.8], "1", 1.0),
    ([1, 2, 3], "2.0", 2),
    ([1, 2, 3], "0", None),
    ([0.5, 1], "true", None),
    ([False, True], "true", True),
    (["80 %", "90 %"], "0.9", "90 %"),
    (["50 MHz", "0.1 GHz"], "0.05 GHz", "50 MHz"),
    (["50 MHz", "0.1 GHz"], "100 MHz", "0.1 GHz"),
    (["50 MHz", "0.1 GHz"], "1", "0.1 GHz"),
    (["50 MHz", "0.1 GHz"], "2", None),
    ([[6, 9], [0.5, 1]], "[0.50, 1.0]", [0.5, 1]),
    ([[6, 9], [0.5, 1]], "0", [6, 9]),
    (["base", "deep"], "1", "deep"),
    (["base", "deep"], "dep", None),
]


@pytest.mark.parametrize(("values", "text", "expected"), SPELT)
def test_a_condition_is_named_in_any_spelling_and_by_number_only_where_that_is_no_value(
    values: Sequence[Any], text: str, expected: Any
) -> None:
    world = Conditions({"a.b": tuple(values)}, {})
    wanted = settings_of([f"a.b={text}"], "--condition")["a.b"]
    if expected is None:
        with pytest.raises(InputError, match="accepted: "):
            world.listed("a.b", wanted)
    else:
        found = world.listed("a.b", wanted)
        assert (found, type(found)) == (expected, type(expected))


@given(st.lists(st.one_of(st.integers(-9, 99), st.decimals(-1, 1, places=3).map(float)), min_size=1, unique=True))
def test_every_number_of_a_condition_is_found_as_it_is_written(values: list[float]) -> None:
    world = Conditions({"a.b": tuple(values)}, {})
    for value in values:
        for text in (repr(value), f"{value:e}", f"{value:.6f}"):
            assert world.listed("a.b", settings_of([f"a.b={text}"])["a.b"]) == value
    for missing in set(range(-10, 101)) - set(values):
        with pytest.raises(InputError, match="did you mean"):
            world.listed("a.b", missing)


def test_a_constraint_is_held_against_points_in_one_condition_only(platform: Platform, workload: Workload) -> None:
    limits = (Constraint(figure=SHARE, at_least=0.85),)
    assert workload.explore is not None
    section = workload.explore.model_copy(update={"constraints": limits})
    made = explore(platform, workload.model_copy(update={"explore": section}), workers=1, evaluate=Fake())
    assert made.feasible == (0, 2), "the mean keeps it"
    assert made.at({"bench.share": 0.8, "bench.seed": 1}).feasible == ()
    worst = made.at({"bench.share": 0.8, "bench.seed": 1}).points[0].result
    assert worst is not None
    assert [reason.kind for reason in worst.reasons] == ["constraint"]
