"""The question: a map with goals and starts, and what is asked of a board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from pydantic import Field

from codesign.ground.errors import InputError, SpecError
from codesign.ground.units import Dimension, parse_quantity
from codesign.inputs.places import parse_place, place_value
from codesign.maps import Crop, OccupancyGrid
from codesign.planners.interface import Problem
from codesign.system import catalog
from codesign.system.bind import plannable
from codesign.system.inspect import at_options
from codesign.system.problem_map import load_grid
from codesign.system.results.model import ResultModel
from codesign.system.scenarios import scenario_of

_OPTIONS = {
    "map": "MAP",
    "map.inflate": "--clearance",
    "map.resolution": "--resolution",
    "goals": "--goal",
    "starts": "--start",
    "reach": "--reach",
    "task": "--task",
    "change": "--change",
}
"""The option that gives each key of the problem."""


class Needs(ResultModel):
    """The needs that a board has to meet. A limit that is None is not asked for."""

    rate_hz: float = Field(description="plans a second, Hz")
    power_w: float | None = Field(default=None, description="most mean power at that rate, W")
    price_usd: float | None = Field(default=None, description="most that the board may cost, USD")
    clearance_m: float | None = Field(default=None, description="obstacles of the map are inflated by this radius, m")

    @property
    def period_s(self) -> float:
        """The time that a plan may take, s."""
        return 1.0 / self.rate_hz


@dataclass(frozen=True, eq=False)
class Question:
    """A question that is sound as far as it is known without a board.

    ``section``: the section ``problem`` of the workload of every design, as YAML has it; ``map_file``: its map, seen
    from the current folder. ``grid``: the map before it is cropped. ``problem``: the map that is planned on.
    """

    needs: Needs
    section: Mapping[str, Any]
    map_file: Path
    grid: OccupancyGrid
    problem: Problem


def parse_needs(rate: str, power: str | None = None, price: str | None = None, clearance: str | None = None) -> Needs:
    """The needs as a user writes them: ``10 Hz``, ``5 W``, ``200 USD``, ``0.3 m``.

    Raises:
        InputError: a quantity that is none, or out of its bounds; ``where`` is the option.
    """
    return Needs(
        rate_hz=float(_quantity(rate, Dimension.RATE, "--rate")),
        power_w=_optional(power, Dimension.POWER, "--power"),
        price_usd=_optional(price, Dimension.MONEY, "--price"),
        clearance_m=_optional(clearance, Dimension.LENGTH, "--clearance"),
    )


def _optional(text: str | None, dimension: Dimension, option: str) -> float | None:
    return None if text is None else float(_quantity(text, dimension, option))


def _quantity(text: str, dimension: Dimension, option: str) -> int | Fraction:
    try:
        return parse_quantity(text, dimension)
    except InputError as wrong:
        raise InputError(wrong.what, option, wrong.hint) from None


def problem_section(
    map_file: Path,
    goals: Sequence[str],
    starts: Sequence[str],
    needs: Needs,
    *,
    task: str = "path",
    unknown: str | None = None,
    resolution: str | None = None,
    changed_cells: int = 20,
    reach: float | None = None,
) -> dict[str, Any]:
    """The section ``problem`` of a workload that asks the question; the map is cropped to its free cells.

    Raises:
        InputError: a goal or a start is no place.
    """
    section: dict[str, Any] = {
        "map": {"file": str(map_file.resolve()), "crop": str(Crop.FREE)},
        "goals": [place_value(parse_place(text, "--goal")) for text in goals],
    }
    if unknown is not None:
        section["map"]["unknown"] = unknown
    if resolution is not None:
        _quantity(resolution, Dimension.LENGTH, "--resolution")
        section["map"]["resolution"] = resolution
    if needs.clearance_m:
        section["map"]["inflate"] = f"{needs.clearance_m:g} m"
    if starts:
        section["starts"] = [place_value(parse_place(text, "--start")) for text in starts]
    if reach is not None:
        section["reach"] = reach
    if task != "path":
        section["task"] = task
    if task == "replan":
        section["change"] = {"count": changed_cells, "seed": 0}
    return section


def ask(needs: Needs, section: Mapping[str, Any], map_file: Path) -> Question:
    """The question, with its map read and its goals and starts checked.

    Raises:
        SpecError: every fault of the map, its goals and starts, at the options.
    """
    faults: SpecError | None = None
    for planner in catalog.planners().values():
        if planner.problem_model is not None:
            continue
        (plug_in,) = (each for each in catalog.plug_ins() if each.planner is planner)
        mapping = {planner.planning_task: {"component": "any", **plug_in.samples.parameters[0]}}
        try:
            workload = catalog.load_workload(workload_tree(planner.name, section, mapping))
        except SpecError as wrong:
            raise at_options(wrong, _OPTIONS) from None
        problem, wrong_here = plannable(workload, scenario_of(workload))
        if problem is not None and not wrong_here:
            return Question(needs, section, map_file, load_grid(workload), problem)
        faults = faults or SpecError(wrong_here)
    if faults is None:
        raise InputError("no installed planner plans on a map", hint="hwsw list shows the planners")
    raise at_options(faults, _OPTIONS)


def workload_tree(planner: str, section: Mapping[str, Any], mapping: Mapping[str, Any]) -> dict[str, Any]:
    """A workload that plans once, as YAML has it."""
    return {
        "kind": "workload",
        "name": "advice",
        "planner": planner,
        "problem": dict(section),
        "scenario": {"type": "plan_once"},
        "mapping": dict(mapping),
    }
