"""Design-space exploration: every point of a workload's axes computed, kept, and held against the others.

``explore`` runs it. Behind it stand ``Space`` (which points there are, and which share work), the stores
(one SQLite file, resumable by running again), the executors (this process, several, or a cluster) and ``Study`` (every
point, the reasons of those that are out, the front).

Exact enumeration is the only sampler: points are cheap, as those that differ in part, clock or schedule
share their functional work, and a front with holes where a sampler did not look is hard to trust.
"""

from __future__ import annotations

from codesign.exploration.cluster import ClusterExecutor
from codesign.exploration.designs import Design, StudyPoint
from codesign.exploration.document import study_schema
from codesign.exploration.executor import Executor, ProcessExecutor, SerialExecutor
from codesign.exploration.file_store import FileStore
from codesign.exploration.front import non_dominated
from codesign.exploration.outcomes import Outcomes
from codesign.exploration.reasons import ReasonCount
from codesign.exploration.run import explore, load_study
from codesign.exploration.space import DesignPoint, Space
from codesign.exploration.store import Entry, EntryState, MemoryStore, Store
from codesign.exploration.study import Study
from codesign.exploration.tally import Progress

__all__ = [
    "ClusterExecutor",
    "Design",
    "DesignPoint",
    "Entry",
    "EntryState",
    "Executor",
    "FileStore",
    "MemoryStore",
    "Outcomes",
    "ProcessExecutor",
    "Progress",
    "ReasonCount",
    "SerialExecutor",
    "Space",
    "Store",
    "Study",
    "StudyPoint",
    "explore",
    "load_study",
    "non_dominated",
    "study_schema",
]
