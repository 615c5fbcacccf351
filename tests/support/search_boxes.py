"""The boxes that branch and bound leaves out, against all designs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def check_boxes(every: Any, trace: Any) -> None:
    """Every design was evaluated or lies in a box, and each box keeps what it claims."""
    space = every.decisions
    levels = space.levels(np.arange(len(space)))
    covered = np.zeros(len(space), np.bool_)
    covered[trace.designs] = True
    for box in trace.excluded:
        inside = np.ones(len(space), np.bool_)
        for (axis, numbers), low, high in zip(space.parts[box.part].axes.items(), box.low, box.high, strict=True):
            inside &= np.isin(levels[axis], numbers[low:high])
        assert inside.sum() == box.designs
        covered |= inside
        feasible = np.flatnonzero(inside & every.judged.feasible)
        for name, bound in (box.bound or {}).items():
            figure = next(f for f in (*every.objectives, *(c.figure for c in every.constraints)) if f.name == name)
            assert (every.judged.figure(figure)[feasible] >= bound).all()
        if box.why == "dominated":
            assert box.by is not None
            ours = [every.designs[box.by].figure(figure) for figure in every.objectives]
            bounds = [box.bound.get(figure.name, -math.inf) for figure in every.objectives]
            assert all(own <= bound for own, bound in zip(ours, bounds, strict=True))
            assert any(own < bound for own, bound in zip(ours, bounds, strict=True))
        else:
            assert not len(feasible)
    assert covered.all()
