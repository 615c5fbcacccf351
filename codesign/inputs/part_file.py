"""Part files: a chip in all its speed grades, found by name and read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from codesign.ground.errors import InputError, choose_hint, clip
from codesign.ground.figures import RESOURCES, Figure, Status
from codesign.ground.models import SPEED_GRADE_PATTERN, Part, RefusalError, SpecModel
from codesign.inputs.base import Spec
from codesign.inputs.fields import CountFigure, FrequencyFigure, Name, PowerFigure, SlicePowerFigure
from codesign.inputs.library import Library


class Resources(SpecModel):
    """Budgets of a part; 0 for what it lacks.

    ``lut4``, two of them a slice, or ``lut6`` where a slice has four or eight LUT of six inputs and twice as many
    flip-flops (Virtex-5 and later). ``block_rams``: as one of ``BlockRam.shapes``; of 36 kbit counts as two.
    """

    slices: CountFigure = Field(
        description="Slices; of a part whose logic cells are not in slices of two LUT, half of the cells."
    )
    lut4: CountFigure | None = Field(default=None, description="LUTs of four inputs; this or lut6 is required.")
    lut6: CountFigure | None = Field(default=None, description="LUTs of six inputs, four or eight of them in a slice.")
    flip_flops: CountFigure = Field(description="Flip-flops.")
    block_rams: CountFigure = Field(
        description="Block RAMs, each of which can have the shapes of block_ram; one of 36 kbit counts as two of 18."
    )
    multipliers: CountFigure = Field(description="Multipliers of 18 × 18 bits, or the nearest that the part has.")

    @model_validator(mode="after")
    def _one_make_of_lut(self) -> Self:
        if (self.lut4 is None) == (self.lut6 is None):
            what = "neither lut4 nor lut6 is given" if self.lut4 is None else "both lut4 and lut6 are given"
            raise RefusalError(what, "give the one that the part's slices are made of")
        return self

    def counted(self) -> dict[str, Figure]:
        """The budgets by kind as laws count them: in LUT4, and in slices of two LUT4 and two flip-flops.

        A LUT6 does what any LUT4 does; it does the work of two where they need no more than five inputs between them.
        So the conversion is a floor, and the interval reaches to twice as much.
        """
        counted = {kind: getattr(self, kind) for kind in RESOURCES}
        if self.lut6 is not None:
            lut6 = "a LUT6 taken for each LUT4 of a law, though two may share one"
            shares = f"laws count slices of two LUT and two flip-flops, {self.counted_a_slice} for each of these"
            counted["lut4"] = _converted(self.lut6, 1, lut6)
            counted["slices"] = _converted(self.slices, self.counted_a_slice, shares)
        return counted

    @property
    def counted_a_slice(self) -> int:
        """Slices of two LUT and two flip-flops, as laws count them, that stand in one of the part."""
        if self.lut6 is None:
            return 1
        return max(1, int(self.lut6.value) // (2 * max(1, int(self.slices.value))))


def _converted(figure: Figure, factor: int, how: str) -> Figure:
    """``factor`` times a count of LUT6 or of their slices, and up to twice as much."""
    amount = factor * int(figure.value)
    return Figure(amount, figure.unit, Status.ASSUMED, f"{figure.source}; {how}", amount, 2 * amount)


class BlockRam(SpecModel):
    """The (depth, width) shapes that one block RAM may be configured as."""

    shapes: Annotated[
        tuple[tuple[Annotated[int, Field(ge=1, le=2**24)], Annotated[int, Field(ge=1, le=4096)]], ...],
        Field(min_length=1, max_length=64),
    ] = Field(description="Shapes that one block RAM can have: [depth, width], in words and bits.")


class PartPower(SpecModel):
    """Power: ``static`` of the chip, ``dynamic`` of one occupied slice of it at 1 MHz and typical activity."""

    static: PowerFigure = Field(description="Of the chip, whatever it does.")
    dynamic: SlicePowerFigure = Field(description="Of one occupied slice at 1 MHz and typical activity.")


class SpeedGrade(SpecModel):
    """Limits of one speed grade."""

    block_ram_clock: FrequencyFigure = Field(description="Fastest clock of a block RAM.")


SpeedGradeName = Annotated[str, Field(pattern=SPEED_GRADE_PATTERN, max_length=8)]


class PartFile(Spec):
    """A part file: one chip in all its speed grades."""

    kind: Literal["part"] = Field(description="This file is a part.")
    name: Name = Field(description="Name of the part, which is that of its file.")
    family: str = Field(description="Family of the chip, such as Virtex-4.")
    description: str = Field(default="", description="What it is, for readers.")
    resources: Resources = Field(description="Budgets of the part.")
    block_ram: BlockRam = Field(description="What one block RAM can be.")
    power: PartPower = Field(description="Power, static and dynamic.")
    speed_grades: Annotated[dict[SpeedGradeName, SpeedGrade], Field(min_length=1)] = Field(
        description='Limits by speed grade, such as "-12".'
    )

    def part(self, speed_grade: str) -> Part:
        """The chip in one of its speed grades."""
        return Part(
            name=self.name,
            family=self.family,
            speed_grade=speed_grade,
            resources=self.resources.counted(),
            block_ram_shapes=self.block_ram.shapes,
            block_ram_clock=self.speed_grades[speed_grade].block_ram_clock,
            static_power=self.power.static,
            dynamic_power=self._dynamic_power(),
        )

    def _dynamic_power(self) -> Figure:
        """Of one slice as laws count them."""
        figure = self.power.dynamic
        share = self.resources.counted_a_slice
        if share == 1:
            return figure
        low, high = (bound / share for bound in figure.interval)
        text = f"{figure.source}; 1/{share} of it for each of the {share} slices that laws count in one of these"
        return Figure(figure.value / share, figure.unit, figure.status, text, low, high)


PARTS = Library("part", PartFile)
"""Part files."""


def load_part(full_name: str, folders: Sequence[Path] = ()) -> Part:
    """The part with a name and speed grade such as ``XC4VLX160-12``.

    Args:
        full_name: name and speed grade.
        folders: searched before the shipped parts, for files ``NAME.yaml``.

    Raises:
        InputError: no such part or speed grade; with the nearest one and the list.
        SpecError: a faulty part file.
    """
    name, grade = (full_name, "") if full_name in PARTS.names(folders) else name_and_grade(full_name)
    part_file = PARTS.find(name, folders)
    if grade not in part_file.speed_grades:
        grades = [f"{name}{accepted}" for accepted in part_file.speed_grades]
        lacks = f"no speed grade {clip(grade)!r}" if grade else "several speed grades; one has to be named"
        raise InputError(f"part {name} has {lacks}", hint=choose_hint(clip(full_name, 60), grades))
    return part_file.part(grade)


def name_and_grade(full_name: str) -> tuple[str, str]:
    """Name and speed grade of a full name; the name alone where there is no dash.

    >>> name_and_grade("LFE5U-85F-8"), name_and_grade("XC4VLX160")
    (('LFE5U-85F', '-8'), ('XC4VLX160', ''))
    """
    name, dash, grade = full_name.rpartition("-")
    return (name, dash + grade) if dash else (full_name, "")


def all_parts(folders: Sequence[Path] = ()) -> dict[str, Part]:
    """All parts, in every speed grade, by full name, sorted."""
    files = [PARTS.load(path) for path in PARTS.names(folders).values()]
    parts = [file.part(grade) for file in files for grade in file.speed_grades]
    return {part.full_name: part for part in sorted(parts, key=lambda part: part.full_name)}


def list_parts(folders: Sequence[Path] = ()) -> list[str]:
    """Full names of all parts, in every speed grade, sorted."""
    return list(all_parts(folders))
