"""The circuits of the wavefront planner: Verilog of the arrays, and what the model expects of it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from more_itertools import chunked
from numpy.typing import NDArray

from codesign.ground.models import Task
from codesign.planners.circuits import (
    SHARED,
    Circuit,
    CircuitStyle,
    Events,
    EventsOfKind,
    Expected,
    Image,
    phase_cycles,
    unsuited,
)
from codesign.planners.counted import index_bits
from codesign.planners.interface import Cell, Problem
from codesign.planners.job import Job
from codesign.planners.wavefront.plan.parameters import Course, Paths, PropagateParameters, ReadOut, WaveEnd
from codesign.planners.wavefront.plan.plan import WavefrontPlan, problem_map, waits
from codesign.planners.wavefront.plan.planner import PLANNER
from codesign.planners.wavefront.plan.wave import longest_distance, register_bits
from codesign.planners.wavefront.styles import AdderComparator, DelayLine, Tiled, tile, timing
from codesign.planners.wavefront.styles.array import ArrayStyle
from codesign.planners.wavefront.styles.resources import LAWS
from codesign.planners.wavefront.styles.timing import EXCHANGE, LOAD, OBSTACLES, PROPAGATE, READ_OUT, TRACK

__all__ = ["CIRCUITS"]


OUTSIDE = 0b10
"""F = 0 and Z = 1: a cell of an element that is no cell of the map."""


@dataclass(frozen=True)
class Words:
    """The words of a circuit.

    - ``bits``: of the register. ``obstacle_bits``: of p^d beside it; 0: none. ``longest``: the last p^d.
    - ``extra``: cycles more to enter a penalised cell; 0: none is penalised.
    - ``shows_free``: whether a word of the read-out has F. ``flags``: bits of a cell in the load stream.
    """

    shape: tuple[int, int]
    bits: int
    obstacle_bits: int
    longest: int
    extra: int
    shows_free: bool
    safe: bool
    chain: bool
    element_cells: int

    @classmethod
    def of(cls, problem: Problem, parameters: PropagateParameters, bits: int) -> Words:
        """The words of a design point with registers of ``bits``."""
        longest = longest_distance(problem.shape, parameters.delays)
        safe, chain = parameters.paths is Paths.SAFE, parameters.read_out is ReadOut.CHAIN
        return cls(
            shape=problem.shape,
            bits=bits,
            obstacle_bits=register_bits(longest) if safe and not chain else 0,
            longest=longest,
            extra=0 if parameters.penalty is None else parameters.penalty.delay,
            shows_free=not parameters.corner_cutting,
            safe=safe,
            chain=chain,
            element_cells=parameters.element_cells,
        )

    @property
    def flags(self) -> int:
        """Bits of a cell in the load stream: F, Z, and P where cells may be penalised."""
        return 3 if self.extra else 2

    @property
    def row_bits(self) -> int:
        """Bits of a row."""
        return index_bits(self.shape[0])

    @property
    def column_bits(self) -> int:
        """Bits of a column."""
        return index_bits(self.shape[1])

    @property
    def word(self) -> int:
        """Bits of a word of the read-out: potential, p^d, F, P."""
        return self.bits + self.obstacle_bits + self.shows_free + bool(self.extra)

    @property
    def elements(self) -> tuple[int, int]:
        """Rows and columns of the processing elements."""
        return -(-self.shape[0] // self.element_cells), self.shape[1]

    @property
    def load_cells(self) -> int:
        """Cells of a word of the load stream; on a small map as many as there are, but enough bits for the start."""
        start = -(-(self.row_bits + self.column_bits) // self.flags)
        return min(timing.LOAD_CELLS, max(start, self.elements[0] * self.elements[1]))

    def packed(
        self, potentials: NDArray[np.int64], distances: NDArray[np.int64] | None, problem_flags: NDArray[np.uint8]
    ) -> NDArray[np.uint64]:
        """The words of all cells as they are read out, in raster order."""
        words = potentials.astype(np.uint64).ravel()
        at = np.uint64(self.bits)
        if distances is not None and self.obstacle_bits:
            words |= distances.astype(np.uint64).ravel() << at
            at += np.uint64(self.obstacle_bits)
        flags = problem_flags.astype(np.uint64).ravel()
        if self.shows_free:
            words |= (flags & np.uint64(1)) << at
            at += np.uint64(1)
        if self.extra:
            words |= (flags >> np.uint64(2)) << at
        return words


def cell_flags(problem: Problem, parameters: PropagateParameters) -> NDArray[np.uint8]:
    """F, Z and P of every cell: bits 0, 1 and 2."""
    flags = problem.free.astype(np.uint8)
    flags[tuple(np.array(problem.goals).T)] |= 2
    extra = problem_map(problem, parameters).extra
    if extra is not None:
        flags |= (extra > 0).astype(np.uint8) << np.uint8(2)
    return flags


def load_stream(problem: Problem, parameters: PropagateParameters, words: Words) -> Image:
    """The start, then the map: the words of each row of cells of the elements, the last word first."""
    row, column = problem.starts[0] if problem.starts else (0, 0)
    flags = np.full((words.elements[0] * words.element_cells, words.shape[1]), OUTSIDE, np.uint8)
    flags[: words.shape[0]] = cell_flags(problem, parameters)
    stream = [row | column << words.row_bits]
    for cell in range(words.element_cells):
        stream += reversed(packed_words(flags[cell :: words.element_cells].ravel(), words.load_cells, words.flags))
    return Image(words.load_cells * words.flags, stream)


def packed_words(flags: NDArray[np.uint8], cells: int, bits: int) -> list[int]:
    """The words of cells in their order: so many a word, ``bits`` a cell, the bits of the first cell lowest."""
    return [
        sum(int(flag) << bits * place for place, flag in enumerate(word)) for word in chunked(flags.tolist(), cells)
    ]


# What the model says of a run: values from the plan, cycles from the laws of the style.

PHASES = (LOAD, OBSTACLES, PROPAGATE, READ_OUT, TRACK)
TILED_PHASES = (LOAD, OBSTACLES, PROPAGATE, EXCHANGE, TRACK)
KINDS = ("potential", "obstacle_potential", "step", "visit")
POTENTIAL, OBSTACLE_POTENTIAL, STEP, VISIT = range(4)


def expected_run(style: ArrayStyle, job: Job[Problem, PropagateParameters], words: Words) -> Expected:
    """The events of a run of ``style`` with the settled parameters of ``job``."""
    cycles, plan = phase_cycles(style.work(job))
    parts = [_visit_events(style, job, cycles[LOAD])] if isinstance(style, Tiled) else []
    parts += _parts(style, job, words, cycles, plan)
    return Expected(Events.joined(parts), cycles)


def _parts(
    style: ArrayStyle, job: Job[Problem, PropagateParameters], words: Words, cycles: dict[str, int], plan: WavefrontPlan
) -> Iterator[EventsOfKind]:
    """The events in the order of their cycles: a chain reports before the path is tracked, an array after it."""
    flags = cell_flags(job.problem, job.parameters)
    potentials = np.where(plan.potentials >= 0, plan.potentials, infinity(style, plan, words)).astype(np.int64)
    distances = None
    if plan.obstacle_potentials is not None:
        distances = plan.obstacle_potentials.astype(np.int64)
        if isinstance(style, AdderComparator | Tiled) and job.problem.free.all():
            # No source at all: these leave their own infinity where a delay line leaves the last count.
            distances[...] = (1 << (words.obstacle_bits or words.bits)) - 1
    cells = np.arange(job.problem.free.size, dtype=np.int64)
    begin = cycles[LOAD] + cycles.get(OBSTACLES, 0)
    if words.chain and distances is not None:
        yield OBSTACLE_POTENTIAL, begin + cells, words.packed(distances, None, flags)
        begin += timing.read_out_cycles(len(cells))
    begin += cycles.get(PROPAGATE, 0) + cycles.get(EXCHANGE, 0)
    shown = words.packed(potentials, distances, flags)
    if words.chain:
        yield POTENTIAL, begin + cells, shown
        begin += timing.read_out_cycles(len(cells))
    if job.does(TRACK):
        yield _steps(job, words, plan, begin)
        begin += cycles[TRACK]
    if not words.chain:
        yield POTENTIAL, begin + timing.READ_LATENCY + cells, shown


def _visit_events(style: Tiled, job: Job[Problem, PropagateParameters], begin: int) -> EventsOfKind:
    """The tiles in the order of their visits, each in the last cycle of the scan that chooses it."""
    tile, tiles = style.array_shape(job), job.parameters.tile_count(*job.problem.shape)
    exchange = timing.exchange_cycles(tile, tiles)
    chosen, cycles = [], []
    for _, visits in style.passes(job):
        begin += timing.scan_cycles(tile[1], tiles)
        ends = begin + np.cumsum(exchange + timing.visit_cycles(visits.span))
        cycles.append(np.concatenate([[begin], ends[:-1]])[: len(ends)] - 1)
        chosen.append(visits.tile.astype(np.uint64))
        begin = int(ends[-1]) if len(ends) else begin
    return VISIT, np.concatenate(cycles).astype(np.int64), np.concatenate(chosen)


def infinity(style: ArrayStyle, plan: WavefrontPlan, words: Words) -> int:
    """The register of a cell that no wave reached: the last count, or all bits of a register or a memory's word."""
    if isinstance(style, AdderComparator | Tiled):
        return (1 << words.bits) - 1
    return plan.largest_potential + 1


def _steps(job: Job[Problem, PropagateParameters], words: Words, plan: WavefrontPlan, begin: int) -> EventsOfKind:
    """The cells of the path behind the start; each is chosen in the last cycle of its step."""
    start = job.problem.starts[0] if job.problem.starts else (0, 0)
    path = np.zeros((0, 2), np.int64)
    if plan.potentials[start] >= 0:
        most = job.parameters.steps if job.parameters.course is Course.LOCAL else None
        path = plan.tracker.follow(start, most)[1:]
    after = np.array([timing.track_cycles(step + 1) for step in range(len(path))], np.int64)
    values = (path[:, 0] << words.column_bits | path[:, 1]).astype(np.uint64)
    return STEP, begin + after - 1, values


# Random design points on random maps.

LARGEST_SIDE = {"delay_line": 12, "adder_comparator": 7, "tiled": 14}
DENSITIES = (0.0, 0.1, 0.25, 0.4)


def random_job(seed: int, style: str) -> Job[Problem, PropagateParameters]:
    """A design point of a style, every option at random, on a map that the planner accepts."""
    rng = np.random.default_rng(seed)
    problem = _problem(rng, LARGEST_SIDE[style])
    parameters = PropagateParameters(**_options(rng, style))
    inside = frozenset({"propagate"}) if rng.random() < 0.2 else None
    job = Job(problem, parameters, inside=inside)
    if PLANNER.check(job) is not None:
        # The start cannot be reached: the wave runs to its own end.
        job = Job(problem, parameters.model_copy(update={"stop": WaveEnd.WHOLE_MAP}), inside=inside)
    return job


def _problem(rng: np.random.Generator, largest_side: int) -> Problem:
    shape = tuple(int(side) for side in rng.integers(1, largest_side + 1, 2))
    free = rng.random(shape) >= rng.choice(DENSITIES)
    free.flat[int(rng.integers(free.size))] = True
    cells = [(int(row), int(column)) for row, column in np.argwhere(free)]

    def chosen(count: int) -> tuple[Cell, ...]:
        return tuple(cells[index] for index in rng.integers(len(cells), size=count))

    goals = tuple(dict.fromkeys(chosen(int(rng.integers(1, 3)))))
    starts = chosen(1)
    task = Task.FIELD if rng.random() < 0.2 else Task.PATH
    return Problem(free, goals, starts, task=task)


def _options(rng: np.random.Generator, style: str) -> dict[str, Any]:
    straight = int(rng.integers(1, 5))
    delays = (2, 3) if rng.random() < 0.5 else (straight, straight + int(rng.integers(0, 4)))
    options: dict[str, Any] = {
        "stop": str(rng.choice(["starts", "whole_map"])),
        "paths": str(rng.choice(["shortest", "safe"])),
        "course": str(rng.choice(["local", "complete"])),
        "steps": int(rng.integers(1, 6)),
        "corner_cutting": bool(rng.integers(2)),
        "delays": delays,
        "read_out": str(rng.choice(["addressed", "chain"])),
    }
    if rng.random() < 0.4:
        options["penalty"] = {"distance": int(rng.integers(1, 6)), "delay": int(rng.integers(1, 5))}
    if style == "delay_line" and rng.random() < 0.4:
        options["element_cells"] = int(rng.choice([2, 4, 8, 16]))
        options["read_out"] = "addressed"
    if style == "tiled" and rng.random() < 0.9:
        options["tile"] = tuple(int(side) for side in rng.integers(1, 7, 2))
    return options


# What the circuit of a tiled array is built for: the sizes of its counters and memories, and the load stream.


@dataclass(frozen=True)
class TileWords:
    """The words of the circuit. ``tile``: rows and columns of a tile; ``tiles``: down and across.

    ``start_bits``: of the word that names the start.
    """

    tile: tuple[int, int]
    tiles: tuple[int, int]
    start_bits: int

    @classmethod
    def of(cls, problem: Problem, parameters: PropagateParameters, words: Words) -> TileWords:
        """The words of a design point."""
        tile = parameters.tile_shape(*problem.shape)
        tiles = -(-problem.rows // tile[0]), -(-problem.columns // tile[1])
        bits = words.row_bits + words.column_bits
        return cls(tile, tiles, bits + index_bits(tiles[0] * tiles[1] * tile[0]) + index_bits(tile[1]))

    @property
    def tile_bits(self) -> int:
        """Bits of the number of a tile."""
        return index_bits(self.tiles[0] * self.tiles[1])

    @property
    def words(self) -> int:
        """Words of the memory of a column."""
        return self.tiles[0] * self.tiles[1] * self.tile[0]

    @property
    def load_cells(self) -> int:
        """Cells of a word of the load stream."""
        return min(timing.LOAD_CELLS, self.tile[1])

    def parameters(self) -> dict[str, int]:
        """The Verilog parameters."""
        return {
            "TILE_ROWS": self.tile[0],
            "TILE_COLUMNS": self.tile[1],
            "DOWN": self.tiles[0],
            "ACROSS": self.tiles[1],
            "DOWN_BITS": self.tiles[0].bit_length(),
            "ACROSS_BITS": self.tiles[1].bit_length(),
            "TILE_BITS": self.tile_bits,
            "ADDRESS_BITS": index_bits(self.words),
            "PLACE_BITS": index_bits(self.tile[1]),
            "STEP_BITS": (self.tile[0] + 1).bit_length(),
            "LEVELS": (self.tile[1] - 1).bit_length(),
        }

    def start_word(self, start: tuple[int, int], words: Words) -> int:
        """The start: its row, its column, its address in the memory of its column, and that column of the tile."""
        row, column = start
        number, place = divmod(column, self.tile[1])
        at = words.row_bits + words.column_bits
        address = row * self.tiles[1] + number
        return row | column << words.row_bits | address << at | place << at + index_bits(self.words)


def tile_stream(problem: Problem, parameters: PropagateParameters, words: Words, tile_words: TileWords) -> Image:
    """The start, then the tiles in raster order, each row by row, the leftmost cells of a row first."""
    (rows, columns), (down, across) = tile_words.tile, tile_words.tiles
    flags = np.full((down * rows, across * columns), OUTSIDE, np.uint8)
    flags[: problem.rows, : problem.columns] = cell_flags(problem, parameters)
    stream = [tile_words.start_word(problem.starts[0] if problem.starts else (0, 0), words)]
    chunk = tile_words.load_cells
    in_tiles = flags.reshape(down, rows, across, columns).transpose(0, 2, 1, 3).reshape(-1, columns)
    for row in in_tiles:
        padded = np.concatenate([row, np.full(-columns % chunk, OUTSIDE, np.uint8)])
        stream += packed_words(padded, chunk, words.flags)
    return Image(max(chunk * words.flags, tile_words.start_bits), stream)


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


class _WaveCircuit(CircuitStyle):
    """A circuit with the words and the run of its style, ``model``."""

    planner = "wavefront"
    model: ClassVar[ArrayStyle]

    def _settled(self, job: Job[Problem, PropagateParameters]) -> tuple[Job[Problem, PropagateParameters], Words]:
        job = replace(job, parameters=self.model.settled(job.parameters))
        return job, Words.of(job.problem, job.parameters, self.model.bits(job))

    def _machine(
        self, job: Job[Problem, PropagateParameters], words: Words, event_bits: int, own: dict[str, int], **parts: Any
    ) -> Circuit:
        """The machine of a design; ``own``: parameters that one kind of machine has. ``parts``: of ``Circuit``.

        Raises:
            UnsuitedError: registers that do not hold the largest potential.
        """
        parameters, problem, largest = job.parameters, job.problem, self.model.largest_potential(job)
        if largest + 1 >= 1 << words.bits:
            raise unsuited(
                "propagate.register_bits",
                f"registers of {words.bits} bits do not hold the potential {largest} and infinity",
                f"give at least {(largest + 1).bit_length()}, or leave it out",
            )
        return Circuit(
            parameters={
                "ROWS": problem.rows,
                "COLUMNS": problem.columns,
                "ROW_BITS": words.row_bits,
                "COLUMN_BITS": words.column_bits,
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
                "WORD": words.word,
                "EVENT_BITS": event_bits,
                **own,
            },
            kinds=KINDS,
            event_bits=event_bits,
            notes=(TRACKER_NOTE,),
            **parts,
        )

    def expected(self, job: Job[Problem, PropagateParameters]) -> Expected:
        """The visits of tiles, the words of all nodes, and the steps of the path of the first start."""
        return expected_run(self.model, *self._settled(job))

    def sample(self, seed: int) -> Job[Problem, PropagateParameters]:
        """A random small map with random parameters, and tiles where the style has them."""
        return random_job(seed, self.style)


class ArrayCircuit(_WaveCircuit):
    """An array for the whole map, in the machine that loads it, runs it, tracks a path and reports."""

    laws = LAWS

    @abstractmethod
    def array(self, parameters: PropagateParameters, /) -> tuple[int, str]:
        """The number of the array, and its node.

        Raises:
            UnsuitedError: parameters that no circuit has.
        """

    def circuit(self, job: Job[Problem, PropagateParameters]) -> Circuit:
        """The machine with the array of the style."""
        job, words = self._settled(job)
        number, node = self.array(job.parameters)
        stream = load_stream(job.problem, job.parameters, words)
        return self._machine(
            job,
            words,
            max(words.word, words.row_bits + words.column_bits),
            {
                "STYLE": number,
                "CHAIN": int(words.chain),
                "LONGEST": words.longest,
                "ELEMENT_CELLS": words.element_cells,
                "ELEMENT_BITS": index_bits(words.element_cells),
                "LOAD_CELLS": words.load_cells,
                "LOAD_WORDS": len(stream.words) - 1,
            },
            top="wavefront_machine",
            sources=(*(HERE / f"{name}.v" for name in MACHINE), SHARED / "ram_1w1r.v"),
            stream=stream,
            phases=PHASES,
            elements=words.elements[0] * words.elements[1],
            pieces={
                "nodes": (node,),
                "memories": ("ram_1w1r",),
                "read-out": ("select_line", "select_number", "select_word"),
                "tracker": ("path_tracker",),
                "control": ("wavefront_machine", "delay_line_array", "adder_array", "element_array"),
            },
        )


class DelayLineCircuit(ArrayCircuit):
    """Figure 2; with ``element_cells``, one such node for several cells."""

    style = "delay_line"
    model = DelayLine()

    def array(self, parameters: PropagateParameters, /) -> tuple[int, str]:
        """A node for every cell, or elements."""
        if parameters.element_cells == 1:
            return DELAY_LINE, "delay_line_node"
        if parameters.read_out is ReadOut.CHAIN:
            what = "propagate.read_out"
            hint = "set read_out: addressed, as the potentials are in the memories of the elements, or element_cells: 1"
            raise unsuited(what, f"no circuit has a chain with {parameters.element_cells} cells an element", hint)
        return ELEMENTS, "wave_element"


class AdderCircuit(ArrayCircuit):
    """Adders and comparators, after Hassoun and Sanghvi."""

    style = "adder_comparator"
    model = AdderComparator()

    def array(self, _parameters: PropagateParameters, /) -> tuple[int, str]:
        """A node for every cell."""
        return ADDER_COMPARATOR, "adder_node"


class TiledCircuit(_WaveCircuit):
    """An array of one tile, with the memories of its columns and a scheduler."""

    laws = tile.LAWS
    style = "tiled"
    model = Tiled()

    def circuit(self, job: Job[Problem, PropagateParameters]) -> Circuit:
        """The machine with the array of the tile."""
        job, words = self._settled(job)
        tiles = TileWords.of(job.problem, job.parameters, words)
        stream = tile_stream(job.problem, job.parameters, words, tiles)
        return self._machine(
            job,
            words,
            max(words.word, words.row_bits + words.column_bits, tiles.tile_bits),
            {**tiles.parameters(), "LOAD_CELLS": tiles.load_cells, "LOAD_BITS": stream.width},
            top="tiled_machine",
            sources=(*(HERE / f"{name}.v" for name in TILED_MACHINE), SHARED / "ram_1w1r.v"),
            stream=stream,
            phases=TILED_PHASES,
            elements=tiles.tile[0] * tiles.tile[1],
            pieces=TILED_PIECES,
        )


CIRCUITS: tuple[CircuitStyle, ...] = (DelayLineCircuit(), AdderCircuit(), TiledCircuit())
