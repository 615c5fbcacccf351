"""Everything that this room registers."""

from __future__ import annotations

from codesign.planners.plug_in import PlugIn, Samples
from codesign.planners.reproduction import Progress, Reproduction
from codesign.planners.velocity_obstacle.paper.settings import VelocityObstacleSettings
from codesign.planners.velocity_obstacle.plan.planner import PLANNER
from codesign.planners.velocity_obstacle.rtl import CIRCUITS
from codesign.planners.velocity_obstacle.styles import ARCHITECTURES


def _reproduce(
    quick: bool = False, progress: Progress | None = None, settings: VelocityObstacleSettings | None = None
) -> Reproduction:
    from codesign.planners.velocity_obstacle.paper.reproduce import velocity_obstacle

    return velocity_obstacle(quick, progress, settings)


PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    circuits=CIRCUITS,
    reproduce=_reproduce,
    settings=VelocityObstacleSettings,
    samples=Samples(
        parameters=({}, {"updates": 40}),
        problems=[{"robots": {"count": count, "arrangement": "circle"}} for count in (4, 5)],
    ),
)
