"""The plug-in of this room."""

from __future__ import annotations

from codesign.planners.grid_search.plan.planner import PLANNER
from codesign.planners.grid_search.styles import ARCHITECTURES, PROBES
from codesign.planners.plug_in import PlugIn, Samples

PLUG_IN = PlugIn(
    planner=PLANNER,
    styles=ARCHITECTURES,
    probes=PROBES,
    samples=Samples(
        parameters=(
            {},
            {"heuristic": "euclidean", "corner_cutting": True},
            {"method": "jump_point"},
            {"method": "theta_star"},
            {"method": "navfn"},
        )
    ),
)
