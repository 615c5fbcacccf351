"""Declared figures by name, and bounds on them, as a mapping or as people write them: ``time < 100 ms``."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Annotated, Any, Literal, Self

from pydantic import (
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
    model_validator,
)
from pydantic_core import CoreSchema, core_schema

from codesign.ground.errors import Fault, InputError, SpecError, choose_hint, clip, show
from codesign.ground.figures import FIGURES, SHORT_NAMES, ResultFigure, found
from codesign.ground.models import RefusalError, SpecModel, refused
from codesign.ground.units import PICOSECONDS_PER_SECOND, SCALES, Dimension, format_quantity, parse_quantity
from codesign.inputs.derived import DerivedFigure, derived, difference, in_scope, known_figures, nodes
from codesign.inputs.expression import MAX_TEXT, parse_comparison


def declared(name: Any) -> ResultFigure:
    """The figure of that name; a figure stays what it is.

    A text that is no name is an expression over figures, whose figure has no other name than this text.

    Raises:
        RefusalError: no figure is declared under this name.
    """
    known = known_figures()
    if (figure := found(name, known)) is not None:
        return figure
    if isinstance(name, str) and not _PLAIN_NAME.fullmatch(name):
        return derived(name, name)
    word = clip(str(name), 60)
    short = f"write {SHORT_NAMES[word]}: {word} is its short name in limits as text" if word in SHORT_NAMES else ""
    raise RefusalError(f"{show(name)} is not accepted", short or choose_hint(word, known))


class _ByName:
    """The way in which models read and write a figure: as its name. The schema lists what is declared when asked."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(declared, serialization=core_schema.to_string_ser_schema())

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        derived_too = {"maxLength": MAX_TEXT, "examples": ["energy_j * plan_time_worst_s"]}
        return {"type": "string", "anyOf": [{"enum": list(FIGURES)}, derived_too]}


FigureName = Annotated[ResultFigure, _ByName()]

_DIMENSIONS = {"s": Dimension.TIME, "W": Dimension.POWER, "J": Dimension.ENERGY, "m": Dimension.LENGTH}

Limit = Annotated[float | None, WithJsonSchema({"type": ["number", "string"]})]
Bound = Literal["at_least", "at_most", "below", "above"]
LOWER: tuple[Bound, ...] = ("at_least", "above")
UPPER: tuple[Bound, ...] = ("at_most", "below")
STRICT: tuple[Bound, ...] = ("above", "below")
BOUNDS = (*LOWER, *UPPER)

_OPERATORS: dict[str, Bound] = {
    "<": "below",
    "<=": "at_most",
    ">": "above",
    ">=": "at_least",
    "≤": "at_most",
    "≥": "at_least",
}
SIGNS: dict[Bound, str] = {"below": "<", "at_most": "<=", "above": ">", "at_least": ">="}
"""The sign of each bound in a limit as text."""

_PLAIN_NAME = re.compile(r"[\w-]*")
_MAX_TEXT = 100
_LIMIT_TEXT = re.compile(r" *([^<>=≤≥!]*?) *([<>=≤≥!~]+) *(.*?) *", re.S)
_NAMED = re.compile(r"[^\W\d]\w*")
_NUMBER = re.compile(r"([+-]?[0-9]+(?:\.[0-9]+)?(?:[eE][+-]?[0-9]{1,2})?) *(.*)", re.S)


class Constraint(SpecModel):
    """Bounds on a figure; as text ``NAME < VALUE``, with ``<=``, ``>`` and ``>=`` too.

    Written with a unit (``5 ms``) for time, power, energy and length; held in s, W, J, m. ``80 %`` of a resource is a
    share of what the part has, and ``of_part`` then true.
    """

    figure: FigureName = Field(description="The figure that is bounded.")
    at_least: Limit = Field(
        default=None, description="Its lower bound: 10 ms, 2 W, 1 J, a bare number, or 80 % of a share or a resource."
    )
    at_most: Limit = Field(default=None, description="Its upper bound, alike.")
    above: Limit = Field(default=None, description="Its lower bound, alike, which itself is out.")
    below: Limit = Field(default=None, description="Its upper bound, alike, which itself is out.")
    of_part: bool = Field(
        default=False,
        description="Whether the bounds are shares of what the part has. It follows from the % of a resource.",
    )

    @model_validator(mode="wrap")
    @classmethod
    def _from_text(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Any:
        return constraint_of(value) if isinstance(value, str) else handler(value)

    @model_validator(mode="before")
    @classmethod
    def _share_of_part(cls, value: Any, info: ValidationInfo) -> Any:
        if not isinstance(value, dict) or not (info.context or {}).get("document"):
            return value
        shares = [key for key in BOUNDS if isinstance(value.get(key), str) and value[key].rstrip().endswith("%")]
        figure = known_figures().get(str(value.get("figure")))
        if "of_part" in value or figure is None or not figure.is_resource or not shares:
            return value
        plain = [key for key in BOUNDS if key in value and key not in shares]
        if plain:
            what = f"{shares[0]} is a share of the part, and {plain[0]} a number of {figure.label}"
            raise RefusalError(what, "write two constraints", (plain[0],))
        return {**value, "of_part": True}

    @field_validator("at_least", "at_most", "above", "below", mode="before")
    @classmethod
    def _with_unit(cls, value: Any, info: ValidationInfo) -> Any:
        figure = info.data.get("figure")
        if figure is None:
            return None  # The figure is refused: how its limit is written follows from the right one.
        # A spec that was dumped and is read again has plain numbers, and no document behind it.
        if value is None or not (info.context or {}).get("document"):
            return value
        if isinstance(value, str):
            return _limit_of(figure, value)
        if isinstance(figure, DerivedFigure) and figure.unit != "1":
            raise RefusalError(f"{show(value)} has no unit", f"write a number and a unit, such as 1 {figure.unit}")
        if figure.unit in _DIMENSIONS:
            example = SCALES[_DIMENSIONS[figure.unit]].example
            raise RefusalError(f"{show(value)} has no unit", f"write a number and a unit, such as {example}")
        if isinstance(value, int | float) and not isinstance(value, bool):
            _check_number(figure, value, show(value))
        return value

    @model_validator(mode="after")
    def _bounds_something(self) -> Self:
        if not self.bounds:
            raise RefusalError("bounds nothing", "give at_least, at_most, or both")
        if self.of_part and not self.figure.is_resource:
            raise RefusalError("is of no part", f"leave it out: {self.figure} is no resource", ("of_part",))
        clash = _clash(self, self)
        if clash is not None:
            lower, upper = clash
            raise RefusalError("nothing is within these bounds", f"{lower} has to be below {upper}", (lower,))
        return self

    @property
    def bounds(self) -> dict[Bound, float]:
        """The bounds that it has."""
        held: dict[Bound, float | None] = {
            "at_least": self.at_least,
            "above": self.above,
            "at_most": self.at_most,
            "below": self.below,
        }
        return {bound: limit for bound, limit in held.items() if limit is not None}


class _OrText:
    """The schema of a constraint in a file: a mapping, or a text."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        text = {"type": "string", "maxLength": MAX_TEXT, "examples": ["time < 100 ms"]}
        return {"anyOf": [text, handler(schema)]}


WrittenConstraint = Annotated[Constraint, _OrText()]


def constraint_of(text: str) -> Constraint:
    """The constraint of a text such as ``time < 100 ms``.

    Raises:
        RefusalError: it is none.
    """
    form = 'write NAME < VALUE, as in "time < 100 ms", "slices < 80 %" or "energy * time < 3 mJ s"'
    if len(text) > MAX_TEXT:
        raise RefusalError(f"a limit of {len(text):,} characters is too long", f"at most {MAX_TEXT}")
    match = _LIMIT_TEXT.fullmatch(text)
    if match is None or not match[1]:
        raise RefusalError(f"{show(clip(text, 60))} is no limit", form)
    name, sign, value = match.groups()
    if sign not in _OPERATORS:
        raise RefusalError(f"{show(sign)} compares nothing", f"accepted: {', '.join(_OPERATORS)}")
    if not value:
        raise RefusalError(f"{show(text)} has no value", form)
    figure = found(SHORT_NAMES.get(name, name), known_figures())
    if figure is None and _PLAIN_NAME.fullmatch(name) and name[0] not in "-0123456789":
        hint = choose_hint(clip(name, 60), (*SHORT_NAMES, *known_figures()))
        raise RefusalError(f"{show(name)} is no figure", hint)
    if figure is None or _NAMED.search(value):
        figure, value = _compared(name, value, text, figure)
    of_part = figure.is_resource and value.endswith("%")
    # Without the context of a document, numbers are taken as they are.
    return Constraint.model_validate({"figure": figure, _OPERATORS[sign]: _limit_of(figure, value), "of_part": of_part})


def _compared(left: str, right: str, text: str, figure: ResultFigure | None) -> tuple[ResultFigure, str]:
    """The figure of a comparison of expressions, and its limit as text: 0 of the difference of two with figures.

    Raises:
        RefusalError: an expression is none, or the units differ.
    """
    if figure is not None and not any(word in nodes() for word in _NAMED.findall(right)):
        return figure, right
    sides = parse_comparison(text, nodes())
    if sides[0].names and not sides[2].names:
        return derived(left, left), right
    if not sides[0].names:
        raise RefusalError(f"{show(left)} names no figure", "write the figure first, and the limit behind the sign")
    apart = difference(left, right)
    return apart, "0" if not apart.node.powers else f"0 {apart.unit}"


def _limit_of(figure: ResultFigure, text: str) -> float:
    """The limit of a figure, in its unit; of a share, and of a resource in %, as a part of 1.

    Raises:
        RefusalError: the text is no limit of this figure.
    """
    if isinstance(figure, DerivedFigure):
        return figure.limit(text)
    dimension = _DIMENSIONS.get(figure.unit)
    if dimension is not None:
        try:
            parsed = parse_quantity(text, dimension)
        except InputError as error:
            raise refused(error) from None
        return float(parsed / PICOSECONDS_PER_SECOND if dimension is Dimension.TIME else parsed)
    match = _NUMBER.fullmatch(text.strip(" ")) if len(text) <= _MAX_TEXT else None
    if match is None:
        raise RefusalError(f"{show(text)} is not a number", _example(figure))
    number, unit = float(match[1]), match[2]
    if unit == "%":
        if figure.counted != "share" and not figure.is_resource:
            raise RefusalError(f"{show(text)} is a share, and {figure} is none", _example(figure))
        if not 0 <= number <= 100:
            raise RefusalError(f"{show(text)} is out of bounds", "a share is from 0 to 100 %")
        return float(number / 100)
    if unit and unit != figure.unit:
        raise RefusalError(f"{show(text)} has no unit of {figure}", _example(figure))
    _check_number(figure, number, show(text))
    return number


def _check_number(figure: ResultFigure, number: float, shown: str) -> None:
    """Refuse a part of a thing, and a share above 1."""
    if figure.counted == "count" and not float(number).is_integer():
        share = f"write {100 * number:.6g} % for a share of the part's {figure.label}"
        hint = share if figure.is_resource and 0 < number < 1 else "write a whole number"
        raise RefusalError(f"{shown}: a count is a whole number", hint)
    if figure.counted == "share" and not 0 <= number <= 1:
        hint = f"write {number:.6g} %, or {number / 100:.6g}" if 1 < number <= 100 else "a share is from 0 to 1"
        raise RefusalError(f"{shown} is out of bounds", hint)


def _example(figure: ResultFigure) -> str:
    """A sentence that says how to write a limit of a figure without a dimension."""
    if figure.is_resource:
        return f"write a whole number, or 80 % for a share of the part's {figure.label}"
    if figure.counted == "share":
        return "write a share, such as 0.99 or 99 %"
    unit = "" if figure.unit == "1" else f", or with its unit {figure.unit}"
    return f"write a {'whole ' if figure.counted == 'count' else ''}number{unit}"


def _clash(lower: Constraint, upper: Constraint) -> tuple[Bound, Bound] | None:
    """The lower bound of one constraint that leaves nothing below an upper bound of another; None where none does."""
    if lower.figure != upper.figure or lower.of_part != upper.of_part:
        return None
    for low in (bound for bound in LOWER if bound in lower.bounds):
        for high in (bound for bound in UPPER if bound in upper.bounds):
            least, most = lower.bounds[low], upper.bounds[high]
            if least > most or (least == most and (low in STRICT or high in STRICT)):
                return low, high
    return None


def contradictions(constraints: Sequence[Constraint]) -> list[tuple[int, RefusalError]]:
    """Each constraint that cannot be kept together with one before it, by its position."""
    faults = []
    for index, constraint in enumerate(constraints):
        for before in constraints[:index]:
            if _clash(constraint, before) or _clash(before, constraint):
                what = f"nothing is within this and {limit_text(before)}"
                faults.append((index, RefusalError(what, "keep one of them, or move one")))
                break
    return faults


def limit_text(constraint: Constraint) -> str:
    """A constraint as text, which is read as the same one.

    >>> limit_text(Constraint(figure=FIGURES["slices"], below=0.8, of_part=True))
    'slices < 80 %'
    >>> limit_text(Constraint(figure=FIGURES["energy_j"], at_most=0.001))
    'energy_j <= 1 mJ'
    """
    figure, unit = constraint.figure, constraint.figure.unit
    is_derived = isinstance(figure, DerivedFigure)
    dimension = None if is_derived else _DIMENSIONS.get(unit)
    end = "" if unit == "1" else f" {unit}"
    texts = []
    for bound, limit in constraint.bounds.items():
        text = f"{100 * limit:.12g} %" if constraint.of_part else f"{limit:.12g}{end}"
        if dimension is not None:
            size = PICOSECONDS_PER_SECOND if dimension is Dimension.TIME else 1
            text = format_quantity(Fraction(repr(limit)) * size, dimension, 12)
        texts.append(f"{figure} {SIGNS[bound]} {text}")
    return " and ".join(texts)


def needs_of(
    texts: Sequence[str], option: str = "--need", figures: Mapping[str, ResultFigure] | None = None
) -> tuple[Constraint, ...]:
    """The constraints of limits as text, which may name ``figures`` beside the declared ones.

    Raises:
        SpecError: every text that is none, and those that contradict each other; ``option`` is their place.
    """
    needs: dict[str, Constraint] = {}
    refusals: list[tuple[str, RefusalError]] = []
    for text in texts:
        try:
            with in_scope(figures or {}):
                needs[text] = constraint_of(text)
        except RefusalError as refusal:
            refusals.append((text, refusal))
    refusals += [(list(needs)[index], refusal) for index, refusal in contradictions(list(needs.values()))]
    if refusals:
        places = ((f"{option} {show(text)}", refusal) for text, refusal in refusals)
        raise SpecError(Fault(place, 0, 0, "", refusal.what, refusal.hint) for place, refusal in places)
    return tuple(needs.values())
