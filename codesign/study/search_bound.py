"""Branch and bound: evaluates designs until no other design can be on the front, and says why of each."""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError
from codesign.study.bounds import Family, OpenFamily, Places
from codesign.study.constraints import Floats
from codesign.study.front import non_dominated
from codesign.study.search import Problem, comparable
from codesign.study.space import Box

_PARTS = 16
_PUT_OFF = 4096


@dataclass(order=True)
class _OpenBox:
    """Designs of a family from ``low`` to ``last`` on its monotone axes, which are not settled.

    ``costs``: a bound below each objective, negated where more is better. ``score``: a weighted sum of them.
    """

    score: float
    number: int
    family: OpenFamily = field(compare=False)
    low: Places = field(compare=False)
    last: Places = field(compare=False)
    costs: Floats = field(compare=False)

    @property
    def traded(self) -> NDArray[np.bool_]:
        """The axes on which the fastest design is not the best."""
        return np.array(self.family.family.traded, np.bool_)

    @property
    def is_single(self) -> bool:
        """True if it is one design."""
        return bool((self.low == self.last).all())


class BoundSearch:
    """Proves the front: every design is evaluated, or is in a box that was excluded.

    A family is opened with its slowest design: where that does not fit, or its clock is above the limit, so is all of
    the family. Of the boxes of all families the one with the least score is taken first (Papadias, Tao, Fu and Seeger,
    SIGMOD 2003): what dominates a box has a lesser score, so it mostly comes before it. A box is excluded if an
    evaluated design dominates its bound, strictly better in one objective, or if its bound breaks a constraint. Else
    it is cut on its longest axis, and its fastest design is evaluated once no axis of it is a matter of trade. Where no
    laws bound a family, all of its designs are evaluated.

    - ``excluded``: see ``Box``. ``complete``: whether all designs were evaluated or excluded.
    """

    name = "bound"
    batch = 64
    endless = False
    repeated = 0

    def __init__(self, problem: Problem) -> None:
        if problem.bounds is None:
            what = "no laws bound points that are computed by a function of your own"
            raise InputError(what, "search", "use nsga2, tpe or random")
        self.excluded: list[Box] = []
        self.complete = False
        self._bounds, self._problem = problem.bounds, problem
        self._signs = np.where(problem.maximise, -1.0, 1.0)
        self._weights: Floats | None = None
        self._coming = self._bounds.families()
        self._opening: list[Family] = []
        self._unbounded: Iterator[int] = iter(())
        self._boxes: list[_OpenBox] = []
        self._numbers = itertools.count()
        self._archives: dict[str, _Archive] = {}
        self._asked: set[int] = set()
        self._task: dict[int, str] = {}

    def ask(self, count: int) -> list[int]:
        """The next designs; empty where the front is proved."""
        # The first batch opens families alone: their designs say how much of each objective is much.
        asked = self._pilots(count if self._weights is None else -(-count // 2))
        asked += itertools.islice(self._unbounded, count - len(asked))
        asked += self._best(count - len(asked))
        asked += self._pilots(count - len(asked))
        self.complete = not asked
        return asked

    def tell(self, designs: Sequence[int], objectives: Floats, excess: Floats) -> None:
        """Keep the designs that dominate others, and open the families of which the slowest design is told."""
        fine = comparable(objectives, excess)
        costs = objectives * self._signs
        if self._weights is None:
            known = costs[fine] if fine.any() else np.ones((1, costs.shape[1]))
            typical = np.abs(np.median(known, axis=0))
            self._weights = 1 / np.where(typical > 0, typical, 1.0)
        for family in self._opening:
            self._open(family)
        self._opening = []
        for place in np.flatnonzero(fine).tolist():
            if (task := self._task.get(designs[place])) is not None:
                self._archive(task).add(designs[place], costs[place])
        for archive in self._archives.values():
            archive.settle()

    def _take(self, design: int) -> int:
        self._asked.add(design)
        return design

    def _archive(self, task: str) -> _Archive:
        if task not in self._archives:
            self._archives[task] = _Archive(len(self._signs))
        return self._archives[task]

    def _pilots(self, room: int) -> list[int]:
        """The slowest designs of some more families."""
        families = list(itertools.islice(self._coming, room))
        self._opening += families
        return [self._take(self._bounds.design(each.part, each.at(each.slowest))) for each in families]

    def _open(self, family: Family) -> None:
        """Put in the boxes of a family."""
        opened = self._bounds.open(family)
        low = np.zeros((1, len(family.sizes)), np.int64)
        last = np.array([family.sizes], np.int64).reshape(1, -1) - 1
        if opened is None:
            self._unbounded = itertools.chain(self._unbounded, self._rest(family))
        elif opened.out or opened.lacks:
            self._exclude(family, low[0], last[0], opened.out or f"lacks {opened.lacks}")
        else:
            self._task[self._bounds.design(family.part, family.at(family.slowest))] = opened.task
            low, last = self._below_limits(opened, low, last)
            self._put(opened, low, last)

    def _rest(self, family: Family) -> Iterator[int]:
        """All designs of a family but the slowest one."""
        for own in itertools.product(*map(range, family.sizes)):
            if own != family.slowest:
                yield self._take(self._bounds.design(family.part, family.at(own)))

    def _best(self, room: int) -> list[int]:
        """The best designs that no evaluated design dominates, nor the bound of one of them another."""
        asked: list[int] = []
        picked = _Archive(len(self._signs))
        put_off: list[_OpenBox] = []
        while self._boxes and len(asked) < room and len(put_off) < _PUT_OFF:
            box = heapq.heappop(self._boxes)
            if self._is_dominated(box):
                continue
            design = self._corner(box)
            if design not in self._asked and not (box.low < box.last)[box.traded].any():
                if picked.dominating(box.costs) >= 0:
                    put_off.append(box)
                    continue
                picked.costs = np.vstack([picked.costs, box.costs])
                picked.designs.append(design)
                self._task[design] = box.family.task
                asked.append(self._take(design))
                # What is left of the box is looked at when this design is known.
                put_off.append(box)
            elif not box.is_single:
                self._split(box)
        for box in put_off:
            heapq.heappush(self._boxes, box)
        return asked

    def _corner(self, box: _OpenBox) -> int:
        """The fastest design of a box."""
        family = box.family.family
        fast, _ = family.corners(box.low[None], box.last[None])
        return self._bounds.design(family.part, family.at(fast[0].tolist()))

    def _is_dominated(self, box: _OpenBox) -> bool:
        """True if an evaluated design dominates a box, which is then excluded."""
        archive = self._archive(box.family.task)
        number = archive.dominating(box.costs)
        if number < 0:
            return False
        values = zip(self._problem.objectives, (box.costs * self._signs).tolist(), strict=True)
        bound = {name: value for name, value in values if math.isfinite(value)}
        self._exclude(box.family.family, box.low, box.last, "dominated", bound, archive.designs[number])
        return True

    def _split(self, box: _OpenBox) -> None:
        """Cut a box on its longest axis, on one that is traded before any other."""
        sizes = np.where(box.traded, box.last - box.low + 1, 1)
        sizes = sizes if sizes.max(initial=1) > 1 else box.last - box.low + 1
        axis = int(sizes.argmax())
        # Part i has the places cuts[i] to cuts[i + 1] - 1 on that axis, and all places of the box on the others.
        cuts = np.linspace(box.low[axis], box.last[axis] + 1, min(_PARTS, int(sizes[axis])) + 1).astype(np.int64)
        low, last = (np.repeat(each[None], len(cuts) - 1, axis=0) for each in (box.low, box.last))
        low[:, axis], last[:, axis] = cuts[:-1], cuts[1:] - 1
        self._put(box.family, low, last, box.costs)

    def _put(self, family: OpenFamily, low: Places, last: Places, above: Floats | None = None) -> None:
        """Put in boxes, with bounds no less than the bounds of the boxes that they are parts of."""
        costs = family.costs(low, last)
        costs = costs if above is None else np.maximum(costs, above)
        left = np.ones(len(low), np.bool_)
        for constraint, figure, box, value in family.broken(low, last):
            if left[box]:
                left[box] = False
                self._exclude(family.family, low[box], last[box], f"constraint {constraint}", {figure: value})
        assert self._weights is not None, "families are opened after a first design was told"
        scores = costs @ self._weights
        for place in np.flatnonzero(left).tolist():
            number = next(self._numbers)
            heapq.heappush(
                self._boxes, _OpenBox(float(scores[place]), number, family, low[place], last[place], costs[place])
            )

    def _below_limits(self, family: OpenFamily, low: Places, last: Places) -> tuple[Places, Places]:
        """The box without the clocks that are above their limits, which are excluded."""
        low, last = low.copy(), last.copy()
        for axis, place in enumerate(family.fastest_allowed()):
            out_low, out_last = low[0].copy(), last[0].copy()
            if family.family.rising[axis]:
                out_low[axis], last[0, axis] = place + 1, place
            else:
                out_last[axis], low[0, axis] = place - 1, place
            if out_low[axis] <= out_last[axis]:
                self._exclude(family.family, out_low, out_last, "clock")
        return low, last

    def _exclude(
        self,
        family: Family,
        low: Places,
        last: Places,
        why: str,
        bound: dict[str, float] | None = None,
        by: int | None = None,
    ) -> None:
        begin, end = family.at(low.tolist()), family.at(last.tolist())
        past = tuple(place + 1 for place in end)
        self.excluded.append(Box(family.part, begin, past, bound, by, why))


class _Archive:
    """The designs of one task that no other one dominates: ``designs``, and ``costs``, designs × objectives."""

    def __init__(self, objectives: int) -> None:
        self.designs: list[int] = []
        self.costs: Floats = np.empty((0, objectives))
        self._new: list[Floats] = []

    def add(self, design: int, costs: Floats) -> None:
        """One more design; it counts after ``settle``."""
        self.designs.append(design)
        self._new.append(costs)

    def settle(self) -> None:
        """Keep the designs that none dominates."""
        if self._new:
            costs = np.vstack([self.costs, *self._new])
            kept = non_dominated(costs, np.zeros(costs.shape[1], np.bool_))
            self.costs, self._new = costs[kept], []
            self.designs = [design for design, keep in zip(self.designs, kept, strict=True) if keep]

    def dominating(self, costs: Floats) -> int:
        """The number of a design that dominates a bound; -1: none does."""
        no_worse = (self.costs <= costs).all(axis=1)
        numbers: NDArray[np.intp] = np.flatnonzero(no_worse)
        better = (self.costs[numbers] < costs).any(axis=1)
        return int(numbers[better.argmax()]) if better.any() else -1
