"""A part: a chip with a vector of resource budgets, its limits, and the source of each number."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from codesign.errors import Fault, InputError, choose_hint
from codesign.figures import Figure
from codesign.spec.base import Spec
from codesign.spec.fields import CountFigure, FrequencyFigure, Name, PowerFigure, SlicePowerFigure
from codesign.spec.locate import data_folder, shown
from codesign.spec.marks import Document, read_document
from codesign.spec.model import SPEED_GRADE_PATTERN, SpecModel
from codesign.spec.scalars import clip
from codesign.spec.validate import validate


class Part(BaseModel):
    """A chip in one speed grade.

    - ``resources``: budgets by kind: slices, lut4, flip_flops, block_rams, multipliers.
    - ``block_ram_shapes``: (depth, width) pairs that one block RAM may be configured as.
    - ``block_ram_clock``: the fastest clock of a block RAM in this speed grade, Hz.
    - ``static_power``: W. ``dynamic_power``: W for each occupied slice and Hz, at typical activity.
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

    @property
    def full_name(self) -> str:
        """Name and speed grade, as platforms name it: ``XC4VLX160-12``."""
        return f"{self.name}{self.speed_grade}"


class Resources(SpecModel):
    """Budgets of a part; 0 for what it lacks."""

    slices: CountFigure
    lut4: CountFigure
    flip_flops: CountFigure
    block_rams: CountFigure
    multipliers: CountFigure


class BlockRam(SpecModel):
    """The (depth, width) shapes that one block RAM may be configured as."""

    shapes: Annotated[
        tuple[tuple[Annotated[int, Field(ge=1, le=2**24)], Annotated[int, Field(ge=1, le=4096)]], ...],
        Field(min_length=1, max_length=64),
    ]


class PartPower(SpecModel):
    """Power: ``static`` of the chip, ``dynamic`` of one occupied slice at 1 MHz and typical activity."""

    static: PowerFigure
    dynamic: SlicePowerFigure


class SpeedGrade(SpecModel):
    """Limits of one speed grade."""

    block_ram_clock: FrequencyFigure


SpeedGradeName = Annotated[str, Field(pattern=SPEED_GRADE_PATTERN, max_length=8)]


class PartFile(Spec):
    """A part file: one chip in all its speed grades."""

    kind: Literal["part"]
    name: Name
    family: str
    description: str = ""
    resources: Resources
    block_ram: BlockRam
    power: PartPower
    speed_grades: Annotated[dict[SpeedGradeName, SpeedGrade], Field(min_length=1)]

    def part(self, speed_grade: str) -> Part:
        """The chip in one of its speed grades."""
        return Part(
            name=self.name,
            family=self.family,
            speed_grade=speed_grade,
            resources={kind: getattr(self.resources, kind) for kind in Resources.model_fields},
            block_ram_shapes=self.block_ram.shapes,
            block_ram_clock=self.speed_grades[speed_grade].block_ram_clock,
            static_power=self.power.static,
            dynamic_power=self.power.dynamic,
        )


def parts_folder() -> Path:
    """The folder of shipped parts."""
    return data_folder("platforms") / "parts"


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
    part_file = load_part_file(files[name])
    if dash + grade not in part_file.speed_grades:
        grades = [f"{name}{known}" for known in part_file.speed_grades]
        lacks = (
            f"no speed grade {clip(dash + grade)!r}" if grade else "several speed grades; one has to be named"
        )
        raise InputError(f"part {name} has {lacks}", hint=choose_hint(clip(full_name, 60), grades))
    return part_file.part(dash + grade)


def list_parts(folders: Sequence[Path] = ()) -> list[str]:
    """Full names of all parts, in every speed grade, sorted."""
    loaded = [load_part_file(path) for path in _part_files(folders).values()]
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


def _name_fault(document: Document, _context: Mapping[str, Any]) -> list[Fault]:
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
    found: dict[str, Path] = {}
    for folder in (*folders, parts_folder()):
        for path in sorted(folder.glob("*.yaml")):
            found.setdefault(path.stem, path)
    return found
