"""The explanation of a run: why it is as it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from codesign.ground.figures import ResultFigure
from codesign.ground.memo import Memo
from codesign.ground.progress import Show, silent
from codesign.inputs import Platform, Workload
from codesign.inputs.derived import DerivedFigure
from codesign.study.constraints import figure_of, with_constraints
from codesign.study.moves import Bench, levers_for, steps_of
from codesign.system.explanation import Explanation, Sure, WhyOut, Words, why_energy, why_time
from codesign.system.results.result import Result
from codesign.system.results.terms import priced
from codesign.system.scenarios import scenario_of, simulate
from codesign.system.verdicts import Verdict, need_verdict, sensitivity


def explain_run(
    platform: Platform,
    workload: Workload,
    asked: Workload | None = None,
    axes: Mapping[str, Any] | None = None,
    show: Show = silent,
) -> Explanation:
    """Explain why a run is as it is: it is simulated, and so is each of its levers and steps.

    Args:
        platform, workload: the design point.
        asked: the workload with the section ``explore`` that names objectives and constraints; by default ``workload``.
        axes: what was set to make the point, for the reader.
        show: is told what is run.

    Raises:
        SpecError: platform, workload and map do not belong together.
    """
    section = (asked or workload).explore
    named = section is not None and "objectives" in section.model_fields_set
    objectives = section.objectives if section is not None and named else scenario_of(workload).objectives
    limits = () if section is None else section.constraints
    memo = Memo()
    # A mission tries its own levers; those of a plan are tried one by one below.
    drives = workload.scenario.type != "plan_once"
    result = with_constraints(simulate(platform, workload, memo=memo, levers=drives), limits)
    bench = Bench(platform, workload, result, objectives, lambda moved: with_constraints(moved, limits), memo, show)
    verdicts = {
        limit.figure: need_verdict(
            result,
            limit.figure,
            limit.at_most if limit.at_most is not None else limit.at_least or 0.0,
            at_least=limit.at_most is None,
        )
        for limit in limits
        if result.simulated
    }
    return Explanation(
        platform=result.platform,
        workload=result.workload,
        axes=dict(axes or {}),
        feasible=result.feasible,
        objectives={figure.name: figure_of(result, figure) for figure in objectives},
        derived=derived_words(objectives),
        result=result,
        time=why_time(result),
        energy=why_energy(result),
        out=tuple(WhyOut(reason=reason, levers=levers_for(bench, reason)) for reason in result.reasons),
        neighbours=steps_of(bench),
        sure=tuple(sure_of(result, figure, verdicts.get(figure)) for figure in objectives if is_priced(result, figure)),
        notes=(bench.cheap,) if bench.cheap and result.mission is None else (),
    )


def derived_words(figures: Sequence[ResultFigure]) -> dict[str, Words]:
    """The words for derived figures, by name."""
    return {each.name: Words(label=each.label, unit=each.unit) for each in figures if isinstance(each, DerivedFigure)}


def is_priced(result: Result, figure: ResultFigure) -> bool:
    """True if a figure of a result is made of prices, and there."""
    return priced(figure) and result.figure(figure) is not None


def sure_of(
    result: Result, figure: ResultFigure, verdict: Verdict | None, best: int | None = None, rival: int | None = None
) -> Sure:
    """The certainty of a figure of a result. ``best``, ``rival``: the points that a verdict of a study names."""
    value, interval = result.figure(figure), result.interval(figure)
    assert value is not None, "the caller looks"
    least, most = (None, None) if interval is None else interval
    moved = next(iter(sensitivity(result, figure)), None)
    return Sure(
        figure=figure.name, value=value, least=least, most=most, moved=moved, verdict=verdict, best=best, rival=rival
    )
