"""The plug-in of this room."""

from __future__ import annotations

from pathlib import Path

from codesign.planners.breadth_first.plan.planner import PLANNER
from codesign.planners.breadth_first.published import BreadthFirstSettings
from codesign.planners.breadth_first.styles import ARCHITECTURES, TASK_STYLES
from codesign.planners.breadth_first.styles.software import PROBES
from codesign.planners.plug_in import Parts, PlugIn, Samples, Timed, named

PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    task_styles=TASK_STYLES,
    circuits=Parts("codesign.planners.breadth_first.rtl:CIRCUITS"),
    probes=PROBES,
    timed=(Timed({"style": "software"}, program=Path(__file__).parent / "styles" / "board.c"),),
    reproduce=named("codesign.planners.breadth_first.paper.measures:PAPER"),
    settings=BreadthFirstSettings,
    samples=Samples(parameters=({}, {"micro_architecture": "pipelined"})),
)
