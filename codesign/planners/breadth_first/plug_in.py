"""The plug-in of this room."""

from __future__ import annotations

from codesign.planners.breadth_first.paper.settings import BreadthFirstSettings
from codesign.planners.breadth_first.plan.planner import PLANNER
from codesign.planners.breadth_first.rtl import CIRCUITS
from codesign.planners.breadth_first.styles import ARCHITECTURES, TASK_STYLES
from codesign.planners.breadth_first.styles.probes import PROBES
from codesign.planners.plug_in import PlugIn, Samples
from codesign.planners.reproduction import Progress, Reproduction, silent


def _reproduce(
    quick: bool = False, progress: Progress = silent, settings: BreadthFirstSettings | None = None
) -> Reproduction:
    from codesign.planners.breadth_first.paper.reproduce import breadth_first

    return breadth_first(quick, progress, settings)


PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    task_styles=TASK_STYLES,
    circuits=CIRCUITS,
    probes=PROBES,
    reproduce=_reproduce,
    settings=BreadthFirstSettings,
    samples=Samples(parameters=({}, {"micro_architecture": "pipelined"})),
)
