"""The first files of somebody with a board, a planner and a map: a platform and a workload that run at once."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from codesign import maps
from codesign.ground.errors import CodesignError, InputError, SpecError
from codesign.ground.figures import label
from codesign.ground.late import late
from codesign.inputs import Platform, load_platform
from codesign.inputs.components import PLANNING_TYPES
from codesign.inputs.files import renamed
from codesign.inputs.places import Place
from codesign.inputs.yaml_tree import parse_document
from codesign.maps.grid import Cell, OccupancyGrid
from codesign.planners.interface import Planner
from codesign.system import catalog, problem_of
from codesign.system.inspect import place_on
from codesign.system.outcome import fit_system
from codesign.system.problem_map import grid_of
from codesign.system.results.result import Reason
from codesign.system.scenarios.run import bind

ndimage = late("scipy.ndimage")

BOARD, PLANNER = "virtex4-pci", "harmonic"
"""The word for a board or a planner that is not named."""

PLATFORM_FILE, WORKLOAD_FILE = "my-platform.yaml", "my-workload.yaml"


@dataclass(frozen=True)
class Beginning:
    """Files by name with their texts, and a sentence about each choice that was made for the user."""

    texts: dict[str, str]
    choices: tuple[str, ...]


def beginning(board: str, planner_name: str, map_file: Path | None, goal: Place | None, folder: Path) -> Beginning:
    """A platform and a workload for ``folder``: the first style and parameters of the planner that fit the board.

    ``map_file``: None: the map of the shipped workload ``labyrinth``.
    ``goal``: None: the free cell nearest to the middle of the map, in its largest connected area.

    ``board``: a shipped name or a file.

    Raises:
        SpecError: the board's file is faulty, or names a file beside it.
        InputError: no such board or planner, the planner takes no map, or nothing of it fits; MapError: the map cannot
            be read, or the goal is no free cell.
    """
    platform = load_platform(board)
    planner = _planner(planner_name)
    grid, map_value = _map_of(map_file)
    goal_text = ""
    if goal is None:
        goal = middle_of_largest(grid)
        goal_text = ", the cell nearest to the middle of the map in its largest area; --goal chooses another"
    else:
        goal = place_on(grid, goal, "--goal")
        maps.check_cells(grid.free, [goal], where="--goal")
    area, free = int(maps.reachable(grid.free, [goal]).sum()), int(grid.free.sum())
    goal_text = f"goal: [{goal[0]}, {goal[1]}]{goal_text}; {area:,} of {free:,} free cells lead to it"
    problem = {"map": map_value, "goals": [list(goal)], "starts": {"count": 16, "seed": 1}}
    mapping, why = _first_that_fits(platform, planner, problem, grid)
    if mapping is None:
        hint = "choose another --board or --planner, or a smaller map"
        raise InputError(f"{planner_name} does not fit {board} with this map: {why}", "--board", hint)
    if map_file is not None:
        map_value["file"] = os.path.relpath(map_file, folder)
    texts = {
        PLATFORM_FILE: renamed("platforms", board, Path(PLATFORM_FILE).stem),
        WORKLOAD_FILE: _workload_text(planner, problem, mapping),
    }
    # A part that stands beside the board's file is not found beside the new one.
    load_platform(parse_document(texts[PLATFORM_FILE].encode(), str(folder / PLATFORM_FILE), folder))
    placed = f"planning: {mapping['style']} on {mapping['component']}, the first style and parameters that fit"
    placed += f"; {why}" if why else ""
    return Beginning(texts, (goal_text, placed))


def _map_of(file: Path | None) -> tuple[OccupancyGrid, dict[str, Any]]:
    """A map, and how a workload in any folder names it. A file is cropped to its free cells."""
    if file is not None:
        return maps.read_map(file), {"file": str(file.resolve()), "crop": str(maps.Crop.FREE)}
    labyrinth = catalog.load_workload("labyrinth")
    grid = grid_of(labyrinth)
    assert grid is not None, "its problem is a map"
    return grid, problem_of(labyrinth).map.model_dump(mode="json")


def middle_of_largest(grid: OccupancyGrid) -> Cell:
    """The free cell nearest to the middle of the map, in its largest 4-connected area.

    Raises:
        InputError: the map has no free cell.
    """
    areas, _ = ndimage.label(grid.free)
    sizes = np.bincount(areas[grid.free].ravel())
    if not sizes.size:
        raise InputError("the map has no free cell", "--map", "give a map with free cells: see docs/maps.md")
    largest = areas == sizes.argmax()
    rows, columns = np.nonzero(largest)
    distance = (rows - grid.free.shape[0] / 2) ** 2 + (columns - grid.free.shape[1] / 2) ** 2
    index = int(distance.argmin())
    return int(rows[index]), int(columns[index])


def _planner(name: str) -> Planner:
    planner = catalog.planner(name)
    if planner.problem_model is not None:
        accepted = sorted(set(catalog.planners()) - set(catalog.problem_models()))
        hint = f"accepted: {', '.join(accepted)}; or change a shipped workload: hwsw show NAME"
        raise InputError(f"{name} plans on no map with a goal", "--planner", hint)
    return planner


def _first_that_fits(
    platform: Platform, planner: Planner, problem: Mapping[str, Any], grid: OccupancyGrid
) -> tuple[dict[str, Any] | None, str]:
    """The first mapping of the planning task that fits, or None; and which other design misses by the least."""
    fault = "no component runs any of its styles"
    misses: list[tuple[float, str, Reason]] = []
    for mapping in _mappings(platform, planner):
        try:
            workload = catalog.load_workload(_workload_text(planner, problem, mapping))
            reasons = fit_system(bind(platform, workload, grid=grid)).reasons
        except CodesignError as refused:
            fault = refused.faults[0].what if isinstance(refused, SpecError) else refused.what
            continue
        design = f"{mapping['style']} on {mapping['component']}"
        if not reasons:
            return mapping, _closest([miss for miss in misses if miss[1] != design])
        worst = max(reasons, key=_factor)
        misses.append((_factor(worst), design, worst))
    return None, _closest(misses) or fault


def _factor(reason: Reason) -> float:
    return reason.demand / reason.limit if reason.limit else math.inf


def _closest(misses: list[tuple[float, str, Reason]]) -> str:
    """The design that passes its limit by the least factor, with the limit; "" where there is none."""
    if not misses:
        return ""
    _, design, reason = min(misses, key=lambda miss: miss[0])
    name, demand, limit = label(reason.name), f"{reason.demand:,.12g}", f"{reason.limit:,.12g}"
    return f"{design} takes {demand} {name} at best, where {limit} are there"


def _mappings(platform: Platform, planner: Planner) -> Iterator[dict[str, Any]]:
    """Mappings of the planning task, in the order in which they are tried."""
    plug_in = next(each for each in catalog.plug_ins() if each.planner is planner)
    styles = catalog.styles_of(planner.name).values()
    for component_type in PLANNING_TYPES:
        for name, component in platform.components.items():
            for style in styles:
                if component.type == component_type == style.component_type:
                    for parameters in plug_in.beginnings:
                        word = next((role for role, component in platform.filled.items() if component == name), name)
                        yield {"component": word, "style": style.style, **parameters}


def _workload_text(planner: Planner, problem: Mapping[str, Any], mapping: Mapping[str, Any]) -> str:
    """A workload file. JSON is YAML too: each value stands on its line as JSON writes it."""
    lines = ["kind: workload", f"name: {Path(WORKLOAD_FILE).stem}"]
    lines += ["", f"planner: {planner.name}", "", "problem:"]
    lines += [f"  {key}: {json.dumps(value)}" for key, value in problem.items()]
    lines += ["", "mapping:", f"  {planner.planning_task}:"]
    lines += [f"    {key}: {_plain(value)}" for key, value in mapping.items()]
    return "\n".join(lines) + "\n"


def _plain(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)
