"""The full results of points: kept ones as they are, those of priced points simulated when they are asked for."""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING

from codesign.errors import InputError
from codesign.exploration.constraints import with_constraints
from codesign.exploration.outcomes import State
from codesign.figures import FIGURES
from codesign.memo import Memo
from codesign.pricing.price import PRICED
from codesign.results.result import Result
from codesign.scenarios import simulate

if TYPE_CHECKING:
    from codesign.exploration.study import Study

_MOST_HELD = 256


class FullResults:
    """The full results of the points of a study by index. The last ones that were simulated are held."""

    def __init__(self, study: Study) -> None:
        self._study, self._memo = study, Memo()
        self._held: OrderedDict[int, Result] = OrderedDict()

    def __getitem__(self, index: int) -> Result | None:
        """The full result of a point, with the constraints that a study without conditions holds it to.

        Raises:
            InputError: it has to be simulated, and is of no exploration, or comes to other figures by now.
            SpecError: a file is missing.
        """
        outcomes = self._study.outcomes
        if outcomes.state[index] != State.DONE:
            return None
        number = int(outcomes.which[index])
        result = outcomes.templates[number] if number in outcomes.whole else self._simulated(index)
        return result if self._study.conditions else with_constraints(result, self._study.constraints)

    def _simulated(self, index: int) -> Result:
        if index not in self._held:
            platform, workload, grid = self._study.points[index].specs_on_its_map()
            result = simulate(platform, workload, memo=self._memo, grid=grid)
            moved = [
                FIGURES[name].label
                for name in PRICED
                if result.figure(FIGURES[name]) != self._study.outcomes.value(FIGURES[name], index)
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
