"""The pictures of one run, from its records, and of the map of a workload."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from codesign.ground.errors import SpecError
from codesign.ground.records import Record, Subject
from codesign.ground.units import counted
from codesign.inputs import Workload
from codesign.system import problem_of
from codesign.system.problem_map import Places, grid_faults
from codesign.views.report.canvas import Format, Picture, with_palette
from codesign.views.report.map_pictures import drive_picture, map_picture, plan_picture
from codesign.views.report.timelines import bars_of, mission_timeline_picture, timeline_picture


def run_pictures(records: Iterable[Record]) -> tuple[Picture, ...]:
    """The pictures of a page that these records allow, in reading order; none for a run that never began."""
    all_records = tuple(records)
    pictures = (run_map_picture(all_records), run_timeline_picture(all_records))
    return tuple(with_palette(picture) for picture in pictures if picture is not None)


def run_map_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """The map of a run: of a mission what was driven, of a plan its field and paths; None without a map."""
    all_records = tuple(records)
    drive = drive_picture(all_records, format=format)
    if drive is not None:
        return drive
    maps: list[Any] = [record for record in all_records if record.ROLE.about is Subject.MAP]
    return plan_picture(maps[-1], all_records, format=format) if maps else None


def run_timeline_picture(records: Iterable[Record], *, format: Format = "png") -> Picture | None:
    """When components and links were busy: of a mission as shares, of a plan each span; None without work."""
    all_records = tuple(records)
    busy = mission_timeline_picture(all_records, format=format)
    if busy is not None:
        return busy
    bars = bars_of(all_records)
    return timeline_picture(bars, format=format) if bars else None


def workload_map_picture(workload: Workload, *, format: Format = "png") -> Picture:
    """The map of a workload with its goals and starts, cropped and prepared as it is planned on.

    Raises:
        SpecError: the map cannot be read, or a place on it is wrong. InputError: the workload has no map.
    """
    problem_of(workload)
    grid, faults = grid_faults(workload, None)
    if grid is None:
        raise SpecError(faults)
    places = Places(workload, grid)
    if places.faults:
        raise SpecError(places.faults)
    problem = places.problem()
    (row, column), shape = problem.corner, problem.free.shape
    goals, starts = ([(each[0] + row, each[1] + column) for each in cells] for cells in (problem.goals, problem.starts))
    counts = f"{counted(len(goals), 'goal')}, {counted(len(starts), 'start')}"
    title = f"The map of {workload.name}: {shape[0]} by {shape[1]} cells, {counts}"
    return map_picture(problem.free, goals, starts=starts, title=title, corner=problem.corner, format=format)
