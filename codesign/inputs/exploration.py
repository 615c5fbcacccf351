"""The section ``explore``: axes, objectives and constraints, and how a space is searched (``search``)."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import (
    BeforeValidator,
    Field,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)
from pydantic_core import InitErrorDetails

from codesign.ground.errors import InputError, choose_hint, clip
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.models import Location, RefusalError, SpecModel, raise_all, refusal_details
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.inputs.aggregate import Aggregate, Rule, Share, rule_for
from codesign.inputs.axes import MAX_VALUES, Part, When, listed, ordered, parts_of, settled
from codesign.inputs.axes import refusals as refusals_of
from codesign.inputs.constraint import Constraint, FigureName, WrittenConstraint, contradictions
from codesign.inputs.derived import DerivedFigures, in_scope, read_figures
from codesign.inputs.fields import Duration

Sampler = Literal["nsga2", "tpe", "random", "bound"]
SAMPLERS: tuple[str, ...] = get_args(Sampler)

ALL = "all"
"""In the place of a sampler: no search, all points."""

MOST_SEED = 2**32 - 1
"""The greatest seed that every generator of random numbers takes."""

ENUMERATED = 500_000
"""All points of a space of at most so many are computed in the place of a search: measured, docs/searching.md."""

POPULATION = 50
STARTUP = 10
MOST_TOGETHER = 10_000

_OPTIONS = {"population": "nsga2", "startup": "tpe"}
"""The sampler that has an option."""


class Searching(SpecModel):
    """The search that says which points to compute, its options, and how many points; as text, the sampler alone."""

    sampler: Sampler = Field(
        description="nsga2, tpe (extra search), random, or bound. As --search."
        f" All but random compute all points of a space of at most {ENUMERATED:,}, where they take few simulations."
    )
    points: Annotated[int, Field(ge=1)] | None = Field(
        default=None, description="Compute no more than so many points. As --points."
    )
    time: Duration | None = Field(default=None, description="Begin no point after this time, such as 10min. As --time.")
    seed: Annotated[int, Field(ge=0, le=MOST_SEED)] = Field(
        default=0, description="The same seed gives the same designs. As --seed."
    )
    population: Annotated[int, Field(ge=2, le=MOST_TOGETHER)] | None = Field(
        default=None, description=f"Of nsga2: designs in a generation. By default {POPULATION}."
    )
    startup: Annotated[int, Field(ge=1, le=MOST_TOGETHER)] | None = Field(
        default=None, description=f"Of tpe: designs drawn at random before it models anything. By default {STARTUP}."
    )

    @field_validator(*_OPTIONS, mode="after")
    @classmethod
    def _of_its_sampler(cls, value: int | None, info: ValidationInfo) -> int | None:
        sampler, owner = info.data.get("sampler"), _OPTIONS[info.field_name or ""]
        if value is not None and sampler is not None and sampler != owner:
            raise RefusalError(
                f"{sampler} has no {info.field_name}", f"it is an option of {owner}: leave it out", of_key=True
            )
        return value

    @property
    def seconds(self) -> float | None:
        """``time`` in seconds."""
        return None if self.time is None else self.time / PICOSECONDS_PER_SECOND

    def as_random(self) -> Self:
        """Random search with the same seed."""
        return self.model_copy(update={"sampler": "random", **dict.fromkeys(_OPTIONS)})


Search = Annotated[
    Searching | None,
    BeforeValidator(lambda raw: {"sampler": raw} if isinstance(raw, str) else raw),
    WithJsonSchema({"anyOf": [{"enum": list(SAMPLERS)}, Searching.model_json_schema()]}, mode="validation"),
]
"""A search as a file has it."""


def check_search(name: str, seed: int) -> None:
    """Refuse a search that does not exist, and a seed that is none.

    Raises:
        InputError: with the nearest name.
    """
    if name not in (*SAMPLERS, ALL):
        raise InputError(f"there is no search {name}", "search", choose_hint(name, (*SAMPLERS, ALL)))
    if not 0 <= seed <= MOST_SEED:
        raise InputError(f"{seed} is no seed", "seed", f"give a whole number from 0 to {MOST_SEED}")


def asked(written: Searching | None, name: str | None, seed: int | None) -> Searching | None:
    """The search of a file, with another sampler or seed where they are named; None: all points are computed.

    With another sampler, budget and seed stay; options that it has not are left out.

    Raises:
        InputError: see ``check_search``; or a seed of no search.
    """
    if name is not None:
        check_search(name, seed or 0)
    if (name or (written and written.sampler) or ALL) == ALL:
        if seed is not None:
            raise InputError(f"a seed of {seed} is of no search", "seed", "name one: --search nsga2")
        return None
    fields: Mapping[str, Any] = {} if written is None else written.model_dump(include=written.model_fields_set)
    sampler = name or fields["sampler"]
    if written is not None and sampler != written.sampler:
        fields = {key: value for key, value in fields.items() if key not in _OPTIONS}
    check_search(sampler, seed or 0)
    update = {**fields, "sampler": sampler, **({} if seed is None else {"seed": seed})}
    return Searching.model_construct(**update)


MAX_AXES = 16
MAX_POINTS = 10**15

_AXIS = re.compile(r"platform|[A-Za-z_][A-Za-z0-9_-]*(\.[A-Za-z_][A-Za-z0-9_-]*)+")


DEFAULT_OBJECTIVES = tuple(
    FIGURES[name] for name in ("plan_time_worst_s", "slices", "block_rams", "energy_j", "share_reaching_goal")
)

FLEET_OBJECTIVES = (FIGURES["first_plan_s"], *DEFAULT_OBJECTIVES[1:])
"""The objectives of an exploration of fleets that names none: a fleet has no plan of its own."""

MISSION_OBJECTIVES = tuple(FIGURES[name] for name in ("mission_time_s", "mission_energy_j", "slices", "block_rams"))
"""The objectives of an exploration of drives that names none: what replans cost is in the time."""


_LIST = {"type": "array", "items": {}, "minItems": 1, "maxItems": MAX_VALUES}
_END = {"type": ["number", "string"]}
_FORMS = {
    "anyOf": [
        _LIST,
        {
            "type": "object",
            "properties": {
                "values": _LIST,
                "from": _END,
                "to": _END,
                "step": _END,
                "factor": {"type": "number", "exclusiveMinimum": 1},
                "count": {"type": "integer", "minimum": 2, "maximum": MAX_VALUES},
                "scale": {"enum": ["linear", "log"]},
                "when": {"type": "object", "minProperties": 1},
            },
            "additionalProperties": False,
        },
    ]
}
"""The forms in which a file writes an axis: see ``axis_forms``."""

Listed = Annotated[
    tuple[Any, ...], Field(min_length=1, max_length=MAX_VALUES), WithJsonSchema(_FORMS, mode="validation")
]
Axes = Annotated[dict[str, Listed], Field()]


class Exploration(SpecModel):
    """Decisions, conditions, objectives and constraints.

    Each combination of values of the axes is a design. A design has one point for each combination of conditions.

    ``axes`` and ``conditions``: raw values by axis, ``TASK.PARAMETER``, ``COMPONENT.FIELD``, ``LINK.FIELD``,
    ``ROLE.FIELD``, ``platform``, ``workload.variant``, or a key of ``workload.problem`` or ``workload.scenario``, in
    file order.
    """

    when: dict[str, dict[str, Any]] = Field(
        default={},
        max_length=MAX_AXES,
        description="For which values of other axes an axis exists: {AXIS: {OTHER: [VALUE, ...]}}. A file writes it in"
        " the axis: {values: [...], when: {OTHER: VALUE}}.",
    )
    axes: Axes = Field(
        default={},
        max_length=MAX_AXES,
        description="Decisions: values to try by axis: TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD, ROLE.FIELD,"
        " platform, workload.variant, ... A list, or a mapping: {from: 1, to: 64, factor: 2}, or step or count;"
        " {values: [...], when: {OTHER: VALUE}}.",
    )
    conditions: Axes = Field(
        default={},
        max_length=MAX_AXES,
        description="The world that each design meets, by axis: maps, sizes, seeds, traffic, error rates. All designs"
        " are run in all combinations.",
    )
    aggregate: Aggregate = Field(
        default={},
        description="How a figure of a design is made of its values in all conditions, by figure and by default:"
        ' worst, best, mean, median, {quantile: 0.9} or {share: "< 100 ms"}. Default: worst.',
    )
    figures: DerivedFigures = Field(
        default={},
        description="Figures derived from declared ones, by name: an expression, energy_j * plan_time_worst_s, or a"
        " mapping with its unit and direction. Objectives, constraints and rules may name them.",
    )
    objectives: Annotated[tuple[FigureName, ...], Field(min_length=1)] = Field(
        default=DEFAULT_OBJECTIVES,
        description="Figures that span the front, each in its own direction; of drives by default"
        f" {', '.join(figure.name for figure in MISSION_OBJECTIVES)}.",
    )
    constraints: Annotated[tuple[WrittenConstraint, ...], Field(max_length=64)] = Field(
        default=(), description='Bounds that a design has to keep, as text, "time < 100 ms", or as a mapping.'
    )
    search: Search = Field(
        default=None,
        description="Which search says which points are computed: the name of a sampler, or a mapping with its budget,"
        " seed and options. Without it, all points are. The command line overrides it (--search all: all points).",
    )

    @model_validator(mode="wrap")
    @classmethod
    def _with_figures(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        raw = value.get("figures", {}) if isinstance(value, Mapping) else {}
        value = _in_order(value)
        try:
            figures = read_figures(raw)
        except (RefusalError, ValidationError):
            # Its field reports it, and the names that it should have are no faults of those that use them.
            return handler({"figures": raw})
        with in_scope(figures):
            return handler(value)

    @property
    def points(self) -> int:
        """The number of points: of each design, as many as there are combinations of conditions; 1 without an axis."""
        return sum(part.size for part in self.parts)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The points by the axes that exist for them."""
        return parts_of(self.every_axis, self.when)

    @property
    def when_as_written(self) -> dict[str, Any]:
        """``when`` with lists, as a document has it."""
        return {
            axis: {other: list(values) for other, values in conditions.items()}
            for axis, conditions in self.when.items()
        }

    def settled(self, values: Mapping[str, Any]) -> Self:
        """The exploration with these axes taken out of it, and those that do not exist for these values.

        What depends on the values, does so no more.
        """
        left = settled(self.axes, self.when, values)
        axes = {axis: listed for axis, listed in self.axes.items() if axis in left}
        conditions = {axis: listed for axis, listed in self.conditions.items() if axis not in values}
        when = {axis: conditions for axis, conditions in left.items() if conditions}
        return self.model_copy(update={"axes": axes, "conditions": conditions, "when": when})

    @property
    def every_axis(self) -> dict[str, tuple[Any, ...]]:
        """Decisions, then conditions."""
        return {**self.axes, **self.conditions}

    @field_validator("axes", "conditions", mode="after")
    @classmethod
    def _distinct_points(cls, value: dict[str, tuple[Any, ...]], info: ValidationInfo) -> dict[str, tuple[Any, ...]]:
        refusals = []
        for axis, values in value.items():
            if not _AXIS.fullmatch(axis):
                hint = "write TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD or platform, such as relax.iterations"
                refusals.append(refusal_details(RefusalError(f"{clip(axis)!r} is no axis", hint), (axis,)))
            texts = [json.dumps(each, sort_keys=True) for each in values]
            refusals += _repeated(texts, (axis,))
        when = info.data.get("when") or {}
        if info.field_name == "axes" and not refusals:
            for conditions in when.values():
                # What is one value and what a list of them follows from the values of the other axis.
                conditions |= {other: listed(raw, value.get(other, ())) for other, raw in conditions.items()}
            refusals += [refusal_details(each, (axis,)) for axis, each in refusals_of(value, when)]
        if not refusals:
            refusals += _too_many(value, when if info.field_name == "axes" else {})
        raise_all("Exploration", refusals)
        return value

    @field_validator("conditions", mode="after")
    @classmethod
    def _conditions_beside_axes(
        cls, value: dict[str, tuple[Any, ...]], info: ValidationInfo
    ) -> dict[str, tuple[Any, ...]]:
        """Conditions that set what an axis sets, and too many of both together."""
        axes: Mapping[str, tuple[Any, ...]] = info.data.get("axes") or {}
        refusals = []
        for condition in value:
            axis = next((axis for axis in axes if overlap(axis, condition)), None)
            if axis is not None:
                refusal = RefusalError(f"sets the same thing as axis {axis}", "keep one of them", of_key=True)
                refusals.append(refusal_details(refusal, (condition,)))
        if axes and not refusals:
            if len(axes) + len(value) > MAX_AXES:
                what = f"{len(axes)} axes and {len(value)} conditions are too many"
                refusals.append(refusal_details(RefusalError(what, f"at most {MAX_AXES} together")))
            refusals += _too_many({**axes, **value}, info.data.get("when") or {})
        raise_all("Exploration", refusals)
        return value

    @field_validator("constraints", mode="after")
    @classmethod
    def _bounds_together(cls, value: tuple[Constraint, ...], info: ValidationInfo) -> tuple[Constraint, ...]:
        aggregate = info.data.get("aggregate") or {}
        raise_all("Exploration", [refusal_details(each, (index,)) for index, each in not_kept(value, aggregate)])
        return value

    @field_validator("objectives", mode="after")
    @classmethod
    def _distinct_objectives(cls, value: tuple[ResultFigure, ...]) -> tuple[ResultFigure, ...]:
        raise_all("Exploration", _repeated([figure.name for figure in value]))
        return value


def not_kept(constraints: Sequence[Constraint], aggregate: Mapping[str, Rule]) -> list[tuple[int, RefusalError]]:
    """Each constraint that no design can keep, by its position.

    It bounds a figure that is aggregated by share, or contradicts one before it.
    """
    refusals = contradictions(constraints)
    for index, limit in enumerate(constraints):
        if isinstance(rule_for(aggregate, limit.figure), Share):
            what = f"{limit.figure} is aggregated by share, which has its limit in the rule"
            hint = "write {share: {...}, required: 0.9} in aggregate, and leave this constraint out"
            refusals.append((index, RefusalError(what, hint)))
    return refusals


def overlap(axis: str, other: str) -> bool:
    """True if two axes set the same thing: the same key, or a key inside the other's."""
    return f"{axis}.".startswith(f"{other}.") or f"{other}.".startswith(f"{axis}.")


def _in_order(value: Any) -> Any:
    """A raw section with each axis behind those that its existence depends on, as far as it can be read."""
    if not isinstance(value, Mapping):
        return value
    axes, when = value.get("axes"), value.get("when")
    if not isinstance(axes, Mapping) or not isinstance(when, Mapping) or len(axes) > MAX_AXES:
        return value
    if not all(isinstance(each, Mapping) for each in when.values()):
        return value
    return {**value, "axes": {axis: axes[axis] for axis in ordered(axes, when)}}


def _too_many(axes: Mapping[str, Sequence[Any]], when: When) -> list[InitErrorDetails]:
    try:
        points = sum(part.size for part in parts_of(axes, when))
    except RefusalError as refusal:
        return [refusal_details(refusal)]
    if points <= MAX_POINTS:
        return []
    sizes = "" if when else f"{' x '.join(str(len(values)) for values in axes.values())} = "
    what = f"{sizes}{points:,} points are too many"
    return [refusal_details(RefusalError(what, f"at most {MAX_POINTS:,}"))]


def _repeated(texts: Sequence[str], location: Location = ()) -> list[InitErrorDetails]:
    """A refusal of each entry that stands in the list before."""
    refusals, seen = [], set()
    for index, text in enumerate(texts):
        if text in seen:
            refusal = RefusalError(f"{clip(text)} is listed twice", "list it once")
            refusals.append(refusal_details(refusal, (*location, index)))
        seen.add(text)
    return refusals
