"""The plug-in of this room."""

from __future__ import annotations

from codesign.planners.harmonic.plan.planner import PLANNER
from codesign.planners.harmonic.published import HarmonicSettings
from codesign.planners.harmonic.styles import ARCHITECTURES, TASK_STYLES
from codesign.planners.harmonic.styles.software import PROBES
from codesign.planners.plug_in import Parts, PlugIn, Samples, named

PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    task_styles=TASK_STYLES,
    circuits=Parts("codesign.planners.harmonic.rtl:CIRCUITS"),
    probes=PROBES,
    reproduce=named("codesign.planners.harmonic.paper.measures:PAPER"),
    settings=HarmonicSettings,
    samples=Samples(
        parameters=(
            {"block": (12, 16), "iterations": 6, "schedule": (7, 15, 23)},
            {"blocks": (3, 2), "iterations": 1, "schedule": (9, 40), "termination": "published"},
            {"blocks": (1, 1), "iterations": 40, "schedule": (70,), "stop": "schedule_end"},
        )
    ),
    beginnings=[
        {"blocks": [count, count], "iterations": 6, "schedule": {"first": 7, "step": 8, "last": 111}}
        for count in (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
    ],
)
