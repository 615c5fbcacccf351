"""Points and designs: a design is one combination of the decisions, with one point in each of the conditions.

Both are views of a study: they are made when they are asked for, and what came of them stands in the study's columns.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, TypeVar, overload

import numpy as np

from codesign.ground.errors import CodesignError, InputError, clip
from codesign.ground.figures import ResultFigure, label
from codesign.ground.memo import Memo
from codesign.ground.progress import Show, silent
from codesign.ground.records import Listener
from codesign.ground.units import format_count
from codesign.inputs import Platform, Workload
from codesign.inputs.axes import value_text
from codesign.inputs.derived import DerivedFigure
from codesign.maps import OccupancyGrid
from codesign.study.aggregation import Spread, interval, spread
from codesign.study.constraints import figure_of, with_constraints
from codesign.study.moves import Bench, gains_of, levers_for, ranked, steps_of
from codesign.study.outcomes import STATES, Word
from codesign.study.reasons import Out, design_outs, point_reasons
from codesign.study.sensitivity import axis_effects
from codesign.study.table import Table
from codesign.system.explanation import Explanation, Moved, Sure, WhyOut, Words, why_energy, why_time
from codesign.system.results.result import Reason, Result
from codesign.system.results.terms import priced
from codesign.system.scenarios import scenario_of, simulate
from codesign.system.verdicts import Verdict, need_verdict, sensitivity

OTHER_QUESTION = "it was asked another question"

T = TypeVar("T")


@dataclass(frozen=True, repr=False)
class StudyPoint:
    """One point of a study by its place in the enumeration. What came of it stands in the columns of the study."""

    study: Table
    index: int

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis}={value}" for axis, value in self.axes.items())
        fate = ("feasible" if self.feasible else "infeasible") if self.state == "done" else self.state
        return f"StudyPoint({self.index}: {clip(axes)}; {fate})"

    @property
    def axes(self) -> dict[str, Any]:
        """The value of each decision and condition."""
        return self.study.space.values(self.index)

    @property
    def state(self) -> Word:
        """Its state: computed, failed (``failure`` says why), or not yet computed."""
        return STATES[int(self.study.outcomes.state[self.index])]

    @property
    def failure(self) -> str | None:
        """The reason for which it could not be computed."""
        return self.study.outcomes.failures.get(self.index)

    @property
    def feasible(self) -> bool:
        """True if it fits and, in a study without conditions, satisfies every constraint."""
        return bool(self.study.judged.feasible_points[self.index])

    @property
    def unreached(self) -> str | None:
        """The reason why the mission of a feasible point ended before its goals; None if it did not, or had none."""
        judged = self.study.judged
        return judged.ends[judged.ended_points[self.index]] if judged.unreached_points[self.index] else None

    @property
    def template(self) -> Result | None:
        """The part of its result that other points share; None if it has no result.

        If many points compute the same, this lacks what prices move: times, energy, power, clock. Ask the point
        for these, and for ``feasible`` and ``reasons``.
        """
        return self.study.outcomes.template(self.index)

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """The reasons for which it is not feasible."""
        return point_reasons(self.study, self.index)

    @property
    def result(self) -> Result | None:
        """Its full result; None where it has none. Of a point that was priced, it is simulated when it is asked for.

        Raises:
            InputError, SpecError: it has to be simulated, and cannot be; see ``specs``.
        """
        return self.study.result(self.index)

    def figure(self, figure: ResultFigure | str) -> float | None:
        """One figure, also by its name, or None where it has none.

        Raises:
            InputError: the study has no figure of this name.
        """
        return self.study.outcomes.value(self.study.figure_of(figure), self.index)

    def interval(self, figure: ResultFigure | str) -> tuple[float, float] | None:
        """The least and the greatest value of a figure inside all intervals; None where it rests on none.

        Raises:
            InputError: the study has no figure of this name.
        """
        return self.study.outcomes.ends(self.study.figure_of(figure), self.index)

    def specs(self) -> tuple[Platform, Workload]:
        """Platform and workload of the point, as ``codesign.simulate`` takes them.

        Raises:
            InputError: the point is of no study that was explored; or a map, part or host file has changed since.
                SpecError: a file is missing; or the point cannot be placed on its platform.
        """
        return self.study.made_of(self.index).point(self.axes)

    def specs_on_its_map(self) -> tuple[Platform, Workload, OccupancyGrid | None]:
        """``specs``, and the map that the study was computed on where it is at hand; see ``Specs``."""
        return self.study.specs_on_its_map(self.index)

    def run(self, *, listeners: Sequence[Listener] = (), levers: bool = False) -> Result:
        """Simulate the point again, for its records or its levers; see ``codesign.simulate``.

        Raises:
            InputError, SpecError: see ``specs``.
        """
        platform, workload, grid = self.specs_on_its_map()
        result = simulate(platform, workload, listeners=listeners, levers=levers, grid=grid)
        return result if self.study.conditions else with_constraints(result, self.study.constraints)

    def explain(self) -> Explanation:
        """Explain why the point is as it is, among the points in the same conditions; see ``Study.explain``."""
        axes = self.axes
        there = self.study.at({name: axes[name] for name in self.study.conditions})
        return Design(there, self.index // self.study.judged.conditions).explain()


@dataclass(frozen=True, repr=False)
class Design:
    """One combination of the decisions by its place in the enumeration of the designs of a study."""

    study: Table
    index: int

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis}={value}" for axis, value in self.axes.items())
        fate = ("feasible" if self.feasible else "infeasible") if self.state == "done" else self.state
        return f"Design({self.index}: {clip(axes)}; {fate})"

    def explain(self, show: Show = silent) -> Explanation:
        """Explain why the design is as it is: time, energy, what keeps it out, its neighbours, and how sure that is.

        ``show`` is told what is run.

        Raises:
            InputError: it failed, or was not computed.
        """
        kind = "design" if self.study.conditions else "point"
        if self.state == "missing":
            hint = "run the same hwsw explore again: it continues where it stopped"
            raise InputError(f"{kind} {self.index} was not computed", hint=hint)
        if self.state == "failed":
            failed = next(point for point in self.points if point.failure is not None)
            hint = f"hwsw run --point {failed.index} STUDY computes it again"
            raise InputError(f"{kind} {self.index} failed: {self.failure}", hint=hint)
        return _explained(self.study, self, show)

    @property
    def axes(self) -> dict[str, Any]:
        """The value of each decision."""
        return self.study.decisions.values(self.index)

    @cached_property
    def points(self) -> tuple[StudyPoint, ...]:
        """Its point in each condition."""
        count = self.study.judged.conditions
        return tuple(StudyPoint(self.study, self.index * count + number) for number in range(count))

    @property
    def state(self) -> Word:
        """``failed`` where one of its points failed, else ``missing`` where one was not computed."""
        return STATES[int(self.study.judged.state[self.index])]

    @property
    def feasible(self) -> bool:
        """True if it fits in every condition that counts, and satisfies every constraint."""
        return bool(self.study.judged.feasible[self.index])

    @property
    def ended(self) -> tuple[str, int] | None:
        """The reason why a mission of a feasible design ended before its goals, and the number of its condition."""
        judged = self.study.judged
        if not judged.unreached[self.index]:
            return None
        condition, why = (int(each[self.index]) for each in judged.ended)
        return judged.ends[why], condition

    @property
    def unreached(self) -> str | None:
        """The reason why a mission of a feasible design ended before its goals; None if all that count reached them."""
        ended = self.ended
        return ended[0] if ended else None

    @property
    def failure(self) -> str | None:
        """The reason for which the first of its points that failed did."""
        return next((point.failure for point in self.points if point.failure is not None), None)

    @cached_property
    def out(self) -> tuple[Out, ...]:
        """The reasons for which it is not feasible; empty if it is, or was not computed."""
        return design_outs(self.study, self.index)

    def figure(self, figure: ResultFigure | str) -> float | None:
        """The aggregated figure; None where it has no value in some condition. A share that meets a limit has all.

        Raises:
            InputError: the study has no figure of this name.
        """
        value = float(self.study.judged.figure(self.study.figure_of(figure))[self.index])
        return None if math.isnan(value) else value

    def spread(self, figure: ResultFigure | str) -> Spread | None:
        """The spread of the figure over the conditions that have it; None where none has.

        Raises:
            InputError: the study has no figure of this name.
        """
        figure = self.study.figure_of(figure)
        judged, world = self.study.judged, self.study.world
        plain = judged.plain(figure)[self.index]
        held = plain[~np.isnan(plain)]
        if not len(held):
            return None
        extent, values = spread(held), judged.values(figure)[self.index]
        if world.draws is None or np.isnan(values).any():
            return extent
        return replace(extent, interval=interval(world.rule(figure), values, figure.maximise, world.draws))


@dataclass(frozen=True)
class Rows(Sequence[T]):
    """The points or the designs of a study: each is made when it is asked for, and holds nothing of what came of it."""

    study: Table
    kind: Callable[[Table, int], T]
    length: int

    def __len__(self) -> int:
        return self.length

    @overload
    def __getitem__(self, place: int) -> T: ...

    @overload
    def __getitem__(self, place: slice) -> tuple[T, ...]: ...

    def __getitem__(self, place: int | slice) -> T | tuple[T, ...]:
        if isinstance(place, slice):
            return tuple(self.kind(self.study, index) for index in range(self.length)[place])
        return self.kind(self.study, range(self.length)[place])

    def __repr__(self) -> str:
        return f"{self.length} of {self.study!r}"


def checked_index(kind: str, index: int, count: int) -> int:
    """The index of a point or design of which there are ``count``.

    Raises:
        InputError: it is out of range; with the range and the nearest one.
    """
    if 0 <= index < count:
        return index
    nearest = format_count(min(max(index, 0), count - 1))
    hint = f"the study has {kind}s 0 to {format_count(count - 1)}; the nearest is {nearest}"
    raise InputError(f"there is no {kind} {clip(str(index), 40)}", hint=hint)


def points_of(table: Table) -> Rows[StudyPoint]:
    """Every point. ``points_of(table)[i].index`` is ``i``."""
    return Rows(table, StudyPoint, len(table.outcomes))


def designs_of(table: Table) -> Rows[Design]:
    """Every combination of the decisions, with its points. ``designs_of(table)[i].index`` is ``i``."""
    return Rows(table, Design, table.judged.count)


def _explained(table: Table, design: Design, show: Show) -> Explanation:
    point, index = _telling(table, design), design.index
    result = point.result
    assert result is not None, "a design that was computed"
    bench, notes = _bench(table, point, result, show)
    return Explanation(
        platform=result.platform,
        workload=result.workload,
        index=index,
        axes=dict(design.axes),
        condition=_condition_text(table, design, point),
        feasible=design.feasible,
        on_front=bool(table.on_front[index]),
        objectives={figure.name: design.figure(figure) for figure in table.objectives},
        derived=derived_words(table.objectives),
        result=result,
        time=why_time(result),
        energy=why_energy(result),
        out=tuple(_why_out(table, design, out, bench) for out in _outs(table, design)),
        neighbours=neighbours_of(table, design),
        sure=() if table.conditions else _sure_in(table, result),
        effects=axis_effects(table, table.objectives),
        notes=notes,
    )


def _telling(table: Table, design: Design) -> StudyPoint:
    """The point of a design that is explained: the first that is out, or else the worst by the first objective."""
    blocked = next((point for point in design.points if not point.feasible), None)
    if blocked is not None or not table.objectives:
        return blocked or design.points[0]
    figure = table.objectives[0]
    sign = -1.0 if figure.maximise else 1.0

    def loss(point: StudyPoint) -> float:
        value = point.figure(figure)
        return -math.inf if value is None else sign * value

    return max(design.points, key=loss)


def _condition_text(table: Table, design: Design, point: StudyPoint) -> str:
    place = point.index - design.points[0].index
    return ", ".join(f"{name} {value}" for name, value in table.world.each[place].items())


def _bench(table: Table, point: StudyPoint, result: Result, show: Show) -> tuple[Bench | None, tuple[str, ...]]:
    """The bench that runs the point with something moved; None, and why, if its specs are not at hand."""
    limits = () if table.conditions else table.constraints
    if result.feasible and not result.reasons:
        return None, ()
    try:
        judged = partial(with_constraints, constraints=limits)
        bench = Bench(*point.specs(), result, table.objectives, judged, show=show)
    except CodesignError as wrong:
        return None, (f"levers are not tried: {str(wrong).partition(chr(10))[0]}",)
    return bench, ((f"levers are not tried: {bench.cheap}",) if bench.cheap else ())


def _outs(table: Table, design: Design) -> list[Out]:
    if table.conditions:
        return list(design.out)
    return [Out(reason) for reason in design.points[0].reasons]


def _why_out(table: Table, design: Design, out: Out, bench: Bench | None) -> WhyOut:
    text = ""
    if out.condition is not None:
        text = _condition_text(table, design, design.points[out.condition])
    levers: tuple[Moved, ...]
    if bench is None or (table.conditions and out.reason not in bench.own.reasons):
        levers = tuple(Moved(what=lever, note="not tried") for lever in out.reason.levers)
    else:
        levers = levers_for(bench, out.reason)
    return WhyOut(reason=out.reason, condition=text, levers=levers)


def neighbours_of(table: Table, design: Design) -> tuple[Moved, ...]:
    """The designs that differ from one in a single axis, those that are better first.

    A design that was asked another question is not compared. One that failed or was not computed is left out.
    """
    own = {figure: design.figure(figure) for figure in table.objectives}
    neighbours = []
    for name, mine in design.axes.items():
        for value in table.axes[name]:
            try:
                other = Design(table, table.decisions.index({**design.axes, name: value}))
            except KeyError:
                # Other axes exist with that value.
                continue
            if value_text(value) != value_text(mine) and other.state == "done":
                neighbours.append(_neighbour(table, design, own, other, name, value))
    return ranked(neighbours)


def _neighbour(
    table: Table, design: Design, own: Mapping[ResultFigure, float | None], other: Design, axis: str, value: Any
) -> Moved:
    figures = {figure: other.figure(figure) for figure in table.objectives}
    questions = {_question(design), _question(other)} - {None}
    asked_the_same = len(questions) < 2
    better, worse = gains_of(own, figures, table.world.maximise) if asked_the_same else ((), ())
    return Moved(
        what=axis,
        before=design.axes.get(axis),
        after=value,
        index=other.index,
        feasible=other.feasible,
        out=tuple(dict.fromkeys(label(out.reason.name) for out in _outs(table, other))),
        figures={figure.name: each for figure, each in figures.items()},
        better=better if design.feasible and other.feasible else (),
        worse=worse if design.feasible and other.feasible else (),
        note="" if asked_the_same else OTHER_QUESTION,
    )


def _question(design: Design) -> str | None:
    """The question that was asked of a design; None if it was not run."""
    template = design.points[0].template
    return None if template is None or template.task is None else template.task.question


def _sure_in(table: Table, result: Result) -> tuple[Sure, ...]:
    """For each objective with an interval: how sure the design's is, and whether the best one by it is the best."""
    rivals, entries = table.rivals, []
    for figure in table.objectives:
        if not is_priced(result, figure):
            continue
        verdict = rivals.verdict(figure)
        best, rival = (
            None if number is None else int(rivals.points[number]) for number in (verdict.winner, verdict.rival)
        )
        entries.append(sure_of(result, figure, verdict, best, rival))
    return tuple(entries)


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
