"""Links of a platform, as declared in YAML: parallel bus, serial line, and one that takes no time."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, Union, get_args

from pydantic import Field, field_validator, model_validator

from codesign.ground.models import RefusalError, SpecModel, choice
from codesign.inputs.components import BusyPower
from codesign.inputs.fields import CountFigure, Duration, FrequencyFigure, Name, PositiveFigure
from codesign.inputs.hardware import Hardware
from codesign.laws.acts import BusLaw, IdealLaw, SerialLaw

MAX_ENDS = 256
MAX_OUTAGES = 1000

Probability = Annotated[float, Field(ge=0, lt=1)]
Ends = Annotated[tuple[Name, ...], Field(min_length=2, max_length=MAX_ENDS)]


class Late(SpecModel):
    """Messages that come late."""

    share: Probability = Field(description="Share of the messages that come late.")
    delay: Duration = Field(description="How much later they come.")


class LinkErrors(SpecModel):
    """The faults of a link, drawn from a stream of its own."""

    bit_error_rate: Probability = Field(default=0.0, description="Probability that a bit arrives wrong.")
    checksum_bits: Annotated[int, Field(ge=0, le=64)] = Field(
        default=16,
        description="Bits of the checksum of each message. With 0 there is none, and damage is not detected.",
    )
    retries: Annotated[int, Field(ge=0, le=1000)] = Field(
        default=3, description="How often a damaged or lost message is sent again."
    )
    timeout: Duration = Field(default=10**9, description="Wait before it is sent again.")
    drop: Probability = Field(default=0.0, description="Probability that a message is lost on the way.")
    late: Late | None = Field(default=None, description="Messages that come late.")
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)] = Field(
        default=0, description="Chooses the messages that go wrong."
    )


class Outage(SpecModel):
    """A span in which the link is down."""

    begin: Duration = Field(description="When it begins.")
    end: Duration | None = Field(default=None, description="When it ends. Without it, the link stays down.")

    @model_validator(mode="after")
    def _ends_later(self) -> Self:
        if self.end is not None and self.end <= self.begin:
            raise RefusalError("the outage ends before it begins", "give a later end, or none", ("end",))
        return self


class AnyLink(Hardware):
    """The keys that every link has."""

    simulated: ClassVar[str] = "Link"
    """The class of ``components`` that carries its messages; the general one where its law is all that is new."""
    if TYPE_CHECKING:
        type: str

    between: Ends = Field(description="Names of the components that it joins.")
    errors: LinkErrors | None = Field(default=None, description="What goes wrong on it. Without it, nothing does.")
    outages: Annotated[tuple[Outage, ...], Field(max_length=MAX_OUTAGES)] = Field(
        default=(), description="Spans of time in which it is down, in order."
    )
    power: BusyPower | None = Field(
        default=None, description="Power, busy and idle. Without it, the energy counts as 0 J and results say so."
    )

    @property
    def drawing(self) -> BusyPower | None:
        """Its power; None where it is not declared."""
        return self.power

    def prices(self) -> frozenset[str]:
        """The prices of its law, and its power."""
        return super().prices() | {"power"}

    def shape(self) -> Any:
        """All but its prices, and whether its power is declared."""
        return super().shape() | {"powered": self.power is not None}

    @field_validator("outages", mode="after")
    @classmethod
    def _in_order(cls, value: tuple[Outage, ...]) -> tuple[Outage, ...]:
        for index, (outage, after) in enumerate(pairwise(value), 1):
            if outage.end is None or after.begin < outage.end:
                what = "the outage begins before the one ahead of it ends"
                raise RefusalError(what, "list outages in order, apart from each other", (index,))
        return value


class BusLink(AnyLink):
    """A parallel bus: ``width`` bits a clock, after ``setup_cycles`` at the start of each burst."""

    law = BusLaw
    simulated = "Bus"

    type: Literal["bus"] = Field(description="A parallel bus, shared by the components that it joins.")
    width: PositiveFigure = Field(description="Bits a word: one word a clock at most.")
    clock: FrequencyFigure = Field(description="Clock of the bus.")
    setup_cycles: CountFigure = Field(description="Cycles before the first word of a burst.")
    burst_words: PositiveFigure = Field(description="Most words of one burst.")
    arbitration: Literal["message", "burst"] = Field(
        default="message", description="When another sender may be next: after a message, or after each burst."
    )


class SerialLink(AnyLink):
    """A serial line (UART), which sends in both directions at once.

    Each character is framed by start, parity and stop bits.
    """

    law = SerialLaw
    simulated = "Serial"

    type: Literal["serial"] = Field(description="A serial line, framed character by character.")
    baud: PositiveFigure = Field(description="Bits a second on the line, frame included.")
    data_bits: Annotated[int, Field(ge=5, le=9)] = Field(default=8, description="Data bits of a character.")
    start_bits: Annotated[int, Field(ge=1, le=1)] = Field(default=1, description="Start bits of a character.")
    stop_bits: float = Field(default=1.0, description="Stop bits of a character: 1, 1.5 or 2.")
    parity: Literal["none", "even", "odd"] = Field(default="none", description="Parity bit of a character.")
    fifo_depth: PositiveFigure = Field(description="Characters that the sender's FIFO holds.")

    @field_validator("stop_bits", mode="before")
    @classmethod
    def _of_the_three(cls, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or value not in {1, 1.5, 2}:
            raise RefusalError(f"{value!r} stop bits", "1, 1.5 or 2")
        return float(value)


class IdealLink(AnyLink):
    """A link that takes no time, for links that are not studied, and for checks."""

    law = IdealLaw
    simulated = "Ideal"

    type: Literal["ideal"] = Field(description="A link that takes no time.")


LINKS: dict[str, type[AnyLink]] = {
    get_args(kind.model_fields["type"].annotation)[0]: kind for kind in AnyLink.__subclasses__()
}
"""The kinds of links by their type in YAML: every subclass of ``AnyLink`` above is one."""

if TYPE_CHECKING:
    Link = AnyLink
else:
    Link = Annotated[Union[tuple(LINKS.values())], choice("type", LINKS)]  # noqa: UP007 - built of the table
