"""The parameters of harmonic control in the mapping of a workload."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum
from itertools import pairwise
from types import MappingProxyType
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from codesign.ground.errors import show
from codesign.ground.models import RefusalError, SpecModel, TaskParameters

MAX_PRECISION = 1023
MAX_CANDIDATES = 128
"""The most candidates of a search: the precisions up to 1,023 bits by eight."""


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


class Start(StrEnum):
    """The values that a first plan begins with."""

    ZERO = "zero"
    LOWER_BOUND = "lower_bound"


START_DESCRIPTION = (
    "what a first plan begins with. lower_bound: the start that task lower_bound makes, which has to be mapped; zero:"
    " zeros, also where that task is mapped. Without it: lower_bound where that task is mapped"
)

PROMOTE_DESCRIPTION = (
    "never: a stage ends once it has settled; {after: K}: a stage but the last ends after K sweeps, though it has not"
    " settled, and such a stage never ends the run. The last field has the same bits. Only with termination: sound"
)

SCHEDULE_DESCRIPTION = (
    "fractional bits of each stage: {first, step, last}, or an explicit rising list; or {optimal: {last, candidates}}:"
    " the schedule of fewest cycles among all through the candidates, found on the map before the run"
)

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


def rising(precisions: Sequence[int], what: str) -> None:
    """Raise RefusalError where the precisions of a ``what`` are none, or do not rise."""
    if not precisions:
        raise RefusalError(f"an empty {what}", "give at least one precision, such as [63]")
    for index, (earlier, later) in enumerate(pairwise(precisions), 1):
        if later <= earlier:
            hint = "precisions rise from stage to stage"
            raise RefusalError(f"precision {later} follows {earlier}", hint, (index,))


class CandidateSeries(SpecModel):
    """Candidates in an arithmetic series: ``first``, ``first + step``, ... below the last precision."""

    first: Annotated[int, Field(ge=1, le=MAX_PRECISION, description="bits of the lowest candidate")] = 7
    step: Annotated[int, Field(ge=1, le=MAX_PRECISION, description="bits from candidate to candidate")] = 8


class Optimum(SpecModel):
    """The schedules that the best is chosen from: those through any of the candidates, to the last precision."""

    last: Annotated[int, Field(ge=1, le=MAX_PRECISION, description="fractional bits of the last stage")]
    candidates: Annotated[
        CandidateSeries | tuple[Precision, ...],
        Field(description="precisions that may come before the last: {first, step}, or a rising list"),
    ] = CandidateSeries()

    @field_validator("candidates", mode="before")
    @classmethod
    def _one_form(cls, value: Any) -> Any:
        return CandidateSeries.model_validate(value) if isinstance(value, dict) else value

    @model_validator(mode="after")
    def _below_last(self) -> Optimum:
        if isinstance(self.candidates, tuple):
            try:
                rising(self.candidates, "list of candidates")
            except RefusalError as wrong:
                raise RefusalError(wrong.what, wrong.hint, ("candidates", *wrong.at)) from None
            if self.candidates[-1] >= self.last:
                what = f"candidate {self.candidates[-1]} is not below the last precision, {self.last}"
                at = ("candidates", len(self.candidates) - 1)
                raise RefusalError(what, "candidates come before the last stage", at)
        if len(self.precisions) > MAX_CANDIDATES + 1:
            what = f"{len(self.precisions) - 1} candidates are too many"
            raise RefusalError(what, f"at most {MAX_CANDIDATES}: take a larger step", ("candidates",))
        return self

    @property
    def precisions(self) -> tuple[int, ...]:
        """The candidates, and the last precision.

        >>> Optimum(last=25).precisions
        (7, 15, 23, 25)
        """
        if isinstance(self.candidates, tuple):
            return (*self.candidates, self.last)
        return (*range(self.candidates.first, self.last, self.candidates.step), self.last)


class OptimalSchedule(SpecModel):
    """The best schedule, left to a search."""

    optimal: Annotated[Optimum, Field(description="the schedules that the best is chosen from")]

    @property
    def precisions(self) -> tuple[int, ...]:
        """Every precision that a stage of it may have."""
        return self.optimal.precisions


class Promotion(SpecModel):
    """The promotion of a stage before it has settled."""

    after: Annotated[int, Field(ge=1, le=1_000_000, description="sweeps of a stage but the last")]


_NO_PROMOTION: Mapping[int, int] = MappingProxyType({})


class RelaxParameters(TaskParameters):
    """The relaxation of the field: the partition, the iterations of a visit, the precisions.

    Exactly one of ``block`` (rows and columns of a block) and ``blocks`` (number of blocks, down and across) is given.
    """

    alternatives: ClassVar[dict[str, tuple[str, ...]]] = {"block": ("blocks",), "blocks": ("block",)}
    shared_across: ClassVar[frozenset[str]] = frozenset({"schedule", "termination", "stop", "pipeline", "digit_bits"})

    block: Annotated[
        tuple[Side, Side] | None,
        Field(description="rows and columns of one block, in nodes; those beyond the map hold obstacles"),
    ] = None
    blocks: Annotated[tuple[Side, Side] | None, Field(description="number of blocks, down and across")] = None
    iterations: Annotated[int, Field(ge=1, le=1_000_000, description="most iterations of one visit, the paper's I")]
    schedule: Annotated[
        PrecisionRange | OptimalSchedule | tuple[Precision, ...], Field(description=SCHEDULE_DESCRIPTION)
    ]
    termination: Annotated[
        Termination, Field(description="sound: no visit of the sweep changed a bit; published: as in the paper")
    ] = Termination.SOUND
    stop: Annotated[Stop, Field(description=STOP_DESCRIPTION)] = Stop.FIRST_WITHOUT_LOCAL_MAXIMA
    promote: Annotated[Promotion | Literal["never"], Field(description=PROMOTE_DESCRIPTION)] = "never"
    start: Annotated[Start | None, Field(description=START_DESCRIPTION)] = None
    pockets: Annotated[Pockets, Field(description=POCKETS_DESCRIPTION)] = Pockets.KEPT
    pipeline: Annotated[
        int, Field(ge=0, le=1, description="1: registers after the memory, on the streams and before the memory")
    ] = 0
    digit_bits: Annotated[
        Literal[1, 2, 4, 8], Field(description="bits of every value that a node of the circuit takes in a cycle")
    ] = 1

    @field_validator("schedule", mode="before")
    @classmethod
    def _one_form(cls, value: Any) -> Any:
        # The form is chosen here, so that a fault is reported once, for the form that the user meant.
        if isinstance(value, dict):
            return (OptimalSchedule if "optimal" in value else PrecisionRange).model_validate(value)
        if value == "optimal":
            hint = "write {optimal: {last: 63}}: the bits that a map needs are part of the question"
            raise RefusalError("the best schedule needs its last precision", hint)
        return value

    @field_validator("schedule", mode="after")
    @classmethod
    def _rising(cls, value: Any) -> Any:
        if isinstance(value, tuple):
            rising(value, "schedule")
        return value

    @field_validator("promote", mode="before")
    @classmethod
    def _promotion(cls, value: Any) -> Any:
        if isinstance(value, dict):
            return Promotion.model_validate(value)
        if value != "never" and not isinstance(value, Promotion):
            raise RefusalError(f"{show(value)} is no promotion", "write never, or {after: 3} for 3 sweeps")
        return value

    @model_validator(mode="after")
    def _sound_stages(self) -> RelaxParameters:
        if isinstance(self.schedule, OptimalSchedule) and self.no_search is not None:
            what, key, hint = self.no_search
            raise RefusalError(what, hint, (key,))
        if isinstance(self.promote, Promotion) and self.termination is Termination.PUBLISHED:
            what = "termination published: a stage from a promoted one may end with wrong cells"
            raise RefusalError(what, "promote early under termination: sound", ("promote",))
        return self

    @model_validator(mode="after")
    def _one_partition(self) -> RelaxParameters:
        if (self.block is None) == (self.blocks is None):
            given = "both block and blocks" if self.block else "neither block nor blocks"
            raise RefusalError(
                f"{given} given", "give exactly one: block: [rows, columns], or blocks: [how many down, across]"
            )
        return self

    @property
    def precisions(self) -> tuple[int, ...]:
        """The precision of each stage; of a schedule that is to be found, every precision that it may have."""
        return self.schedule if isinstance(self.schedule, tuple) else self.schedule.precisions

    @property
    def promote_after(self) -> Mapping[int, int]:
        """By precision, the sweeps after which a stage is left. A stage that has none runs until it has settled."""
        if not isinstance(self.promote, Promotion):
            return _NO_PROMOTION
        return dict.fromkeys(self.precisions[:-1], self.promote.after)

    @property
    def to_find(self) -> tuple[str, ...]:
        """The schedule, where it is left to a search."""
        return ("schedule",) if isinstance(self.schedule, OptimalSchedule) else ()

    @property
    def no_search(self) -> tuple[str, str, str] | None:
        """The reason why no best schedule can be found, its key, and the remedy; None if it can be."""
        if self.termination is not Termination.SOUND:
            what = f"termination {self.termination.value}: costs of stages do not add up over a schedule"
            return what, "termination", "the best schedule can be found for termination: sound"
        if isinstance(self.promote, Promotion):
            what = "promoted stages: costs of stages do not add up over a schedule"
            return what, "promote", "the best schedule can be found for promote: never"
        return None

    @property
    def begins_at_bound(self) -> bool:
        """True if a first plan begins at the result of task ``lower_bound``, where it is mapped."""
        return self.start is not Start.ZERO

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
