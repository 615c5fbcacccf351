"""Figures that an exploration derives from declared ones: an expression, with a unit and a direction."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, ValidationError, WithJsonSchema

from codesign.ground.errors import choose_hint, clip, show
from codesign.ground.figures import FIGURES, SHORT_NAMES, ResultFigure
from codesign.ground.figures import label as label_of
from codesign.ground.models import RefusalError, SpecModel, details_of, raise_all, refusal_details
from codesign.inputs.expression import (
    FUNCTIONS,
    MAX_TEXT,
    Column,
    Node,
    Why,
    as_number,
    column,
    evaluate,
    evaluate_ends,
    figure_node,
    known_units,
    no_figure,
    parse,
    undefined,
    unit_text,
    why_undefined,
)

MAX_FIGURES = 16
MAX_NAME = 60
MAX_UNIT = 200

COLUMNS = frozenset(
    {"index", "design", "feasible", "on_front", "state", "why_not", "reason", "codesign", "platform", "platform_digest"}
    | {"workload_digest", "map_digest", "seeds", "date"}
)
"""The columns of a table of points that are no figures."""

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True)
class DerivedFigure(ResultFigure):
    """A figure that an expression over declared figures makes.

    - ``definition``: the expression as it was written. ``node``: as it was read.
    - ``size``: of its unit, in base units.
    """

    value: Callable[[Any], float | None] | None = field(default=None, compare=False)
    definition: str = ""
    node: Node = field(default=Node("number", (), "0"), compare=False)
    size: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "value", lambda result: self.of(lambda name: result.figure(FIGURES[name])))

    def __reduce__(self) -> tuple[Callable[..., DerivedFigure], tuple[Any, ...]]:
        given = (self.name, self.within, self.description, self.label, self.unit, self.maximise)
        return _again, (*given, self.definition, self.node, self.size)

    @property
    def names(self) -> tuple[str, ...]:
        """The declared figures that it is made of."""
        return self.node.names

    def of(self, figure: Callable[[str], float | None]) -> float | None:
        """Its value for one point, by the values of the declared figures; None where it has none."""
        value = as_number(evaluate(self.node, lambda name: column(figure(name)))) / self.size
        return value if math.isfinite(value) else None

    def why_none(self, figure: Callable[[str], float | None]) -> str | None:
        """The reason for no value at one point (``division by zero in ...``); None if the point has a value."""
        return why_undefined(self.node, figure) or (None if self.of(figure) is not None else _TOO_LARGE)

    def whys(self, columns: Callable[[str], Column]) -> list[Why]:
        """The reasons for no value in entries of the columns of its ``names``, each with these entries.

        The first that holds an entry is its reason: equal to ``why_none`` for each entry by itself.
        """
        late = np.isnan(derived_column(self, columns))
        whys = [*undefined(self.node, columns), (_TOO_LARGE, late)]
        return [(why, np.broadcast_to(where, late.shape)) for why, where in whys]

    def limit(self, text: str) -> float:
        """The limit of a text, such as ``3 mJ s``, in its unit.

        Raises:
            RefusalError: it is no expression without figures, or of another unit.
        """
        node = parse(text, {})
        if node.powers != self.node.powers:
            mine, example = unit_text(self.node.powers), f"write a number and a unit: 1 {self.unit}"
            what = f"{show(text)} is in {unit_text(node.powers)}, and {self} in {mine}"
            raise RefusalError(what, "write a plain number" if not self.node.powers else example)
        return constant_of(node) / self.size

    @property
    def as_written(self) -> dict[str, str]:
        """The keys and texts that a file says of it."""
        return {"expression": self.definition, "unit": self.unit, "direction": self.direction, "label": self.label}


_TOO_LARGE = "a number too large for its unit"


def _again(*given: Any) -> DerivedFigure:
    names = ("name", "within", "description", "label", "unit", "maximise", "definition", "node", "size")
    return DerivedFigure(**dict(zip(names, given, strict=True)))


def constant_of(node: Node) -> float:
    """The value of an expression without figures, in base units."""
    return as_number(evaluate(node, no_figure))


def derived_column(figure: DerivedFigure, columns: Callable[[str], Column]) -> Column:
    """The value of a derived figure for each entry of the columns of its ``names``; NaN: none.

    Equal to ``figure.of`` for each entry by itself, to the bit.
    """
    return _in_unit(evaluate(figure.node, columns), figure)


def derived_ends(figure: DerivedFigure, ends: Callable[[str], tuple[Column, Column]]) -> tuple[Column, Column]:
    """The least and the greatest value of a derived figure inside the intervals of its ``names``; NaN: none."""
    low, high = (_in_unit(each, figure) for each in evaluate_ends(figure.node, ends))
    none = np.isnan(low) | np.isnan(high)
    return np.where(none, np.nan, low), np.where(none, np.nan, high)


def derived_bounds(
    figure: DerivedFigure, columns: Callable[[str], Column], bounds: Callable[[str], tuple[Column, Column]]
) -> tuple[Column, Column]:
    """The least and the greatest value of a derived figure inside the intervals of its ``names``.

    NaN where none of them rests on an interval, or where it has no value somewhere inside them. ``columns``: their
    values, 1-d; ``bounds``: the ends of their intervals, NaN where they rest on none.
    """
    unsure = np.zeros(1, np.bool_)

    def ends(name: str) -> tuple[Column, Column]:
        nonlocal unsure
        value, (low, high) = columns(name), bounds(name)
        given = ~np.isnan(low)
        unsure = unsure | given
        return np.where(given, low, value), np.where(given, high, value)

    low, high = derived_ends(figure, ends)
    return np.where(unsure, low, np.nan), np.where(unsure, high, np.nan)


def derived_interval(
    figure: DerivedFigure, value: Callable[[str], float | None], interval: Callable[[str], tuple[float, float] | None]
) -> tuple[float, float] | None:
    """``derived_bounds`` of one result; None in the place of NaN."""

    def columns(name: str) -> Column:
        held = value(name)
        return np.array([math.nan if held is None else held], np.float64)

    def bounds(name: str) -> tuple[Column, Column]:
        low, high = interval(name) or (math.nan, math.nan)
        return np.array([low], np.float64), np.array([high], np.float64)

    low, high = (float(each[0]) for each in derived_bounds(figure, columns, bounds))
    return None if math.isnan(low) else (low, high)


def _in_unit(values: Column, figure: DerivedFigure) -> Column:
    with np.errstate(over="ignore"):
        own = values / figure.size
    return np.where(np.isfinite(own), own, np.nan)


_SCOPE: ContextVar[Mapping[str, ResultFigure]] = ContextVar("_SCOPE", default=FIGURES)


@contextmanager
def in_scope(figures: Mapping[str, ResultFigure]) -> Iterator[None]:
    """Let these figures be named beside the declared ones while the block runs."""
    token = _SCOPE.set({**FIGURES, **figures})
    try:
        yield
    finally:
        _SCOPE.reset(token)


def known_figures() -> Mapping[str, ResultFigure]:
    """The figures that may be named, by name: the declared ones, and those derived by the exploration being read."""
    return _SCOPE.get()


def nodes() -> dict[str, Node]:
    """The meaning of each name in an expression: the known figures, their columns, and their short names."""
    known = {
        name: figure.node if isinstance(figure, DerivedFigure) else figure_node(name, figure.unit)
        for name, figure in known_figures().items()
    }
    columns = {figure.column: known[name] for name, figure in known_figures().items()}
    return {**{short: known[name] for short, name in SHORT_NAMES.items()}, **columns, **known}


def derived(name: str, text: str, unit: str | None = None, *, maximise: bool = False, label: str = "") -> DerivedFigure:
    """The figure of an expression over the known figures.

    Raises:
        RefusalError: it is no expression, names no figure, or has another unit.
    """
    node = parse(text, nodes())
    if not node.names:
        raise RefusalError(f"{show(clip(text, 60))} names no figure", choose_hint("", FIGURES))
    return _figure(name, text, node, unit, maximise=maximise, label=label)


def difference(left: str, right: str) -> DerivedFigure:
    """The figure that is below 0 where the one expression is below the other.

    Raises:
        RefusalError: see ``derived``.
    """
    return derived(f"{left} - ({right})", f"{left} - ({right})")


def _figure(name: str, text: str, node: Node, unit: str | None, *, maximise: bool, label: str) -> DerivedFigure:
    size = 1.0
    if unit is not None and unit != "1":
        wanted = _unit_node(unit)
        if wanted.powers != node.powers:
            what = f"{show(clip(text, 60))} is in {unit_text(node.powers)}, not in {clip(unit, 60)}"
            raise RefusalError(what, f"write {unit_text(node.powers)}, or leave the unit out", ("unit",))
        size = constant_of(wanted)
    elif unit == "1" and node.powers:
        what = f"{show(clip(text, 60))} is in {unit_text(node.powers)}"
        raise RefusalError(what, "leave the unit out", ("unit",))
    unit = unit or unit_text(node.powers)
    if len(unit) > MAX_UNIT:
        hint = "divide it by powers of its unit, such as 1 J^2"
        raise RefusalError(f"{show(clip(text, 60))} has a unit of {len(unit)} characters", hint)
    return DerivedFigure(
        name,
        "derived",
        f"{text}, of the exploration",
        label or label_of(name),
        unit,
        maximise,
        definition=text,
        node=node,
        size=size,
    )


def _unit_node(unit: str) -> Node:
    try:
        node = parse(f"1 {unit}", {})
    except RefusalError as refusal:
        raise RefusalError(f"{show(clip(unit, 60))} is no unit", refusal.hint, ("unit",)) from None
    if not constant_of(node) > 0:
        raise RefusalError(f"{show(clip(unit, 60))} is no unit", "write a unit, such as mJ s", ("unit",))
    return node


class WrittenFigure(SpecModel):
    """A derived figure as a file has it; as text, its expression alone."""

    expression: str = Field(max_length=MAX_TEXT, description="Over figures, such as energy_j * plan_time_worst_s.")
    unit: str | None = Field(
        default=None, max_length=MAX_UNIT, description="Its unit, such as mJ s; by default in base units."
    )
    direction: Literal["minimise", "maximise"] = Field(
        default="minimise", description="Which of two designs an objective of it prefers."
    )
    label: str = Field(default="", max_length=MAX_NAME, description="What tables and plots call it.")


def read_figures(raw: Any) -> dict[str, DerivedFigure]:
    """The derived figures of a section ``figures``. One may name those before it.

    Raises:
        ValidationError: every fault. RefusalError: it is no mapping, or too long.
    """
    if not isinstance(raw, Mapping):
        raise RefusalError(f"{show(raw)} is not a mapping", "write {NAME: EXPRESSION}")
    if len(raw) > MAX_FIGURES:
        raise RefusalError(f"{len(raw)} figures are too many", f"at most {MAX_FIGURES}")
    figures: dict[str, DerivedFigure] = {}
    refusals = []
    for name, written in raw.items():
        try:
            _check_name(name, raw)
            with in_scope(figures):
                figures[name] = _with_column(_read(name, written), raw, figures)
        except RefusalError as refusal:
            refusals.append(refusal_details(refusal, (str(name),)))
        except ValidationError as error:
            refusals += details_of(error, (str(name),))
    raise_all("figures", refusals)
    return figures


def _read(name: str, raw: Any) -> DerivedFigure:
    if isinstance(raw, DerivedFigure):
        return raw
    form = {"expression": raw} if isinstance(raw, str) else raw
    if not isinstance(form, Mapping):
        raise RefusalError(f"{show(raw)} is no expression", "write a text, such as energy_j * 2")
    written = WrittenFigure.model_validate(form)
    maximise = written.direction == "maximise"
    try:
        return derived(name, written.expression, written.unit, maximise=maximise, label=written.label)
    except RefusalError as refusal:
        at = () if isinstance(raw, str) else refusal.at or ("expression",)
        raise RefusalError(refusal.what, refusal.hint, at) from None


def _check_name(name: Any, names: Collection[Any]) -> None:
    if not isinstance(name, str) or not _NAME.fullmatch(name) or len(name) > MAX_NAME:
        hint = f"letters, digits and _, a letter first, at most {MAX_NAME}"
        raise RefusalError(f"{show(name)} is not a name", hint, of_key=True)
    kinds: dict[str, Collection[str]] = {
        "a figure": FIGURES,
        "a short name of a figure": SHORT_NAMES,
        "a function": FUNCTIONS,
        "a unit": known_units(),
        "the rule of all other figures": ("default",),
    }
    kind = next((kind for kind, names in kinds.items() if name in names), None)
    if kind is not None:
        raise RefusalError(f"{name} is {kind}", "choose another name", of_key=True)
    declared = {each.column for each in FIGURES.values()}
    stem = re.sub("_(low|high)$", "", name)
    of_interval = stem != name and (stem in declared or stem in names)
    if name in COLUMNS or name in declared or of_interval:
        raise RefusalError(f"{name} is a column of tables", "choose another name", of_key=True)


def _with_column(figure: DerivedFigure, names: Collection[Any], before: Mapping[str, DerivedFigure]) -> DerivedFigure:
    """The figure, where the column of its name and unit is no name or column of another figure."""
    others = [*FIGURES.values(), *before.values()]
    taken = {*names, *COLUMNS, *(each.name for each in others), *(each.column for each in others)} - {figure.name}
    for own in (figure.column, f"{figure.column}_low", f"{figure.column}_high"):
        if own in taken:
            what = f"{figure.name} in {figure.unit} has the column {figure.column} of tables, and {own} is another"
            raise RefusalError(what, "choose another name", of_key=True)
    return figure


def _as_written(figures: Mapping[str, DerivedFigure]) -> dict[str, Any]:
    return {name: figure.as_written for name, figure in figures.items()}


DerivedFigures = Annotated[
    # Not of the dataclass: a file, and its reference, have expressions here.
    dict[str, Any],
    PlainValidator(read_figures),
    PlainSerializer(_as_written),
    WithJsonSchema(
        {
            "type": "object",
            "maxProperties": MAX_FIGURES,
            "propertyNames": {"pattern": f"^{_NAME.pattern}$"},
            "additionalProperties": {
                "anyOf": [{"type": "string", "maxLength": MAX_TEXT}, WrittenFigure.model_json_schema()]
            },
        }
    ),
]
"""Derived figures by name."""
