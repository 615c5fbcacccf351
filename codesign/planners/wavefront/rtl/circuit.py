"""The circuits of the arrays for whole maps: styles ``delay_line`` and ``adder_comparator``."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

from codesign.ground.errors import Fault, UnsuitedError
from codesign.planners.circuits import SHARED, Circuit, CircuitStyle, Expected
from codesign.planners.interface import Problem
from codesign.planners.job import Job
from codesign.planners.wavefront.plan.parameters import Course, PropagateParameters, ReadOut
from codesign.planners.wavefront.plan.plan import waits
from codesign.planners.wavefront.rtl.expected import KINDS, PHASES, TILED_PHASES, expected_run
from codesign.planners.wavefront.rtl.layout import Words, load_stream
from codesign.planners.wavefront.rtl.samples import random_job
from codesign.planners.wavefront.rtl.tile_layout import TileWords, tile_stream
from codesign.planners.wavefront.styles import AdderComparator, DelayLine, Tiled, tile
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.resources import LAWS
from codesign.planners.wavefront.styles.steps import TRACK

HERE = Path(__file__).parent
MACHINE = (
    *(
        "wavefront_machine",
        "select_word",
        "select_line",
        "select_number",
        "path_tracker",
        "delay_line_array",
        "delay_line_node",
    ),
    *("adder_array", "adder_node", "element_array", "wave_element"),
)
"""The modules of the machine: it names every array, and Yosys reads them all."""

TILED_MACHINE = (
    *("tiled_machine", "tile_array", "halo_cell", "tile_column", "tile_cursor", "tile_scheduler"),
    *("earliest_changes", "select_line", "select_number", "path_tracker", "delay_line_node"),
)
"""The modules of the machine with an array of one tile."""

TILED_PIECES = {
    "nodes": ("delay_line_node",),
    "halo": ("halo_cell",),
    "column memories": ("tile_column",),
    "scheduler": ("tile_scheduler", "earliest_changes"),
    "tracker": ("path_tracker",),
    "cursor": ("tile_cursor",),
    "read-out": ("select_line", "select_number"),
    "control": ("tiled_machine", "tile_array"),
}
"""The lines of the demand of a tile's array, and their modules."""

DELAY_LINE, ADDER_COMPARATOR, ELEMENTS = 0, 1, 2
"""The arrays that the machine knows, by their number."""

TRACKER_NOTE = "The first step of the tracked path begins with the start that the first word of the stream names."


class ArrayCircuit(CircuitStyle):
    """An array for the whole map, in the machine that loads it, runs it, tracks a path and reports."""

    planner = "wavefront"
    laws = LAWS
    model: ClassVar[ArrayStyle]

    @abstractmethod
    def array(self, parameters: PropagateParameters, /) -> tuple[int, str]:
        """The number of the array, and its node.

        Raises:
            UnsuitedError: parameters that no circuit has.
        """

    def circuit(self, job: Job[Problem, PropagateParameters]) -> Circuit:
        """The machine with the array of the style."""
        job = replace(job, parameters=self.model.settled(job.parameters))
        parameters, problem = job.parameters, job.problem
        number, node = self.array(parameters)
        words = Words.of(problem, parameters, self.model.bits(job))
        _check_width(words, self.model.largest_potential(job))
        stream = load_stream(problem, parameters, words)
        event_bits = max(words.word, words.row_bits + words.column_bits)
        return Circuit(
            top="wavefront_machine",
            sources=(*(HERE / f"{name}.v" for name in MACHINE), SHARED / "ram_1w1r.v"),
            parameters={
                "STYLE": number,
                "ROWS": problem.rows,
                "COLUMNS": problem.columns,
                "ROW_BITS": words.row_bits,
                "COLUMN_BITS": words.column_bits,
                "STRAIGHT": parameters.delays[0],
                "DIAGONAL": parameters.delays[1],
                "EXTRA": words.extra,
                "CORNER_CUTTING": int(parameters.corner_cutting),
                "SAFE": int(words.safe),
                "CHAIN": int(words.chain),
                "WAITS": int(waits(problem, parameters)),
                "TRACK": int(job.does(TRACK)),
                "MOST_STEPS": parameters.steps if parameters.course is Course.LOCAL else 0,
                "BITS": words.bits,
                "OBSTACLE_BITS": words.obstacle_bits,
                "LONGEST": words.longest,
                "ELEMENT_CELLS": words.element_cells,
                "ELEMENT_BITS": max(1, (words.element_cells - 1).bit_length()),
                "FLAGS": words.flags,
                "LOAD_CELLS": words.load_cells,
                "LOAD_WORDS": len(stream.words) - 1,
                "WORD": words.word,
                "EVENT_BITS": event_bits,
            },
            stream=stream,
            phases=PHASES,
            kinds=KINDS,
            event_bits=event_bits,
            elements=words.elements[0] * words.elements[1],
            pieces={
                "nodes": (node,),
                "memories": ("ram_1w1r",),
                "read-out": ("select_line", "select_number", "select_word"),
                "tracker": ("path_tracker",),
                "control": ("wavefront_machine", "delay_line_array", "adder_array", "element_array"),
            },
            notes=(TRACKER_NOTE,),
        )

    def expected(self, job: Job[Problem, PropagateParameters]) -> Expected:
        """The words of all nodes, and the steps of the path of the first start."""
        job = replace(job, parameters=self.model.settled(job.parameters))
        words = Words.of(job.problem, job.parameters, self.model.bits(job))
        return expected_run(self.model, job, words)

    def sample(self, seed: int) -> Job[Problem, PropagateParameters]:
        """A random small map with random parameters."""
        return random_job(seed, self.style)


class DelayLineCircuit(ArrayCircuit):
    """Figure 2; with ``element_cells``, one such node for several cells."""

    style = "delay_line"
    model = DelayLine()

    def array(self, parameters: PropagateParameters, /) -> tuple[int, str]:
        """A node for every cell, or elements."""
        if parameters.element_cells == 1:
            return DELAY_LINE, "delay_line_node"
        if parameters.read_out is ReadOut.CHAIN:
            raise _unsuited(
                "read_out",
                f"no circuit has a chain with {parameters.element_cells} cells an element",
                "set read_out: addressed, as the potentials are in the memories of the elements, or element_cells: 1",
            )
        return ELEMENTS, "wave_element"


class AdderCircuit(ArrayCircuit):
    """Adders and comparators, after Hassoun and Sanghvi."""

    style = "adder_comparator"
    model = AdderComparator()

    def array(self, _parameters: PropagateParameters, /) -> tuple[int, str]:
        """A node for every cell."""
        return ADDER_COMPARATOR, "adder_node"


class TiledCircuit(CircuitStyle):
    """An array of one tile, with the memories of its columns and a scheduler."""

    planner = "wavefront"
    laws = tile.LAWS
    style = "tiled"
    model = Tiled()

    def circuit(self, job: Job[Problem, PropagateParameters]) -> Circuit:
        """The machine with the array of the tile."""
        job = replace(job, parameters=self.model.settled(job.parameters))
        parameters, problem = job.parameters, job.problem
        words = Words.of(problem, parameters, self.model.bits(job))
        _check_width(words, self.model.largest_potential(job))
        tiles = TileWords.of(problem, parameters, words)
        stream = tile_stream(problem, parameters, words, tiles)
        event_bits = max(words.word, words.row_bits + words.column_bits, tiles.tile_bits)
        return Circuit(
            top="tiled_machine",
            sources=(*(HERE / f"{name}.v" for name in TILED_MACHINE), SHARED / "ram_1w1r.v"),
            parameters={
                "ROWS": problem.rows,
                "COLUMNS": problem.columns,
                "ROW_BITS": words.row_bits,
                "COLUMN_BITS": words.column_bits,
                **tiles.parameters(),
                "STRAIGHT": parameters.delays[0],
                "DIAGONAL": parameters.delays[1],
                "EXTRA": words.extra,
                "CORNER_CUTTING": int(parameters.corner_cutting),
                "SAFE": int(words.safe),
                "WAITS": int(waits(problem, parameters)),
                "TRACK": int(job.does(TRACK)),
                "MOST_STEPS": parameters.steps if parameters.course is Course.LOCAL else 0,
                "BITS": words.bits,
                "OBSTACLE_BITS": words.obstacle_bits,
                "FLAGS": words.flags,
                "LOAD_CELLS": tiles.load_cells,
                "LOAD_BITS": stream.width,
                "WORD": words.word,
                "EVENT_BITS": event_bits,
            },
            stream=stream,
            phases=TILED_PHASES,
            kinds=KINDS,
            event_bits=event_bits,
            elements=tiles.tile[0] * tiles.tile[1],
            pieces=TILED_PIECES,
            notes=(TRACKER_NOTE,),
        )

    def expected(self, job: Job[Problem, PropagateParameters]) -> Expected:
        """The visits of tiles, the words of all cells, and the steps of the path of the first start."""
        job = replace(job, parameters=self.model.settled(job.parameters))
        words = Words.of(job.problem, job.parameters, self.model.bits(job))
        return expected_run(self.model, job, words)

    def sample(self, seed: int) -> Job[Problem, PropagateParameters]:
        """A random small map with random parameters and tiles."""
        return random_job(seed, self.style)


def _unsuited(key: str, what: str, hint: str) -> UnsuitedError:
    return UnsuitedError([Fault("circuit", 0, 0, f"propagate.{key}", what, hint)])


def _check_width(words: Words, largest: int) -> None:
    if largest + 1 >= 1 << words.bits:
        raise _unsuited(
            "register_bits",
            f"registers of {words.bits} bits do not hold the potential {largest} and infinity",
            f"give at least {(largest + 1).bit_length()}, or leave it out",
        )
