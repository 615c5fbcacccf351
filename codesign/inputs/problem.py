"""The problem of a workload: the map, generated or read, its goals and its starts."""

from __future__ import annotations

import difflib
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, PrivateAttr, ValidationInfo, WrapValidator, field_validator, model_validator

from codesign.errors import clip, outside_map, show
from codesign.inputs.fields import Cell
from codesign.inputs.task import Change
from codesign.models import RefusalError, SpecModel, Task, choice, raise_all, refusal_details

MAX_CELLS = 2**24

Side = Annotated[int, Field(ge=1, le=MAX_CELLS)]
Seed = Annotated[int, Field(ge=0, le=2**64 - 1)]
Share = Annotated[float, Field(ge=0, le=1)]


class GeneratedMap(SpecModel, ABC):
    """What all generated maps share: a size of at most 2^24 cells."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, int]:
        """Rows and columns of the map to come."""

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        rows, columns = self.shape
        if rows * columns > MAX_CELLS:
            raise RefusalError(
                f"a map of {rows} × {columns} cells is too large", f"at most {MAX_CELLS:,} cells"
            )
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
    loops: Share = Field(
        default=0.0, description="Share of the remaining walls that are opened, which makes loops."
    )


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


class FileMap(SpecModel):
    """A map in a file: MovingAI ``.map``, ROS map_server YAML, text, PNG or PGM."""

    file: Annotated[str, Field(min_length=1, max_length=4096)] = Field(
        description="Path of the map, relative to the workload file."
    )
    _path: Path = PrivateAttr()

    @property
    def path(self) -> Path:
        """Where the map lies, seen from the current folder."""
        return self._path

    @field_validator("file", mode="before")
    @classmethod
    def _names_a_file(cls, value: Any) -> Any:
        if value is None or value == "":
            raise RefusalError("names no file", f"write the path of a map; {_RELATIVE}")
        return value

    @model_validator(mode="after")
    def _must_be_a_file(self, info: ValidationInfo) -> Self:
        document = (info.context or {}).get("document")
        path = (document.folder if document else Path()) / self.file
        try:
            there, is_file, is_folder = path.exists(), path.is_file(), path.is_dir()
        except (OSError, ValueError):
            there = is_file = is_folder = False
        if there and not is_file:
            what = f"{clip(self.file)} is not a file but a {'folder' if is_folder else 'device or a pipe'}"
            hint = "name a regular file: an image, a text, or the YAML of map_server"
            raise RefusalError(what, hint, ("file",))
        if not there:
            raise RefusalError(f"{clip(self.file)} does not exist", _near(path, self.file), ("file",))
        self._path = path
        return self


_RELATIVE = "the path is relative to this workload file"


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
        raise RefusalError(
            "neither file nor generate is given", f"{hint}; generators: {', '.join(sorted(MAPS))}"
        )
    return _choose_generator.func(value, handler, info)  # type: ignore[call-arg]


Map = Annotated[
    FileMap | MazeMap | RoomsMap | RandomMap | SpiralMap | CorridorMap | EmptyMap, WrapValidator(_choose_map)
]


class SampledStarts(SpecModel):
    """Starts drawn at random from the free cells with a path to a goal across the sides of cells."""

    count: Annotated[int, Field(ge=1, le=100_000)] = Field(default=64, description="How many starts.")
    seed: Seed = Field(default=0, description="Chooses which cells.")


def _choose_starts(value: Any, handler: Any, info: ValidationInfo) -> Any:
    if isinstance(value, dict):
        return SampledStarts.model_validate(value, context=info.context)
    if isinstance(value, list | tuple | SampledStarts):
        return handler(value)
    raise RefusalError(
        f"{show(value)} names no starts", "write a list of [row, column], or {count: 64, seed: 0}"
    )


Cells = Annotated[tuple[Cell, ...], Field(min_length=1)]
Starts = Annotated[Cells | SampledStarts, WrapValidator(_choose_starts)]


class ProblemSpec(SpecModel):
    """What is to be planned: a map, goals, and starts that judge the plan."""

    map: Map = Field(description="The map: generated, or read from a file.")
    goals: Cells = Field(description="Goals: a list of [row, column], counted from 0 at the top left.")
    starts: Starts = Field(
        default=SampledStarts(),
        description="Starts that judge the plan. {count, seed} draws them from the cells with a path across the sides"
        " of cells to a goal. A list [[row, column], ...] names them; the planner's own moves must lead"
        " each of them to a goal.",
    )
    task: Task = Field(
        default=Task.PATH,
        description="What is asked and timed. path: a path from each start; field: an answer in every cell that leads"
        " to a goal; replan: a path from each start after a change.",
    )
    change: Change | None = Field(
        default=None,
        description="The change that task replan follows: {blocked, freed}, lists of cells, or {count, seed}, drawn."
        " The other tasks leave it out.",
    )
    arrive: Share = Field(
        default=1.0,
        description="Share of the starts that can arrive which have to arrive. A plan of fewer is not feasible.",
    )

    @model_validator(mode="after")
    def _has_a_change(self) -> Self:
        if self.task is Task.REPLAN and self.change is None:
            hint = "add change: {count: 20, seed: 0}, or name cells: {blocked: [[row, column], ...]}"
            raise RefusalError("task replan follows a change of the map, and none is given", hint, ("task",))
        return self

    @field_validator("goals", "starts", mode="after")
    @classmethod
    def _cells_inside(cls, value: Any, info: ValidationInfo) -> Any:
        """Cells of a generated map are checked here; those of a map file once it is read."""
        if isinstance(value, SampledStarts):
            return value
        refusals, seen = [], set()
        declared = info.data.get("map")
        shape = declared.shape if isinstance(declared, GeneratedMap) else None
        for index, cell in enumerate(value):
            if cell in seen:
                refusal = RefusalError(f"{list(cell)} is named twice", "name it once")
                refusals.append(refusal_details(refusal, (index,)))
            elif shape and not (cell[0] < shape[0] and cell[1] < shape[1]):
                refusals.append(refusal_details(RefusalError(*outside_map(cell, shape)), (index,)))
            seen.add(cell)
        raise_all("ProblemSpec", refusals)
        return value
