"""A platform: components and the links between them, as declared in YAML."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, ValidationInfo, field_validator, model_validator

from codesign.errors import Fault, InputError, SpecError, choose_hint
from codesign.spec.base import Spec
from codesign.spec.fields import CountFigure, FrequencyFigure, Name, PositiveFigure, PowerFigure, TimeFigure
from codesign.spec.locate import find_spec, shipped_names
from codesign.spec.marks import Document, read_document
from codesign.spec.model import RefusalError, SpecModel, choice, refused
from codesign.spec.part import Part, load_part
from codesign.spec.scalars import clip
from codesign.spec.validate import validate
from codesign.units import format_frequency

MAX_NAMES = 256
"""Components of a platform, links of a platform, and components that one link joins."""


class FpgaComponent(SpecModel):
    """A programmable chip with one clock."""

    type: Literal["fpga"] = Field(description="An FPGA.")
    part: str = Field(description="Name and speed grade of the part, such as XC4VLX160-12.")
    clock: FrequencyFigure = Field(description="Clock of the design, at most the part's block RAM limit.")
    _chip: Part = PrivateAttr()

    @property
    def chip(self) -> Part:
        """The part, loaded."""
        return self._chip

    @field_validator("part", mode="after")
    @classmethod
    def _known_part(cls, value: str, info: ValidationInfo) -> str:
        try:
            load_part(value, _part_folders(info))
        except SpecError:
            raise
        except InputError as error:
            raise refused(error) from None
        return value

    @model_validator(mode="after")
    def _clock_within_part(self, info: ValidationInfo) -> Self:
        self._chip = load_part(self.part, _part_folders(info))
        limit = self._chip.block_ram_clock.interval[1]
        if self.clock.value > limit:
            what = f"{format_frequency(self.clock.value)} is above the {format_frequency(limit)} limit"
            hint = "lower the clock, or choose a faster part"
            raise RefusalError(f"{what} of part {self.part}", hint, ("clock",))
        return self


def _part_folders(info: ValidationInfo) -> tuple[Path, ...]:
    """The folder ``parts`` beside the platform file."""
    document = (info.context or {}).get("document")
    return (document.folder / "parts",) if document else ()


class ProcessorPower(SpecModel):
    """Power of a processor while it computes and while it waits."""

    busy: PowerFigure = Field(description="While it computes.")
    idle: PowerFigure = Field(description="While it waits.")


class ProcessorComponent(SpecModel):
    """A processor that runs named kernels."""

    type: Literal["processor"] = Field(description="A processor: the robot's host, a PC.")
    clock: FrequencyFigure = Field(description="Clock of the processor.")
    costs: dict[Name, TimeFigure] = Field(
        default={}, description="Time for one unit of each named kernel, such as harmonic_node_update."
    )
    power: ProcessorPower = Field(description="Power, busy and idle.")


class BusLink(SpecModel):
    """A parallel bus: ``width`` bits a clock, after ``setup_cycles`` at the start of each burst."""

    type: Literal["bus"] = Field(description="A parallel bus, shared by the components that it joins.")
    between: Annotated[tuple[Name, ...], Field(min_length=2, max_length=MAX_NAMES)] = Field(
        description="The components that it joins."
    )
    width: PositiveFigure = Field(description="Bits a word: one word a clock at most.")
    clock: FrequencyFigure = Field(description="Clock of the bus.")
    setup_cycles: CountFigure = Field(description="Cycles before the first word of a burst.")
    burst_words: PositiveFigure = Field(description="Most words of one burst.")


COMPONENTS: dict[str, type[SpecModel]] = {"fpga": FpgaComponent, "processor": ProcessorComponent}
LINKS: dict[str, type[SpecModel]] = {"bus": BusLink}

Component = Annotated[FpgaComponent | ProcessorComponent, choice("type", COMPONENTS)]
Link = Annotated[BusLink, choice("type", LINKS)]


class Platform(Spec):
    """Components and links."""

    kind: Literal["platform"] = Field(description="This file is a platform.")
    name: Name = Field(description="Name of the platform.")
    description: str = Field(default="", description="What it is, for humans.")
    components: Annotated[dict[Name, Component], Field(min_length=1, max_length=MAX_NAMES)] = Field(
        description="Components by name."
    )
    links: Annotated[dict[Name, Link], Field(max_length=MAX_NAMES)] = Field(
        default={}, description="Links by name."
    )

    def _identity(self) -> dict[str, Any]:
        chips = [
            part.chip.model_dump(mode="json")
            for part in self.components.values()
            if isinstance(part, FpgaComponent)
        ]
        return {**super()._identity(), "chips": chips}


def _link_faults(document: Document, _context: Mapping[str, Any]) -> list[Fault]:
    """Links that join what is no component, or one twice, or that go by the name of a component."""
    tree = document.tree if isinstance(document.tree, dict) else {}
    components, links = tree.get("components"), tree.get("links")
    if not isinstance(components, dict) or not isinstance(links, dict):
        return []
    if max(len(components), len(links)) > MAX_NAMES:
        return []
    faults = []
    for name, link in links.items():
        if name in components:
            what, hint = f"{clip(name)} names a component too", "give the link a name of its own"
            faults.append(document.fault(("links", name), what, hint, at_key=True))
        ends = link.get("between") if isinstance(link, dict) else None
        ends = ends[:MAX_NAMES] if isinstance(ends, list) else []
        for index, end in enumerate(ends):
            path = ("links", name, "between", index)
            if not isinstance(end, str):
                continue
            if end not in components:
                hint = choose_hint(clip(end, 60), components)
                faults.append(document.fault(path, f"there is no component {clip(end)!r}", hint))
            elif end in ends[:index]:
                faults.append(document.fault(path, f"{clip(end)} is named twice", "name it once"))
    return faults


def load_platform(source: str | Path) -> Platform:
    """The platform with a shipped name (``virtex4-pci``), or in a file (with a separator or ``.yaml``).

    Its parts are looked for in the folder ``parts`` beside the file first, then among the shipped ones.

    Raises:
        InputError: no shipped platform of that name.
        SpecError: all the faults of the file.
    """
    path, shown = find_spec(source, "platforms")
    document = read_document(path, shown)
    return validate(Platform, document, also=_link_faults).with_document(document)


def list_platforms() -> list[str]:
    """Names of the shipped platforms."""
    return shipped_names("platforms")
