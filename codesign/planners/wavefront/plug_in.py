"""Everything that this room registers."""

from __future__ import annotations

from codesign.planners.plug_in import PlugIn, Samples
from codesign.planners.reproduction import Progress, Reproduction
from codesign.planners.wavefront.paper.settings import WavefrontSettings
from codesign.planners.wavefront.plan.planner import PLANNER
from codesign.planners.wavefront.rtl import CIRCUITS
from codesign.planners.wavefront.styles import ARCHITECTURES, TASK_STYLES
from codesign.planners.wavefront.styles.probes import PROBES


def _reproduce(
    quick: bool = False, progress: Progress | None = None, settings: WavefrontSettings | None = None
) -> Reproduction:
    from codesign.planners.wavefront.paper.reproduce import wavefront

    return wavefront(quick, progress, settings)


PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    task_styles=TASK_STYLES,
    circuits=CIRCUITS,
    probes=PROBES,
    reproduce=_reproduce,
    settings=WavefrontSettings,
    samples=Samples(parameters=({}, {"stop": "starts"}, {"paths": "safe", "tile": (8, 8)})),
    beginnings=[{}, *({"tile": [side, side]} for side in (128, 96, 64, 48, 32, 24, 16, 8))],
)
