"""A ``PlugIn``: a planner of this or another package, with its styles, probes and reproduction.

Each ``PlugIn`` is the value of one entry point of the group ``codesign.planners``. A package may leave the planner out
and add styles to a planner of another package.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from codesign.ground.late import load
from codesign.planners.circuits import CircuitStyle
from codesign.planners.interface import Planner
from codesign.planners.reproduction import Progress, Reproduction, Settings, silent
from codesign.planners.styles import Architecture, TaskStyle


@dataclass(frozen=True)
class Probe:
    """A measurement of a kernel on this machine.

    ``run`` computes ``units`` units of the kernel. ``without`` does the other work of ``run``; None: there is none.
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


@dataclass(frozen=True)
class Timed:
    """A plan that ``hwsw calibrate host`` times on maps of several kinds and sizes, from a start to a goal.

    The costs of its kernels are fitted to these times together, with an interval that holds on other maps too.

    - ``parameters``: of the planning task, with its style on a processor. Each of its kernels has a probe.
    - ``most_cells``: of the largest map that it is timed on.
    - ``program``: the path of a program of the same plan for a board without this package, in C (``.c``) or for NumPy
      (``.py``): see docs/calibration.md. None: it is not timed there. A plan whose kernels all stand in those before it
      is timed there alone.
    """

    parameters: Mapping[str, Any]
    most_cells: int = 1 << 20
    program: Path | None = None


class Reproduce(Protocol):
    """Compares the model with the paper of the planner."""

    def __call__(self, quick: bool = False, progress: Progress = silent, settings: Any = None) -> Reproduction:
        """Every row of the paper that the model can be compared with.

        ``quick``: fewer and smaller maps, seconds instead of minutes. ``progress`` is called with a line of text for
        each part of the work. ``settings``: of the model that the plug-in declares; by default as published.
        """


def named(where: str) -> Callable[..., Any]:
    """A function that is named as ``MODULE:NAME`` and imported when it is first called."""

    def called(*arguments: Any, **named: Any) -> Any:
        return load(where)(*arguments, **named)

    return called


class Parts(Sequence[Any]):
    """Parts that are named as ``MODULE:NAME``. The module is imported when one of them is asked for."""

    def __init__(self, where: str) -> None:
        self._where = where

    def __getitem__(self, index: Any) -> Any:
        return load(self._where)[index]

    def __len__(self) -> int:
        return len(load(self._where))


@dataclass(frozen=True)
class Samples:
    """The samples that ``codesign.testing`` checks a planner and its styles with.

    - ``parameters``: sets of parameters of the planning task, as a workload writes them. Each runs in a moment.
    - ``problems``: two different problems of the planner, or mappings for its ``problem_model``. None: two maps
      of six rooms, 24 × 32 cells. Required where the planner has a ``problem_model``.
    """

    parameters: Sequence[Mapping[str, Any]] = ({},)
    problems: Sequence[Any] | None = None


@dataclass(frozen=True)
class PlugIn:
    """All that one planner registers.

    - ``planner``: the planner, or None where ``styles`` and ``task_styles`` belong to a planner of another package.
    - ``styles``: architecture styles of the planning task.
    - ``task_styles``: styles of tasks that are placed by themselves.
    - ``circuits``: the Verilog of styles on an FPGA, for ``hwsw rtl``, ``verify`` and ``synth``.
    - ``probes``: the measurements of ``hwsw calibrate host``, by the name of the kernel. Styles on a processor count
      their cost in kernels. A probe is made when it is needed.
    - ``timed``: the plans whose times these costs are fitted to; kernels of the first are held for the next.
    - ``reproduce``: the comparison with the paper for ``hwsw reproduce``; None where there is no paper.
    - ``settings``: the model of the settings of that comparison that ``hwsw reproduce --set`` moves.
    - ``samples``: the samples of the conformance suite.
    - ``beginnings``: sets of parameters of the planning task for a first workload on any map, the best first. ``hwsw
      init`` writes the first that fits the board.
    """

    planner: Planner | None = None
    styles: tuple[Architecture, ...] = ()
    task_styles: tuple[TaskStyle, ...] = ()
    circuits: Sequence[CircuitStyle] = ()
    probes: Mapping[str, Callable[[], Probe]] = field(default_factory=dict)
    timed: Sequence[Timed] = ()
    reproduce: Reproduce | None = None
    settings: type[Settings] = Settings
    samples: Samples = Samples()
    beginnings: Sequence[Mapping[str, Any]] = ({},)
