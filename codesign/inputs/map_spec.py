"""The map of a problem: generated, or read from a file."""

from __future__ import annotations

import difflib
import re
from abc import ABC, abstractmethod
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    Field,
    PlainSerializer,
    PrivateAttr,
    ValidationInfo,
    WithJsonSchema,
    WrapValidator,
    field_validator,
    model_validator,
)

from codesign.ground.errors import InputError, clip, show
from codesign.ground.models import Location, RefusalError, SpecModel, choice, refused
from codesign.ground.units import Dimension, parse_quantity
from codesign.inputs.fields import Length
from codesign.maps.prepare import Crop, Radius, Steps, Unknown

MAX_CELLS = 2**24

Side = Annotated[int, Field(ge=1, le=MAX_CELLS)]
Seed = Annotated[int, Field(ge=0, le=2**64 - 1)]
Share = Annotated[float, Field(ge=0, le=1)]


_CELLS = re.compile(r" *([0-9]{1,6}(?:\.[0-9]{1,6})?) *cells? *")


def _read_radius(value: Any, _handler: Any) -> Radius:
    if isinstance(value, Radius):
        return value
    if not isinstance(value, str):
        raise RefusalError(f"{show(value)} is no radius", "write it in metres or cells: 0.3 m, or 6 cells")
    in_cells = _CELLS.fullmatch(value)
    if in_cells is not None:
        return Radius(float(in_cells[1]), "cells")
    try:
        return Radius(float(parse_quantity(value, Dimension.LENGTH)), "m")
    except InputError as wrong:
        raise refused(wrong) from None


_RADIUS_TEXT = {"type": "string", "pattern": "^[0-9.]+ *(cells?|um|mm|cm|m|km)$", "examples": ["0.3 m"]}
InflateRadius = Annotated[Radius, WrapValidator(_read_radius), PlainSerializer(str), WithJsonSchema(_RADIUS_TEXT)]


class PreparedMap(SpecModel):
    """The steps from a map to what is planned on; ``maps.prepare`` has their order."""

    inflate: InflateRadius | None = Field(
        default=None,
        description="Blocks each cell with its middle at most this far from the middle of an obstacle cell or from the"
        " outside of the map: 0.3 m, or 6 cells. It comes before downsample.",
    )
    downsample: Annotated[int, Field(ge=1, le=4096)] = Field(
        default=1,
        description="Joins so many cells in each direction to one, which is free where all of them are free. Cells and"
        " metres a cell are those of the new map.",
    )
    crop: Crop = Field(
        default=Crop.NONE,
        description="Plans on a part of the map: none: on all of it; free: on the rectangle around all free cells;"
        " reachable: around those that are joined to a goal or to a named start. Rows, columns and metres stay those of"
        " the whole map.",
    )
    resolution: Length | None = Field(
        default=None, description="Metres a cell of the map as it is read, where it does not say so itself."
    )

    @property
    def steps(self) -> Steps:
        """The steps that the map takes before cropping."""
        return Steps(inflate=self.inflate, downsample=self.downsample, resolution=self.resolution)

    @field_validator("resolution", mode="after")
    @classmethod
    def _above_zero(cls, value: float | None) -> float | None:
        if value == 0:
            raise RefusalError("a resolution of 0", "metres a cell, above 0")
        return value


class GeneratedMap(PreparedMap, ABC):
    """The base of all generated maps: a size of at most 2^24 cells."""

    @property
    def parameters(self) -> dict[str, Any]:
        """The parameters of the generator."""
        return self.model_dump(exclude={"generate", *PreparedMap.model_fields})

    @property
    @abstractmethod
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map to come."""

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        rows, columns = self.shape
        if rows * columns > MAX_CELLS:
            raise RefusalError(f"a map of {rows} × {columns} cells is too large", f"at most {MAX_CELLS:,} cells")
        return self


class _Sized(GeneratedMap):
    rows: Side = Field(description="Rows of the map.")
    columns: Side = Field(description="Columns of the map.")

    @property
    def shape(self) -> tuple[int, int]:
        return self.rows, self.columns


class MazeMap(_Sized):
    """A maze: perfect where ``loops`` is 0."""

    generate: Literal["maze"] = Field(description="A maze.")
    corridor: Side = Field(default=1, description="Width of the corridors, cells.")
    wall: Side = Field(default=1, description="Thickness of the walls, cells.")
    seed: Seed = Field(default=0, description="Chooses one of the possible mazes.")
    loops: Share = Field(default=0.0, description="Share of the remaining walls that are opened, which makes loops.")


class RoomsMap(_Sized):
    """Rooms with doors, all connected."""

    generate: Literal["rooms"] = Field(description="Rooms with doors.")
    room: tuple[Side, Side] = Field(default=(16, 16), description="Rows and columns of a room, cells.")
    door: Side = Field(default=2, description="Width of the doors, cells.")
    wall: Side = Field(default=1, description="Thickness of the walls, cells.")
    seed: Seed = Field(default=0, description="Chooses doors and their places.")
    extra_doors: Share = Field(default=0.0, description="Share of the remaining walls that get a door too.")


class RandomMap(_Sized):
    """Square obstacles thrown at random until ``density`` of the map is covered."""

    generate: Literal["random"] = Field(description="Random obstacles.")
    density: Share = Field(description="Share of the map that obstacles cover.")
    seed: Seed = Field(default=0, description="Chooses the places of the obstacles.")
    size: Annotated[int, Field(ge=1, le=256)] = Field(default=1, description="Side of an obstacle, cells.")


class SpiralMap(_Sized):
    """One corridor, from the top left clockwise to the middle."""

    generate: Literal["spiral"] = Field(description="A spiral.")
    corridor: Side = Field(default=1, description="Width of the corridor, cells.")
    wall: Side = Field(default=1, description="Thickness of the walls, cells.")


class CorridorMap(GeneratedMap):
    """A free strip."""

    generate: Literal["corridor"] = Field(description="A free strip.")
    length: Side = Field(description="Columns of the map.")
    width: Side = Field(default=1, description="Rows of the map.")

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map to come."""
        return self.width, self.length


class EmptyMap(_Sized):
    """No obstacle."""

    generate: Literal["empty"] = Field(description="No obstacle.")


class FileMap(PreparedMap):
    """A map in a file: MovingAI ``.map``, ROS map_server YAML, text, PNG, BMP or PGM."""

    file: Annotated[str, Field(min_length=1, max_length=4096)] = Field(
        description="Path of the map, relative to the workload file."
    )
    unknown: Unknown = Field(
        default=Unknown.BLOCKED, description="What a cell counts as that the map says nothing about."
    )
    _path: Path = PrivateAttr()

    @property
    def path(self) -> Path:
        """The path of the map, seen from the current folder."""
        return self._path

    @property
    def steps(self) -> Steps:
        """The steps that the map takes before cropping."""
        return replace(super().steps, unknown=self.unknown)

    @field_validator("file", mode="before")
    @classmethod
    def _names_a_file(cls, value: Any) -> Any:
        return named(value, "map")

    @model_validator(mode="after")
    def _must_be_a_file(self, info: ValidationInfo) -> Self:
        kinds = "an image, a text, or the YAML of map_server"
        self._path = beside(info, self.file, ("file",), kinds)
        return self


def named(value: Any, what: str) -> Any:
    """The path of a file as it is written, refused where there is none; ``what`` the file holds."""
    if value is None or value == "":
        raise RefusalError("names no file", f"write the path of a {what}; {_RELATIVE}")
    return value


def beside(info: ValidationInfo, written: str, at: Location, kinds: str) -> Path:
    """The path of a file that a workload names, seen from the current folder; it is a regular file.

    ``at``: the key of the path. ``kinds``: of files that are accepted, for the remedy.
    """
    document = (info.context or {}).get("document")
    path = (document.folder if document else Path()) / written
    try:
        there, is_file, is_folder = path.exists(), path.is_file(), path.is_dir()
    except (OSError, ValueError):
        there = is_file = is_folder = False
    if there and not is_file:
        what = f"{clip(written)} is not a file but a {'folder' if is_folder else 'device or a pipe'}"
        raise RefusalError(what, f"name a regular file: {kinds}", at)
    if not there:
        raise RefusalError(f"{clip(written)} does not exist", _near(path, written), at)
    return path


_RELATIVE = "the path is relative to the file that names it"


def _near(path: Path, written: str) -> str:
    try:
        names = [entry.name for entry in path.parent.iterdir()][:1000]
    except (OSError, ValueError):
        return _RELATIVE
    near = difflib.get_close_matches(path.name, names, n=1)
    return f"did you mean {Path(written).with_name(near[0])}? {_RELATIVE}" if near else _RELATIVE


MAPS: dict[str, type[GeneratedMap]] = {
    "maze": MazeMap,
    "rooms": RoomsMap,
    "random": RandomMap,
    "spiral": SpiralMap,
    "corridor": CorridorMap,
    "empty": EmptyMap,
}
"""The model of each map generator, by the name it has in YAML and in ``codesign.maps.GENERATORS``."""

_choose_generator = choice("generate", MAPS)


def _choose_map(value: Any, handler: Any, info: ValidationInfo) -> Any:
    if isinstance(value, FileMap):
        return value
    if isinstance(value, dict) and "file" in value and "generate" not in value:
        return FileMap.model_validate(value, context=info.context)
    if isinstance(value, dict) and "generate" not in value:
        hint = "write file: PATH of a map, or generate: and its parameters"
        raise RefusalError("neither file nor generate is given", f"{hint}; generators: {', '.join(sorted(MAPS))}")
    return _choose_generator.func(value, handler, info)  # type: ignore[call-arg]


Map = Annotated[
    FileMap | MazeMap | RoomsMap | RandomMap | SpiralMap | CorridorMap | EmptyMap, WrapValidator(_choose_map)
]
