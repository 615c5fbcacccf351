"""Occupancy grids: read from files, generated from seeds, and measured (reach, distance, clearance)."""

from __future__ import annotations

from codesign.ground.late import by_name

__getattr__, __dir__, __all__ = by_name(__name__, __file__)
