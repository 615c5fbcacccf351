"""Part files: a chip in all its speed grades, found by name and read."""

from __future__ import annotations

import contextlib
import functools
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from codesign.errors import Fault, InputError, choose_hint, clip
from codesign.figures import RESOURCES, Figure, Status
from codesign.inputs.base import Spec
from codesign.inputs.document import Document
from codesign.inputs.faults import validate
from codesign.inputs.fields import CountFigure, FrequencyFigure, Name, PowerFigure, SlicePowerFigure
from codesign.inputs.files import data_folder, shown
from codesign.inputs.yaml_tree import read_document
from codesign.models import SPEED_GRADE_PATTERN, RefusalError, SpecModel
from codesign.part import Part

LUT6_SLICE = 2
"""Slices of two LUT and two flip-flops that stand in one of four LUT6 and at least four flip-flops."""


class Resources(SpecModel):
    """Budgets of a part; 0 for what it lacks.

    ``lut4``, or ``lut6`` where a slice has four LUT of six inputs (Virtex-5 and later). ``block_rams``: of 18 kbit; one
    of 36 kbit counts as two.
    """

    slices: CountFigure = Field(description="Slices.")
    lut4: CountFigure | None = Field(
        default=None, description="LUTs of four inputs; this or lut6 is required."
    )
    lut6: CountFigure | None = Field(default=None, description="LUTs of six inputs, four of them in a slice.")
    flip_flops: CountFigure = Field(description="Flip-flops.")
    block_rams: CountFigure = Field(description="Block RAMs of 18 kbit; one of 36 kbit counts as two.")
    multipliers: CountFigure = Field(description="Multipliers.")

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
            halves = "laws count slices of two LUT and two flip-flops, two of them for each of these"
            counted["lut4"] = _converted(self.lut6, 1, lut6)
            counted["slices"] = _converted(self.slices, LUT6_SLICE, halves)
        return counted


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
        if self.resources.lut6 is None:
            return figure
        low, high = (bound / LUT6_SLICE for bound in figure.interval)
        text = f"{figure.source}; half of it for each of the two slices that laws count in one of these"
        return Figure(figure.value / LUT6_SLICE, figure.unit, figure.status, text, low, high)


def parts_folder() -> Path:
    """The folder of shipped parts."""
    return data_folder("platforms/parts")


def load_part(full_name: str, folders: Sequence[Path] = ()) -> Part:
    """The part with a name and speed grade such as ``XC4VLX160-12``.

    Args:
        full_name: name and speed grade.
        folders: searched before the shipped parts, for files ``NAME.yaml``.

    Raises:
        InputError: no such part or speed grade; with the nearest one and the list.
        SpecError: a faulty part file.
    """
    files = _part_files(folders)
    name, dash, grade = full_name.partition("-")
    if name not in files:
        raise InputError(f"there is no part {clip(name)!r}", hint=choose_hint(clip(name, 60), files))
    part_file = load_part_file(files[name] / f"{name}.yaml")
    if dash + grade not in part_file.speed_grades:
        grades = [f"{name}{accepted}" for accepted in part_file.speed_grades]
        lacks = (
            f"no speed grade {clip(dash + grade)!r}" if grade else "several speed grades; one has to be named"
        )
        raise InputError(f"part {name} has {lacks}", hint=choose_hint(clip(full_name, 60), grades))
    return part_file.part(dash + grade)


def part_state(full_name: str, folders: Sequence[Path] = ()) -> tuple[tuple[int, int], ...]:
    """When the files of a part were changed, and their sizes: what is kept of a part holds for this state alone."""
    name, states = full_name.partition("-")[0], []
    for folder in (*folders, parts_folder()):
        with contextlib.suppress(OSError, ValueError):
            state = os.stat(f"{folder}/{name}.yaml")
            states.append((state.st_mtime_ns, state.st_size))
    return tuple(states)


def list_parts(folders: Sequence[Path] = ()) -> list[str]:
    """Full names of all parts, in every speed grade, sorted."""
    loaded = [load_part_file(folder / f"{name}.yaml") for name, folder in _part_files(folders).items()]
    return sorted(f"{part.name}{grade}" for part in loaded for grade in part.speed_grades)


def load_part_file(path: Path) -> PartFile:
    """A part file; read once a process as long as it does not change.

    Raises:
        SpecError: all the faults of the file.
    """
    try:
        state = path.stat()
    except OSError:
        return _load_part_file(path, 0, 0)
    return _load_part_file(path, state.st_mtime_ns, state.st_size)


@functools.lru_cache(maxsize=256)
def _load_part_file(path: Path, _modified: int, _size: int) -> PartFile:
    document = read_document(path, shown(path))
    return validate(PartFile, document, also=_name_fault).with_document(document)


def _name_fault(document: Document) -> list[Fault]:
    """Parts are found by the names of their files, so the two have to agree."""
    name = document.tree.get("name") if isinstance(document.tree, dict) else None
    expected = Path(document.file).stem
    if not isinstance(name, str) or name == expected:
        return []
    return [
        document.fault(
            ("name",), f"{clip(name)!r} in file {expected}.yaml", "give file and part the same name"
        )
    ]


def _part_files(folders: Sequence[Path]) -> dict[str, Path]:
    """The folder of each part file, by the name of the part."""
    folder_of: dict[str, Path] = {}
    for folder in (*folders, parts_folder()):
        # No folder, no parts.
        with contextlib.suppress(OSError):
            names = [name.removesuffix(".yaml") for name in os.listdir(folder) if name.endswith(".yaml")]
            folder_of |= {name: folder for name in names if name not in folder_of}
    return folder_of
