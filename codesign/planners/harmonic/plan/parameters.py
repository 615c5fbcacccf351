"""The parameters of harmonic control in the mapping of a workload."""

from __future__ import annotations

from enum import StrEnum
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from codesign.models import RefusalError, SpecModel, TaskParameters

MAX_PRECISION = 1023


class Termination(StrEnum):
    """The test for the convergence of a stage (see ``relax``)."""

    SOUND = "sound"
    PUBLISHED = "published"


class Stop(StrEnum):
    """The end of a run."""

    FIRST_WITHOUT_LOCAL_MAXIMA = "first_without_local_maxima"
    SCHEDULE_END = "schedule_end"


class Pockets(StrEnum):
    """The free cells from which no path leads to a goal, in the map that is sent."""

    KEPT = "kept"
    FILLED = "filled"


POCKETS_DESCRIPTION = (
    "free cells from which no path leads to a goal. kept: they are sent as free cells, and each is a local maximum for"
    " ever; filled: the processor that sends the map makes obstacles of them before, by a flood from the goals"
)

STOP_DESCRIPTION = (
    "first_without_local_maxima: after the first stage without local maxima, pockets counted; schedule_end: after the"
    " last stage."
    " A plan from a lower bound runs the last stage only, so it has the bits of a restart under schedule_end"
)


class PrecisionRange(SpecModel):
    """An arithmetic series of precisions: ``first``, ``first + step``, ... and ``last`` itself, always."""

    first: Annotated[int, Field(ge=1, le=MAX_PRECISION, description="fractional bits of the first stage")]
    step: Annotated[int, Field(ge=1, le=MAX_PRECISION, description="bits added from stage to stage")]
    last: Annotated[int, Field(ge=1, le=MAX_PRECISION, description="fractional bits of the last stage")]

    @model_validator(mode="after")
    def _rises(self) -> PrecisionRange:
        if self.last < self.first:
            what = f"the last precision, {self.last}, is below the first, {self.first}"
            raise RefusalError(what, "precisions rise from stage to stage", ("last",))
        return self

    @property
    def precisions(self) -> tuple[int, ...]:
        """The precisions in order.

        >>> PrecisionRange(first=7, step=8, last=25).precisions
        (7, 15, 23, 25)
        """
        return (*range(self.first, self.last, self.step), self.last)


Side = Annotated[int, Field(ge=1, le=4096)]
Precision = Annotated[int, Field(ge=1, le=MAX_PRECISION)]


class RelaxParameters(TaskParameters):
    """The relaxation of the field: the partition, the iterations of a visit, the precisions.

    Exactly one of ``block`` (rows and columns of a block) and ``blocks`` (number of blocks, down and across) is given.
    """

    alternatives: ClassVar[dict[str, tuple[str, ...]]] = {"block": ("blocks",), "blocks": ("block",)}

    block: Annotated[
        tuple[Side, Side] | None,
        Field(description="rows and columns of one block, in nodes; those beyond the map hold obstacles"),
    ] = None
    blocks: Annotated[tuple[Side, Side] | None, Field(description="number of blocks, down and across")] = None
    iterations: Annotated[
        int, Field(ge=1, le=1_000_000, description="most iterations of one visit, the paper's I")
    ]
    schedule: Annotated[
        PrecisionRange | tuple[Precision, ...],
        Field(description="fractional bits of each stage: {first, step, last}, or an explicit rising list"),
    ]
    termination: Annotated[
        Termination,
        Field(description="sound: no visit of the sweep changed a bit; published: as in the paper"),
    ] = Termination.SOUND
    stop: Annotated[Stop, Field(description=STOP_DESCRIPTION)] = Stop.FIRST_WITHOUT_LOCAL_MAXIMA
    pockets: Annotated[Pockets, Field(description=POCKETS_DESCRIPTION)] = Pockets.KEPT
    pipeline: Annotated[
        int,
        Field(ge=0, le=1, description="1: registers after the memory, on the streams and before the memory"),
    ] = 0
    digit_bits: Annotated[
        Literal[1, 2, 4, 8],
        Field(description="bits of every value that a node of the circuit takes in a cycle"),
    ] = 1

    @field_validator("schedule", mode="before")
    @classmethod
    def _one_form(cls, value: Any) -> Any:
        # The form is chosen here, so that a fault is reported once, for the form that the user meant.
        if isinstance(value, dict):
            return PrecisionRange.model_validate(value)
        return value

    @field_validator("schedule", mode="after")
    @classmethod
    def _rising(cls, value: PrecisionRange | tuple[int, ...]) -> PrecisionRange | tuple[int, ...]:
        if isinstance(value, tuple):
            if not value:
                raise RefusalError("an empty schedule", "give at least one precision, such as [63]")
            for index, (earlier, later) in enumerate(pairwise(value), 1):
                if later <= earlier:
                    hint = "precisions rise from stage to stage"
                    raise RefusalError(f"precision {later} follows {earlier}", hint, (index,))
        return value

    @model_validator(mode="after")
    def _one_partition(self) -> RelaxParameters:
        if (self.block is None) == (self.blocks is None):
            given = "both block and blocks" if self.block else "neither block nor blocks"
            raise RefusalError(
                f"{given} given",
                "give exactly one: block: [rows, columns], or blocks: [how many down, across]",
            )
        return self

    @property
    def precisions(self) -> tuple[int, ...]:
        """The precision of each stage."""
        return self.schedule.precisions if isinstance(self.schedule, PrecisionRange) else self.schedule

    def block_shape(self, rows: int, columns: int) -> tuple[int, int]:
        """Rows and columns of a block on a map of ``rows`` × ``columns``.

        >>> RelaxParameters(blocks=(2, 2), iterations=6, schedule=(7,)).block_shape(71, 132)
        (36, 66)
        """
        if self.block is not None:
            return self.block
        assert self.blocks is not None
        return -(-rows // self.blocks[0]), -(-columns // self.blocks[1])

    def block_count(self, rows: int, columns: int) -> int:
        """The number of blocks that cover a map of ``rows`` × ``columns``."""
        down, across = self.block_grid(rows, columns)
        return down * across

    def block_grid(self, rows: int, columns: int) -> tuple[int, int]:
        """The numbers of blocks down and across that cover a map of ``rows`` × ``columns``."""
        height, width = self.block_shape(rows, columns)
        return -(-rows // height), -(-columns // width)


class DecideParameters(TaskParameters):
    """The decision task has no parameters."""


class LowerBoundParameters(TaskParameters):
    """The task that computes a start nowhere above the field has no parameters.

    The start is at the last precision. A plan from this start has the bits of a restart under ``stop: schedule_end``.
    Under ``first_without_local_maxima`` a restart may end at an earlier stage, with fewer bits.
    """


class DetectParameters(TaskParameters):
    """The task that detects whether a sweep changed a bit has no parameters."""
