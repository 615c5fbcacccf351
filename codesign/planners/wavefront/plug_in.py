"""Everything that this room registers."""

from __future__ import annotations

from pathlib import Path

from codesign.planners.plug_in import Parts, PlugIn, Samples, Timed, named
from codesign.planners.wavefront.plan.planner import PLANNER
from codesign.planners.wavefront.published import WavefrontSettings
from codesign.planners.wavefront.styles import ARCHITECTURES, TASK_STYLES
from codesign.planners.wavefront.styles.software import PROBES

PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    task_styles=TASK_STYLES,
    circuits=Parts("codesign.planners.wavefront.rtl:CIRCUITS"),
    probes=PROBES,
    timed=(Timed({"style": "software"}, program=Path(__file__).parent / "styles" / "board.c"),),
    reproduce=named("codesign.planners.wavefront.paper.measures:PAPER"),
    settings=WavefrontSettings,
    samples=Samples(parameters=({}, {"stop": "starts"}, {"paths": "safe", "tile": (8, 8)})),
    beginnings=[{}, *({"tile": [side, side]} for side in (128, 96, 64, 48, 32, 24, 16, 8))],
)
