"""Points and designs: a design is one combination of the decisions, with one point in each of the conditions.

Both are views of a study: they are made when they are asked for, and what came of them stands in the study's columns.
"""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar, overload

import numpy as np

from codesign.errors import InputError, choose_hint, clip, nearest, show
from codesign.exploration.aggregation import Draws, Spread, interval, spread
from codesign.exploration.constraints import budget_of, unsatisfied, with_constraints
from codesign.exploration.outcomes import STATES, Word
from codesign.exploration.rows import axis_column
from codesign.figures import FIGURES, ResultFigure
from codesign.inputs.aggregate import Rule, Share, rule_for
from codesign.records import Listener
from codesign.results.result import Reason, Result
from codesign.scenarios import simulate
from codesign.units import format_count

if TYPE_CHECKING:
    from codesign.explanation import Explanation
    from codesign.exploration.specs import Specs
    from codesign.exploration.study import Study
    from codesign.inputs import Platform, Workload
    from codesign.maps import OccupancyGrid

T = TypeVar("T")

_PERCENT = re.compile(r"[0-9]+(\.[0-9]+)? *%")

SEED = ".seed"
"""The end of the name of a condition that is drawn: its values stand for all that might have been drawn."""


@dataclass(frozen=True, repr=False)
class StudyPoint:
    """One point of a study by its place in the enumeration. What came of it stands in the columns of the study."""

    study: Study
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
        """What became of it: computed, failed (``failure`` says why), or not yet computed."""
        return STATES[int(self.study.outcomes.state[self.index])]

    @property
    def failure(self) -> str | None:
        """Why it could not be computed."""
        return self.study.outcomes.failures.get(self.index)

    @property
    def feasible(self) -> bool:
        """Whether it fits and, in a study without conditions, satisfies every constraint."""
        return bool(self.study.judged.feasible_points[self.index])

    @property
    def unreached(self) -> str | None:
        """Why the mission of a feasible point ended before its goals; None where it reached them, or had none."""
        judged = self.study.judged
        return judged.ends[judged.ended_points[self.index]] if judged.unreached_points[self.index] else None

    @property
    def template(self) -> Result | None:
        """What its result has in common with those of other points; None where it has no result.

        Where many points compute the same, this lacks what prices move: times, energy, power, clock. Ask the point
        for these, and for ``feasible`` and ``reasons``.
        """
        return self.study.outcomes.template(self.index)

    @property
    def reasons(self) -> tuple[Reason, ...]:
        """Why it is not feasible."""
        outcomes, template = self.study.outcomes, self.template
        if template is None:
            return ()
        number = int(outcomes.reason[self.index])
        reasons = template.reasons if number < 0 else (*template.reasons, outcomes.reasons[number])
        unreached = template.mission is not None and not template.mission.reached
        fits = bool(self.study.judged.fits_points[self.index])
        limits = () if self.study.conditions else self.study.constraints
        return reasons + tuple(
            reason
            for limit in limits
            for reason in unsatisfied(
                limit,
                lambda name: self.figure(FIGURES[name]),
                budget_of(template, limit),
                feasible=fits,
                unreached=unreached,
            )
        )

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
        return self._specs.point(self.axes)

    def specs_on_its_map(self) -> tuple[Platform, Workload, OccupancyGrid | None]:
        """``specs``, and the map that the study was computed on where it is at hand; see ``Specs``."""
        return self._specs.point_on_its_map(self.axes)

    @property
    def _specs(self) -> Specs:
        specs = self.study.specs
        if specs is None:
            raise InputError(f"{self!r} is of no exploration, so nothing is known of its specs")
        return specs

    def run(self, *, listeners: Sequence[Listener] = (), levers: bool = False) -> Result:
        """Simulate the point again, for its records or its levers; see ``codesign.simulate``.

        Raises:
            InputError, SpecError: see ``specs``.
        """
        platform, workload, grid = self.specs_on_its_map()
        result = simulate(platform, workload, listeners=listeners, levers=levers, grid=grid)
        return result if self.study.conditions else with_constraints(result, self.study.constraints)

    def explain(self) -> Explanation:
        """Why the point is as it is, among the points in the same conditions; see ``Study.explain``."""
        axes = self.axes
        return self.study.at({name: axes[name] for name in self.study.conditions}).explain(
            self.index // self.study.judged.conditions
        )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _spelt(axis: str, values: Sequence[Any]) -> list[str]:
    """A text for each value of an axis, equal for 1 and 1.0, 0.8 and 80 %, 50 MHz and 0.05 GHz; true is no 1."""
    shares = [
        float(value[:-1]) / 100 if isinstance(value, str) and _PERCENT.fullmatch(value) else value
        for value in values
    ]
    texts_alone = all(isinstance(each, str) for each in shares)
    entries = axis_column(axis, shares)[1] if texts_alone else shares
    texts = (json.dumps(entry, sort_keys=True) for entry in entries)
    return [repr(json.loads(text, parse_int=Fraction, parse_float=Fraction)) for text in texts]


@dataclass(frozen=True)
class Conditions:
    """The conditions of a study, and the rules by which a figure is made of its values in all of them."""

    axes: Mapping[str, tuple[Any, ...]]
    aggregate: Mapping[str, Rule]

    @cached_property
    def each(self) -> tuple[dict[str, Any], ...]:
        """Every combination of conditions, the last axis moving fastest; one without any where there are none."""
        return tuple(
            dict(zip(self.axes, values, strict=True)) for values in itertools.product(*self.axes.values())
        )

    @cached_property
    def draws(self) -> Draws | None:
        """The number of the seed, or combination of seeds, of each condition; None where fewer than two were drawn."""
        places = itertools.product(*(range(len(values)) for values in self.axes.values()))
        drawn = [position for position, name in enumerate(self.axes) if name.endswith(SEED)]
        seeds = [tuple(place[position] for position in drawn) for place in places]
        numbers = {seed: number for number, seed in enumerate(dict.fromkeys(seeds))}
        return np.array([numbers[seed] for seed in seeds], np.intp) if len(numbers) > 1 else None

    def listed(self, name: str, value: Any) -> Any:
        """The value of a condition that is named by itself, in any spelling, or by its number.

        A number is one of the list only where no value of the condition is a number itself.

        Raises:
            InputError: no such condition, or no such value of it.
        """
        if name not in self.axes:
            hint = choose_hint(name, self.axes) if self.axes else "the study has no conditions"
            raise InputError(f"there is no condition {name}", "condition", hint)
        values = self.axes[name]
        *spelt, wanted = _spelt(name, (*values, value))
        if wanted in spelt:
            return values[spelt.index(wanted)]
        numbers = [each for each in values if _is_number(each)]
        if _is_number(value) and not numbers and value in range(len(values)):
            return values[int(value)]
        texts = [clip(str(each) if _is_number(each) else json.dumps(each), 60) for each in values]
        near: str | None = None
        if numbers and _is_number(value):
            near = str(min(numbers, key=lambda each: abs(each - value)))
        elif isinstance(value, str):
            near = nearest(value, [each for each in values if isinstance(each, str)])
        listed = ", ".join(texts if numbers else (f"{number}: {text}" for number, text in enumerate(texts)))
        hint = f"did you mean {near}? accepted: {listed}" if near else f"accepted: {listed}"
        raise InputError(f"{name} has no value {show(value)}", "condition", clip(hint, 400))

    def rule(self, figure: ResultFigure) -> Rule:
        """The rule of a figure."""
        return rule_for(self.aggregate, figure)

    def maximise(self, figure: ResultFigure) -> bool:
        """Whether more of the aggregated figure is better: of a share that meets a limit it is, whatever the figure."""
        return figure.maximise or isinstance(self.rule(figure), Share)


@dataclass(frozen=True)
class Out:
    """Why a design is not feasible: a reason of its point in one condition, or of all of them together (None)."""

    reason: Reason
    condition: int | None = None


@dataclass(frozen=True, repr=False)
class Design:
    """One combination of the decisions by its place in the enumeration of the designs of a study."""

    study: Study
    index: int

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis}={value}" for axis, value in self.axes.items())
        fate = ("feasible" if self.feasible else "infeasible") if self.state == "done" else self.state
        return f"Design({self.index}: {clip(axes)}; {fate})"

    def explain(self) -> Explanation:
        """Why the design is as it is; see ``Study.explain``."""
        return self.study.explain(self.index)

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
        """Whether it fits in every condition that counts, and satisfies every constraint."""
        return bool(self.study.judged.feasible[self.index])

    @property
    def ended(self) -> tuple[str, int] | None:
        """Why a mission of a feasible design ended before its goals, and the number of that condition."""
        judged = self.study.judged
        if not judged.unreached[self.index]:
            return None
        condition, why = (int(each[self.index]) for each in judged.ended)
        return judged.ends[why], condition

    @property
    def unreached(self) -> str | None:
        """Why a mission of a feasible design ended before its goals; None where all that count reached them."""
        ended = self.ended
        return ended[0] if ended else None

    @property
    def failure(self) -> str | None:
        """Why the first of its points that failed did."""
        return next((point.failure for point in self.points if point.failure is not None), None)

    @cached_property
    def out(self) -> tuple[Out, ...]:
        """Why it is not feasible; empty where it is, or was not computed."""
        judged = self.study.judged
        if not judged.out[self.index]:
            return ()
        out = [
            Out(reason, number)
            for number, point in enumerate(self.points)
            if judged.counts_points[point.index]
            for reason in point.reasons
        ]
        for broken in (*judged.broken, *judged.short):
            place = int(np.searchsorted(broken.which, self.index))
            if place < len(broken.which) and broken.which[place] == self.index:
                out.append(Out(broken.reason(place)))
        return tuple(out)

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

    study: Study
    kind: Callable[[Study, int], T]
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
