"""Points of a study against single runs: every figure, both ends of its interval, and the reasons, to the last bit."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from codesign.ground.errors import UnsuitedError
from codesign.ground.figures import FIGURES
from codesign.ground.progress import Show, silent, tracked
from codesign.ground.units import counted
from codesign.study.constraints import figure_of
from codesign.study.outcomes import State
from codesign.study.study import Study


@dataclass(frozen=True)
class Check:
    """The number of points that were run alone, and their differences from the study: one line each."""

    points: int
    differences: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """The outcome of the check.

        >>> Check(1000, ()).sentence
        '1,000 points were run alone: all figures equal'
        >>> Check(1, ("point 7: ...",)).sentence
        '1 point was run alone: 1 figure differs'
        """
        ran = f"{counted(self.points, 'point')} {'was' if self.points == 1 else 'were'} run alone"
        differ = f"{counted(len(self.differences), 'figure')} differ{'s' if len(self.differences) == 1 else ''}"
        return f"{ran}: {differ if self.differences else 'all figures equal'}"


def check_points(study: Study, count: int, seed: int = 0, *, show: Show = silent) -> Check:
    """Run random points of a study alone, at most ``count`` of those that were computed, and compare all figures.

    Raises:
        InputError: a file of the study has changed since. SpecError: a file is missing.
    """
    done = np.flatnonzero(study.outcomes.state == State.DONE).tolist()
    chosen = sorted(random.Random(seed).sample(done, min(count, len(done))))
    tracked_points = tracked(chosen, show, "points run alone", len(chosen))
    return Check(len(chosen), tuple(line for index in tracked_points for line in _differences(study, index)))


def _differences(study: Study, index: int) -> Iterator[str]:
    point, outcomes = study.points[index], study.outcomes
    try:
        # Without a memo: nothing is shared with any other point.
        alone = point.run()
    except UnsuitedError as wrong:
        if not any(reason.kind == "mapping" for reason in point.reasons):
            yield f"point {index}: alone, {wrong.faults[0].what}"
        return
    for figure in FIGURES.values():
        pairs = (
            ("", outcomes.value(figure, index), figure_of(alone, figure)),
            (" between its ends", outcomes.ends(figure, index), alone.interval(figure)),
        )
        for what, ours, its in pairs:
            if ours != its:
                yield f"point {index}: {figure.name}{what} is {ours!r} in the study, {its!r} alone"
    if point.reasons != alone.reasons:
        yield f"point {index}: it is out for other reasons alone"
