"""Everything that this room registers."""

from __future__ import annotations

from pathlib import Path

from codesign.planners.plug_in import PlugIn, Samples, Timed, named
from codesign.planners.relaxation.plan.planner import PLANNER
from codesign.planners.relaxation.published import RelaxationSettings
from codesign.planners.relaxation.styles import ARCHITECTURES, TASK_STYLES
from codesign.planners.relaxation.styles.host import PROBES

PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    task_styles=TASK_STYLES,
    probes=PROBES,
    timed=(
        Timed({"style": "sequential", "method": "gs", "tolerance": 1e-15, "max_iterations": 300}, 1 << 17),
        Timed({"style": "sequential", "method": "gs", "max_iterations": 300}, 1 << 17),
        Timed({"style": "sequential", "method": "direct"}, 40_000),
        Timed(
            {"style": "sequential", "method": "gs", "tolerance": 1e-15, "max_iterations": 8},
            1 << 17,
            Path(__file__).parent / "styles" / "board.py",
        ),
    ),
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
