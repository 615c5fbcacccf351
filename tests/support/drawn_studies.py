"""Studies of any kind, drawn: priced points, missions, failures, conditions, rules, constraints."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from explore_fakes import mission, result
from hypothesis import strategies as st
from plain_study import Plain

from codesign.ground.figures import FIGURES
from codesign.inputs.aggregate import Quantile, Share
from codesign.inputs.constraint import constraint_of
from codesign.study.outcomes import Outcomes, State
from codesign.study.pricing.price import PRICED
from codesign.study.study import Study
from codesign.system.results.mission import LinkUse
from codesign.system.results.result import Reason, Result

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
TWICE = MISFIT.model_copy(update={"reasons": (*MISFIT.reasons, MISFIT.reasons[0].model_copy(update={"gap": 99}))})
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
    axes = {name: tuple(f"{place} MHz" for place in range(size)) for name, size in zip(names, sizes, strict=True)}
    conditions: dict[str, tuple[Any, ...]] = {}
    if draw(st.booleans()):
        conditions = {"a.b": tuple(range(draw(st.integers(1, 3)))), "c.seed": (0, 1)[: draw(st.integers(1, 2))]}
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
    outcomes = outcomes_of(points)
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


def outcomes_of(points: list[Plain]) -> Outcomes:
    """The points as two batches: those of even indices and the others."""
    outcomes = Outcomes.empty(len(points))
    for begin in (0, 1):
        batch = points[begin::2]
        columns = {name: np.array([point.prices.get(name, math.nan) for point in batch], np.float64) for name in PRICED}
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
