"""The best precision schedule of a map, exactly.

Under sound termination a converged stage leaves the least fixed point of its precision, from any start. So the cost of
a stage depends on its first and last precision alone, and the cost of a schedule is the sum over its stages. The best
of all 2^(n-1) schedules through n precisions is a shortest path. The search takes at most n(n+1)/2 stages; it simulates
a stage only when it reaches its start.

The termination test of the paper can end a stage with wrong cells. They depend on the stages before, so costs do not
add up, and there is no such search.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from codesign.errors import InputError
from codesign.memo import Memo

if TYPE_CHECKING:
    from codesign.planners.harmonic.plan import Field, Stage
    from codesign.planners.harmonic.plan.parameters import RelaxParameters
    from codesign.planners.interface import Problem

_END = -1


@dataclass(frozen=True)
class Schedule:
    """Precisions in order, and the sum of the costs of their stages."""

    precisions: tuple[int, ...]
    cost: int


def best_schedule(
    stage_cost: Callable[[int | None, int], int],
    candidates: Iterable[int],
    last: int,
    ends: Callable[[int], bool] = lambda _: False,
) -> Schedule:
    """The cheapest rising schedule that ends at ``last``; among equals, one with the fewest stages.

    Args:
        stage_cost: cost ≥ 0 of a stage, from a precision (None: from zero) to a higher one. Called at most once for
            each pair.
        candidates: the precisions that may come before ``last``; those not below it are left out.
        last: fractional bits of the last stage.
        ends: whether a run would end after a stage at this precision. Called only after ``stage_cost`` of a stage to
            this precision. A schedule that reaches such a precision ends there.

    Raises:
        InputError: a precision below 1.

    >>> best_schedule(lambda begin, end: (end - (begin or 0)) ** 2, range(1, 9), 9).cost
    9
    """
    import networkx

    rungs = sorted({precision for precision in candidates if precision < last} | {last})
    if rungs[0] < 1:
        raise InputError(f"a precision of {rungs[0]} bits", "candidates", "precisions start at 1")
    graph = networkx.DiGraph()
    graph.add_edges_from((0, precision) for precision in rungs)
    graph.add_edges_from((low, high) for low in rungs for high in rungs if low < high)
    graph.add_edges_from((precision, _END) for precision in rungs)

    # The scale makes the cost decide first; among equal costs each stage counts one.
    scale = len(rungs) + 1
    over: dict[int, bool] = {}

    def weight(begin: int, end: int, _: object) -> int | None:
        if begin and begin not in over:
            over[begin] = begin == last or ends(begin)
        if end == _END:
            return 0 if over[begin] else None
        if begin and over[begin]:
            return None
        return stage_cost(begin or None, end) * scale + 1

    total, path = networkx.single_source_dijkstra(graph, 0, _END, weight=weight)
    return Schedule(tuple(path[1:-1]), total // scale)


def optimise_schedule(
    problem: Problem,
    parameters: RelaxParameters,
    candidates: Iterable[int],
    memo: Memo | None = None,
    cycles: Callable[[Stage], int] = lambda stage: stage.cycles,
) -> Schedule:
    """The schedule of fewest cycles for a problem.

    It ends at the last precision of ``parameters``, or, where they stop the run at the first stage without local
    maxima, at any precision that leaves none. The search simulates every stage that it needs, bit for bit.
    The last precision of a run may depend on the schedule; the field at a precision never does.

    Args:
        problem: map and goals.
        parameters: partition, iterations, when the run stops, and the last precision; its schedule is not
            used otherwise.
        candidates: precisions that may come before the last.
        memo: keeps stages and fields for searches that share them.
        cycles: the cost of a stage, for example with the cycles of switching blocks; iterations × (p + 2) by default.

    Raises:
        InputError: termination is not sound, or a precision is below 1.
    """
    from codesign.planners.harmonic.plan.parameters import Stop, Termination

    if parameters.termination is not Termination.SOUND:
        raise InputError(
            f"termination {parameters.termination.value}: costs of stages do not add up over a schedule",
            "termination",
            "the best schedule can be found for termination: sound",
        )
    stages = _Stages(problem, parameters, Memo() if memo is None else memo)
    stops = parameters.stop is Stop.FIRST_WITHOUT_LOCAL_MAXIMA
    return best_schedule(
        lambda begin, end: cycles(stages.between(begin, end)),
        candidates,
        parameters.precisions[-1],
        lambda precision: stops and stages.local_maxima[precision] == 0,
    )


class _Stages:
    """The stages of a problem between any two precisions, each simulated once.

    ``local_maxima``: of the least field, at every precision with a simulated stage.
    """

    def __init__(self, problem: Problem, parameters: RelaxParameters, memo: Memo) -> None:
        from codesign.planners.harmonic.plan.pockets import sent_map

        self._problem, self._pockets = problem, parameters.pockets
        self._free = sent_map(problem, parameters)
        self._memo = memo
        self._block = parameters.block_shape(*problem.shape)
        self._iterations = parameters.iterations
        self.local_maxima: dict[int, int] = {}

    def between(self, begin: int | None, end: int) -> Stage:
        """The stage from one precision (None: from zero) to another."""
        key = ("stage", self._problem.digest, self._pockets, self._block, self._iterations, begin, end)
        stage = self._memo.get(key, lambda: self._simulated(begin, end))
        self.local_maxima[end] = stage.local_maxima
        return stage

    def _simulated(self, begin: int | None, end: int) -> Stage:
        stage, field = self._run(begin, end)
        self._memo.get(("least field", self._problem.digest, end), lambda: field)
        return stage

    def _field(self, precision: int) -> Field:
        # A stage to this precision ran before. Where the memo had no room, the field is computed again from zero.
        key = ("least field", self._problem.digest, precision)
        return self._memo.get(key, lambda: self._run(None, precision)[1])

    def _run(self, begin: int | None, end: int) -> tuple[Stage, Field]:
        from codesign.planners.harmonic.plan.relax import stage_cost

        return stage_cost(
            self._free,
            self._problem.goals,
            None if begin is None else self._field(begin),
            end,
            block=self._block,
            iterations=self._iterations,
        )
