"""The form of a certificate: its definition, its head, and its columns.

An entry is a row (one design with its exact figures) or a box (many designs, with the best figures that any of them
may have). The rows come first. docs/certificates.md describes every field.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AllowInfNan, BaseModel, ConfigDict, Field

MAX_SPACE = 2**62
"""Most designs of a space, so that counts of designs are whole numbers of 64 bits."""

MAX_ROWS = 10_000_000
MAX_BOXES = 1_000_000
MAX_PARTS = 1000
MAX_REASONS = MAX_ROWS
MAX_TEXTS = 10_000
"""Most different texts. What has no text of its own says so."""

_MOST_AXES = 32
_MOST_FIGURES = 256


class Claim(IntEnum):
    """The reason for which an entry is where it is. ``by`` of the entry has the number that the claim names.

    A box has ``DOMINATED``, ``CONSTRAINT``, ``UNFIT`` or ``MISSING``.
    """

    FRONT = 0
    """On the front."""
    DOMINATED = 1
    """Row ``by``, which is on the front, is as good in every objective and better in one."""
    CONSTRAINT = 2
    """The figure breaks constraint ``by``, or there is none."""
    UNFIT = 3
    """It cannot be built, or not used: reason ``by`` has demand and limit."""
    UNREACHED = 4
    """Its mission ended before its goals: text ``by`` says how."""
    LACKING = 5
    """It has no figure for objective ``by``."""
    SAME = 6
    """It is the same design as row ``by``, which is an earlier one, and counts there."""
    FAILED = 7
    """It could not be computed: text ``by`` says why."""
    MISSING = 8
    """It was not computed."""


WORDS = {
    Claim.FRONT: "on the front",
    Claim.DOMINATED: "dominated",
    Claim.CONSTRAINT: "break a constraint",
    Claim.UNFIT: "unfit",
    Claim.UNREACHED: "goals not reached",
    Claim.LACKING: "lack an objective",
    Claim.SAME: "same as another",
    Claim.FAILED: "failed",
    Claim.MISSING: "not computed",
}
"""The fact that is said of the designs of each claim."""


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


Finite = Annotated[float, AllowInfNan(False)]


class Axis(_Model):
    """A decision: its values, and for which values of other axes, by their numbers, it exists."""

    axis: str
    values: list[Any] = Field(min_length=1, max_length=100_000)
    when: dict[str, list[int]]


class Condition(_Model):
    """A condition that every design meets."""

    axis: str
    values: list[Any]


class Objective(_Model):
    """A figure that spans the front, by its number in ``figures``."""

    figure: int
    direction: Literal["minimise", "maximise"]


class Bound(_Model):
    """A bound of a constraint on figure ``figure``: of its value, or of its share of the budget ``budget``."""

    figure: int
    bound: Literal["at_least", "at_most", "above", "below"]
    limit: Finite
    budget: int | None


class Stated(_Model):
    """A figure that is stated of each entry. Of a box, it is the least possible value, or the greatest."""

    name: str
    unit: str
    best: Literal["least", "greatest"]


class Definition(_Model):
    """The question of a study: what was explored, and what for."""

    platform: str
    workload: str
    axes: list[Axis] = Field(max_length=_MOST_AXES)
    conditions: list[Condition] = Field(max_length=_MOST_AXES)
    aggregate: dict[str, Any]
    derived: dict[str, Any]
    figures: list[Stated] = Field(max_length=_MOST_FIGURES)
    objectives: list[Objective] = Field(min_length=1, max_length=_MOST_FIGURES)
    constraints: list[Bound] = Field(max_length=_MOST_FIGURES)
    budgets: list[str] = Field(max_length=_MOST_FIGURES)
    identity: dict[str, str]
    contents: dict[str, dict[str, str]]


class ReasonName(_Model):
    """The name of what passes its limit, and if the limit is what it may come to at most or at least."""

    kind: str
    name: str
    unit: str
    side: Literal["at_most", "at_least"]


class Head(_Model):
    """The sizes and names of the columns."""

    format: Literal["hwsw certificate"]
    version: Literal[1]
    rows: int = Field(ge=0, le=MAX_ROWS)
    boxes: int = Field(ge=0, le=MAX_BOXES)
    reasons: int = Field(ge=0, le=MAX_REASONS)
    parts: list[dict[str, list[int]]] = Field(min_length=1, max_length=MAX_PARTS)
    tasks: list[str] = Field(max_length=MAX_TEXTS)
    names: list[ReasonName] = Field(max_length=MAX_TEXTS)
    texts: list[str] = Field(max_length=MAX_TEXTS)


class Digests(_Model):
    """SHA-256, hex: of the definition; and of definition, head and columns."""

    study: str
    content: str


Columns = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Certificate:
    """A certificate. The texts are the JSON of the file, UTF-8. ``digests``: those that it states."""

    definition: Definition
    head: Head
    columns: Columns
    texts: tuple[bytes, bytes]
    digests: Digests

    @classmethod
    def of(cls, definition: Definition, head: Head, columns: Columns) -> Certificate:
        """The certificate of these, with its digests."""
        texts = _text(definition), _text(head)
        return cls(definition, head, columns, texts, digests_of(texts, columns))


def digests_of(texts: tuple[bytes, bytes], columns: Columns) -> Digests:
    """The digests of the texts of definition and head, and of the columns in their order, each after its name."""
    study = hashlib.sha256(texts[0]).hexdigest()
    content = hashlib.sha256(study.encode() + texts[1])
    for name, column in columns.items():
        content.update(name.encode())
        content.update(np.ascontiguousarray(column).tobytes())
    return Digests(study=study, content=content.hexdigest())


def _text(model: BaseModel) -> bytes:
    """The JSON of a model, the same for equal ones."""
    document = model.model_dump(mode="json")
    return json.dumps(document, sort_keys=False, separators=(",", ":"), allow_nan=False).encode()


def layout(definition: Definition, head: Head) -> dict[str, tuple[str, tuple[int, ...]]]:
    """The type and the shape of every column, in the order of the file."""
    entries, axes = head.rows + head.boxes, len(definition.axes)
    return {
        "design": ("<i8", (head.rows,)),
        "claim": ("|u1", (entries,)),
        "by": ("<i4", (entries,)),
        "task": ("<i4", (entries,)),
        "figures": ("<f8", (len(definition.figures), entries)),
        "budgets": ("<f8", (len(definition.budgets), entries)),
        "part": ("<i4", (head.boxes,)),
        "low": ("<i4", (head.boxes, axes)),
        "high": ("<i4", (head.boxes, axes)),
        "name": ("<i4", (head.reasons,)),
        "demand": ("<f8", (head.reasons,)),
        "limit": ("<f8", (head.reasons,)),
    }
