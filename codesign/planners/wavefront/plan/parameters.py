"""The parameters of the wavefront planner, as a workload's mapping gives them."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import AfterValidator, Field, model_validator

from codesign.ground.models import RefusalError, SpecModel, TaskParameters
from codesign.planners.wavefront.plan.grid import DELAYS, MAX_DELAY, MAX_EXTRA_DELAY, tile_count


class WaveEnd(StrEnum):
    """The end of the wave."""

    STARTS = "starts"
    WHOLE_MAP = "whole_map"


class Paths(StrEnum):
    """The paths that are tracked."""

    SHORTEST = "shortest"
    SAFE = "safe"


class Course(StrEnum):
    """The part of a path that is tracked before the robot sets out."""

    LOCAL = "local"
    COMPLETE = "complete"


class ReadOut(StrEnum):
    """The way in which the potentials leave the array."""

    ADDRESSED = "addressed"
    CHAIN = "chain"


Delay = Annotated[int, Field(ge=1, le=MAX_DELAY)]
MAX_ELEMENT_CELLS = 1024
"""Rows of one memory."""

MAX_TILES = 16_384
"""Each visit of a tile costs this program tens of microseconds, whatever its size."""

Side = Annotated[int, Field(ge=1, le=4096)]


class Penalty(SpecModel):
    """Extra delay near obstacles: nodes with a longer delay line (the paper's conclusion).

    The map marks these nodes when it is loaded. The plan's time does not count how they are determined.
    """

    distance: int = Field(ge=1, le=65_535, description="largest obstacle potential of a penalised cell, 2 a cell")
    delay: int = Field(ge=1, le=MAX_EXTRA_DELAY, description="cycles more to enter such a cell")


def _power_of_two(cells: int) -> int:
    if cells & (cells - 1):
        below = 1 << (cells.bit_length() - 1)
        raise ValueError(f"{cells} is no power of two, such as {below} or {2 * below}")
    return cells


class PropagateParameters(TaskParameters):
    """The run of the wave, the tracked paths, and the width of the registers."""

    stop: WaveEnd = Field(
        default=WaveEnd.STARTS,
        description="starts: when the wave reaches the start that asks, as in the paper; whole_map: at its own end."
        " For problem.task: field every wave runs to its own end",
    )
    paths: Paths = Field(
        default=Paths.SHORTEST,
        description="shortest: equation 2; safe: equations 4 and 5, with a wave from all obstacles",
    )
    course: Course = Field(
        default=Course.LOCAL,
        description="local: only the next steps are tracked, in a drive again at every control turn;"
        " complete: the whole path of the first start",
    )
    steps: int = Field(default=1, ge=1, le=65_535, description="steps of a local course")
    register_bits: int | None = Field(
        default=None, ge=1, le=31, description="width of each node's register; by default as wide as this problem needs"
    )
    corner_cutting: bool = Field(
        default=True,
        description="whether a diagonal step may pass between obstacles, as in the paper; a drive needs false",
    )
    delays: tuple[Delay, Delay] = Field(default=DELAYS, description="cycles of a straight and of a diagonal step")
    penalty: Penalty | None = Field(default=None, description="extra delay near obstacles")
    read_out: ReadOut = Field(
        default=ReadOut.ADDRESSED,
        description="addressed: a node is read by row and column, like a RAM; chain: the registers shift the"
        " potentials out after the wave, one a cycle, into a memory",
    )
    element_cells: Annotated[
        int,
        Field(
            ge=1,
            le=MAX_ELEMENT_CELLS,
            description="cells of a column that share one processing element of style delay_line: a step of the wave"
            " takes as many cycles; a power of two",
        ),
        AfterValidator(_power_of_two),
    ] = 1
    tile: tuple[Side, Side] | None = Field(
        default=None, description="rows and columns of the array of style tiled; by default the whole map"
    )

    @model_validator(mode="after")
    def _rising(self) -> PropagateParameters:
        if self.delays[1] < self.delays[0]:
            what = f"a diagonal step of {self.delays[1]} cycles is shorter than a straight one of {self.delays[0]}"
            raise RefusalError(what, "give [straight, diagonal], such as [2, 3]", ("delays",))
        return self

    def tile_shape(self, rows: int, columns: int) -> tuple[int, int]:
        """Rows and columns of a tile on a map of ``rows`` × ``columns``: by default the map's own.

        A tile larger than the map is a partial tile: its other nodes hold obstacles.
        """
        return self.tile or (rows, columns)

    def tile_count(self, rows: int, columns: int) -> int:
        """The number of tiles that cover a map of ``rows`` × ``columns``."""
        return tile_count((rows, columns), self.tile_shape(rows, columns))


class TrackParameters(TaskParameters):
    """The tracking of a path has no parameters of its own."""
