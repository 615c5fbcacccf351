"""Everything that this room registers."""

from __future__ import annotations

from codesign.planners.plug_in import PlugIn, Samples, named
from codesign.planners.relaxation.plan.planner import PLANNER
from codesign.planners.relaxation.published import RelaxationSettings
from codesign.planners.relaxation.styles import ARCHITECTURES, TASK_STYLES
from codesign.planners.relaxation.styles.probes import PROBES

PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    task_styles=TASK_STYLES,
    probes=PROBES,
    reproduce=named("codesign.planners.relaxation.paper.measures:PAPER"),
    settings=RelaxationSettings,
    samples=Samples(
        parameters=(
            {"method": "sor", "omega": 1.8, "tolerance": 1e-9},
            {"method": "mam", "omega": 1.7, "r": 1.5},
            {"method": "direct"},
        )
    ),
)
