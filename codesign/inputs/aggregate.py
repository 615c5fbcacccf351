"""The rules by which a figure of a design is made of its values in all conditions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, ValidationError, ValidationInfo, WithJsonSchema
from pydantic_core import InitErrorDetails

from codesign.ground.errors import choose_hint, clip, show
from codesign.ground.figures import FIGURES, SHORT_NAMES, ResultFigure
from codesign.ground.models import RefusalError, SpecModel, details_of, raise_all, refusal_details
from codesign.inputs.constraint import BOUNDS, Constraint, constraint_of, declared
from codesign.inputs.derived import known_figures

DEFAULT = "default"
"""The key of the rule of every figure that has no rule of its own."""

WORDS = ("worst", "best", "mean", "median")


class Quantile(SpecModel):
    """The value that this share of the conditions reaches or betters. At 0.9 of ten conditions it is the ninth best."""

    quantile: float = Field(gt=0, lt=1, description="The share of the conditions, between 0 and 1.")

    def __str__(self) -> str:
        return f"quantile {self.quantile:g}"


class Share(SpecModel):
    """The share of the conditions that meet a limit of the figure. More of it is better, whatever the figure.

    A condition in which the design is infeasible, or does not reach its goals, does not meet the limit.
    """

    share: Constraint = Field(
        description='The limit: as text, "< 100 ms"; or at_most, at_least, below and above, in the unit of the figure.'
    )
    required: float | None = Field(
        default=None, gt=0, le=1, description="The least share of a feasible design; by default none is required."
    )

    def __str__(self) -> str:
        return "share"


Word = Literal["worst", "best", "mean", "median"]
Rule = Word | Quantile | Share
WORST: Word = "worst"


def _rule(figure: ResultFigure | None, raw: Any, context: Any) -> Rule:
    """One rule as YAML, or a definition that was kept, has it.

    Raises:
        RefusalError, ValidationError: it is none.
    """
    if isinstance(raw, Quantile | Share) or (isinstance(raw, str) and raw in WORDS):
        return raw  # type: ignore[return-value]
    if isinstance(raw, Mapping) and "quantile" in raw:
        return Quantile.model_validate(raw, context=context)
    if isinstance(raw, Mapping) and "share" in raw:
        if figure is None:
            raise RefusalError("share needs a figure", "give this rule to a figure by its name", ("share",))
        return Share.model_validate({**raw, "share": _limit(figure, raw["share"])}, context=context)
    accepted = f'{", ".join(WORDS)}, {{quantile: 0.9}}, {{share: "< LIMIT"}}'
    near = choose_hint(raw, WORDS).partition(" accepted")[0] if isinstance(raw, str) else ""
    near = f"{near} " if near.endswith("?") else ""
    raise RefusalError(f"{show(raw)} is no rule", f"{near}accepted: {accepted}")


def _limit(figure: ResultFigure, raw: Any) -> Constraint | dict[str, Any]:
    """The limit of a share from its raw form: a mapping, or a text such as ``< 100 ms``.

    Raises:
        RefusalError: it is none, or of another figure.
    """
    limit: Constraint | dict[str, Any]
    if isinstance(raw, str) and set(raw) & set("<>≤≥"):
        try:
            limit = constraint_of(raw if raw.strip(" ")[:1].isalpha() else f"{figure} {raw}")
        except RefusalError as refusal:
            raise RefusalError(refusal.what, refusal.hint, ("share",)) from None
        name = limit.figure.name
    elif isinstance(raw, Mapping):
        limit, name = {**raw, "figure": figure.name}, raw.get("figure", figure.name)
    else:
        raise RefusalError(f"{show(raw)} is no limit", 'write {share: "< LIMIT"}', ("share",))
    if name != figure.name:
        raise RefusalError("the limit is of another figure", f"leave figure out: it is {figure}", ("share",))
    return limit


def _rules(value: Any, info: ValidationInfo) -> Any:
    if not isinstance(value, Mapping):
        hint = f"write {{{DEFAULT}: mean}}, or a rule for each figure: {{first_plan_s: {{quantile: 0.9}}}}"
        raise RefusalError(f"{show(value)} is not a mapping of rules", hint)
    rules: dict[str, Rule] = {}
    refusals: list[InitErrorDetails] = []
    for key, raw in value.items():
        try:
            figure = None if key == DEFAULT else declared(key)
        except RefusalError as refusal:
            short = key in SHORT_NAMES
            hint = str(refusal.hint) if short else choose_hint(clip(str(key), 60), (*known_figures(), DEFAULT))
            refusals.append(refusal_details(RefusalError(f"{show(key)} is no figure", hint, of_key=True), (str(key),)))
            continue
        try:
            rules[str(key)] = _rule(figure, raw, info.context)
        except RefusalError as refusal:
            refusals.append(refusal_details(refusal, (str(key),)))
        except ValidationError as error:
            refusals += details_of(error, (str(key),))
    raise_all("aggregate", refusals)
    return rules


_LIMIT = {"type": ["number", "string"]}
_RULE_SCHEMA = {
    "anyOf": [
        {"enum": list(WORDS)},
        {
            "type": "object",
            "properties": {"quantile": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1}},
            "required": ["quantile"],
            "additionalProperties": False,
        },
        {
            "type": "object",
            "properties": {
                "share": {
                    "anyOf": [
                        {"type": "string", "description": "a limit as text, such as < 100 ms"},
                        {
                            "type": "object",
                            "properties": dict.fromkeys(BOUNDS, _LIMIT),
                            "additionalProperties": False,
                            "minProperties": 1,
                        },
                    ]
                },
                "required": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
            },
            "required": ["share"],
            "additionalProperties": False,
        },
    ]
}

Aggregate = Annotated[
    dict[str, Rule],
    BeforeValidator(_rules),
    WithJsonSchema(
        {
            "type": "object",
            "propertyNames": {"anyOf": [{"enum": [DEFAULT, *FIGURES]}, {"type": "string"}]},
            "additionalProperties": _RULE_SCHEMA,
        },
        mode="validation",
    ),
]
"""A rule by the name of a figure, and ``default`` for all others."""


def rule_for(aggregate: Mapping[str, Rule], figure: ResultFigure) -> Rule:
    """The rule of a figure: its own, else the default, else ``worst``."""
    return aggregate.get(figure.name, aggregate.get(DEFAULT, WORST))


def rule_as_written(rule: Rule) -> Any:
    """A rule as YAML has it, with plain numbers: what is kept of it, and what JSON says."""
    if isinstance(rule, str):
        return rule
    fields = rule.model_dump(mode="json", exclude_none=True)
    if isinstance(rule, Share):
        limit = rule.share
        fields["share"] = {**limit.bounds, **({"of_part": True} if limit.of_part else {})}
    return fields
