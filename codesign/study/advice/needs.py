"""The question: a map with goals and starts, and what is asked of a board."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from codesign.ground.errors import InputError, SpecError, choose_hint
from codesign.ground.units import PICOSECONDS_PER_SECOND, Dimension, counted, format_power, format_quantity, format_time
from codesign.inputs.constraint import Constraint, needs_of
from codesign.inputs.places import cell_text, parse_place, place_value, point_text
from codesign.maps import Crop, OccupancyGrid
from codesign.planners.interface import Problem
from codesign.study.advice.motion import Motion, motion_text, option_quantity
from codesign.system import catalog
from codesign.system.bind import plannable
from codesign.system.inspect import at_options
from codesign.system.problem_map import load_grid
from codesign.system.results.model import ResultModel
from codesign.system.results.result import reach_text
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


Where = Literal["fabric", "host", "split"]
"""The placement of a design: all on an FPGA, all on a processor, or a task on another component."""

SHARE = 0.8
"""The share of a part's logic that a design may use: a fuller one hardly routes. Assumed."""


class Needs(ResultModel):
    """The needs that a board has to meet. A limit that is None is not asked for."""

    rate_hz: float = Field(description="plans a second, Hz: one over the time that a plan may take")
    power_w: float | None = Field(default=None, description="most mean power at that rate, W")
    price_usd: float | None = Field(default=None, description="most that the board may cost, USD")
    clearance_m: float | None = Field(default=None, description="obstacles of the map are inflated by this radius, m")
    motion: Motion | None = Field(
        default=None,
        description="the body that has to stop in time; without a rate of its own, the rate follows from it",
    )
    rate_is_asked: bool = Field(default=True, description="whether the rate was asked for, not a speed")
    detour: float | None = Field(
        default=None, description="most that a path may be as long as the shortest 8-connected one, of every start"
    )
    share: float = Field(default=SHARE, description="the share of a part's logic that a design may use")
    limits: tuple[Constraint, ...] = Field(default=(), description="limits on other figures, as of hwsw run --need")
    on: Where | None = Field(default=None, description="only designs of this placement")
    planner: str | None = Field(default=None, description="only designs of this planner")
    style: str | None = Field(default=None, description="only designs of this architecture style")

    @property
    def period_s(self) -> float:
        """The time that a plan may take, s."""
        return 1.0 / self.rate_hz

    @property
    def only(self) -> str:
        """The placement, planner and style that designs are limited to, in words; "" where they are not."""
        return " ".join(filter(None, (f"on {self.on}" if self.on else "", self.planner, self.style)))

    @property
    def remark(self) -> str:
        """A remark on the power where the sensor begins fewer plans than the rate says; "" where it does not."""
        sensor = None if self.motion is None or self.rate_is_asked else self.motion.sensor_hz
        if sensor is None or sensor >= self.rate_hz:
            return ""
        rate, scans = (format_quantity(each, Dimension.RATE) for each in (self.rate_hz, sensor))
        return f"power is at {rate}; the sensor begins plans at {scans}, which takes no more"


class Goal(ResultModel):
    """A goal, as users count it: in the whole map."""

    row: int = Field(description="its row")
    column: int = Field(description="its column")
    x_m: float | None = Field(description="to the right in the frame of the map, m; None of a map without a scale")
    y_m: float | None = Field(description="up, m")

    def __str__(self) -> str:
        cell = cell_text((self.row, self.column))
        return (
            f"cell {cell}"
            if self.x_m is None or self.y_m is None
            else f"cell {cell}, its middle at {point_text(self.x_m, self.y_m)}"
        )


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

    @property
    def goals(self) -> tuple[Goal, ...]:
        """The goals in cells and in metres."""
        cells = [self.problem.named(cell) for cell in self.problem.goals]
        frame = self.grid.frame
        points = [(None, None) if frame is None else frame.point(*cell) for cell in cells]
        return tuple(
            Goal(row=cell[0], column=cell[1], x_m=at[0], y_m=at[1]) for cell, at in zip(cells, points, strict=True)
        )

    def __str__(self) -> str:
        """The question as it was understood, in a sentence."""
        problem, needs, cell = self.problem, self.needs, self.grid.resolution
        size = f"{problem.rows} × {problem.columns} cells"
        if cell is not None:
            height, width = problem.rows * cell, problem.columns * cell
            size += f" of {format_quantity(cell, Dimension.LENGTH)} ({height:.4g} × {width:.4g} m)"
        goals = "; ".join(map(str, self.goals[:_MOST_GOALS]))
        more = len(self.goals) - _MOST_GOALS
        goals += f" and {more} more" if more > 0 else ""
        reached = [] if problem.reach is None else [reach_text([problem.reach])]
        starts = counted(len(problem.starts), "start") + ("" if "starts" in self.section else ", drawn")
        what = _TASKS[self.section.get("task", "path")]
        limits = [] if needs.motion is None else [motion_text(needs.motion, judged_by_rate=needs.rate_is_asked)]
        limits += [] if needs.power_w is None else [f"at most {format_power(needs.power_w)}"]
        limits += [] if needs.price_usd is None else [f"at most {needs.price_usd:g} USD"]
        limits += [f"obstacles grown by {needs.clearance_m:g} m"] if needs.clearance_m else []
        limits += [] if needs.detour is None else [f"paths at most {needs.detour:g} times the shortest"]
        limits += [f"{each.figure.label} {text}" for each in needs.limits for text in _bounds(each)]
        limits += [f"only designs {needs.only}"] if needs.only else []
        period = format_time(round(needs.period_s * PICOSECONDS_PER_SECOND))
        when = f"{what} within {period} ({format_quantity(needs.rate_hz, Dimension.RATE)})"
        parts = [f"{when} on {self.map_file.name}, {size}, to {goals}", *reached, starts, *limits]
        return f"Asked: {'; '.join(parts)}"


def _bounds(limit: Constraint) -> list[str]:
    """The bounds of a limit in words: ``at least 2``."""
    return [f"{bound.replace('_', ' ')} {value:g}" for bound, value in limit.bounds.items()]


_MOST_GOALS = 3
"""Goals that the sentence names."""

_TASKS = {"path": "a path", "field": "a field of paths", "replan": "a new path after a change"}


def parse_needs(
    rate: str | None,
    power: str | None = None,
    price: str | None = None,
    clearance: str | None = None,
    motion: Motion | None = None,
) -> Needs:
    """The needs as a user writes them: ``10 Hz``, ``5 W``, ``200 USD``, ``0.3 m``.

    The rate is one over the longest plan that the ``motion`` leaves where no rate is given.

    Raises:
        InputError: a quantity that is none, or out of its bounds; no rate and no motion, or a rate beside a speed;
            ``where`` is the option.
    """
    if rate is None and motion is None:
        hint = "give --rate, such as 10Hz; or --range and --brake, with --speed or for the speed that a board allows"
        raise InputError("nothing says how quick a plan has to be", "--rate", hint)
    if rate is not None and motion is not None and motion.speed_mps is not None:
        what = f"--speed asks for {format_quantity(1 / motion.plan_s, Dimension.RATE)}, so both ask for a rate"
        raise InputError(what, "--rate", "leave one of them out: the one that asks for less")
    if rate is not None:
        rate_hz = option_quantity(rate, Dimension.RATE, "--rate")
    else:
        assert motion is not None, "refused above"
        rate_hz = 1 / motion.plan_s
    return Needs(
        rate_hz=rate_hz,
        power_w=_optional(power, Dimension.POWER, "--power"),
        price_usd=_optional(price, Dimension.MONEY, "--price"),
        clearance_m=_optional(clearance, Dimension.LENGTH, "--clearance"),
        motion=motion,
        rate_is_asked=rate is not None,
    )


def limited(
    needs: Needs,
    *,
    detour: float | None = None,
    needs_of_figures: Sequence[str] = (),
    share: float | None = None,
    on: Where | None = None,
    planner: str | None = None,
    style: str | None = None,
) -> Needs:
    """The needs with limits on the paths and on the designs that are searched.

    Raises:
        InputError: no such planner or style; ``where`` is the option. SpecError: a text that is no limit.
    """
    styles = list(dict.fromkeys(each for of, each in catalog.architectures() if planner in (None, of)))
    for word, option, accepted in ((planner, "--planner", list(catalog.planners())), (style, "--style", styles)):
        if word is not None and word not in accepted:
            of = f" of {planner}" if option == "--style" and planner is not None else ""
            raise InputError(f"no {option[2:]}{of} {word!r}", option, choose_hint(word, accepted))
    limits = {
        "detour": detour,
        "limits": needs_of(needs_of_figures),
        "on": on,
        "planner": planner,
        "style": style,
        "share": needs.share if share is None else share,
    }
    return needs.model_copy(update=limits)


def _optional(text: str | None, dimension: Dimension, option: str) -> float | None:
    return None if text is None else option_quantity(text, dimension, option)


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
        option_quantity(resolution, Dimension.LENGTH, "--resolution")
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
