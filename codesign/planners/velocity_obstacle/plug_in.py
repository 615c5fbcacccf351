"""Everything that this room registers."""

from __future__ import annotations

from codesign.planners.plug_in import Parts, PlugIn, Samples, named
from codesign.planners.velocity_obstacle.plan.planner import PLANNER
from codesign.planners.velocity_obstacle.published import VelocityObstacleSettings
from codesign.planners.velocity_obstacle.styles import ARCHITECTURES

PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    circuits=Parts("codesign.planners.velocity_obstacle.rtl:CIRCUITS"),
    reproduce=named("codesign.planners.velocity_obstacle.paper.measures:PAPER"),
    settings=VelocityObstacleSettings,
    samples=Samples(
        parameters=({}, {"updates": 40}),
        problems=[{"robots": {"count": count, "arrangement": "circle"}} for count in (4, 5)],
    ),
)
