"""Design-space exploration: every point of a workload's axes computed, kept, and held against the others.

``explore`` runs it. Behind it stand ``Space`` (which points there are, and which share work), the stores
(one SQLite file, resumable by running again), the executors (this process, several, or a cluster) and ``Study`` (every
point, the reasons of those that are out, the front).

Exact enumeration is the only sampler: points are cheap, as those that differ in part, clock or schedule
share their functional work, and a front with holes where a sampler did not look is hard to trust.
"""

from __future__ import annotations

from codesign.ground.late import by_name

__getattr__, __dir__, __all__ = by_name(__name__, __file__)
