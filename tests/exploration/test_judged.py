"""What a study computes in arrays equals what follows point by point from the definitions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from explore_fakes import mission, result
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_study import Plain, PlainStudy

from codesign.exploration.outcomes import Outcomes, State
from codesign.exploration.study import Study
from codesign.figures import FIGURES
from codesign.inputs.aggregate import Quantile, Share
from codesign.inputs.constraint import constraint_of
from codesign.pricing.price import PRICED
from codesign.results.mission import LinkUse
from codesign.results.result import Reason, Result

TOO_FAST = [
    Reason(kind="clock", name="fpga", demand=120, limit=100, gap=20, unit="Hz", levers=("slow down",)),
    Reason(kind="clock", name="fpga", demand=150, limit=100, gap=50, unit="Hz"),
]


def run(*, link: int, **changes: Any) -> Result:
    """A result of a run that sends so many messages over its link."""
    figures = {name: changes.pop(name) for name in ("slices", "share", "path") if name in changes}
    use = LinkUse.model_construct(sent=link, delivered=link, bits=0, dropped={}, in_flight=0)
    fields = {
        "places": {"relax": "fpga" if link else "host"},
        "links": {"axi": use},
        "utilisation": {"axi": 0.1 * link, "fpga": 0.5 * link, "host": 0.5},
    }
    # As of a priced point: what prices move is not in the template.
    return result(**figures).model_copy(update={**fields, "time": None, **changes})


MISFIT = result(slices=130, fits=False)
TWICE = MISFIT.model_copy(
    update={"reasons": (*MISFIT.reasons, MISFIT.reasons[0].model_copy(update={"gap": 99}))}
)
TEMPLATES = [
    run(link=1),
    run(link=1, slices=60, share=0.5),
    run(link=0),
    run(link=0, resources=()),
    run(link=1, path=None),
    run(link=1, mission=mission()),
    run(link=1, mission=mission(reached=False)),
    run(link=1, feasible=False, reasons=(TOO_FAST[1].model_copy(update={"kind": "quality", "limit": 0}),)),
    MISFIT,
    TWICE,
    result(slices=101, fits=False),
]
LIMITS = [
    "first_plan < 2 s", "first_plan >= 1 s", "slices <= 60 %", "slices < 60", "share_reaching_goal > 50 %",
    "path_length_ratio <= 2", "mission_time < 50 s", "power <= 1 W",
]  # fmt: skip
OBJECTIVES = ["first_plan_s", "slices", "share_reaching_goal", "mission_time_s", "path_length_ratio_mean"]
RULES: list[Any] = [
    "worst", "best", "mean", "median", Quantile(quantile=0.6),
    Share(share=constraint_of("first_plan_s < 2 s")),
    Share(share=constraint_of("first_plan_s <= 2 s"), required=0.6),
]  # fmt: skip
PRICES = st.sampled_from([1.0, 2.0, 3.0, math.nan])


@st.composite
def studies(draw: st.DrawFn) -> tuple[Study, list[Plain]]:
    """A study, most of its points priced, and its points one by one."""
    sizes = draw(st.tuples(st.integers(1, 3), st.integers(1, 3), st.integers(1, 2)))
    names = "axi.clock", "relax.block", "workload.variant"
    axes = {
        name: tuple(f"{place} MHz" for place in range(size)) for name, size in zip(names, sizes, strict=True)
    }
    conditions: dict[str, tuple[Any, ...]] = {}
    if draw(st.booleans()):
        conditions = {
            "a.b": tuple(range(draw(st.integers(1, 3)))),
            "c.seed": (0, 1)[: draw(st.integers(1, 2))],
        }
    count = math.prod(sizes) * math.prod(map(len, conditions.values()))
    some = draw(st.lists(st.sampled_from(range(len(TEMPLATES))), min_size=1, max_size=4))
    points = [_point(draw, some) for _ in range(count)]
    limits = draw(st.lists(st.sampled_from(LIMITS), max_size=3, unique=True))
    objectives = draw(st.lists(st.sampled_from(OBJECTIVES), min_size=1, max_size=3, unique=True))
    aggregate = {}
    if conditions:
        default = st.sampled_from(RULES[:5])
        aggregate = draw(
            st.fixed_dictionaries({}, optional={"default": default, "first_plan_s": st.sampled_from(RULES)})
        )
    figures = tuple(FIGURES[name] for name in objectives)
    outcomes = _outcomes(points)
    return Study(
        "bench", "maze", axes, figures, tuple(map(constraint_of, limits)), outcomes, conditions, aggregate
    ), points


def _point(draw: st.DrawFn, some: list[int]) -> Plain:
    fate = draw(st.integers(0, 19))
    if fate < 2:
        return Plain(failure=f"failed {fate}") if fate else Plain()
    template = TEMPLATES[draw(st.sampled_from(some))]
    seconds, watts = draw(PRICES), draw(PRICES)
    prices = {name: seconds for name in PRICED if not math.isnan(seconds)} if template.utilisation else {}
    if not math.isnan(watts):
        prices["power"] = watts
    else:
        prices.pop("power", None)
    too_fast = draw(st.sampled_from([None, None, None, *TOO_FAST]))
    return Plain(template, prices, too_fast)


def _outcomes(points: list[Plain]) -> Outcomes:
    """The points as two batches: those of even indices and the others."""
    outcomes = Outcomes.empty(len(points))
    for begin in (0, 1):
        batch = points[begin::2]
        columns = {
            name: np.array([point.prices.get(name, math.nan) for point in batch], np.float64)
            for name in PRICED
        }
        states = [State[point.state.upper()] for point in batch]
        which = [-1 if point.template is None else TEMPLATES.index(point.template) for point in batch]
        reason = [-1 if point.too_fast is None else TOO_FAST.index(point.too_fast) for point in batch]
        outcomes.join(
            np.arange(begin, len(points), 2),
            Outcomes(
                np.array(states, np.int8),
                np.array(which, np.int32),
                columns,
                columns,
                columns,
                np.array(reason, np.int32),
                list(TEMPLATES),
                reasons=list(TOO_FAST),
                failures={place: point.failure for place, point in enumerate(batch) if point.failure},
            ),
        )
    return outcomes


@settings(max_examples=400, deadline=None)
@given(studies())
def test_arrays_equal_the_definitions(drawn: tuple[Study, list[Plain]]) -> None:
    study, points = drawn
    plain = PlainStudy(study, points)
    for point, its in zip(study.points, points, strict=True):
        assert (point.state, point.feasible, point.unreached) == (its.state, its.feasible, its.unreached)
        assert (point.failure, list(point.reasons)) == (its.failure, its.reasons)
        assert [point.figure(each) for each in FIGURES.values()] == [
            its.figure(each) for each in FIGURES.values()
        ]
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


@settings(max_examples=100, deadline=None)
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
        "bench",
        "maze",
        axes,
        (FIGURES["first_plan_s"],),
        (),
        _outcomes(points),
        conditions,
        {"first_plan_s": share},
    )
    assert [design.ended is not None for design in study.designs] == [True, False, True, True, False]
    plain = PlainStudy(study, points).designs
    assert [design.ended for design in study.designs] == [each.ended for each in plain]
