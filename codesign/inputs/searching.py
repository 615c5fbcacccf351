"""The key ``search`` of ``explore``: how a space is searched of which not all points are computed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BeforeValidator, Field, ValidationInfo, WithJsonSchema, field_validator

from codesign.ground.errors import InputError, choose_hint
from codesign.ground.models import RefusalError, SpecModel
from codesign.ground.units import PICOSECONDS_PER_SECOND
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


def _form(raw: Any) -> Any:
    return {"sampler": raw} if isinstance(raw, str) else raw


Search = Annotated[
    Searching | None,
    BeforeValidator(_form),
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
