"""Design-space exploration: every point of a workload's axes computed, kept, and held against the others.

``explore`` runs it. Behind it stand ``Space`` (which points there are, and which share work), the stores
(one SQLite file, resumable by running again), the executors (this process or several), ``Study`` (every
point, the reasons of those that are out, the front) and ``best_schedule`` (the best precision schedule, as
a shortest path).

Exact enumeration is the only sampler: points are cheap, as those that differ in part, clock or schedule
share their functional work, and a front with holes where a sampler did not look is hard to trust.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import Any

from codesign.explore.document import study_schema
from codesign.explore.executor import Executor, ProcessExecutor, SerialExecutor
from codesign.explore.front import non_dominated
from codesign.explore.run import Progress, explore, load_study
from codesign.explore.schedule import Schedule, best_schedule, optimise_schedule
from codesign.explore.space import DesignPoint, Space
from codesign.explore.store import Entry, FileStore, MemoryStore, State, Store
from codesign.explore.study import Outcome, ReasonCount, Study

__all__ = [
    "DesignPoint",
    "Entry",
    "Executor",
    "FileStore",
    "MemoryStore",
    "Outcome",
    "ProcessExecutor",
    "Progress",
    "ReasonCount",
    "Schedule",
    "SerialExecutor",
    "Space",
    "State",
    "Store",
    "Study",
    "best_schedule",
    "explore",
    "load_study",
    "non_dominated",
    "optimise_schedule",
    "study_schema",
]


class _CallableModule(ModuleType):
    """Importing this package sets ``codesign.explore`` to the package, over the function of that name: either works."""

    def __call__(self, *args: Any, **kwargs: Any) -> Study:
        return explore(*args, **kwargs)


sys.modules[__name__].__class__ = _CallableModule
