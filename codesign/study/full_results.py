"""The full results of points: kept ones as they are, and priced points simulated when they are asked for."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable

from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES
from codesign.ground.memo import Memo
from codesign.inputs import Platform, Workload
from codesign.inputs.constraint import Constraint
from codesign.maps import OccupancyGrid
from codesign.study.constraints import with_constraints
from codesign.study.outcomes import Outcomes, State
from codesign.study.pricing.price import PRICED
from codesign.system.results.result import Result
from codesign.system.scenarios import simulate

_MOST_HELD = 256


class FullResults:
    """The full results of points by index. The last ones that were simulated are held.

    ``limits``: the constraints that each point is held to. ``specs``: of a point, for ``simulate``.
    """

    def __init__(
        self,
        outcomes: Outcomes,
        limits: tuple[Constraint, ...],
        specs: Callable[[int], tuple[Platform, Workload, OccupancyGrid | None]],
    ) -> None:
        self._outcomes, self._limits, self._specs, self._memo = outcomes, limits, specs, Memo()
        self._held: OrderedDict[int, Result] = OrderedDict()

    def __getitem__(self, index: int) -> Result | None:
        """The full result of a point, with a reason for each limit that it does not keep.

        Raises:
            InputError: it has to be simulated, and is of no exploration, or comes to other figures by now.
            SpecError: a file is missing.
        """
        outcomes = self._outcomes
        if outcomes.state[index] != State.DONE:
            return None
        number = int(outcomes.which[index])
        result = outcomes.templates[number] if number in outcomes.whole else self._simulated(index)
        return with_constraints(result, self._limits)

    def _simulated(self, index: int) -> Result:
        if index not in self._held:
            platform, workload, grid = self._specs(index)
            result = simulate(platform, workload, memo=self._memo, grid=grid)
            moved = [
                FIGURES[name].label
                for name in PRICED
                if result.figure(FIGURES[name]) != self._outcomes.value(FIGURES[name], index)
            ]
            if moved:
                raise InputError(
                    f"point {index} has another {' and another '.join(moved)} now than in the study",
                    hint="other code computed the study: run hwsw explore again",
                )
            self._held[index] = result
            if len(self._held) > _MOST_HELD:
                self._held.popitem(last=False)
        self._held.move_to_end(index)
        return self._held[index]
