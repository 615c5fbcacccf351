"""The designs that ``benchmarks.measure`` synthesises and places.

``designs/ROOM.py`` has those of a room: ``RESOURCES``, a sequence of ``Design`` that resource laws are fitted to, and
``CLOCKS``, a sequence of ``Placed`` that clock laws are fitted to. Either may be missing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from codesign.planners.interface import Problem


def free_map(rows: int, columns: int) -> Problem:
    """A map without obstacles; the goal is in a corner."""
    return Problem(np.ones((rows, columns), bool), ((0, 0),), ((rows - 1, columns - 1),))


@dataclass(frozen=True)
class Design:
    """A design point: what it plans on, the raw parameters of the planning task, and other fields of its ``Job``."""

    style: str
    parameters: Mapping[str, Any]
    problem: Callable[[], Any]
    task: str = ""
    job: Mapping[str, Any] = field(default_factory=dict)


FEW = 1, 2, 3
"""Seeds of a design that a law is fitted to: five are for those that it is held against."""


@dataclass(frozen=True)
class Placed:
    """A design on a part, with the seeds that it is placed with."""

    design: Design
    part: str
    seeds: Sequence[int] = (1, 2, 3, 4, 5)
