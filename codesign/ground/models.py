"""The base of every model of a spec: strict scalars, closed keys, and refusals with a remedy.

Pydantic checks. ``codesign.inputs.faults`` turns its errors into faults with places. Three rules keep the faults clear:

- A model is strict by construction, for any annotation of its fields: text never becomes a number or a boolean, a
  boolean never becomes a number, 6.0 never becomes 6. Lists become tuples, because YAML has no tuples.
- ``choice`` chooses between models (``type: fpga``) before any model is tried, so only the chosen one reports faults.
- A validator refuses a value with ``RefusalError``, with a remedy and, where needed, the key inside.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, ClassVar, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    GetCoreSchemaHandler,
    ModelWrapValidatorHandler,
    ValidationError,
    ValidationInfo,
    WrapValidator,
    model_validator,
)
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError

from codesign.ground.errors import InputError, choose_hint, clip, show
from codesign.ground.figures import Figure

# The frame of a map: where its cells lie in metres.

_ROUNDING = 1e-9
"""Cells: a point this near below a side of a cell lies on that side."""


@dataclass(frozen=True)
class Frame:
    """Metres for the cells of a map, as map_server has them: x to the right, y up.

    - ``rows``: of the map. ``resolution``: metres a cell.
    - ``origin``: (x, y, yaw) of the lower left corner of the map, metres and radians. The yaw turns the map around this
      corner, counterclockwise.
    """

    rows: int
    resolution: float = 1.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def point(self, row: float, column: float) -> tuple[float, float]:
        """(x, y) in metres of a place in cells. Whole numbers of cells are middles.

        >>> Frame(rows=10, resolution=0.5, origin=(-1.0, 2.0, 0.0)).point(9, 0)
        (-0.75, 2.25)
        """
        return self._turned((column + 0.5) * self.resolution, (self.rows - row - 0.5) * self.resolution)

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """(row, column) of the cell that a point in metres lies in, inside of the map or not.

        A point on the side between two cells belongs to the right one and to the upper one.

        >>> Frame(rows=10, resolution=0.5, origin=(-1.0, 2.0, 0.0)).cell(-0.75, 2.25)
        (9, 0)
        """
        left, below, yaw = self.origin
        right, up = x - left, y - below
        across = right * math.cos(yaw) + up * math.sin(yaw)
        along = up * math.cos(yaw) - right * math.sin(yaw)
        column = math.floor(across / self.resolution + _ROUNDING)
        return self.rows - 1 - math.floor(along / self.resolution + _ROUNDING), column

    def part(self, row: int, column: int, rows: int) -> Frame:
        """The frame of a part of the map: ``rows`` rows from ``row`` on, columns from ``column`` on."""
        below = (self.rows - row - rows) * self.resolution
        corner = self._turned(column * self.resolution, below)
        return Frame(rows, self.resolution, (*corner, self.origin[2]))

    def _turned(self, right: float, up: float) -> tuple[float, float]:
        left, below, yaw = self.origin
        if not yaw:
            return left + right, below + up
        return (left + right * math.cos(yaw) - up * math.sin(yaw), below + right * math.sin(yaw) + up * math.cos(yaw))


# A part: a chip with a vector of resource budgets, its limits, and the source of each number.


@dataclass(frozen=True)
class OtherRam:
    """RAM of a part besides its block RAM, of one kind.

    ``count``: its blocks. ``shapes``: (depth, width) pairs that one may be configured as. ``ports``: words that one
    reads or writes in a cycle. ``clock``: its fastest one, Hz.
    """

    count: Figure
    shapes: tuple[tuple[int, int], ...]
    ports: int
    clock: Figure


class Part(BaseModel):
    """A chip in one speed grade.

    - ``resources``: budgets by kind: slices, lut4, flip_flops, block_rams, multipliers. Laws count LUT of four inputs,
      slices of two of them with two flip-flops, and block RAMs of 18 kbit; a part of another make is converted.
    - ``block_ram_shapes``: (depth, width) pairs that one block RAM may be configured as.
    - ``block_ram_clock``: the fastest clock of a block RAM in this speed grade, Hz.
    - ``other_rams``: RAM besides the block RAM, by the name of its kind.
    - ``static_power``: W. ``dynamic_power``: W for each occupied slice (as counted here) and Hz, at typical activity.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    family: str
    speed_grade: str
    resources: dict[str, Figure]
    block_ram_shapes: tuple[tuple[int, int], ...]
    block_ram_clock: Figure
    static_power: Figure
    dynamic_power: Figure
    other_rams: dict[str, OtherRam] = {}

    @property
    def full_name(self) -> str:
        """Name and speed grade, as platforms name it: ``XC4VLX160-12``."""
        return f"{self.name}{self.speed_grade}"


NAME_PATTERN = r"^[A-Za-z_][A-Za-z0-9_-]*$"
SPEED_GRADE_PATTERN = r"^-[0-9A-Za-z]+$"


class Task(StrEnum):
    """The question to a planner on a map, which is timed.

    - ``path``: from each start, a request of its own: the map is sent, a path is planned, the answer is received.
    - ``field``: the deciding component holds an answer for every cell that leads to a goal.
    - ``replan``: as ``path``, after a change of a map that was planned on before.
    """

    PATH = "path"
    FIELD = "field"
    REPLAN = "replan"


Location = tuple[str | int, ...]
"""The path of a key inside a model: field names and list indices."""


class RefusalError(ValueError):
    """A value that a validator refuses.

    Args:
        what: the fault, with the value.
        hint: the remedy.
        at: the key inside the validated value that is at fault; the value itself by default.
        of_key: whether the key itself is refused, for any value.
    """

    def __init__(self, what: str, hint: str | None = None, at: Location = (), *, of_key: bool = False) -> None:
        super().__init__(what, hint, at)
        self.what = what
        self.hint = hint
        self.at = at
        self.of_key = of_key


def refused(error: InputError) -> RefusalError:
    """The refusal with the text of an input error."""
    return RefusalError(error.what, error.hint)


def refusal_details(refusal: RefusalError, location: Location = (), value: object = None) -> InitErrorDetails:
    """One line of a validation error, for validators that report several refusals at once (``raise_all``)."""
    return InitErrorDetails(type="value_error", loc=location, input=value, ctx={"error": refusal})


def raise_all(title: str, details: list[InitErrorDetails]) -> None:
    """Raise one validation error of all ``details``; pydantic merges it into the error of the model around."""
    if details:
        raise ValidationError.from_exception_data(title, details)


def details_of(
    error: ValidationError, prefix: Location = (), accepted: Sequence[str] | None = None
) -> list[InitErrorDetails]:
    """The lines of a validation error, to be raised again further out, at ``prefix``.

    ``accepted``: the keys of the model that was validated; an unknown key is reported with them.
    """
    lines = []
    for line in error.errors(include_url=False):
        kind: str | PydanticCustomError = line["type"]
        if accepted is not None and len(line["loc"]) == 1 and kind in {"extra_forbidden", "unknown_key"}:
            kind = PydanticCustomError("unknown_key", "unknown key", {"accepted": list(accepted)})
        elif kind == "unknown_key":
            kind = PydanticCustomError("unknown_key", "unknown key", line["ctx"])
        location = (*prefix, *line["loc"])
        lines.append(InitErrorDetails(type=kind, loc=location, input=line["input"], ctx=line.get("ctx", {})))
    return lines


def _strict(schema: Any) -> Any:
    """The core schema with every scalar in it made strict."""
    if isinstance(schema, list):
        return [_strict(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    # A mapping of fields is no schema: its keys are the user's names, and one may be called type or default.
    is_schema = isinstance(schema.get("type"), str)
    kept = {"metadata", "default", "config"} if is_schema else set()
    strict = {key: value if key in kept else _strict(value) for key, value in schema.items()}
    if is_schema and strict["type"] in {"int", "float", "bool", "str"}:
        strict["strict"] = True
    return strict


class SpecModel(BaseModel):
    """A mapping of a spec: closed keys, strict scalars, frozen."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return _strict(handler(source))  # type: ignore[no-any-return]

    @model_validator(mode="wrap")
    @classmethod
    def _name_accepted_keys(cls, value: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(value)
        except ValidationError as error:
            lines = details_of(error, accepted=list(cls.model_fields))
            raise ValidationError.from_exception_data(cls.__name__, lines) from None


class TaskParameters(SpecModel):
    """The base of the models that the parameters of a task are checked against.

    - ``alternatives``: for each parameter, the parameters that say the same in another way; a point of an exploration
      that sets one of them removes the others.
    - ``shared_across``: the parameters that leave most of the work of a run as it is. Runs that differ in these alone
      share it through ``Job.memo``, and an exploration has the same worker compute them.
    """

    alternatives: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    shared_across: ClassVar[frozenset[str]] = frozenset()

    def unused(self, _external_memory: bool, /) -> tuple[str, ...]:
        """Names of the parameters that a design does not use. Results leave them out. By default none.

        The argument says whether the mapping names an external memory.
        """
        return ()

    def block_count(self, _rows: int, _columns: int, /) -> int | None:
        """The number of blocks of a map of this size; None for a map without blocks."""
        return None

    @property
    def precisions(self) -> tuple[int, ...]:
        """Fractional bits of each stage; empty where a plan has no stages."""
        return ()

    @property
    def to_find(self) -> tuple[str, ...]:
        """Names of the parameters that are left to a search on the map (``Architecture.find``). By default none."""
        return ()

    @property
    def begins_at_bound(self) -> bool:
        """True if a first plan begins at the result of task ``lower_bound``, where it is mapped. By default it does."""
        return True


def choice(key: str, models: Mapping[str, type[BaseModel]]) -> WrapValidator:
    """The validator of a union of models that ``key`` chooses from; annotate the union with it."""

    def choose(value: Any, _handler: Callable[[Any], Any], info: ValidationInfo) -> Any:
        if isinstance(value, tuple(models.values())):
            return value
        accepted = f"accepted: {', '.join(sorted(models))}"
        if not isinstance(value, dict):
            raise RefusalError(f"{show(value)} is not a mapping", f"write {key}: and its parameters; {accepted}")
        if key not in value:
            raise RefusalError(f"{key} is missing", accepted)
        name = value[key]
        if not isinstance(name, str) or name not in models:
            raise RefusalError(f"there is no {key} {show(name)}", choose_hint(clip(str(name), 60), models), (key,))
        return models[name].model_validate(value, context=info.context)

    return WrapValidator(choose)
