"""Why a design of a study, or a run, is as it is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from codesign.errors import CodesignError, InputError
from codesign.explanation import Explanation, Moved, Sure, WhyOut, Words, why_energy, why_time
from codesign.exploration.constraints import figure_of, with_constraints
from codesign.exploration.designs import Design, Out, StudyPoint, checked_index
from codesign.exploration.moves import Bench, gains_of, levers_for, ranked, steps_of
from codesign.figures import ResultFigure, label
from codesign.inputs import Platform, Workload
from codesign.inputs.boxes import value_text
from codesign.inputs.derived import DerivedFigure
from codesign.memo import Memo
from codesign.progress import Show, silent
from codesign.results.result import Result
from codesign.results.terms import priced
from codesign.scenarios import scenario_of, simulate
from codesign.verdicts import Verdict, need_verdict, sensitivity

if TYPE_CHECKING:
    from codesign.exploration.study import Study

OTHER_QUESTION = "it was asked another question"


def explain_run(
    platform: Platform,
    workload: Workload,
    asked: Workload | None = None,
    axes: Mapping[str, Any] | None = None,
    show: Show = silent,
) -> Explanation:
    """Why a run is as it is: it is simulated, and so is each of its levers and steps.

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
    bench = Bench(
        platform, workload, result, objectives, lambda moved: with_constraints(moved, limits), memo, show
    )
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
        derived=_derived(objectives),
        result=result,
        time=why_time(result),
        energy=why_energy(result),
        out=tuple(WhyOut(reason=reason, levers=levers_for(bench, reason)) for reason in result.reasons),
        neighbours=steps_of(bench),
        sure=tuple(
            _sure(result, figure, verdicts.get(figure)) for figure in objectives if _known(result, figure)
        ),
        notes=(bench.cheap,) if bench.cheap and result.mission is None else (),
    )


def _derived(figures: Sequence[ResultFigure]) -> dict[str, Words]:
    return {
        each.name: Words(label=each.label, unit=each.unit)
        for each in figures
        if isinstance(each, DerivedFigure)
    }


def _known(result: Result, figure: ResultFigure) -> bool:
    return priced(figure) and result.figure(figure) is not None


def _sure(
    result: Result,
    figure: ResultFigure,
    verdict: Verdict | None,
    best: int | None = None,
    rival: int | None = None,
) -> Sure:
    value, interval = result.figure(figure), result.interval(figure)
    assert value is not None, "the caller looks"
    least, most = (None, None) if interval is None else interval
    moved = next(iter(sensitivity(result, figure)), None)
    return Sure(
        figure=figure.name,
        value=value,
        least=least,
        most=most,
        moved=moved,
        verdict=verdict,
        best=best,
        rival=rival,
    )


def explain_design(study: Study, index: int, show: Show = silent) -> Explanation:
    """Why a design is as it is; see ``Study.explain``."""
    design = _design_of(study, index)
    point = _telling(study, design)
    result = point.result
    assert result is not None, "a design that was computed"
    bench, notes = _bench(study, point, result, show)
    return Explanation(
        platform=result.platform,
        workload=result.workload,
        index=index,
        axes=dict(design.axes),
        condition=_condition_text(study, design, point),
        feasible=design.feasible,
        on_front=bool(study.on_front[index]),
        objectives={figure.name: design.figure(figure) for figure in study.objectives},
        derived=_derived(study.objectives),
        result=result,
        time=why_time(result),
        energy=why_energy(result),
        out=tuple(_why_out(study, design, out, bench) for out in _outs(study, design)),
        neighbours=neighbours_of(study, design),
        sure=() if study.conditions else _sure_in(study, result),
        effects=study.sensitivity(),
        notes=notes,
    )


def _design_of(study: Study, index: int) -> Design:
    kind = "design" if study.conditions else "point"
    design = study.designs[checked_index(kind, index, len(study.designs))]
    if design.state == "missing":
        hint = "run the same hwsw explore again: it continues where it stopped"
        raise InputError(f"{kind} {index} was not computed", hint=hint)
    if design.state == "failed":
        failed = next(point for point in design.points if point.failure is not None)
        hint = f"hwsw run --point {failed.index} STUDY computes it again"
        raise InputError(f"{kind} {index} failed: {design.failure}", hint=hint)
    return design


def _telling(study: Study, design: Design) -> StudyPoint:
    """The point of a design that is explained: the first that is out, or else the worst by the first objective."""
    blocked = next((point for point in design.points if not point.feasible), None)
    if blocked is not None or not study.objectives:
        return blocked or design.points[0]
    figure = study.objectives[0]
    sign = -1.0 if figure.maximise else 1.0

    def loss(point: StudyPoint) -> float:
        value = point.figure(figure)
        return -math.inf if value is None else sign * value

    return max(design.points, key=loss)


def _condition_text(study: Study, design: Design, point: StudyPoint) -> str:
    place = point.index - design.points[0].index
    return ", ".join(f"{name} {value}" for name, value in study.world.each[place].items())


def _bench(
    study: Study, point: StudyPoint, result: Result, show: Show
) -> tuple[Bench | None, tuple[str, ...]]:
    """What runs the point with something moved; None, and why, where its specs are not at hand."""
    limits = () if study.conditions else study.constraints
    if result.feasible and not result.reasons:
        return None, ()
    try:
        judged = partial(with_constraints, constraints=limits)
        bench = Bench(*point.specs(), result, study.objectives, judged, show=show)
    except CodesignError as wrong:
        return None, (f"levers are not tried: {str(wrong).partition(chr(10))[0]}",)
    return bench, ((f"levers are not tried: {bench.cheap}",) if bench.cheap else ())


def _outs(study: Study, design: Design) -> list[Out]:
    if study.conditions:
        return list(design.out)
    return [Out(reason) for reason in design.points[0].reasons]


def _why_out(study: Study, design: Design, out: Out, bench: Bench | None) -> WhyOut:
    text = ""
    if out.condition is not None:
        text = _condition_text(study, design, design.points[out.condition])
    levers: tuple[Moved, ...]
    if bench is None or (study.conditions and out.reason not in bench.own.reasons):
        levers = tuple(Moved(what=lever, note="not tried") for lever in out.reason.levers)
    else:
        levers = levers_for(bench, out.reason)
    return WhyOut(reason=out.reason, condition=text, levers=levers)


def neighbours_of(study: Study, design: Design) -> tuple[Moved, ...]:
    """The designs that differ from one in a single axis, those that are better first.

    A design that was asked another question is not compared. One that failed or was not computed is left out.
    """
    own = {figure: design.figure(figure) for figure in study.objectives}
    neighbours = []
    for name, mine in design.axes.items():
        for value in study.axes[name]:
            try:
                other = study.designs[study.decisions.index({**design.axes, name: value})]
            except KeyError:
                # Other axes exist with that value.
                continue
            if value_text(value) != value_text(mine) and other.state == "done":
                neighbours.append(_neighbour(study, design, own, other, name, value))
    return ranked(neighbours)


def _neighbour(
    study: Study,
    design: Design,
    own: Mapping[ResultFigure, float | None],
    other: Design,
    axis: str,
    value: Any,
) -> Moved:
    figures = {figure: other.figure(figure) for figure in study.objectives}
    questions = {_question(design), _question(other)} - {None}
    asked_the_same = len(questions) < 2
    better, worse = gains_of(own, figures, study.world.maximise) if asked_the_same else ((), ())
    return Moved(
        what=axis,
        before=design.axes.get(axis),
        after=value,
        index=other.index,
        feasible=other.feasible,
        out=tuple(dict.fromkeys(label(out.reason.name) for out in _outs(study, other))),
        figures={figure.name: each for figure, each in figures.items()},
        better=better if design.feasible and other.feasible else (),
        worse=worse if design.feasible and other.feasible else (),
        note="" if asked_the_same else OTHER_QUESTION,
    )


def _question(design: Design) -> str | None:
    """What was asked of a design; None where it was not run."""
    template = design.points[0].template
    return None if template is None or template.task is None else template.task.question


def _sure_in(study: Study, result: Result) -> tuple[Sure, ...]:
    """For each objective with an interval: how sure the design's is, and whether the best one by it is the best."""
    rivals, entries = study.rivals, []
    for figure in study.objectives:
        if not _known(result, figure):
            continue
        verdict = rivals.verdict(figure)
        best, rival = (
            None if number is None else int(rivals.points[number])
            for number in (verdict.winner, verdict.rival)
        )
        entries.append(_sure(result, figure, verdict, best, rival))
    return tuple(entries)
