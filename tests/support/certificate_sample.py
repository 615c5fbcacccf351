"""A study and boxes with every kind of claim that a certificate makes."""

from __future__ import annotations

from random import Random
from typing import Any

from explore_fakes import result

from codesign.ground.figures import FIGURES
from codesign.inputs.constraint import constraint_of
from codesign.study.outcomes import Outcomes
from codesign.study.space import Box
from codesign.study.study import Study

OBJECTIVES = tuple(FIGURES[name] for name in ("first_plan_s", "slices", "path_length_ratio_mean"))


def sample(seed: int = 0) -> tuple[Study, list[Box]]:
    """A study with every kind of claim but the same designs, and boxes in a space with two parts."""
    rng = Random(seed)
    outcomes: list[Any] = [
        result(seconds=1, slices=50, path=1.5), result(seconds=5, slices=10, path=1.5), result(path=None, slices=40),
        result(seconds=9, slices=90), "failed", result(slices=120, fits=False), result(slices=140, fits=False), None,
    ]  # fmt: skip
    outcomes += [
        result(seconds=rng.randint(2, 9), slices=rng.randint(20, 60), path=rng.choice([1.5, 1.7, 2.0]))
        for _ in range(40)
    ]
    outcomes += [None] * 24
    axes = {"a.b": (0, 1), "a.c": tuple(range(6)), "a.d": (0, 1, 2, 3), "a.e": (0, 1)}
    when = {"a.e": {"a.b": (1,)}}
    limits = (constraint_of("slices <= 80"), constraint_of("slices < 95 %"))
    study = Study("bench", "maze", axes, OBJECTIVES, limits, Outcomes.of(outcomes), when=when)
    at_best = {"first_plan_s": 2.0, "slices": 51.0, "path_length_ratio_mean": 1.5}
    excluded = [
        Box(1, (0, 3, 0, 0), (1, 6, 2, 2), at_best, 0, "dominated"),
        Box(1, (0, 3, 2, 0), (1, 5, 4, 2), {"slices": 99.0}, why="constraint slices"),
        Box(1, (0, 5, 2, 0), (1, 6, 4, 1), why="no clock"),
        Box(1, (0, 5, 2, 1), (1, 6, 4, 2)),
    ]
    return study, excluded
