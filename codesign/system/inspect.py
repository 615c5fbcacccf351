"""The specs at hand, the schemas of inputs and outputs, and one problem for designs of several planners."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from codesign import inputs as spec
from codesign import maps
from codesign.ground.errors import Fault, InputError, SpecError, choose_hint, clip, outside_map
from codesign.ground.models import Part, Task
from codesign.ground.units import counted
from codesign.inputs import Platform, Spec, Workload, design_point, has_axis
from codesign.inputs.document import Document, KeyPath, Origin, put
from codesign.inputs.faults import validate
from codesign.inputs.files import is_path
from codesign.inputs.library import CALIBRATIONS, HOSTS, PARTS
from codesign.inputs.places import Place, Point, cell_text, place_value, point_text
from codesign.inputs.platform import load_prices
from codesign.inputs.problem import ProblemSpec
from codesign.inputs.value_types import default_text, type_text
from codesign.inputs.yaml_tree import read_document
from codesign.maps import OccupancyGrid, Window
from codesign.maps.survey import Survey
from codesign.planners.reproduction import Settings
from codesign.system import catalog
from codesign.system.verdicts import RunDocument


def point_of(platform: Platform, workload: Workload, settings: Mapping[str, Any]) -> tuple[Platform, Workload]:
    """Platform and workload with a raw value put in the place of each named axis.

    Raises:
        SpecError: an axis that is none, or a value that is not accepted.
    """
    return spec.design_point(platform, workload, settings, "--set ") if settings else (platform, workload)


def schema_of(kind: str) -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a file, or of a ``result``.

    ``kind``: ``platform``, ``workload``, ``part``, ``host``, ``calibration``, ``prices`` or ``result``.

    Raises:
        InputError: another kind.
    """
    if kind == "result":
        return {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            **RunDocument.model_json_schema(mode="serialization"),
        }
    files = ("platform", "workload", "part", "host", "calibration", "prices")
    if kind not in files:
        raise InputError(f"there is no schema of {kind!r}", hint=choose_hint(kind, [*files, "result"]))
    return spec.json_schema(kind, catalog.task_models(), catalog.problem_models())


@dataclass(frozen=True)
class Parameter:
    """A parameter of a task, in words: accepted values, default, meaning."""

    task: str
    name: str
    accepted: str
    default: str
    meaning: str


@dataclass(frozen=True)
class PlannerFacts:
    """A planner as its users see it: parameters of its tasks, styles by name, and policies, the default first.

    ``styles`` of the planning task, and of tasks that are placed by themselves as ``TASK.STYLE``.
    """

    name: str
    description: str
    parameters: tuple[Parameter, ...]
    styles: dict[str, str]
    policies: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """The facts for JSON."""
        return asdict(self)


def planner_facts(name: str) -> PlannerFacts:
    """The facts of an installed planner.

    Raises:
        InputError: no such planner is installed, or it cannot be loaded.
    """
    planner = catalog.planner(name)
    parameters = tuple(each for task, model in planner.tasks.items() for each in _parameters(task, model))
    styles = {style: f"on {each.component_type}: {each.description}" for style, each in catalog.styles_of(name).items()}
    styles |= {
        f"{task}.{style}": f"on {component}"
        for planner_name, task, component, style in catalog.task_styles()
        if planner_name == name
    }
    return PlannerFacts(name, planner.description, parameters, styles, planner.policies)


def paper_settings(names: Iterable[str]) -> tuple[Parameter, ...]:
    """The settings of the papers of these planners, which ``hwsw reproduce --set`` moves."""
    return tuple(each for name in names for each in _parameters(name, catalog.paper_settings(name)))


def settings_by_paper(names: Sequence[str], values: Mapping[str, Any]) -> dict[str, Settings]:
    """The settings of each paper, by its planner: a value is of every paper that has a setting of that name.

    Raises:
        SpecError: a value that is not accepted, or a name that no paper has.
    """
    models = {name: catalog.paper_settings(name) for name in names}
    accepted = sorted({key for model in models.values() for key in model.model_fields})
    faults = [
        Fault(f"--set {clip(key)}", 0, 0, "", "there is no such setting", choose_hint(clip(key, 60), accepted))
        for key in values
        if key not in accepted
    ]
    settings: dict[str, Settings] = {}
    for name, model in models.items():
        raw: dict[KeyPath, Any] = {(key,): value for key, value in values.items() if key in model.model_fields}
        document = put(Document("", Path(), {}), raw, lambda path: Origin((f"--set {path[0]}",)))
        try:
            settings[name] = validate(model, document)
        except SpecError as wrong:
            faults += wrong.faults
    if faults:
        raise SpecError(dict.fromkeys(faults))
    return settings


def _parameters(group: str, model: type[BaseModel]) -> Iterator[Parameter]:
    for key, info in model.model_fields.items():
        texts = type_text(info.annotation, tuple(info.metadata)), default_text(info), info.description or ""
        yield Parameter(group, key, *map(_plain, texts))


def _plain(text: str) -> str:
    """A text of the reference pages without the marks of Markdown."""
    return text.replace("`", "")


def own_names(sources: Iterable[str | Path]) -> set[str]:
    """The names that files give, whatever their kind; of those that can be read."""
    names = set()
    for source in filter(is_path, sources):
        with suppress(SpecError):
            tree = read_document(Path(source), str(source)).tree
            names |= {tree["name"]} if isinstance(tree, dict) and isinstance(tree.get("name"), str) else set()
    return names


def load_any(source: str | Path, own: Collection[str] = ()) -> Spec | Part:
    """The spec of a source of any kind. ``own``: the names of platforms of the user's own, for prices."""
    if not is_path(source):
        shipped: dict[str, Callable[[str], Spec | Part]] = {
            **dict.fromkeys(HOSTS.names(), HOSTS.find),
            **dict.fromkeys(spec.list_parts(), spec.load_part),
            **dict.fromkeys(spec.list_workloads(), catalog.load_workload),
            **dict.fromkeys(spec.list_platforms(), spec.load_platform),
        }
        name = str(source)
        if name not in shipped:
            raise InputError(f"there is no shipped spec {name!r}", hint=choose_hint(name, shipped))
        return shipped[name](name)
    tree = read_document(Path(source), str(source)).tree
    kind = tree.get("kind") if isinstance(tree, dict) else None
    readers: dict[Any, Callable[[Path], Spec]] = {
        "platform": spec.load_platform,
        "part": PARTS.load,
        "host": HOSTS.load,
        "calibration": CALIBRATIONS.load,
        "prices": lambda file: load_prices(file, own),
    }
    read = readers.get(kind) if isinstance(kind, str) else None
    return catalog.load_workload(source) if read is None else read(Path(source))


def problem_of(workload: Workload) -> ProblemSpec:
    """The map, goals and starts of a workload.

    Raises:
        InputError: its planner has a problem of another kind.
    """
    if not isinstance(workload.problem, ProblemSpec):
        what = f"the problem of {workload.name} is not a map with goals and starts"
        raise InputError(what, hint="choose a workload of another planner")
    return workload.problem


def problem_from_map(file: Path, goal: Place, start: Place, reach: float | None = None) -> ProblemSpec:
    """The problem of one goal and one start on a map file; ``reach``: see ``ProblemSpec``.

    Raises:
        SpecError: there is no such file, or a place is none; at --map, --goal and --start.
    """
    tree: dict[str, Any] = {
        "map": {"file": str(file.resolve())},
        "goals": [place_value(goal)],
        "starts": [place_value(start)],
    }
    tree |= {} if reach is None else {"reach": reach}
    try:
        return validate(ProblemSpec, Document("command line", Path(), tree))
    except SpecError as wrong:
        raise at_options(wrong) from None


def with_task(problem: ProblemSpec, task: str) -> ProblemSpec:
    """The problem with another task.

    Raises:
        InputError: task ``replan``, and the problem declares no change.
    """
    if task == Task.REPLAN and problem.change is None:
        hint = "name a workload with problem.change by --on, such as change: {count: 20, seed: 0}"
        raise InputError("task replan follows a change of the map, and none is declared", "--task", hint)
    return problem.model_copy(update={"task": Task(task)})


def with_problem(workload: Workload, problem: ProblemSpec) -> Workload:
    """The workload on another map, with its goals and starts.

    Raises:
        InputError: its planner takes no map.
    """
    problem_of(workload)
    return workload.model_copy(update={"problem": problem})


def applicable(platform: Platform, workload: Workload, settings: Mapping[str, Any]) -> tuple[Platform, Workload]:
    """Platform and workload with those settings that name a parameter or a field they have.

    Raises:
        SpecError: a value that is not accepted.
    """
    chosen = {axis: value for axis, value in settings.items() if has_axis(platform, workload, axis)}
    return design_point(platform, workload, chosen, "--set ") if chosen else (platform, workload)


_OPTIONS = {"map": "--map", "goals": "--goal", "starts": "--start"}


def at_options(wrong: SpecError, options: Mapping[str, str] = _OPTIONS) -> SpecError:
    """The same faults; the faults of the map, its goal and its start stand at the options that gave them.

    ``options``: by the key of the problem, whole or its first part.
    """
    return SpecError(_at_option(fault, options) for fault in wrong.faults)


def _at_option(fault: Fault, options: Mapping[str, str]) -> Fault:
    key = fault.key.removeprefix("problem.")
    option = options.get(key, options.get(key.partition(".")[0].partition("[")[0]))
    return fault if option is None else Fault(option, 0, 0, "", fault.what, fault.hint)


Cell = tuple[int, int]


def place_on(grid: OccupancyGrid, place: Cell | Point, option: str) -> Cell:
    """The cell of a place that a user asks for.

    Raises:
        InputError: it is outside of the map, or in metres on a map without a resolution; at ``option``.
    """
    if isinstance(place, Point):
        if grid.frame is None:
            what = f"{place} is in metres, and the map does not say how large a cell is"
            raise InputError(what, option, "write ROW,COLUMN, or give the map a resolution, such as 5cm")
        place = grid.frame.cell(place.x, place.y)
    if not (0 <= place[0] < grid.rows and 0 <= place[1] < grid.columns):
        what, hint = outside_map(place, grid.shape)
        raise InputError(what, option, hint)
    return place


def map_lines(figures: Survey, at: Cell | None = None) -> Iterator[str]:
    """The facts of a map, a line each; ``at``: a cell to find the nearest free cell of."""
    grid = figures.grid
    yield f"{grid.source}: {grid.rows} × {grid.columns} cells (rows × columns)"
    frame = grid.frame
    if frame is None:
        yield "metres: unknown, as the map gives no resolution"
    else:
        size = f"{grid.columns * frame.resolution:g} × {grid.rows * frame.resolution:g} m (x × y)"
        left, below = frame.origin[:2]
        yield f"metres: {frame.resolution:g} m a cell, {size}, lower left corner {point_text(left, below)}"
        if frame.origin[2]:
            yield f"turned: {frame.origin[2]:g} rad around that corner"
    known = f"{figures.free:,} free, {figures.blocked:,} blocked, {figures.unknown:,} unknown"
    yield f"cells: {known}"
    count = len(figures.components)
    if count:
        largest = f"the largest has {figures.components[0]:,} cells"
        yield f"free space: {counted(count, 'component')} across the sides of cells, {largest}"
        for name, part in (("free", figures.around_free), ("reachable", figures.around_largest)):
            yield f"crop: {name} leaves {_saved(grid, part)}"
    else:
        yield "free space: none"
    if at is not None:
        yield _nearest(grid, at)
    yield from (f"note: {remark}" for remark in grid.remarks)


def _saved(grid: OccupancyGrid, part: Window) -> str:
    share = part.rows * part.columns / grid.free.size
    last = (part.row + part.rows - 1, part.column + part.columns - 1)
    cells = f"{cell_text(part.corner)} to {cell_text(last)}"
    return f"{part.rows} × {part.columns} cells, {cells}: {share:.1%} of the map"


def _nearest(grid: OccupancyGrid, at: Cell) -> str:
    near = maps.nearest_free(grid.free, at)
    if near is None:
        return f"at {_named(grid, at)}: no cell of the map is free"
    if near == at:
        return f"at {_named(grid, at)}: free"
    where = "unknown" if grid.unknown is not None and grid.unknown[at] else "blocked"
    return f"at {_named(grid, at)}: {where}; the nearest free cell is {_named(grid, near)}"


def _named(grid: OccupancyGrid, cell: Cell) -> str:
    frame = grid.frame
    return cell_text(cell) if frame is None else f"{cell_text(cell)}, {point_text(*frame.point(*cell))}"
