"""Rules of the declarations of a plug-in: names, types, and members that have a default."""

from __future__ import annotations

from collections import Counter
from typing import Any, get_args

import numpy as np

from codesign.ground.models import SpecModel, TaskParameters
from codesign.inputs.components import PLANNING_TYPES
from codesign.planners.interface import LOWER_BOUND, Planner, Policy
from codesign.planners.plug_in import PlugIn
from codesign.planners.styles import Architecture, Memory, TaskStyle
from codesign.testing.case import Case, Rule, names, of, require, rule

POLICIES = set(get_args(Policy))
FIGURES = {"stages", "precision", "details"}


def _is_count(value: Any) -> bool:
    return type(value) is int and value >= 0


def _is_line(text: Any) -> bool:
    return isinstance(text, str) and bool(text.strip()) and "\n" not in text and not text.endswith(".")


@rule()
def plug_in_holds_parts_of_one_planner(case: Case) -> None:
    """A ``PlugIn`` of a planner with at least one style, all of them the planner's own, none twice."""
    plug_in, planner = case.plug_in, case.planner
    require(isinstance(plug_in, PlugIn), f"a {type(plug_in).__name__} is given, not a PlugIn")
    require(isinstance(planner, Planner), f"{planner!r} does not derive from codesign.plugin.Planner")
    for style, base in [(style, Architecture) for style in case.styles] + [
        (style, TaskStyle) for style in case.task_styles
    ]:
        require(isinstance(style, base), f"{style!r} does not derive from codesign.plugin.{base.__name__}")
        require(style.planner == planner.name, f"{of(style)} is of planner {style.planner!r}, not of {planner.name!r}")
    require(plug_in.planner is None or case.styles, "no style: nothing can run the planner")
    require(case.styles or case.task_styles, "neither a planner nor a style is registered")
    keys = Counter(style.style for style in case.styles)
    require(max(keys.values(), default=1) == 1, f"two styles have one name, of {names(keys)}")
    tasks = Counter((style.task, style.component_type, style.style) for style in case.task_styles)
    require(max(tasks.values(), default=1) == 1, f"two styles of one task have one name, of {names(tasks)}")
    for kernel, probe in plug_in.probes.items():
        require(kernel and callable(probe), f"the probe of kernel {kernel!r} cannot be called")


@rule()
def planner_names_its_planning_task(case: Case) -> None:
    """``planning_task`` is one of ``tasks``, and each has a model of parameters."""
    planner = case.planner
    require(planner.name, "the planner has no name")
    require(_is_line(planner.description), f"description {planner.description!r} is no line without a full stop")
    require(
        planner.planning_task in planner.tasks,
        f"planning task {planner.planning_task!r} is none of the tasks {names(planner.tasks)}",
    )
    for task, model in planner.tasks.items():
        sound = isinstance(model, type) and issubclass(model, TaskParameters)
        require(sound, f"task {task!r} has parameters of {model!r}, which is no subclass of TaskParameters")
    for style in case.task_styles:
        require(style.task in planner.tasks, f"{of(style)} is of no task of {names(planner.tasks)}")


@rule()
def planner_members_have_their_types(case: Case) -> None:
    """Members with defaults keep the types of ``Planner``, and the sample parameters fit the problem."""
    planner, job = case.planner, case.job
    model: Any = planner.problem_model
    sound = model is None or (isinstance(model, type) and issubclass(model, SpecModel))
    require(sound, f"problem_model {model!r} is neither None nor a subclass of SpecModel")
    require(type(planner.answers_no_way) is bool, f"answers_no_way is {planner.answers_no_way!r}, not a boolean")
    wrong: Any = planner.check(job)
    require(wrong is None, f"check refuses the sample parameters: {wrong!r}; give others")
    refused: Any = planner.check_drive(job)
    sound = isinstance(refused, tuple) and len(refused) == 3 and all(isinstance(each, str) for each in refused)
    require(refused is None or sound, f"check_drive gives {refused!r}, not (key, sentence, hint) or None")
    taken = planner.memory(job)
    require(_is_count(taken), f"memory gives {taken!r}, not a number of bytes")
    levers: Any = planner.memory_levers(job)
    require(isinstance(levers, list), f"memory_levers gives {levers!r}, not a list of texts")
    require(all(isinstance(lever, str) for lever in levers), f"memory_levers gives {levers!r}, not texts")
    fields = planner.fields_a_stage
    require(_is_count(fields), f"fields_a_stage is {fields!r}, not a number of fields")
    horizon = planner.horizon(job)
    require(horizon is None or horizon > 0, f"horizon gives {horizon!r}, neither None nor above 0 cells")


@rule()
def figures_and_field_fit_a_result(case: Case) -> None:
    """``figures`` fills only the planner's own fields; ``field_of`` gives one float64 for each cell."""
    figures: Any = case.planner.figures(case.plan)
    require(isinstance(figures, dict), f"figures gives {type(figures).__name__}, not a dictionary")
    strange = set(figures) - FIGURES
    require(not strange, f"figures fills {names(strange)}; a planner fills only {names(FIGURES)}")
    field: Any = case.planner.field_of(case.plan)
    if field is not None:
        name, unit, values = field
        require(name and isinstance(name, str) and isinstance(unit, str), "field_of gives no name or no unit")
        shape = (case.problem.rows, case.problem.columns)
        require(
            values.dtype == np.float64 and values.shape == shape,
            f"field_of gives {values.dtype} {values.shape}, not float64 {shape}",
        )


@rule()
def policies_have_what_they_take(case: Case) -> None:
    """``restart`` is the default; ``lower_bound`` has its task, and ``continue`` has a start."""
    planner = case.planner
    require(planner.policies[:1] == ("restart",), f"the first policy of {planner.policies} is not 'restart'")
    strange = set(planner.policies) - POLICIES
    require(not strange, f"policies {names(strange)} are none of {names(POLICIES)}")
    require(
        ("lower_bound" in planner.policies) == (LOWER_BOUND in planner.tasks),
        "policy 'lower_bound' and task 'lower_bound' come together: one of them is missing",
    )
    start = planner.start_of(case.plan)
    require(
        ("continue" in planner.policies) == (start is not None),
        f"start_of gives {type(start).__name__}: policy 'continue' needs a start, and only that policy has one",
    )


@rule(lambda case: bool(case.every_style))
def style_members_have_their_types(case: Case) -> None:
    """Members of styles keep the types of their base classes."""
    for style in case.every_style:
        require(style.style, f"a style of planner {style.planner!r} has no name")
        require(
            _is_line(style.description),
            f"description {style.description!r} of {of(style)} is no line without a full stop",
        )
        require(style.component_type in PLANNING_TYPES, f"{of(style)} runs on none of {names(PLANNING_TYPES)}")
    for style in case.styles:
        require(type(style.supports_external) is bool, f"supports_external of {of(style)} is no boolean")
        require(
            style.supports_external <= (style.component_type == "fpga"),
            f"{of(style)} runs on no FPGA and cannot keep its memories beside one",
        )
        memory: Any = style.memory(case.job_on(style))
        if memory is not None:
            require(isinstance(memory, Memory), f"memory of {of(style)} gives {type(memory).__name__}")
            sound = memory.width > 0 and memory.words and all(words > 0 for words in memory.words.values())
            require(sound, f"memory of {of(style)} has no words or words of no bits: {memory}")


RULES: tuple[Rule, ...] = (
    plug_in_holds_parts_of_one_planner,
    planner_names_its_planning_task,
    planner_members_have_their_types,
    style_members_have_their_types,
    policies_have_what_they_take,
    figures_and_field_fit_a_result,
)
