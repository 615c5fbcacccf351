"""The certificate of the front of a study. ``codesign.study.certificates`` checks it, and knows no study."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import CertificateError, clip
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.numbering import Numbering
from codesign.inputs.aggregate import Share, rule_as_written
from codesign.inputs.axes import value_text
from codesign.inputs.constraint import UPPER, Bound, Constraint
from codesign.study.certificates.check import Verdict, check
from codesign.study.certificates.file import write_certificate
from codesign.study.certificates.form import (
    MAX_BOXES,
    MAX_ROWS,
    MAX_TEXTS,
    Certificate,
    Claim,
    Definition,
    Head,
    ReasonName,
    layout,
)
from codesign.study.front import dominators
from codesign.study.groups import Groups
from codesign.study.outcomes import State
from codesign.study.space import Box, points_of
from codesign.study.table import Table
from codesign.system.results.result import Reason, Result

# The claims of a certificate: for every design of a study whether it is on the front, and why not, in columns.

Numbers = NDArray[np.int64]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Limit:
    """One bound on a figure of designs. ``of_part``: the constraint, where it bounds a share of what the part has."""

    figure: ResultFigure
    bound: Bound
    value: float
    of_part: Constraint | None = None


class Listed:
    """Texts, each once, by their numbers; at most ``MAX_TEXTS``: all further ones are one."""

    def __init__(self) -> None:
        self._numbers = Numbering[str]()

    @property
    def texts(self) -> list[str]:
        """All of them, by number."""
        return list(self._numbers)

    def number(self, text: str) -> int:
        """The number of a text, of which the first line counts."""
        line = clip(text.partition("\n")[0], 200)
        if line not in self._numbers and len(self._numbers) >= MAX_TEXTS - 1:
            line = "another one of too many"
        return self._numbers[line]


class Reasons:
    """Reasons, each once, by their numbers: the number of the name, demand and limit."""

    def __init__(self) -> None:
        self._names = Numbering[tuple[str, str, str, str]]()
        self._held = Numbering[tuple[int, float, float]]()

    @property
    def names(self) -> list[ReasonName]:
        """The names of what passes its limit, by number."""
        return [
            ReasonName.model_validate(dict(zip(ReasonName.model_fields, name, strict=True))) for name in self._names
        ]

    @property
    def held(self) -> Floats:
        """All of them, by number: reasons × (name, demand, limit)."""
        return np.array(list(self._held), np.float64).reshape(-1, 3)

    def number(self, reason: Reason) -> int:
        """The number of a reason."""
        demand, limit = float(reason.demand), float(reason.limit)
        if not abs(demand - limit) > 0:
            # A reason without figures is 1 against 0, as that of a mapping.
            demand, limit = 1.0, 0.0
        side: Literal["at_least", "at_most"] = "at_least" if demand < limit else "at_most"
        name = str(reason.kind), clip(reason.name, 200), reason.unit, side
        if name not in self._names and len(self._names) >= MAX_TEXTS - 2:
            name = "", "another one of too many", "", side
        return self._held[self._names[name], demand, limit]


class Claims:
    """The entries of a certificate: first the rows, of ``designs`` of the study, then the ``boxes``."""

    def __init__(self, table: Table, excluded: Sequence[Box]) -> None:
        entries = Entries.of(table, excluded)
        self._table, self.boxes, self._places = entries.study, entries.boxes, entries.places
        self.reasons, self.texts = Reasons(), Listed()
        self.designs, held = entries.rows, entries.holder >= 0
        self._row = np.where(held, -1, np.cumsum(~held) - 1)

    def _ends_of(self, box: Box) -> tuple[list[int], list[int]]:
        """The places of a box on all axes of the space: 0 and 1 on those that its part lacks."""
        space = self._table.decisions
        own = dict(zip(space.parts[box.part].axes, zip(box.low, box.high, strict=True), strict=True))
        low, high = zip(*(own.get(axis, (0, 1)) for axis in space.axes), strict=True)
        return list(low), list(high)

    def _row_of(self, design: int | None) -> int:
        """The row of the study that a design has; the first one where it has none."""
        row = 0 if design is None else int(np.searchsorted(self._places, design))
        return row if row < len(self._places) and self._places[row] == design else 0

    @cached_property
    def figures(self) -> tuple[ResultFigure, ...]:
        """The figures that are stated: objectives, and what is constrained."""
        return tuple(dict.fromkeys((*self._table.objectives, *(limit.figure for limit in self.limits))))

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """Every bound that designs keep."""
        table = self._table
        limits = [
            Limit(each.figure, bound, float(value), each if each.of_part else None)
            for each in table.constraints
            for bound, value in each.bounds.items()
        ]
        for name, rule in table.aggregate.items():
            if isinstance(rule, Share) and rule.required is not None:
                figure = table.figures[name] if name in table.figures else FIGURES[name]
                limits.append(Limit(figure, "at_least", rule.required))
        return tuple(limits)

    @cached_property
    def budgets(self) -> tuple[Constraint, ...]:
        """The constraints that bound shares of a part."""
        return tuple(dict.fromkeys(limit.of_part for limit in self.limits if limit.of_part is not None))

    @cached_property
    def tasks(self) -> list[str]:
        """The tasks of the table."""
        templates = self._table.outcomes.templates
        return sorted({_task(templates[number]) for number in self._table.outcomes.used()}) or [""]

    @cached_property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The columns of the certificate, by name."""
        table, chosen = self._table, self.designs
        judged, outcomes, boxes = table.judged, table.outcomes, self.boxes
        figures = np.array([judged.figure(figure)[chosen] for figure in self.figures])
        figures[:, judged.state[chosen] != State.DONE] = math.nan
        bounds = [box.bound or {} for box in boxes]
        best = [[bound.get(figure.name, math.nan) for bound in bounds] for figure in self.figures]
        numbers = {name: number for number, name in enumerate(self.tasks)}
        # A template that no point has counts for nothing.
        of_points = outcomes.each(lambda template: numbers.get(_task(template), 0), 0)
        task = judged.by_design(of_points)[chosen, 0]
        tasks = [of_points[self._row_of(box.by) * judged.conditions] for box in boxes]
        ends, unknown = [self._ends_of(box) for box in boxes], np.full(len(boxes), math.nan)
        budgets = [np.concatenate([judged.budgets(limit)[chosen], unknown]) for limit in self.budgets]
        columns: dict[str, NDArray[Any]] = {
            "design": self._places[chosen],
            "task": np.concatenate([task, np.array(tasks, np.int64)]),
            "figures": np.concatenate([figures, np.array(best, np.float64).reshape(figures.shape[0], -1)], axis=1),
            "budgets": np.array(budgets),
            "part": np.array([box.part for box in boxes]),
            "low": np.array([low for low, _ in ends]),
            "high": np.array([high for _, high in ends]),
        }
        claim, by = self._claims(columns["figures"], columns["task"])
        name, demand, limit = self.reasons.held.T
        return {**columns, "claim": claim, "by": by, "name": name, "demand": demand, "limit": limit}

    def _claims(self, figures: Floats, task: Numbers) -> tuple[Numbers, Numbers]:
        """Claim and number of every entry. The last that is put counts."""
        table, judged, chosen = self._table, self._table.judged, self.designs
        claim, by = np.full((2, figures.shape[1]), -1, np.int64)

        def put(which: NDArray[np.bool_], what: Claim, numbers: Any) -> None:
            rows = np.flatnonzero(which[chosen])
            claim[rows], by[rows] = what, numbers[chosen[rows]]

        nothing = np.zeros(judged.count, np.int64)
        every = np.ones(judged.count, np.bool_)
        put(every, Claim.DOMINATED, nothing)
        for number, figure in reversed([*enumerate(table.objectives)]):
            put(np.isnan(judged.figure(figure)), Claim.LACKING, nothing + number)
        put(judged.unreached, Claim.UNREACHED, self._ends)
        for number, broken in reversed([*enumerate(self._broken)]):
            put(broken & judged.out, Claim.CONSTRAINT, nothing + number)
        unfit = self._unfit
        put(unfit >= 0, Claim.UNFIT, unfit)
        first = self._row[table.first_of_same]
        put(~table.distinct_designs & (first >= 0), Claim.SAME, first)
        put(judged.state == State.FAILED, Claim.FAILED, self._failures)
        put(judged.state == State.MISSING, Claim.MISSING, nothing)
        front = np.zeros(judged.count, np.bool_)
        front[list(table.front)] = True
        put(front, Claim.FRONT, nothing)
        for number, box in enumerate(self.boxes, len(chosen)):
            claim[number], by[number] = self._of_box(box, figures[:, number])
        self._put_dominators(claim, by, figures, task)
        return claim, by

    def _put_dominators(self, claim: Numbers, by: Numbers, figures: Floats, task: Numbers) -> None:
        objectives = self._table.objectives
        costs = figures[[self.figures.index(figure) for figure in objectives]].T
        maximise = [self._table.world.maximise(figure) for figure in objectives]
        for own in np.unique(task):
            entries = np.flatnonzero((task == own) & (claim == Claim.DOMINATED))
            front = np.flatnonzero((task == own) & (claim == Claim.FRONT))
            places = dominators(costs[entries], maximise, costs[front])
            lacking = entries[places < 0]
            if len(lacking):
                what = f"no design of the front dominates box {int(lacking[0]) - len(self.designs)}"
                raise CertificateError(what, hint="compute its designs, or give a better bound")
            by[entries] = front[places]

    def _of_box(self, box: Box, figures: Floats) -> tuple[Claim, int]:
        if not box.why:
            return Claim.MISSING, 0
        if box.by is not None:
            return Claim.DOMINATED, 0
        for number, limit in enumerate(self.limits):
            # The bound of a figure says nothing of a limit on its other side, nor of a share of an unknown part.
            of_side = (limit.bound in UPPER) != self._table.world.maximise(limit.figure)
            value = figures[[self.figures.index(limit.figure)]]
            if of_side and limit.of_part is None and not np.isnan(value) and not _keeps(limit, value):
                return Claim.CONSTRAINT, number
        reason = Reason(kind="bound", name=box.why, demand=1, limit=0, gap=1, unit="")
        return Claim.UNFIT, self.reasons.number(reason)

    @property
    def _broken(self) -> list[NDArray[np.bool_]]:
        """The designs that do not keep each limit."""
        judged = self._table.judged
        return [
            ~_keeps(limit, judged.figure(limit.figure), judged.budgets(limit.of_part) if limit.of_part else 1.0)
            for limit in self.limits
        ]

    @property
    def _ends(self) -> Numbers:
        """The number of the text that says why a mission of each design ended."""
        judged = self._table.judged
        _, why = judged.ended
        return self._numbered(np.where(judged.unreached, why, -1), judged.ends, self.texts.number)

    @property
    def _failures(self) -> Numbers:
        """The number of the text that says why each design failed."""
        numbers = np.full(self._table.judged.count, -1, np.int64)
        messages = self._table.outcomes.failures
        for point in sorted(messages, reverse=True):
            numbers[point // self._table.judged.conditions] = point
        for design in np.flatnonzero(numbers >= 0).tolist():
            numbers[design] = self.texts.number(messages[int(numbers[design])])
        return numbers

    @property
    def _unfit(self) -> Numbers:
        """The number of the first reason that keeps each design out; -1: it has none but constraints."""
        judged, outcomes = self._table.judged, self._table.outcomes
        late = len(outcomes.templates)
        own = [number if template.reasons else -1 for number, template in enumerate(outcomes.templates)]
        first = np.array([*own, -1])[outcomes.which]
        first = np.where((first < 0) & (outcomes.reason >= 0), outcomes.reason + late, first)
        table = np.asarray(judged.by_design(np.where(judged.counts_points, first, -1)), np.int64)
        which = np.asarray(table[np.arange(len(table)), (table >= 0).argmax(axis=1)], np.int64)
        held = [*(template.reasons[:1] for template in outcomes.templates), *((each,) for each in outcomes.reasons)]
        return self._numbered(which, held, lambda reasons: self.reasons.number(reasons[0]))

    def _numbered(self, which: Numbers, held: Sequence[Any], number: Any) -> Numbers:
        """Numbers by first use in the order of the designs, in place of places in a list."""
        numbers = np.full(len(held) + 1, -1, np.int64)
        for each in which[Groups.of(which).in_turn.firsts].tolist():
            if each >= 0:
                numbers[each] = number(held[each])
        return numbers[which]


def _task(template: Result) -> str:
    return "" if template.task is None else template.task.task


def _keeps(limit: Limit, values: Floats, budgets: Floats | float = 1.0) -> NDArray[np.bool_]:
    """The values that keep a limit, as flags; a value that is missing keeps none."""
    scale = np.where(np.isnan(budgets) | (np.asarray(budgets) == 0), 1.0, budgets)
    compare = {"at_least": np.greater_equal, "at_most": np.less_equal, "above": np.greater, "below": np.less}
    return np.asarray(compare[limit.bound](values / scale, limit.value), np.bool_)


def certify(table: Table, path: Path | str, excluded: Sequence[Box] | None = None) -> Verdict:
    """Write the certificate of the front of a study to a file, once the checker has accepted it.

    ``excluded``: boxes of designs that were not computed; by default the study's own.

    Raises:
        CertificateError: the study has no objectives, or more designs than a certificate holds; or nothing excludes a
            box, or a design betters its box. RunError: the file cannot be written.
    """
    certificate = certificate_of(table, excluded)
    verdict = check(certificate)
    write_certificate(certificate, Path(path))
    return verdict


def certificate_of(table: Table, excluded: Sequence[Box] | None = None) -> Certificate:
    """The certificate of the front of a study; see ``certify``."""
    if not table.objectives:
        raise CertificateError("the study has no objectives, so it has no front", hint="name objectives")
    space = table.decisions
    claims = Claims(table, table.excluded if excluded is None else excluded)
    if len(claims.designs) > MAX_ROWS or len(claims.boxes) > MAX_BOXES:
        most = f"a certificate has at most {MAX_ROWS:,} designs one by one, and {MAX_BOXES:,} boxes"
        raise CertificateError(most, hint="certify a part of the study, by --set or --axis")
    given = claims.columns
    definition = _definition(table, claims)
    head = Head(
        format="hwsw certificate",
        version=1,
        rows=len(claims.designs),
        boxes=len(claims.boxes),
        reasons=len(claims.reasons.held),
        parts=[{axis: list(numbers) for axis, numbers in box.axes.items()} for box in space.parts],
        tasks=claims.tasks,
        names=claims.reasons.names,
        texts=claims.texts.texts,
    )
    columns = {
        name: np.ascontiguousarray(given[name], kind).reshape(shape)
        for name, (kind, shape) in layout(definition, head).items()
    }
    return Certificate.of(definition, head, columns)


def differences(certificate: Certificate, table: Table, excluded: Sequence[Box] | None = None) -> list[str]:
    """The parts in which a certificate is not the study's own; nothing if they are equal."""
    own, its = certificate_of(table, excluded), certificate
    heads = [json.loads(each.texts[0]) | json.loads(each.texts[1]) for each in (own, its)]
    texts = [name for name, value in heads[0].items() if value != heads[1][name]]
    columns = [
        f"column {name}"
        for name, column in own.columns.items()
        if not np.array_equal(column, its.columns[name], equal_nan=column.dtype.kind == "f")
    ]
    return texts or columns or ([] if own.digests == its.digests else ["text"])


def _definition(table: Table, claims: Claims) -> Definition:
    """The definition of the study: what it is of, and what for."""
    space, figures = table.decisions, claims.figures
    numbers = {axis: [*map(value_text, values)] for axis, values in space.axes.items()}
    document: dict[str, Any] = {
        "platform": table.platform,
        "workload": table.workload,
        "axes": [
            {
                "axis": axis,
                "values": list(values),
                "when": {
                    other: [numbers[other].index(value_text(value)) for value in held]
                    for other, held in space.when.get(axis, {}).items()
                },
            }
            for axis, values in space.axes.items()
        ],
        "conditions": [{"axis": axis, "values": list(values)} for axis, values in table.conditions.items()],
        "aggregate": {name: rule_as_written(rule) for name, rule in table.aggregate.items()},
        "derived": {name: figure.as_written for name, figure in table.figures.items()},
        "figures": [
            {"name": figure.name, "unit": figure.unit, "best": "greatest" if table.world.maximise(figure) else "least"}
            for figure in figures
        ],
        "objectives": [
            {"figure": figures.index(figure), "direction": "maximise" if table.world.maximise(figure) else "minimise"}
            for figure in table.objectives
        ],
        "constraints": [
            {
                "figure": figures.index(limit.figure),
                "bound": limit.bound,
                "limit": limit.value,
                "budget": claims.budgets.index(limit.of_part) if limit.of_part else None,
            }
            for limit in claims.limits
        ],
        "budgets": [limit.figure.name for limit in claims.budgets],
        "identity": dict(table.specs.identity) if table.specs else {},
        "contents": {axis: dict(own) for axis, own in table.specs.contents.items()} if table.specs else {},
    }
    return Definition.model_validate(document)


# The entries of a certificate: designs that were evaluated one by one, boxes of others, and what is left.

_FEW = 64
_NOTHING = "its boxes prove nothing: explore without --search bound"


@dataclass(frozen=True, eq=False)
class Entries:
    """The entries of a certificate of a study.

    - ``study``: with its designs in the order of the space. ``places``: their numbers in the whole space.
    - ``boxes``: of designs that were not evaluated; the last ones hold the designs that are in no box of a search.
    - ``holder``: for each design of the study the number of the box that stands for it; -1: it is a row.
    """

    study: Table
    boxes: Sequence[Box]
    holder: Numbers

    @classmethod
    def of(cls, study: Table, excluded: Sequence[Box]) -> Entries:
        """The entries of a study with these boxes, without the boxes of which each design was evaluated.

        Raises:
            CertificateError: a design that was evaluated is better than its box allows.
        """
        if study.chosen is not None:
            order = np.argsort(np.array(study.chosen, np.int64))
            conditions = len(study.world.each)
            outcomes = study.outcomes.chosen(points_of(order.tolist(), conditions))
            study = replace(study, chosen=tuple(np.array(study.chosen)[order].tolist()), outcomes=outcomes)
        every = cls(study, excluded, np.full(study.judged.count, -1, np.int64))
        boxes, holder = every._needed()
        entries = cls(study, boxes, holder)
        entries._check_held()
        return entries if study.chosen is None else replace(entries, boxes=(*boxes, *entries._left()))

    @cached_property
    def places(self) -> Numbers:
        """The number of each design of the study in the whole space."""
        chosen = self.study.chosen
        return np.arange(self.study.judged.count) if chosen is None else np.array(chosen, np.int64)

    @property
    def rows(self) -> Numbers:
        """The designs of the study that are rows."""
        return np.flatnonzero(self.holder < 0)

    def _needed(self) -> tuple[list[Box], Numbers]:
        """The boxes with a design that was not evaluated; and for each design of the study its box."""
        holder, known = self.holder.copy(), self.study.judged.state != State.MISSING
        for part, own in self._by_part.items():
            rows, places = self._rows_in(part)
            low, high = self._ends(part)
            holder[rows] = np.append(own, -1)[holders(low, high, places)]
        sizes = [math.prod(np.subtract(box.high, box.low).tolist()) for box in self.boxes]
        # A box stays unless all of its designs were evaluated: as many evaluated designs lie in it as it has.
        evaluated = np.bincount(holder[known & (holder >= 0)], minlength=len(sizes))
        kept = [number for number, size in enumerate(sizes) if evaluated[number] < size]
        numbers = np.full(len(sizes) + 1, -1, np.int64)
        numbers[kept] = np.arange(len(kept))
        return [self.boxes[number] for number in kept], numbers[holder]

    @cached_property
    def _by_part(self) -> dict[int, Numbers]:
        """The boxes in each part of the space that has one, by number."""
        parts = np.array([box.part for box in self.boxes], np.int64)
        return {int(parts[members[0]]): members for members in Groups.of(parts).members}

    def _ends(self, part: int) -> tuple[Numbers, Numbers]:
        """Begin and end of each box in a part of the space, boxes × axes."""
        boxes = [self.boxes[number] for number in self._by_part.get(part, ())]
        shape = len(boxes), len(self.study.decisions.parts[part].axes)
        low, high = [box.low for box in boxes], [box.high for box in boxes]
        return np.array(low, np.int64).reshape(shape), np.array(high, np.int64).reshape(shape)

    def _rows_in(self, part: int) -> tuple[Numbers, Numbers]:
        """The designs of the study in a part of the space, and their places on its axes."""
        box = self.study.decisions.parts[part]
        begin, end = np.searchsorted(self.places, [box.begin, box.begin + box.size])
        shape = [*map(len, box.axes.values())] or [1]
        own = np.unravel_index(self.places[begin:end] - box.begin, shape)
        places = np.stack(own, axis=1).astype(np.int64)[:, : len(box.axes)]
        return np.arange(begin, end), places

    def _left(self) -> list[Box]:
        """Boxes of the designs that are in no other entry."""
        left = []
        for part, box in enumerate(self.study.decisions.parts):
            rows, places = self._rows_in(part)
            places = places[self.holder[rows] < 0]
            low, high = self._ends(part)
            first, last = np.concatenate([places, low]), np.concatenate([places + 1, high])
            shape = tuple(map(len, box.axes.values()))
            left += [Box(part, *ends) for ends in rest_of(first, last, shape)]
        return left

    def _check_held(self) -> None:
        """Refuse boxes of which a design that was evaluated says that they are none."""
        study, held = self.study, np.flatnonzero(self.holder >= 0)
        boxes = [self.boxes[number] for number in self.holder[held]]
        feasible = study.judged.feasible[held]
        wrong = feasible & np.array([bool(box.why) and box.by is None for box in boxes], np.bool_)
        for figure in study.objectives:
            bounds = np.array([(box.bound or {}).get(figure.name, math.nan) for box in boxes])
            values = study.judged.figure(figure)[held]
            wrong |= feasible & (values > bounds if study.world.maximise(figure) else values < bounds)
        if wrong.any():
            design = int(self.places[held[int(wrong.argmax())]])
            what = f"design {design} was evaluated, and is better than its box allows"
            raise CertificateError(what, hint=_NOTHING)


def holders(low: Numbers, high: Numbers, places: Numbers) -> Numbers:
    """For each design the number of the box that it is in; -1: none.

    ``low``, ``high``: boxes × axes. ``places``: designs × axes.

    >>> holders(np.array([[0, 0], [2, 1]]), np.array([[2, 1], [3, 3]]), np.array([[1, 0], [2, 2], [0, 2]]))
    array([ 0,  1, -1])
    """
    found = np.full(len(places), -1, np.int64)
    stack = [(np.arange(len(low)), low, high, np.arange(len(places)))]
    while stack:
        boxes, low, high, own = stack.pop()
        cut = None if len(boxes) <= _FEW or not len(own) else _cut(low, high)
        if cut is not None:
            axis, at = cut
            below, behind, before = low[:, axis] < at, high[:, axis] > at, places[own, axis] < at
            clipped = low[behind]
            clipped[:, axis] = np.maximum(clipped[:, axis], at)
            stack.append((boxes[below], low[below], high[below], own[before]))
            stack.append((boxes[behind], clipped, high[behind], own[~before]))
            continue
        for box, first, last in zip(boxes.tolist(), low, high, strict=True):
            found[own[((places[own] >= first) & (places[own] < last)).all(axis=1)]] = box
    return found


def rest_of(low: Numbers, high: Numbers, shape: tuple[int, ...]) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Boxes that fill a grid together with boxes that do not meet: begin and end of each, boxes × axes.

    >>> rest_of(np.array([[1, 0]]), np.array([[2, 2]]), (2, 3))
    [((0, 0), (1, 3)), ((1, 2), (2, 3))]
    """
    if sum((high - low).prod(axis=1).tolist()) == math.prod(shape):
        return []
    rest: list[tuple[tuple[int, ...], tuple[int, ...]]] = []
    stack = [((0,) * len(shape), shape, low, high)]
    while stack:
        begin, end, low, high = stack.pop()
        if not len(low):
            rest.append((begin, end))
        elif len(low) == 1:
            rest += _around(begin, end, low[0].tolist(), high[0].tolist())
        else:
            cut = _cut(low, high)
            if cut is None:
                raise CertificateError("two boxes hold the same design", hint=_NOTHING)
            axis, at = cut
            before, behind = low[:, axis] < at, high[:, axis] > at
            top, clipped = high[before].copy(), low[behind].copy()
            top[:, axis], clipped[:, axis] = np.minimum(top[:, axis], at), np.maximum(clipped[:, axis], at)
            middle, start = [*end], [*begin]
            middle[axis] = start[axis] = at
            stack += [(tuple(start), end, clipped, high[behind]), (begin, tuple(middle), low[before], top)]
    return rest


def _around(
    begin: Sequence[int], end: Sequence[int], low: Sequence[int], high: Sequence[int]
) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Boxes around one box in a larger one."""
    around = []
    first, last = [*begin], [*end]
    for axis, (bottom, top) in enumerate(zip(low, high, strict=True)):
        for one, other in ((first[axis], bottom), (top, last[axis])):
            if one < other:
                around.append(((*first[:axis], one, *first[axis + 1 :]), (*last[:axis], other, *last[axis + 1 :])))
        first[axis], last[axis] = bottom, top
    return around


def _cut(low: Numbers, high: Numbers) -> tuple[int, int] | None:
    """Axis and place of a cut that leaves few boxes on each side; None where no cut parts them."""
    best, cut = len(low), None
    for axis in range(low.shape[1]):
        begins = np.unique(low[:, axis])
        if len(begins) > 1:
            at = int(begins[len(begins) // 2])
            more = int(max((low[:, axis] < at).sum(), (high[:, axis] > at).sum()))
            # Of two boxes one may reach across: the cut still makes both smaller.
            if more < best or cut is None:
                best, cut = more, (axis, at)
    return cut
