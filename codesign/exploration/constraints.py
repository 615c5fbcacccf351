"""Results held against constraints: a reason for each bound that a figure does not keep."""

from __future__ import annotations

from codesign.figures import ResultFigure
from codesign.inputs.constraint import LOWER, STRICT, Constraint
from codesign.results.result import Reason, Result


def figure_of(result: Result, figure: ResultFigure) -> float | None:
    """One figure as designs are compared by it. A design that needs no chip takes none of a chip's resources."""
    value = result.figure(figure)
    placed = not any(reason.kind == "mapping" for reason in result.reasons)
    if value is None and figure.is_resource and result.part is None and not result.resources and placed:
        return 0.0
    return value


def with_constraints(result: Result, constraints: tuple[Constraint, ...]) -> Result:
    """The result with a reason for every constraint that it does not satisfy.

    A figure that a feasible point does not have (no start arrives, so no path length) satisfies no
    constraint; one that a point lacks because it does not fit, and was never run, is not held against it.
    """
    unreached = result.mission is not None and not result.mission.reached
    reasons = [
        reason
        for limit in constraints
        for reason in unsatisfied(
            limit,
            figure_of(result, limit.figure),
            budget_of(result, limit),
            feasible=result.feasible,
            unreached=unreached,
        )
    ]
    if not reasons:
        return result
    return result.model_copy(update={"feasible": False, "reasons": (*result.reasons, *reasons)})


def budget_of(result: Result, constraint: Constraint) -> int | None:
    """How many the part has of a resource that a constraint bounds by a share; None where it bounds none so."""
    if not constraint.of_part:
        return None
    return next((use.budget for use in result.resources if use.resource == constraint.figure.name), None)


def unsatisfied(
    constraint: Constraint, value: float | None, budget: int | None, *, feasible: bool, unreached: bool
) -> list[Reason]:
    """A reason for each bound that the value of the constrained figure does not keep.

    ``budget``: what the part has of a resource that is bounded by a share. A design without a part has a share of 0.
    """
    figure, unit = constraint.figure, constraint.figure.unit
    reasons = []
    for bound, limit in constraint.bounds.items():
        sign, name = 1 if bound in LOWER else -1, f"{figure} {bound.replace('_', ' ')}"
        if value is None and not feasible:
            continue
        if constraint.of_part:
            name = f"{name} {100 * limit:.6g} %"
        most, demand = limit, 0.0 if value is None else value
        if value is None:
            name += f": {'goals not reached' if unreached else 'no such figure'}"
        else:
            # Of a share the quotient is compared: it is exact where the limit is, which the product is not.
            over = sign * (limit - (value / budget if budget else value))
            if over < 0 or (over == 0 and bound not in STRICT):
                continue
            most *= budget or 1
        gap = abs(most) if value is None else max(0.0, sign * (most - value))
        reasons.append(Reason(kind="constraint", name=name, demand=demand, limit=most, gap=gap, unit=unit))
    return reasons
