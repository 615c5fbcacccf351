"""The arguments of ``relax``, checked once, so that all modules below may rely on them, and what it reports."""

from __future__ import annotations

import itertools
import operator
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from codesign.ground.errors import InputError, MapError, choose_hint, outside_map
from codesign.planners.harmonic.plan.fixed_point import Field, limbs_needed
from codesign.planners.harmonic.plan.parameters import MAX_PRECISION, Termination


@dataclass(frozen=True)
class Stage:
    """The counts of one stage.

    Attributes:
        precision: fractional bits p.
        sweeps, visits, iterations: their numbers, over all blocks.
        local_maxima: free cells, goals left out, with no strictly greater neighbour at the end.
        promoted: the stage was left after a number of sweeps, before it settled.
    """

    precision: int
    sweeps: int
    visits: int
    iterations: int
    local_maxima: int
    promoted: bool = False

    @property
    def ends_a_run(self) -> bool:
        """True if a run that stops without local maxima stops here: the stage settled, and left none."""
        return self.local_maxima == 0 and not self.promoted

    @property
    def cycles(self) -> int:
        """Clock cycles of the iterations alone: p + 2 each (section 5.4), for any size of the block."""
        return self.iterations * (self.precision + 2)


@dataclass(frozen=True, eq=False)
class VisitBatch:
    """Consecutive visits of one stage, in order.

    Attributes:
        stage_index: index of the stage in the schedule, from 0.
        precision: fractional bits p.
        block: int32, index of the block in raster order.
        iterations: int32, iterations of each visit, 1..I.
    """

    stage_index: int
    precision: int
    block: NDArray[np.int32]
    iterations: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Visits:
    """Visits one by one, or the sums of the visits of each block: arrays of one length.

    ``block``: int32. ``iterations``: int64. ``count``: int64, how many visits. ``early``: int64, how many of them ended
    before their last iteration.
    """

    block: NDArray[np.int32]
    iterations: NDArray[np.int64]
    count: NDArray[np.int64]
    early: NDArray[np.int64]

    @classmethod
    def none(cls, blocks: int) -> Self:
        """The sums of no visits, for ``blocks`` blocks."""
        return cls(np.arange(blocks, dtype=np.int32), *np.zeros((3, blocks), np.int64))

    def add(self, batch: VisitBatch, most_iterations: int) -> None:
        """Add the visits of a batch to these sums. ``most_iterations``: of one visit."""
        blocks = len(self.block)
        self.iterations[:] += np.bincount(batch.block, batch.iterations, blocks).astype(np.int64)
        self.count[:] += np.bincount(batch.block, minlength=blocks)
        early = batch.block[batch.iterations < most_iterations]
        self.early[:] += np.bincount(early, minlength=blocks)


@dataclass(frozen=True, eq=False)
class StageEnd:
    """The end of a stage: its index in the schedule, its counts, and its field.

    ``fault``: the reason why the stage did not settle; empty where it did.
    """

    stage_index: int
    stage: Stage
    field: Field
    fault: str = ""


MAX_CELLS = 1 << 24
# Every block takes some kilobytes besides its cells.
MAX_BLOCKS = 1 << 16
MAX_ITERATIONS = (1 << 31) - 1


@dataclass(frozen=True, eq=False)
class Arguments:
    """Checked arguments of ``relax``.

    ``free``: bool, rows × columns, goals included. ``goals``: (row, column) pairs on free cells, each once.
    ``block``: rows and columns of a full block, cut to the map. ``schedule``: rising precisions. ``start``: a field at
    ``schedule[0]`` with goals at 2^p and obstacles at 0.
    """

    free: NDArray[np.bool_]
    goals: tuple[tuple[int, int], ...]
    block: tuple[int, int]
    iterations: int
    schedule: tuple[int, ...]
    termination: Termination
    start: Field

    @cached_property
    def movable(self) -> NDArray[np.bool_]:
        """The computed cells: free and no goal."""
        cells = self.free.copy()
        cells[tuple(np.array(self.goals).T)] = False
        return cells

    @cached_property
    def reachable(self) -> NDArray[np.bool_]:
        """The free cells from which some 4-connected path leads to a goal, goals included."""
        from scipy import ndimage

        labels, _ = ndimage.label(self.free)
        with_goal = np.unique(labels[tuple(np.array(self.goals).T)])
        return np.asarray(np.isin(labels, with_goal) & self.free)


def check_arguments(
    free: Any, goals: Any, *, block: Any, iterations: Any, schedule: Any, termination: Any, start: Any
) -> Arguments:
    """Check the arguments of ``relax``: MapError for an unusable map or goal, InputError for any other argument."""
    cells = _check_map(free)
    precisions = _check_schedule(schedule)
    goal_cells = _check_goals(goals, cells)
    return Arguments(
        free=cells,
        goals=goal_cells,
        block=_check_block(block, cells),
        iterations=_check_iterations(iterations),
        schedule=precisions,
        termination=_check_termination(termination),
        start=_check_start(start, cells, goal_cells, precisions[0]),
    )


def _whole_number(value: Any, where: str) -> int:
    try:
        return operator.index(value)
    except TypeError:
        raise InputError(f"{value!r} is not a whole number", where) from None


def _check_map(free: Any) -> NDArray[np.bool_]:
    array = np.asarray(free)
    if array.ndim != 2:
        raise MapError(f"the map has {array.ndim} dimensions, not 2", "free", "give a bool array, rows × columns")
    if array.size == 0:
        raise MapError(f"the map is empty: {array.shape[0]} × {array.shape[1]} cells", "free")
    if array.size > MAX_CELLS:
        what = f"the map has {array.shape[0]} × {array.shape[1]} cells, more than {MAX_CELLS}"
        raise MapError(what, "free", "use a coarser map, or a part of it")
    if array.dtype != np.bool_ and not (array.dtype.kind in "iu" and np.isin(array, (0, 1)).all()):
        raise MapError(f"the map holds {array.dtype}, not bool", "free", "True for free cells, False for obstacles")
    return array.astype(np.bool_)


def _check_goals(goals: Any, free: NDArray[np.bool_]) -> tuple[tuple[int, int], ...]:
    if not isinstance(goals, Iterable):
        raise MapError(f"goals {goals!r} are not a list of (row, column) pairs", "goals")
    rows, columns = free.shape
    cells: dict[tuple[int, int], None] = {}
    for goal in goals:
        if not isinstance(goal, Sequence | np.ndarray) or len(goal) != 2:
            raise MapError(f"goal {goal!r} is not a (row, column) pair", "goals")
        row, column = (_whole_number(index, "goals") for index in goal)
        if not (0 <= row < rows and 0 <= column < columns):
            what, hint = outside_map((row, column), free.shape, "goal")
            raise MapError(what, "goals", hint)
        if not free[row, column]:
            raise MapError(f"goal ({row}, {column}) is on an obstacle", "goals", "move the goal to a free cell")
        cells[row, column] = None
    if not cells:
        raise MapError("no goal is given", "goals", "give at least one (row, column) on a free cell")
    return tuple(cells)


def _check_block(block: Any, free: NDArray[np.bool_]) -> tuple[int, int]:
    if not isinstance(block, Sequence | np.ndarray) or len(block) != 2:
        raise InputError(f"block {block!r} is not a (rows, columns) pair", "block")
    height, width = (_whole_number(side, "block") for side in block)
    rows, columns = free.shape
    if height < 1 or width < 1:
        raise InputError(f"block of {height} × {width} nodes has no nodes", "block")
    # All nodes beyond the map are obstacles; nothing is computed for them.
    height, width = min(height, rows), min(width, columns)
    blocks = -(-rows // height) * -(-columns // width)
    if blocks > MAX_BLOCKS:
        raise InputError(
            f"{blocks} blocks of {height} × {width} nodes are more than {MAX_BLOCKS}", "block", "use larger blocks"
        )
    return height, width


def _check_iterations(iterations: Any) -> int:
    count = _whole_number(iterations, "iterations")
    if not 1 <= count <= MAX_ITERATIONS:
        raise InputError(f"{count} iterations a visit is outside 1..{MAX_ITERATIONS}", "iterations")
    return count


def _check_schedule(schedule: Any) -> tuple[int, ...]:
    if not isinstance(schedule, Sequence | np.ndarray | range) or isinstance(schedule, str):
        raise InputError(f"schedule {schedule!r} is not a list of precisions", "schedule")
    precisions = tuple(_whole_number(precision, "schedule") for precision in schedule)
    if not precisions:
        raise InputError("the schedule is empty", "schedule", "give at least one precision, in bits")
    for precision in precisions:
        if not 1 <= precision <= MAX_PRECISION:
            raise InputError(f"precision {precision} is outside 1..{MAX_PRECISION} bits", "schedule")
    for earlier, later in itertools.pairwise(precisions):
        if later <= earlier:
            raise InputError(f"precision {later} follows {earlier}", "schedule", "precisions rise from stage to stage")
    return precisions


def _check_termination(termination: Any) -> Termination:
    words = [word.value for word in Termination]
    if not isinstance(termination, str) or termination not in words:
        raise InputError(f"termination {termination!r} is unknown", "termination", choose_hint(str(termination), words))
    return Termination(termination)


def _check_start(start: Any, free: NDArray[np.bool_], goals: tuple[tuple[int, int], ...], precision: int) -> Field:
    if start is None:
        start = Field(np.zeros((*free.shape, limbs_needed(precision)), np.uint64), precision)
    field = start if isinstance(start, Field) else Field.from_ints(start, precision)
    if field.shape != free.shape:
        raise InputError(f"start of {field.shape} values for a map of {free.shape} cells", "start")
    shifted = field.shifted(precision)
    # A field of the same precision belongs to the caller.
    limbs = shifted.limbs.copy() if shifted is field else shifted.limbs
    limbs.flags.writeable = True
    limbs[~free] = 0
    rows, columns = np.array(goals).T
    limbs[rows, columns] = 0
    limbs[rows, columns, precision // 64] = np.uint64(1 << precision % 64)
    return Field(limbs, precision)
