"""Pictures of a run, made of its records."""

from __future__ import annotations

from collections.abc import Iterable

from codesign.records import MapRecord, Record, StageRecord, TrajectoryRecord
from codesign.report.plots import Picture, map_picture


def run_pictures(records: Iterable[Record]) -> tuple[Picture, ...]:
    """The map with the last potential and the traced ways to the goal; none where the records hold no map."""
    listed = list(records)
    maps = [record for record in listed if isinstance(record, MapRecord)]
    if not maps:
        return ()
    stages = [record for record in listed if isinstance(record, StageRecord)]
    ways = [record.points for record in listed if isinstance(record, TrajectoryRecord)]
    goals = [(int(row), int(column)) for row, column in maps[-1].goals]
    potential = stages[-1].potential if stages else None
    title = f"Potential after {stages[-1].precision} bits, and ways to the goal" if stages else "Map and ways"
    return (map_picture(maps[-1].free, goals, potential=potential, trajectories=ways, title=title),)
