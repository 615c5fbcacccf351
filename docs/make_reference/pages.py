"""The pages of ``docs/reference`` by file name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from codesign import planners
from codesign.ground.figures import FIGURES
from codesign.inputs.components import COMPONENTS
from codesign.inputs.exploration import Exploration
from codesign.inputs.library import CalibrationFile, HostFile, PartFile
from codesign.inputs.links import LINKS, AnyLink
from codesign.inputs.map_spec import MAPS, FileMap, PreparedMap
from codesign.inputs.platform import Platform, PricesFile
from codesign.inputs.problem import ProblemSpec
from codesign.inputs.scenario import SCENARIOS
from codesign.inputs.tasks import SCENARIO_TASKS, ExtraTask
from codesign.inputs.workload import TaskMapping, Variant, Workload
from codesign.study.document import StudyDocument
from codesign.system import catalog
from codesign.system.results.result import Result
from docs.make_reference.model_tables import Keys, fields_of, models_in, table
from docs.make_reference.proto import proto_page
from docs.make_reference.python_pages import commands_page, python_page, trace_page

FOLDER = Path(__file__).parent.parent / "reference"
MADE = "This page is made from the code by `make docs`. Change the descriptions there, not here."
FIGURE = (
    "A `figure` is written short, as `150 MHz` or `32`, or long, with its status and its source"
    " ([spec.md](../spec.md#values)). Times, frequencies and the like always have a unit."
)
SHIPPED = sorted(plug_in.parent.name for plug_in in Path(planners.__file__).parent.glob("*/plug_in.py"))
"""The planners of this package by name; other plug-ins that are installed stay off the page."""


def pages() -> dict[str, str]:
    """Every page of the reference by its file name."""
    makers: Mapping[str, Callable[[], list[str]]] = {
        "platform.md": platform_page,
        "workload.md": workload_page,
        "part.md": part_page,
        "host.md": host_page,
        "calibration.md": calibration_page,
        "prices.md": prices_page,
        "result.md": result_page,
        "trace.md": trace_page,
        "python.md": python_page,
        "cli.md": commands_page,
    }
    return {name: _text(maker()) for name, maker in makers.items()} | {"trace.proto": proto_page()}


def _text(lines: list[str]) -> str:
    text = "\n".join(MADE if line == "MADE" else line for line in lines)
    while "\n\n\n" in text:
        text = text.replace("\n\n\n", "\n\n")
    return text.strip() + "\n"


def _file_head(title: str) -> list[str]:
    return [f"# {title}", "", "MADE", "", FIGURE, ""]


def platform_page() -> list[str]:
    """Keys of a platform file."""
    documented: dict[type, str] = dict.fromkeys(COMPONENTS.values(), "See [below](#components).")
    documented |= dict.fromkeys(LINKS.values(), "See [below](#links).")
    keys = Keys(documented)
    lines = [*_file_head("Platform files"), *keys.section(2, "Platform", Platform), "## Components", ""]
    for kind, model in COMPONENTS.items():
        lines += keys.section(3, f"`type: {kind}`", model)
    lines += ["## Links", "", *keys.section(3, "Every link", AnyLink)]
    for kind, model in LINKS.items():
        lines += keys.section(3, f"`type: {kind}`", model, without=AnyLink.model_fields)
    return lines


def part_page() -> list[str]:
    """Keys of a part file."""
    return [*_file_head("Part files"), *Keys({}).section(2, "Part", PartFile)]


def host_page() -> list[str]:
    """Keys of a host file."""
    return [*_file_head("Host files"), *Keys({}).section(2, "Host", HostFile)]


def calibration_page() -> list[str]:
    """Keys of a calibration file."""
    return [*_file_head("Calibration files"), *Keys({}).section(2, "Calibration", CalibrationFile)]


def prices_page() -> list[str]:
    """Keys of a file of prices."""
    return [*_file_head("Files of prices"), *Keys({}).section(2, "Prices", PricesFile)]


def workload_page() -> list[str]:
    """Keys of a workload file, and the parameters of the planners' tasks."""
    documented: dict[type, str] = {
        FileMap: "See [below](#maps).",
        **dict.fromkeys(MAPS.values(), "See [below](#maps)."),
        **dict.fromkeys(SCENARIOS.values(), "See [below](#scenarios)."),
        ExtraTask: "See [below](#added-tasks).",
        TaskMapping: "See [below](#mapping).",
        Variant: "See [below](#variants).",
        Exploration: "See [below](#exploration).",
        ProblemSpec: "See [below](#problem).",
    }
    keys = Keys(documented)
    lines = [*_file_head("Workload files"), *keys.section(2, "Workload", Workload)]
    lines += keys.section(2, "Problem", ProblemSpec)
    problem_models, task_models = catalog.problem_models(), catalog.task_models()
    for name in SHIPPED:
        if name in problem_models:
            lines += keys.section(3, f"Problem of planner `{name}`", problem_models[name])
    steps = tuple(PreparedMap.model_fields)
    lines += ["## Maps", "", *keys.section(3, "Steps of every map", PreparedMap)]
    lines += keys.section(3, "`file`", FileMap, without=steps)
    for name, generator in MAPS.items():
        lines += keys.section(3, f"`generate: {name}`", generator, without=steps)
    lines += ["## Scenarios", ""]
    for name, scenario in SCENARIOS.items():
        lines += keys.section(3, f"`type: {name}`", scenario)
        tasks = ", ".join(f"`{task}`" for task in SCENARIO_TASKS[name])
        lines += [f"It brings the tasks {tasks}.", ""]
    lines += keys.section(2, "Added tasks", ExtraTask)
    lines += keys.section(2, "Mapping", TaskMapping, without=("parameters",))
    lines += ["The other keys of a task are its parameters, which depend on the planner.", ""]
    for planner in SHIPPED:
        for task, parameters in task_models[planner].items():
            if parameters.model_fields:
                lines += keys.section(3, f"Task `{task}` of planner `{planner}`", parameters)
    lines += keys.section(2, "Variants", Variant)
    lines += keys.section(2, "Exploration", Exploration)
    return [*lines, *_figures()]


def _figures() -> list[str]:
    """The figures that may be an objective or a constraint."""
    rows = [
        (f"`{figure}`", "" if figure.unit == "1" else figure.unit, figure.aim.split()[0], figure.description)
        for figure in FIGURES.values()
    ]
    return ["## Figures", "", *table(("figure", "unit", "best", "what it is"), rows), ""]


def result_page() -> list[str]:
    """What ``hwsw run --json`` and ``hwsw explore --json`` print."""
    lines = ["# Results", "", "MADE", ""]
    lines += [
        "`hwsw run --json` prints a `Result`, `hwsw explore --json` a `StudyDocument`. `hwsw schema result` and",
        "`hwsw schema study` print their JSON Schemas.",
        "",
    ]
    models = _reachable([Result, StudyDocument])
    documented = {model: f"See [`{model.__name__}`](#{model.__name__.lower()})." for model in models}
    keys = Keys(documented, with_defaults=False)
    for model in models:
        lines += keys.section(2, f"`{model.__name__}`", model)
    return lines


def _reachable(roots: list[type]) -> list[type]:
    """The models and all models inside them, each once, in the order of mention."""
    ordered = list(roots)
    for model in ordered:
        for info in fields_of(model).values():
            ordered += [each for each in models_in(info.annotation) if each not in ordered]
    return ordered
