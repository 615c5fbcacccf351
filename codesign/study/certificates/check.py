"""The checker of certificates: whether the front follows from the figures stated. It simulates nothing.

It needs NumPy and the certificate alone, and imports nothing that computes a front.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import CertificateError
from codesign.ground.numbering import distinct
from codesign.study.certificates.form import MAX_SPACE, WORDS, Axis, Bound, Certificate, Claim, digests_of

Flags = NDArray[np.bool_]
_BLOCK, _PAIRS = 256, 2**23
_ENDS = {"at_least": np.greater_equal, "at_most": np.less_equal, "above": np.greater, "below": np.less}


@dataclass(frozen=True)
class Trust:
    """A part of an accepted certificate that nothing else in it shows.

    - ``what``: in words. ``designs``: of how many.
    - ``eligible``: how many of these are off the front for no other reason than that or a design that dominates them:
      they have every objective and keep every constraint, or have no figures that could tell. None of what is no
      claim.
    """

    what: str
    designs: int
    eligible: int | None = None


@dataclass(frozen=True)
class Verdict:
    """The contents of an accepted certificate: how many designs each claim stands for, and the designs of the front.

    ``trusted``: what of it the checker could not recompute.
    """

    designs: dict[Claim, int]
    front: tuple[int, ...]
    trusted: tuple[Trust, ...]

    @property
    def missing(self) -> int:
        """The number of designs that were not computed."""
        return self.designs[Claim.MISSING]


def check(certificate: Certificate) -> Verdict:
    """Check every claim.

    Raises:
        CertificateError: the first that does not hold.
    """
    columns, digests = certificate.columns, digests_of(certificate.texts, certificate.columns)
    require(certificate.digests.study == digests.study, "its definition is not the one that its digest is of")
    require(certificate.digests.content == digests.content, "its content is not that which its digest is of")
    sizes = covered(certificate)
    entries = _Entries(certificate)
    entries.check_numbers()
    entries.check_front()
    entries.check_dominated()
    entries.check_others()
    entries.check_same()
    entries.check_unfit()
    claim, front = columns["claim"], columns["design"][entries.of(Claim.FRONT)]
    designs = {each: int(sizes[claim == each].sum()) for each in Claim}
    return Verdict(designs, tuple(np.sort(front).tolist()), tuple(entries.trusted(sizes)))


class _Entries:
    """The claims of the entries, each held against the figures stated."""

    def __init__(self, certificate: Certificate) -> None:
        self._held, columns = certificate, certificate.columns
        self._claim, self._by, self._task = (columns[name] for name in ("claim", "by", "task"))
        self._figures, self._design = columns["figures"], columns["design"]

    def of(self, claim: Claim) -> NDArray[np.intp]:
        """The entries with a claim."""
        return np.flatnonzero(self._claim == claim)

    def check_numbers(self) -> None:
        """Every number names something."""
        definition, head = self._held.definition, self._held.head
        ends = dict.fromkeys((Claim.DOMINATED, Claim.SAME), head.rows)
        ends |= dict.fromkeys((Claim.UNREACHED, Claim.FAILED), len(head.texts))
        ends |= {Claim.CONSTRAINT: len(definition.constraints), Claim.LACKING: len(definition.objectives)}
        ends |= {Claim.UNFIT: head.reasons, Claim.FRONT: 1, Claim.MISSING: 1}
        table = np.array([ends[claim] for claim in Claim] + [0] * (256 - len(Claim)))
        self._refuse((self._by < 0) | (self._by >= table[self._claim]), "names nothing that there is")
        used = [*(each.figure for each in definition.objectives), *(each.figure for each in definition.constraints)]
        tasks = len(self._held.head.tasks)
        self._refuse((self._task < 0) | (self._task >= tasks), "has a task that there is not")
        sound = all(0 <= number < len(definition.figures) for number in used)
        budgets = [each.budget for each in definition.constraints if each.budget is not None]
        require(sound and all(0 <= number < len(definition.budgets) for number in budgets), "a figure lacks")
        for objective in definition.objectives:
            best = definition.figures[objective.figure].best
            require((best == "least") == (objective.direction == "minimise"), "a direction is reversed")
        of_boxes = np.isin(self._claim, (Claim.DOMINATED, Claim.CONSTRAINT, Claim.UNFIT, Claim.MISSING))
        self._refuse(~of_boxes & (np.arange(len(self._claim)) >= head.rows), "is a box with such a claim")
        name, demand, limit = (self._held.columns[each] for each in ("name", "demand", "limit"))
        require(bool(((name >= 0) & (name < len(head.names))).all()), "a reason has no name")
        upper = np.array([each.side == "at_most" for each in head.names], np.bool_)[name]
        passed = np.where(upper, demand > limit, demand < limit)
        require(bool(passed.all()), "a reason does not pass its limit")

    @property
    def _costs(self) -> NDArray[np.float64]:
        objectives = self._held.definition.objectives
        signs = [1.0 if each.direction == "minimise" else -1.0 for each in objectives]
        return np.asarray(self._figures[[each.figure for each in objectives]] * np.array(signs)[:, None])

    def check_front(self) -> None:
        """The designs of the front keep all constraints, and none of them dominates another."""
        front = self.of(Claim.FRONT)
        for bound in self._held.definition.constraints:
            self._refuse(front[~self._keeps(bound, front)], "is on the front and breaks a constraint")
        costs, tasks = self._costs[:, front], self._task[front]
        self._refuse(front[np.isnan(costs).any(axis=0)], "is on the front and lacks an objective")
        # No design dominates one that is better in the first objective.
        order = np.argsort(costs[0], kind="stable")
        front, costs, tasks = front[order], costs[:, order], tasks[order]
        block = max(1, min(_BLOCK, _PAIRS // max(1, len(front))))
        for begin in range(0, len(front), block):
            some = slice(begin, begin + block)
            # no_worse[i, j]: design i of the front has the task of design j of the block, and is no worse in any
            # objective. Then it dominates where it is better in one.
            to = np.searchsorted(costs[0], costs[0, some][-1], "right")
            no_worse = tasks[:to, None] == tasks[some]
            for cost in costs:
                no_worse &= cost[:to, None] <= cost[some]
            one, other = np.nonzero(no_worse)
            better = (costs[:, one] < costs[:, begin + other]).any(axis=0)
            self._refuse(np.sort(front[begin + other[better]]), "is on the front and is dominated")

    def check_dominated(self) -> None:
        """Each is dominated by the design of the front that it names, a box by its best figures."""
        entries, costs = self.of(Claim.DOMINATED), self._costs
        named = self._by[entries]
        holds = (self._claim[named] == Claim.FRONT) & (self._task[named] == self._task[entries])
        holds &= (costs[:, named] <= costs[:, entries]).all(axis=0)
        holds &= (costs[:, named] < costs[:, entries]).any(axis=0)
        self._refuse(entries[~holds], "is not dominated by the design that it names")

    def check_others(self) -> None:
        """Check the entries that break a constraint, lack an objective, or have no figures."""
        definition, figures = self._held.definition, self._figures
        broken = self.of(Claim.CONSTRAINT)
        for number, bound in enumerate(definition.constraints):
            entries = broken[self._by[broken] == number]
            holds = ~self._keeps(bound, entries)
            least = definition.figures[bound.figure].best == "least"
            if least != (bound.bound in ("at_most", "below")):
                holds &= entries < self._held.head.rows
            boxes = entries >= self._held.head.rows
            known = ~np.isnan(figures[bound.figure, entries])
            if bound.budget is not None:
                known &= least & ~np.isnan(self._held.columns["budgets"][bound.budget, entries])
            self._refuse(entries[~holds | (boxes & ~known)], "does not break the constraint that it names")
        lacking = self.of(Claim.LACKING)
        figure = np.array([each.figure for each in definition.objectives])[self._by[lacking]]
        self._refuse(lacking[~np.isnan(figures[figure, lacking])], "has the objective that it is to lack")
        empty = np.flatnonzero(np.isin(self._claim, (Claim.FAILED, Claim.MISSING)))
        self._refuse(empty[~np.isnan(figures[:, empty]).all(axis=0)], "was not computed and has figures")

    def check_same(self) -> None:
        """Each has the figures, the task and the budgets of an earlier design that was computed."""
        same = self.of(Claim.SAME)
        first = self._by[same]
        holds = (self._task[same] == self._task[first]) & (self._design[first] < self._design[same])
        holds &= ~np.isin(self._claim[first], (Claim.SAME, Claim.FAILED, Claim.MISSING))
        for values in (self._figures, self._held.columns["budgets"]):
            own, its = values[:, same], values[:, first]
            holds &= ((own == its) | (np.isnan(own) & np.isnan(its))).all(axis=0)
        self._refuse(same[~holds], "is not the same as the design that it names")

    def check_unfit(self) -> None:
        """A resource that passes its limit is the figure of its name, its limit the budget, where they are stated."""
        definition, columns = self._held.definition, self._held.columns
        names = [each.name for each in definition.figures]
        for resources, stated, reason in (
            (names, self._figures, "demand"),
            (definition.budgets, columns["budgets"], "limit"),
        ):
            for resource, values in zip(resources, stated, strict=True):
                rows = self._short_of(resource)
                wrong = values[rows] != columns[reason][self._by[rows]]
                self._refuse(rows[wrong], f"is unfit by another {reason} of {resource} than it has")

    def _short_of(self, resource: str) -> NDArray[np.intp]:
        """The rows that are unfit by a resource. A figure over conditions is no demand of a single run."""
        head, rows = self._held.head, self.of(Claim.UNFIT)
        kinds = np.array([each.kind == "resource" and each.name == resource for each in head.names], np.bool_)
        if self._held.definition.conditions or not kinds.any():
            return rows[:0]
        rows = rows[rows < head.rows]
        return rows[kinds[self._held.columns["name"][self._by[rows]]]]

    def trusted(self, sizes: NDArray[np.int64]) -> Iterator[Trust]:
        """The parts that nothing else in the certificate shows, of so many designs each entry."""
        claim, head, definition = self._claim, self._held.head, self._held.definition
        rows, computed = np.arange(len(claim)) < head.rows, ~np.isin(claim, (Claim.FAILED, Claim.MISSING))
        bounded = np.isin(claim, (Claim.DOMINATED, Claim.CONSTRAINT))
        for what, which in (("figures, tasks and budgets", rows & computed), ("bounds of boxes", ~rows & bounded)):
            if which.any():
                yield Trust(what, int(sizes[which].sum()))
        eligible = ~np.isnan(self._costs).any(axis=0)
        for bound in definition.constraints:
            eligible &= self._keeps(bound, np.arange(len(claim)))
        counted = sizes * (eligible | ~rows | ~computed)
        shown = np.zeros(len(claim), np.bool_)
        for resource in {each.name for each in definition.figures} & {*definition.budgets}:
            shown[self._short_of(resource)] = True
        reasons = [f"{each.kind} {each.name}" for each in head.names]
        for kind, texts in (
            *((Claim.UNFIT, reasons), (Claim.UNREACHED, head.texts)),
            *((Claim.FAILED, head.texts), (Claim.SAME, [""])),
        ):
            entries = np.flatnonzero((claim == kind) & ~shown)
            numbers = self._by[entries] * (kind != Claim.SAME)
            if kind == Claim.UNFIT:
                numbers = self._held.columns["name"][numbers]
            used, places = distinct(numbers)
            sums = np.zeros((2, len(used)), np.int64)
            for total, of in zip(sums, (sizes, counted), strict=True):
                np.add.at(total, places, of[entries])
            for number, designs, open_ in zip(used.tolist(), *sums.tolist(), strict=True):
                text = f": {texts[number]}" if texts[number] else ""
                yield Trust(f"{WORDS[kind]}{text}", designs, open_)

    def _keeps(self, bound: Bound, entries: NDArray[np.intp]) -> Flags:
        """The entries that keep a bound, as flags. A figure that is missing keeps none."""
        values = self._figures[bound.figure, entries]
        if bound.budget is not None:
            budget = self._held.columns["budgets"][bound.budget, entries]
            values = values / np.where(np.isnan(budget) | (budget == 0), 1.0, budget)
        return np.asarray(_ENDS[bound.bound](values, bound.limit))

    def _refuse(self, wrong: NDArray[Any], what: str) -> None:
        """Refuse the first of entries that are wrong: flags of all, or their numbers."""
        numbers = np.flatnonzero(wrong) if wrong.dtype == np.bool_ else wrong
        if len(numbers):
            first, rows = int(numbers[0]), self._held.head.rows
            place = f"design {self._design[first]}" if first < rows else f"box {first - rows}"
            require(False, f"{place} {what}")


Int = NDArray[np.int64]
Shapes = list[tuple[int, ...]]

MAX_DENSE = 100_000_000
"""Most designs of a space that are marked one by one."""

_FEW = 64
_MOST_WORK = 200
HINT = "its front is not proved: write it again, hwsw explore … --certify FILE"


def require(holds: bool, what: str) -> None:
    """Refuse a certificate where something does not hold.

    Raises:
        CertificateError: it does not.
    """
    if not holds:
        raise CertificateError(what, hint=HINT)


def covered(certificate: Certificate) -> NDArray[np.int64]:
    """The number of designs of each entry, int64.

    Raises:
        CertificateError: a design of the space is in no entry, or in two.
    """
    head, columns = certificate.head, certificate.columns
    shapes = _parts(certificate.definition.axes, head.parts)
    ends = [0, *itertools.accumulate(map(math.prod, shapes))]
    require(ends[-1] <= MAX_SPACE, f"its space has more than {MAX_SPACE:,} designs")
    design, part, low, high = (columns[name].astype(np.int64) for name in ("design", "part", "low", "high"))
    require(bool(((design >= 0) & (design < ends[-1])).all()), "a design is outside the space")
    known = (part >= 0) & (part < len(shapes))
    sides = np.array(shapes, np.int64).reshape(len(shapes), low.shape[1])[np.where(known, part, 0)]
    known &= ((low >= 0) & (low < high) & (high <= sides)).all(axis=1)
    require(bool(known.all()), f"box {int(known.argmin())} is outside the space" if len(known) else "")
    dense = ends[-1] <= MAX_DENSE
    (_count_each if dense else _count_apart)(design, part, low, high, shapes, ends)
    return np.concatenate([np.ones(len(design), np.int64), (high - low).prod(axis=1)])


def _count_each(design: Int, part: Int, low: Int, high: Int, shapes: Shapes, ends: list[int]) -> None:
    """Mark every design of the space, each once."""
    taken = np.zeros(ends[-1], np.bool_)
    taken[design] = True
    require(int(taken.sum()) == len(design), "a design stands in two rows")
    for box, (own, first, last) in enumerate(zip(part.tolist(), low.tolist(), high.tolist(), strict=True)):
        inside = taken[ends[own] : ends[own + 1]].reshape(shapes[own])[tuple(map(slice, first, last))]
        require(not inside.any(), f"box {box} holds a design that another entry holds")
        inside[...] = True
    require(bool(taken.all()), f"design {int(taken.argmin())} is in no entry")


def _count_apart(design: Int, part: Int, low: Int, high: Int, shapes: Shapes, ends: list[int]) -> None:
    """Of a space that is too large to mark: entries that do not meet, and are as many designs as the space."""
    of_rows = np.searchsorted(np.array(ends[1:]), design, side="right")
    for own, shape in enumerate(shapes):
        rows = design[of_rows == own] - ends[own]
        places = np.stack(np.unravel_index(rows, shape), axis=1).astype(np.int64)
        first = np.concatenate([places, low[part == own]])
        last = np.concatenate([places + 1, high[part == own]])
        require(_apart(first, last), "two of its entries hold the same design")
        size = sum((last - first).prod(axis=1).tolist())
        require(size == math.prod(shape), f"{math.prod(shape) - size:,} designs of part {own} are in no entry")


def _apart(low: Int, high: Int) -> bool:
    """True if no two boxes meet. They are cut in two, again and again, until few are left to compare."""
    stack, work = [(low, high)], _MOST_WORK * (len(low) + 1)
    while stack:
        low, high = stack.pop()
        work -= len(low)
        require(work > 0, "its boxes lie too much across each other")
        if len(low) <= _FEW:
            apart = ((high[:, None] <= low) | (high <= low[:, None])).any(axis=2)
            if not (apart | np.eye(len(low), dtype=np.bool_)).all():
                return False
            continue
        begins = [np.unique(column) for column in low.T]
        if max(map(len, begins)) == 1:
            return False
        cuts = [own[len(own) // 2] for own in begins]
        larger = [
            max((low[:, axis] < cut).sum(), (high[:, axis] > cut).sum()) if len(begins[axis]) > 1 else len(low) + 1
            for axis, cut in enumerate(cuts)
        ]
        axis = int(np.argmin(larger))
        cut = cuts[axis]
        before, behind = low[:, axis] < cut, high[:, axis] > cut
        clipped = low[behind]
        clipped[:, axis] = np.maximum(clipped[:, axis], cut)
        stack += [(low[before], high[before]), (clipped, high[behind])]
    return True


def _parts(axes: list[Axis], parts: list[dict[str, list[int]]]) -> list[tuple[int, ...]]:
    """The shape of each part, with 1 for an axis that it lacks: together they are the space, each design once."""
    values = {axis.axis: set(range(len(axis.values))) for axis in axes}
    require(len(values) == len(axes), "an axis stands in it twice")
    conditions = [(other, set(held)) for axis in axes for other, held in axis.when.items()]
    known = all(held <= values.get(other, set()) for other, held in conditions)
    require(known, "an axis depends on values that there are not")
    cells, sets = 0, [{name: set(numbers) for name, numbers in part.items()} for part in parts]
    for part, chosen in zip(parts, sets, strict=True):
        sound = list(part) == [name for name in values if name in part] and all(
            own <= values[name] and len(own) == len(part[name]) > 0 for name, own in chosen.items()
        )
        for axis in axes:
            # It exists where all conditions hold: for every value of the part, or for none.
            holds = all(chosen.get(other, {-1}) <= set(held) for other, held in axis.when.items())
            fails = any(not chosen.get(other, set()) & set(held) for other, held in axis.when.items())
            sound = sound and (holds if axis.axis in part else fails)
        require(sound, "a part of its space does not follow from its axes")
        # Of the grid of all axes, a design is as many cells as the axes that it lacks have combinations.
        cells += math.prod(len(part.get(name, own)) for name, own in values.items())
    for one, other in itertools.combinations(sets, 2):
        apart = any(one[name].isdisjoint(other[name]) for name in one.keys() & other.keys())
        require(apart, "two parts of its space hold the same designs")
    require(cells == math.prod(map(len, values.values())), "its parts are not the whole space")
    return [tuple(len(part.get(name, [0])) for name in values) for part in parts]
