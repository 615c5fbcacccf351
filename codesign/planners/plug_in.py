"""What one room, or a package of somebody else's, brings along: a planner, its styles, and what goes with them.

Each is registered as one entry point of the group ``codesign.planners``, of which the value is a ``PlugIn``. A package
may leave the planner out and add styles to a planner of another package.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from codesign.planners.interface import Planner
from codesign.planners.reproduction import Progress, Reproduction
from codesign.planners.styles import Architecture, TaskStyle

GROUP = "codesign.planners"
"""The entry-point group."""


@dataclass(frozen=True)
class Probe:
    """One way to time a kernel on this machine.

    ``run`` computes ``units`` units of the kernel. ``without``, where there is one, does everything that ``run`` does
    beside them.
    """

    units: int
    run: Callable[[], object]
    without: Callable[[], object] | None = None

    def seconds(self) -> float:
        """Seconds a unit, measured once."""
        spent = _timed(self.run) - (0.0 if self.without is None else _timed(self.without))
        return spent / self.units


def _timed(run: Callable[[], object]) -> float:
    """Seconds of this thread on a core: the same on an idle machine as on a busy one."""
    begin = time.thread_time()
    run()
    return time.thread_time() - begin


class Reproduce(Protocol):
    """Holds the model against the planner's paper."""

    def __call__(self, quick: bool = False, progress: Progress | None = None) -> Reproduction:
        """Every row of the paper that the model can be held against.

        ``quick``: fewer and smaller maps, seconds instead of minutes. ``progress`` is called with a line of text for
        each part of the work.
        """


@dataclass(frozen=True)
class Samples:
    """What ``codesign.testing`` checks a planner and its styles on.

    - ``parameters``: sets of parameters of the planning task as a workload writes them. Each runs in a moment.
    - ``problems``: two problems that differ: what the planner takes, or mappings for its ``problem_model``. None: two
      maps of six rooms, 24 × 32 cells. Required where the planner has a ``problem_model``.
    """

    parameters: Sequence[Mapping[str, Any]] = ({},)
    problems: Sequence[Any] | None = None


@dataclass(frozen=True)
class PlugIn:
    """Everything of one planner.

    - ``planner``: the planner, or None where ``styles`` and ``task_styles`` are of a planner of another package.
    - ``styles``: architecture styles of the planning task.
    - ``task_styles``: styles of tasks that are placed by themselves.
    - ``probes``: how ``hwsw calibrate host`` times each kernel whose cost the styles on a processor are counted in, by
      the name of the kernel. A probe is made when it is needed.
    - ``reproduce``: how ``hwsw reproduce`` holds the model against the planner's paper; None where there is no paper.
    - ``samples``: what the conformance suite checks planner and styles on.
    """

    planner: Planner | None = None
    styles: tuple[Architecture, ...] = ()
    task_styles: tuple[TaskStyle, ...] = ()
    probes: Mapping[str, Callable[[], Probe]] = field(default_factory=dict)
    reproduce: Reproduce | None = None
    samples: Samples = Samples()
