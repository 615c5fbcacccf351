"""The parameters that are worth a try: paths that a robot can follow, and tiles that fit the part."""

from __future__ import annotations

from codesign.planners.styles import Designs

DESIGNS: Designs = tuple(({"stop": stop, "corner_cutting": False},) for stop in ("starts", "whole_map"))
"""A robot cannot pass between two obstacles that touch at a corner."""

MOST_CELLS = 2**18
"""Cells of the map times starts up to which tiles are visited for each start by itself. A search would take minutes
beyond. The wave over the whole map takes at least as long on the array, and one computation for all starts."""

TILE_SIDES = (8, 16, 24, 32, 48, 64, 96, 128, 192, 256)
MOST_TILES = 3
"""The number of tiles that are tried, the largest that fit: a larger tile is visited less often, a smaller one has a
faster clock."""
