"""Pockets: free cells from which no path leads to a goal. Their values stay 0, so each is a local maximum for ever."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from codesign.planners.harmonic.plan.parameters import Pockets, RelaxParameters
from codesign.planners.interface import Problem


def sent_map(problem: Problem, parameters: RelaxParameters) -> NDArray[np.bool_]:
    """The free cells of the map as it is sent to the planner: bool, rows × columns.

    With ``pockets: filled`` the sender turns pockets into obstacles. No value of any other cell depends on that.
    """
    if parameters.pockets is Pockets.KEPT:
        return problem.free
    from codesign.maps.reach import reachable

    return reachable(problem.free, problem.goals)
