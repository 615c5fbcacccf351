"""The entry points of planners and styles, and the headlines of ours, found without loading any of them."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

GROUP = "codesign.planners"
"""The entry-point group."""

HEADLINES = Path(__file__).with_name("headlines.json")
"""By the value of an entry point of ours, what a list says of it: ``make docs`` writes it."""

Headlines = Mapping[str, Mapping[str, str]]
"""By kind (planners, tasks, styles), names and one-line descriptions."""


def is_ours(point: EntryPoint) -> bool:
    """True if a plug-in is of this package."""
    return point.value.startswith("codesign.")


def registered() -> tuple[EntryPoint, ...]:
    """The entry points of all installed plug-ins: ours first, then by name."""
    points = entry_points(group=GROUP)
    return tuple(sorted(points, key=lambda point: (not is_ours(point), point.name, point.value)))


def kept_headlines() -> dict[str, Headlines]:
    """The headlines of our plug-ins, by the value of the entry point."""
    kept: dict[str, Headlines] = json.loads(HEADLINES.read_text(encoding="utf-8"))
    return kept
