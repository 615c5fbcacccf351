"""The map of a workload as it is planned on, and the places on it that the workload names.

Everything here is in the frame of the whole map. Only the ``Problem`` is cropped.
"""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import Any

import numpy as np

from codesign import maps
from codesign.ground.errors import Fault, MapError, outside_map, printable
from codesign.ground.memo import Memo, Same
from codesign.inputs import Workload, fault
from codesign.inputs.map_spec import FileMap
from codesign.inputs.places import Point, ScenarioLine, cell_text, point_text
from codesign.inputs.problem import ProblemSpec
from codesign.maps import Crop, MovingAiScenario, OccupancyGrid, Steps
from codesign.planners.interface import Problem
from codesign.system.results.result import reach_text

Cell = tuple[int, int]

LENGTH_ERROR = 0.005
"""Cells: the rounding of the lengths in MovingAI's files."""

_grids = Memo(max_bytes=256 * 2**20)


def grid_of(workload: Workload) -> OccupancyGrid | None:
    """The workload's map, or None where the planner's problem is of another kind.

    Raises:
        MapError: the map cannot be read or made.
    """
    return load_grid(workload) if isinstance(workload.problem, ProblemSpec) else None


def load_grid(workload: Workload) -> OccupancyGrid:
    """The workload's map after all steps but cropping; kept in this process, so that a thousand points read it once.

    Raises:
        MapError: the map cannot be read or made. ``where`` is a key of the map where that is at fault.
    """
    assert isinstance(workload.problem, ProblemSpec), "the problem is a map with goals and starts"
    return _after(workload.problem, workload.problem.map.steps)


def _after(problem: ProblemSpec, steps: Steps) -> OccupancyGrid:
    wanted = problem.map
    if isinstance(wanted, FileMap):
        file = wanted.path
        stamp = ("file", maps.map_stamp(file))
        return _grids.get((*stamp, steps), lambda: maps.read_prepared(file, steps))
    parameters, name = wanted.parameters, wanted.generate
    key = ("generate", name, repr(sorted(parameters.items())), steps)
    return _grids.get(key, lambda: maps.prepare(maps.generate(name, **parameters), steps))


def grid_faults(workload: Workload, grid: OccupancyGrid | None) -> tuple[OccupancyGrid | None, list[Fault]]:
    """The map, or why it cannot be read or made, or has no free cell. ``grid``: the map where it was made before."""
    assert isinstance(workload.problem, ProblemSpec), "the problem is a map with goals and starts"
    try:
        grid = load_grid(workload) if grid is None else grid
    except MapError as wrong:
        # Steps and generators name the parameter at fault, a key of the map; a reader names a place in its file.
        keys = type(workload.problem.map).model_fields
        own = wrong.where is not None and (wrong.where in keys or workload.map_file is None)
        path: tuple[str | int, ...] = ("problem", "map", *([wrong.where] if own and wrong.where else []))
        what = wrong.what if own or wrong.where is None else f"{wrong.where}: {wrong.what}"
        return None, [fault(workload, path, what, wrong.hint)]
    if grid.free.any():
        return grid, []
    return None, [fault(workload, ("problem", "map"), "no cell of the map is free", _why_none(workload.problem))]


def _why_none(problem: ProblemSpec) -> str:
    """The remedy for a map without a free cell: the first step after which none is left."""
    steps = problem.map.steps
    plain = _after(problem, Steps(unknown=steps.unknown))
    if plain.free.any() and not _after(problem, replace(steps, downsample=1)).free.any():
        return f"inflate by less than {steps.inflate}"
    if plain.free.any():
        return f"downsample by less than {steps.downsample}"
    if plain.unknown is not None and plain.unknown.any():
        unknown = f"{int(plain.unknown.sum()):,} of {plain.free.size:,} cells unknown"
        return f"{unknown}: set unknown: free, or check the thresholds of the map"
    return "give a map with free cells, or check the thresholds of the image"


def map_notes(workload: Workload, grid: OccupancyGrid | None) -> tuple[str, ...]:
    """The assumptions about the map: how unknown cells count, the greys of a bare image. ``grid``: as for binding."""
    grid = grid_of(workload) if grid is None else grid
    return () if grid is None else tuple(f"problem.map: {remark}" for remark in grid.remarks)


class Places:
    """The goals and starts of a workload as cells of its map, with every fault in them."""

    def __init__(self, workload: Workload, grid: OccupancyGrid) -> None:
        assert isinstance(workload.problem, ProblemSpec), "the problem is a map with goals and starts"
        self._workload, self._grid, self._problem = workload, grid, workload.problem
        self.faults: list[Fault] = []
        self.goals, _ = self._cells("goals", self._problem.goals)
        self.lengths: tuple[float, ...] = ()
        self.starts: tuple[Cell, ...] = ()
        self.reach = None if self.faults else self._reach()
        starts = self._problem.starts
        if isinstance(starts, tuple | ScenarioLine):
            self.starts, lengths = self._cells("starts", starts)
            self.lengths = lengths if starts == self._problem.goals else ()
        elif not self.faults:
            # The points of a study draw from the same map, which is searched once.
            cells = hashlib.sha256(grid.free.tobytes()).digest()
            key = ("starts", cells, grid.shape, self.goals, starts.count, starts.seed)
            self.starts = _grids.get(key, lambda: _drawn(grid, self.goals, starts.count, starts.seed))

    def problem(self) -> Problem:
        """The cropped problem: one object for all points of a study that ask the same of one map."""
        key = "problem", Same(self._grid), self._problem.map.crop, self.goals, self.starts, self.lengths
        return _grids.get(key, self._cropped)

    def _cropped(self) -> Problem:
        grid, wanted = self._grid, self._problem.map
        named = () if wanted.crop is Crop.NONE else (*self.goals, *self.starts)
        window = maps.window(grid, wanted.crop, named)
        whole = window.corner == (0, 0) and (window.rows, window.columns) == grid.shape
        part = grid if whole else maps.cropped(grid, window)
        return Problem(
            free=part.free,
            goals=_moved(self.goals, window.corner),
            starts=_moved(self.starts, window.corner),
            resolution=grid.resolution,
            corner=window.corner,
            origin=part.origin,
            optimal_lengths=self.lengths,
            unknown=part.unknown,
            reach=self.reach,
        )

    def _reach(self) -> float:
        """The share of the free cells from which a path leads to a goal; fewer than have to are a fault."""
        free, goals = self._grid.free, self.goals
        key = "reach", Same(self._grid), goals
        number, cells = _grids.get(key, lambda: (int(maps.reachable(free, goals).sum()), int(free.sum())))
        if number < self._problem.reach * cells:
            near = maps.nearest_free(maps.largest_component(free), goals[0])
            assert near is not None, "a map without a free cell is refused before"
            what = f"a path leads to a goal from {number:,} of {cells:,} free cells ({100 * number / cells:.3g} %)"
            hint = (
                f"fewer than {100 * self._problem.reach:g} %: a pocket. The nearest cell of the largest part is"
                f" {cell_text(near)}; problem.reach sets the least share, as --reach of hwsw advise does"
            )
            self.faults.append(fault(self._workload, ("problem", "goals"), what, hint))
        return number / cells

    def _cells(self, name: str, places: Any) -> tuple[tuple[Cell, ...], tuple[float, ...]]:
        """The cells, with the lengths that a scenario file gives."""
        if isinstance(places, ScenarioLine):
            return self._of_scenario(name, places)
        cells: dict[Cell, int] = {}
        for index, place in enumerate(places):
            path = ("problem", name, index)
            cell = self._cell(path, place)
            if cell is None:
                continue
            if cell in cells:
                what = f"it lies in cell {cell_text(cell)}, as {name}[{cells[cell]}] does"
                self.faults.append(fault(self._workload, path, what, "name it once"))
            cells.setdefault(cell, index)
        return tuple(cells), ()

    def _cell(self, path: tuple[str | int, ...], place: Cell | Point) -> Cell | None:
        """The free cell of a place; None where there is a fault."""
        if isinstance(place, tuple):
            cell, text = (int(place[0]), int(place[1])), f"cell {cell_text(place)}"
            outside = outside_map(cell, self._grid.shape)
        elif self._grid.frame is None:
            what = f"{place} is in metres, and the map does not say how large a cell is"
            hint = "give the map its resolution, as resolution: 5 cm or --resolution 5cm, or write row and column"
            self.faults.append(fault(self._workload, path, what, hint))
            return None
        else:
            cell = self._grid.frame.cell(place.x, place.y)
            text, outside = f"{place}, cell {cell_text(cell)},", self._outside(place)
        wrong = self._blocked(cell, text, outside, metres=isinstance(place, Point))
        if wrong is not None:
            self.faults.append(fault(self._workload, path, *wrong))
        return None if wrong else cell

    def _outside(self, place: Point) -> tuple[str, str]:
        frame, (rows, columns) = self._grid.frame, self._grid.shape
        assert frame is not None
        first, last = frame.point(rows - 1, 0), frame.point(0, columns - 1)
        size = f"{columns * frame.resolution:g} × {rows * frame.resolution:g} m"
        what = f"{place} is outside of the map of {size}"
        return what, f"middles of cells are from {point_text(*first)} to {point_text(*last)}"

    def _blocked(self, cell: Cell, text: str, outside: tuple[str, str], *, metres: bool) -> tuple[str, str] | None:
        """The reason for which a cell cannot be planned from or to, and the remedy; None if it is free."""
        grid = self._grid
        if not (0 <= cell[0] < grid.rows and 0 <= cell[1] < grid.columns):
            return outside
        if grid.free[cell]:
            return None
        near = maps.nearest_free(grid.free, cell)
        assert near is not None, "a map without a free cell is refused before"
        shown = cell_text(near)
        if metres and grid.frame is not None:
            shown = f"{point_text(*grid.frame.point(*near))}, cell {shown}"
        return f"{text} is {self._why(cell)}", f"the nearest free cell is {shown}"

    def _why(self, cell: Cell) -> str:
        """The step that blocks a cell, in words: the first of the steps to do so."""
        steps, problem = self._problem.map.steps, self._problem
        without = _after(problem, replace(steps, inflate=None))
        if without.free[cell]:
            return f"within {steps.inflate} of an obstacle (inflate)"
        if without.unknown is not None and without.unknown[cell]:
            return "in unknown space"
        return "on an obstacle"

    def _of_scenario(self, name: str, line: ScenarioLine) -> tuple[tuple[Cell, ...], tuple[float, ...]]:
        key = ("scen", maps.map_stamp(line.path))
        try:
            scenarios = _grids.get(key, lambda: maps.read_scenarios(line.path))
            chosen = maps.choose_scenarios(scenarios, line=line.line, bucket=line.bucket, same_goal=line.same_goal)
        except MapError as wrong:
            own = wrong.where in ("line", "bucket")
            what = wrong.what if own else f"{wrong.where}: {wrong.what}"
            self._refuse(name, wrong.where if own and wrong.where else "scen", what, wrong.hint)
            return (), ()
        if self._other_map(name, chosen[0]):
            return (), ()
        pairs = {scenario.start: scenario for scenario in chosen}
        if name == "goals":
            pairs = {chosen[0].goal: chosen[0]}
        for cell, scenario in pairs.items():
            text = f"line {scenario.line}: cell {cell_text(cell)}"
            wrong_cell = self._blocked(cell, text, outside_map(cell, self._grid.shape), metres=False)
            if wrong_cell is not None:
                self._refuse(name, line.key, *wrong_cell)
        return tuple(pairs), tuple(scenario.optimal_length for scenario in pairs.values())

    def _other_map(self, name: str, scenario: MovingAiScenario) -> bool:
        """True if a problem is of another map than the workload's, by name or size; that is a fault."""
        file, wanted = self._workload.map_file, self._problem.map
        its_name = scenario.map_name.replace("\\", "/").rpartition("/")[2]
        what = None
        hint = "name the .scen file of this map, or the map of this .scen file"
        if file is None or file.name.casefold() != its_name.casefold():
            here = f"the map is {printable(file.name)}" if file else "the map is generated"
            what = f"it is of the map {printable(its_name)}, and {here}"
        elif wanted.downsample > 1:
            what, hint = ("its cells are those of the whole map, and downsample joins them", "remove downsample")
        elif scenario.shape != self._grid.shape:
            sizes = [" × ".join(str(side) for side in shape) for shape in (scenario.shape, self._grid.shape)]
            what = f"it is of a map of {sizes[0]} cells, and the map has {sizes[1]}"
        if what is not None:
            self._refuse(name, "scen", what, hint)
        return what is not None

    def _refuse(self, name: str, key: str, what: str, hint: str | None) -> None:
        """Note a fault of a scenario file; once, where starts and goals are of the same problem."""
        name = "goals" if self._problem.starts is self._problem.goals else name
        wrong = fault(self._workload, ("problem", name, key), what, hint)
        self.faults += [wrong] if wrong not in self.faults else []


def _moved(cells: tuple[Cell, ...], corner: Cell) -> tuple[Cell, ...]:
    return tuple((row - corner[0], column - corner[1]) for row, column in cells)


def length_error(problem: Problem) -> float | None:
    """The largest difference, over the starts, of the shortest 8-connected path and the length of a ``.scen`` file.

    In cells. None where no such file gives the lengths, or where one of the starts has no path.
    """
    if not problem.optimal_lengths:
        return None
    lengths = _grids.get(
        ("octile", problem.digest),
        lambda: [maps.distance_octile(problem.free, problem.goals)[start] for start in problem.starts],
    )
    error = float(np.abs(np.subtract(lengths, problem.optimal_lengths)).max())
    return error if np.isfinite(error) else None


def reach_notes(problem: Problem) -> tuple[str, ...]:
    """A note where not every free cell has a path to a goal."""
    if problem.reach is None or problem.reach == 1:
        return ()
    return (f"problem.goals: {reach_text([problem.reach])}",)


def length_notes(problem: Problem) -> tuple[str, ...]:
    """A note if the lengths of a ``.scen`` file are not the lengths on this map."""
    error = length_error(problem)
    if error is None or error <= LENGTH_ERROR:
        return ()
    return (
        f"problem.goals: the shortest 8-connected path differs from the length in the .scen file by up to {error:.2f}"
        " cells: the map is not the one that the file was made for, or a step changed it",
    )


def _drawn(grid: OccupancyGrid, goals: tuple[Cell, ...], count: int, seed: int) -> tuple[Cell, ...]:
    """Starts drawn without replacement from the cells with a path to a goal; all of them where there are fewer.

    A path crosses the sides of cells here, whatever the planner's moves are. So all planners are judged by the same
    starts.
    """
    cells = maps.reachable(grid.free, goals)
    for row, column in goals:
        cells[row, column] = False
    candidates = np.argwhere(cells)
    if len(candidates) > count:
        chosen = np.random.Generator(np.random.PCG64(seed)).choice(len(candidates), count, replace=False)
        candidates = candidates[np.sort(chosen)]
    return tuple((int(row), int(column)) for row, column in candidates)
