"""The order in which the modules of the package may import each other."""

from __future__ import annotations

from places import ROOT

# Lowest first. A module imports only from levels below its own, and from its own entry. The longest name that fits
# decides: `codesign.planners.harmonic.paper` is in the room of harmonic control, `codesign.planners.styles` is not.
ROOMS = sorted(path.parent.name for path in (ROOT / "codesign").glob("planners/*/plug_in.py"))

LEVELS: list[list[str]] = [
    ["ground", "views", "hardware"],
    ["ground.errors", "ground.late", "version"],
    ["ground.units", "ground.numbering"],
    ["ground.figures"],
    ["ground.memo", "ground.progress"],
    ["ground.files", "ground.notebooks", "ground.gtkwave"],
    ["ground.interrupts"],
    ["ground.kernel_cache"],
    ["ground.node"],
    ["laws"],
    ["ground.models", "study.certificates"],
    ["ground.activity"],
    ["ground.records"],
    ["maps", "views.trace"],
    ["inputs"],
    ["planners.external_memory", "planners.map_flood", "planners.registered"],
    ["planners.measured"],
    ["planners.job"],
    ["planners.clock_law", "planners.counted", "planners.interface", "planners.reproduction"],
    ["planners.styles", "planners.circuits", "planners.papers"],
    ["planners.plug_in"],
    ["plugin"],
    [f"planners.{room}" for room in ROOMS],
    ["planners", "components"],
    ["system.results"],
    ["system.verdicts"],
    ["system.explanation"],
    ["system"],
    ["system.scenarios"],
    ["hardware.rtl", "study.pricing"],
    ["study", "hardware.calibrate", "testing"],
    ["study.advice"],
    ["hardware.reproduce", "hardware.fidelity"],
    ["views.bags"],
    ["views.report"],
    ["views.exports"],
    ["face"],
    [""],
    ["cli"],
    ["__main__"],
]


ROOM_NAMES = {f"planners.{room}" for room in ROOMS}
LEVEL = {name: level for level, names in enumerate(LEVELS) for name in names}


# Within a room, the leftmost first. What stands in none of these is the room itself: it may import them all.
ROOM_ORDER = ["published", "measured", "plan", "styles", "rtl", "paper"]


# trace depends on records alone: nothing of the simulation may know it.
MAY_USE_TRACE = {"views.trace", "views.exports", "face", "", "cli", "__main__"}
