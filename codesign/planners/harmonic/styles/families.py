"""Blocks of every shape in families, with a lower bound of their cycles.

Let J_k be the field after k iterations of the whole map as one block, from zero. An iteration of a block sets its cells
to what J_(k + 1) has, or less, if no value is above J_k, as an update is monotone; the others stay. So after k
iterations, of any blocks in any order, no value is above J_k. A stage therefore takes as many iterations that change
a bit as the one block does. In its last sweep each block has one more, which changes none.

The field of a stage depends on nothing but its bits. All schedules here have the same first stages, up to the one that
may be the last: the first whose field leads somewhere from the starts. The iterations of the one block in these stages
bound the cycles of every design that serves.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from codesign.ground.late import late
from codesign.ground.memo import Memo
from codesign.ground.models import Part
from codesign.planners.harmonic.plan.arguments import check_arguments
from codesign.planners.harmonic.styles import resources, timing
from codesign.planners.harmonic.styles.designs import (
    FIRST,
    LAST,
    STEP,
    VISITS,
    block_chain,
    block_designs,
    lasts_of,
    machine,
)
from codesign.planners.interface import Cell, Problem
from codesign.planners.styles import Family, Sides, side_classes

engines = late("codesign.planners.harmonic.plan.engine")

_settled = Memo(max_bytes=2**20)

Parts = Callable[[], Iterator[Family]]
Given = AbstractSet[tuple[int, ...]]

NAMES = "block rows", "block columns"
"""The ranges of a family."""

QUICK = 4096
"""Cycles of iterations that are computed for the bound of every family; a sharper bound computes what it needs."""


def least_stages(problem: Problem, most_cycles: int) -> tuple[tuple[int, int], ...]:
    """The first stages of the whole map as one block: their bits, and the iterations they take to settle.

    Every design that serves has these stages: as long as all values around a start are 0, a plan has no way from there,
    and its start is a local maximum, so the run goes on. The last stage has only the iterations so far, where all take
    more than ``most_cycles`` cycles of the bit-serial circuit.
    """
    key = "harmonic stages", problem.map_digest, problem.starts
    computed, stages = _settled.held(key) or (0, ())
    if computed < most_cycles:
        # A later question about more cycles begins anew, and so it is answered for twice as many.
        computed = 1 << (most_cycles - 1).bit_length()
        stages, ended = _stages(problem, computed)
        _settled.keep(key, (1 << 62 if ended else computed, stages))
    return tuple(stages)


def _stages(problem: Problem, most_cycles: int) -> tuple[tuple[tuple[int, int], ...], bool]:
    arguments = check_arguments(
        problem.free, problem.goals, block=problem.shape, iterations=1, schedule=LAST, termination="sound", start=None
    )
    engine, left = engines.Engine(arguments), most_cycles
    stages: list[tuple[int, int]] = []
    for precision in range(FIRST, LAST[-1] + 1, STEP):
        each = timing.iteration_cycles(precision)
        *_, end = engine.run(len(stages), precision, left // each + 1)
        stages.append((precision, end.stage.iterations))
        left -= each * end.stage.iterations
        if end.fault or not any(_is_dark(end.field.limbs, start) for start in problem.starts):
            return tuple(stages), not end.fault
    return tuple(stages), True


def _is_dark(limbs: NDArray[np.uint64], start: Cell) -> bool:
    """True if the values of a cell and of its eight neighbours are 0."""
    row, column = start
    return not limbs[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2].any()


@dataclass(frozen=True)
class BlockSpace:
    """All blocks of a map on a part, with the decision module or without.

    ``warm``: a plan begins at the result of task ``lower_bound``, so no iteration of the first stage is sure.
    """

    problem: Problem
    part: Part
    decides: bool
    warm: bool

    def families(self) -> Iterator[Family]:
        """The chains that are most promising, then all other blocks as one family."""
        designs = block_designs(self.problem.shape, self.part, self.decides)
        given = {tuple(chain[0]["block"]) for chain in designs}
        for chain in designs:
            height, width = chain[0]["block"]
            yield self._family(chain, (height, height), (width, width), len(chain))
        rows, columns = (side_classes(side) for side in self.problem.shape)
        classes = [(down, served) for down in rows if (served := [each for each in columns if self._count(down, each)])]
        count = sum(self._count(down, across, given) for down, served in classes for across in served)

        def sharper(most_cycles: int) -> Mapping[str, int]:
            return {"": self.least_cycles(most_cycles)}

        if count:
            yield Family(
                chain=(),
                units={"": self.least_cycles(QUICK)},
                ranges={name: (1, side) for name, side in zip(NAMES, self.problem.shape, strict=True)},
                count=count,
                least=self._least((1, 1)),
                clock_alone=True,
                sharper=None if self.warm else sharper,
                parts=partial(self._classes, classes, given),
            )

    def _classes(self, classes: Sequence[tuple[Sides, Sequence[Sides]]], given: Given) -> Iterator[Family]:
        """The classes of blocks that were not ``given``, and last those that cannot fit."""
        unfit = []
        for down, served in classes:
            fitting = self._fitting(down[0], served)
            for across in served[:fitting]:
                count = self._count(down, across, given)
                if count:
                    yield self._family((), down, across, count, partial(self._chains, down, across, given))
            if fitting < len(served):
                unfit.append((down, served[fitting:]))
        for down, beyond in unfit:
            count = sum(self._count(down, across, given) for across in beyond)
            chain = (self._least((down[0], beyond[0][0])),)
            yield self._family(chain, down, (beyond[0][0], beyond[-1][1]), count)

    def _chains(self, down: Sides, across: Sides, given: Given) -> Iterator[Family]:
        for shape in product(range(down[0], down[1] + 1), range(across[0], across[1] + 1)):
            for iterations in VISITS if shape not in given else ():
                chain = block_chain(shape, iterations, self._lasts(shape))
                yield self._family(chain, (shape[0], shape[0]), (shape[1], shape[1]), len(chain))

    def _count(self, down: Sides, across: Sides, given: Given = frozenset()) -> int:
        """The designs of a class, as many for each of its blocks."""
        inside = sum(down[0] <= row <= down[1] and across[0] <= column <= across[1] for row, column in given)
        blocks = (down[1] - down[0] + 1) * (across[1] - across[0] + 1) - inside
        return blocks * len(VISITS) * len(self._lasts((down[0], across[0])))

    def _family(
        self, chain: tuple[Mapping[str, Any], ...], rows: Sides, columns: Sides, count: int, parts: Parts | None = None
    ) -> Family:
        least = rows[0], columns[0]

        def sharper(most_cycles: int) -> Mapping[str, int]:
            return {"": self.cycles(least, most_cycles)}

        ranges = dict(zip(NAMES, (rows, columns), strict=True))
        units = {"": self.cycles(least, QUICK)}
        sharp = None if self.warm else sharper
        return Family(chain, units, ranges, count, self._least(least), sharper=sharp, parts=parts)

    def cycles(self, block: tuple[int, int], most_cycles: int) -> int:
        """Cycles that no design of a block that serves undercuts, nor of a larger one with as many blocks."""
        grid = [-(-cells // side) for cells, side in zip(self.problem.shape, block, strict=True)]
        return self._cycles(resources.memories(*block, *grid), grid[0] * grid[1], block, most_cycles)

    def least_cycles(self, most_cycles: int) -> int:
        """Cycles that no design of any block that serves undercuts: the memories of all blocks hold the map."""
        rows, columns = self.problem.shape
        return self._cycles(-(-rows * columns // resources.RAM_WIDTH), 1, (1, 1), most_cycles)

    def _cycles(self, memories: int, blocks: int, block: tuple[int, int], most_cycles: int) -> int:
        stages: tuple[tuple[int, int], ...] = ((FIRST, 1),)
        load = timing.load_start_cycles(memories, blocks, FIRST)
        if not self.warm:
            stages, load = least_stages(self.problem, most_cycles), timing.load_cycles(memories, blocks, FIRST)
        passes = sum((count - 1 + blocks) * timing.iteration_cycles(bits) for bits, count in stages)
        last = stages[-1][0]
        end = timing.decision_cycles(last) if self.decides else timing.read_cycles(*block, blocks, last)
        return load + passes + end

    def _least(self, block: tuple[int, int]) -> Mapping[str, Any]:
        return block_chain(block, VISITS[0], [FIRST])[0]

    def _lasts(self, block: tuple[int, int]) -> list[int]:
        return lasts_of(self.problem.shape, block, self.part)

    def _may_fit(self, block: tuple[int, int]) -> bool:
        """A map of this one block has the fewest memories at its borders."""
        return resources.fits(machine(block, block, FIRST, self.decides), self.part)

    def _fitting(self, height: int, served: Sequence[Sides]) -> int:
        """The number of these columns that may fit: behind the first that cannot, none can."""
        return bisect_left(served, True, key=lambda across: not self._may_fit((height, across[0])))
