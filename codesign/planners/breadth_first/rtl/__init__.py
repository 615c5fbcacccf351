"""The circuit of style ``state_machine`` (Vacariu et al. 2008) in Verilog-2005, and what a run of it has to report.

Values of events follow from the plan, cycles from ``styles.timing``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from codesign.ground.models import Task
from codesign.planners.breadth_first.plan.parameters import (
    Address,
    MemoryPlace,
    MicroArchitecture,
    SearchParameters,
    VgaController,
)
from codesign.planners.breadth_first.plan.planner import searched
from codesign.planners.breadth_first.plan.search import BreadthFirstPlan
from codesign.planners.breadth_first.styles import resources, timing
from codesign.planners.breadth_first.styles.state_machine import StateMachine
from codesign.planners.breadth_first.styles.timing import INIT, PATH, SEARCH, TRACK, discoverers, expansions
from codesign.planners.circuits import (
    SHARED,
    Circuit,
    CircuitStyle,
    Events,
    Expected,
    Image,
    Pins,
    phase_cycles,
    unsuited,
)
from codesign.planners.counted import index_bits
from codesign.planners.interface import Problem
from codesign.planners.job import Job

# Random design points of the state machine.

MOST_SIDE = 20
MOST_GOALS = 3


def random_job(seed: int) -> Job[Problem, SearchParameters]:
    """A map of 1 × 2 to 20 × 20 cells with up to half of them obstacles, 1 to 3 goals, and every option at random.

    In one job of eight the task is ``field``; in one of three the queue is as short as the search allows, and in one
    of nine even shorter, so that it overflows.
    """
    random = np.random.default_rng([seed, 2008])
    shape = int(random.integers(1, MOST_SIDE + 1)), int(random.integers(2, MOST_SIDE + 1))
    free = random.random(shape) >= random.uniform(0.0, 0.5)
    count = min(1 + int(random.integers(1, MOST_GOALS + 1)), free.size)
    cells = random.choice(free.size, count, replace=False)
    free.ravel()[cells] = True
    start, *goals = ((int(cell) // shape[1], int(cell) % shape[1]) for cell in cells)
    field = random.random() < 1 / 8
    problem = Problem(free, tuple(goals[:1] if field else goals), (start,), task=Task.FIELD if field else Task.PATH)
    micro_architecture = MicroArchitecture(random.choice(list(MicroArchitecture)))
    displays = set(VgaController)
    if micro_architecture is MicroArchitecture.PIPELINED:
        displays.remove(VgaController.SHARED)
    parameters = SearchParameters(
        micro_architecture=micro_architecture,
        address=Address(random.choice(list(Address))),
        display=VgaController(random.choice(sorted(displays))),
    )
    job = Job(problem, parameters)
    if random.random() < 1 / 3:
        depth = searched(job).queue_depth - int(random.random() < 1 / 3)
        job = Job(problem, parameters.model_copy(update={"queue_words": max(1, depth)}))
    return job


# The outputs of the display: the syncs in every cycle, and the picture once the search has ended.

PINS = {"horizontal_sync": 1, "vertical_sync": 1, "colour": 3}
"""The outputs of the display, and their bits, the lowest first."""

_SYNCS, _ALL, _DIRECTION = 0b00011, 0b11111, 0b01100
_HORIZONTAL, _VERTICAL, _COLOUR = 0, 1, 2
_COLOURS = np.array([0b000, 0b111, 0b100, 0b010], np.uint16)
"""Of an obstacle or the start, a free cell, a goal or path, a visited cell: the words of the memory of the cells."""


@dataclass(frozen=True)
class Screen:
    """Pixels of a line with its borders, lines of a frame, where the syncs lie, and clocks of a pixel.

    ``half``: the first pixel of the right half. The numbers stand in ``breadth_first_display.v`` too.
    """

    half: int = 400
    line: int = 1344
    sync: tuple[int, int] = (936, 1072)
    frame: int = 806
    line_sync: tuple[int, int] = (687, 693)
    pixel_cycles: int = 2


SCREEN = Screen()

_LATER = 2
"""Cycles from the first one to that in which the first pixel after the reset is put out."""
_SETTLED = 3
"""Cycles from the last one of a run to a pixel that shows what it left in the memories."""


def shown_pins(problem: Problem, plan: BreadthFirstPlan, visited: int, tracked: bool, end: int, screen: Screen) -> Pins:
    """The outputs over a run of ``end`` cycles, and over one frame and the lines of the map after it.

    ``visited``: how many cells the search marked; it may have ended early. ``tracked``: whether a path was marked.
    While the search runs, the colour is said outside of the map only.
    """
    shown = (screen.frame + problem.rows) * screen.line
    pixels = shown + -(-(end + _SETTLED) // screen.pixel_cycles)
    begin = _LATER + screen.pixel_cycles * np.arange(pixels, dtype=np.int64)
    value, known = (
        np.resize(each, pixels) for each in _frame(problem, screen, *_memories(problem, plan, visited, tracked))
    )
    on_map = np.zeros((screen.frame, screen.line), np.bool_)
    on_map[: problem.rows] = _columns(problem, screen) >= 0
    known[(begin < end + _SETTLED) & np.resize(on_map, pixels)] = _SYNCS
    both = value | known << np.uint16(8)
    first = np.append(0, np.flatnonzero(both[1:] != both[:-1]) + 1)
    return Pins(
        begin[first],
        value[first].astype(np.uint64),
        known[first].astype(np.uint64),
        int(begin[-1]) + screen.pixel_cycles,
    )


def _columns(problem: Problem, screen: Screen) -> NDArray[np.int64]:
    """The column of the map under each pixel of a line of it; -1 where none is."""
    x = np.arange(screen.line, dtype=np.int64)
    column = np.where(x < screen.half, x, x - screen.half)
    return np.where(column < problem.columns, column, -1)


def _frame(
    problem: Problem, screen: Screen, code: NDArray[np.int64], direction: NDArray[np.int64]
) -> tuple[NDArray[np.uint16], NDArray[np.uint16]]:
    """Uint16, lines × pixels: the outputs at each pixel of a frame after the run, and which bits are known."""
    x, y = np.arange(screen.line), np.arange(screen.frame)[:, None]
    value = np.zeros((screen.frame, screen.line), np.uint16)
    value |= ((x >= screen.sync[0]) & (x < screen.sync[1])).astype(np.uint16) << _HORIZONTAL
    value |= ((y >= screen.line_sync[0]) & (y < screen.line_sync[1])).astype(np.uint16) << _VERTICAL
    known = np.full_like(value, _ALL)
    left = _COLOURS[code]
    right = np.where(code >= 2, 0b100 | np.maximum(direction, 0), 0).astype(np.uint16)
    # No direction was written where nothing was discovered: a goal that was not reached, the start of the path.
    unwritten = (code >= 2) & (direction < 0)
    column, rows = _columns(problem, screen), slice(0, problem.rows)
    colour = np.where(x < screen.half, left[:, column], right[:, column])
    value[rows] |= np.where(column >= 0, colour, 0).astype(np.uint16) << _COLOUR
    known[rows][(column >= 0) & (x >= screen.half) & unwritten[:, column]] &= ~np.uint16(_DIRECTION)
    return value, known


def _memories(
    problem: Problem, plan: BreadthFirstPlan, visited: int, tracked: bool
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Int64, rows × columns: the cells and the directions that a run leaves; direction -1 where none was written."""
    code = problem.free.astype(np.int64)
    direction = np.full(problem.shape, -1, np.int64)
    if problem.task is Task.FIELD:
        code[problem.goals[0]] = 0
    else:
        for goal in problem.goals:
            code[goal] = 2
        code[problem.starts[0]] = 0
    cells = plan.pushed[1 : 1 + visited].astype(np.int64)
    code.flat[cells] = 3
    direction.flat[cells] = plan.directions.ravel()[cells]
    if tracked:
        code[tuple(plan.path.T)] = 2
    return code, direction


OBSTACLE, FREE, GOAL, START = range(4)
"""A word of the load stream: a cell of the map, row by row."""

POP, PUSH, PATH_CELL, EMPTY, OVERFLOW = range(5)
KINDS = ("pop", "push", "path", "empty", "overflow")
"""Events; the head of ``breadth_first_machine.v`` says what their values are."""

PIXELS = "A pixel of the display lasts two clocks: 65 MHz where the design runs at 130 MHz."

HERE = Path(__file__).parent
MODULES = tuple(f"breadth_first_{name}" for name in ("machine", "memory", "move", "queue", "schedule"))
TOP, SCREEN_TOP, DISPLAY = "breadth_first_top", "breadth_first_screen_top", "breadth_first_display"

SHOWN = {VgaController.NONE: 0, VgaController.SHARED: 1, VgaController.COPY: 2}

SearchJob = Job[Problem, SearchParameters]


def refuse(job: SearchJob) -> None:
    """Raise UnsuitedError where no circuit of the state machine does the job."""
    problem, parameters = job.problem, job.parameters
    if parameters.memory is not MemoryPlace.BLOCK_RAM or job.external is not None:
        key = "search.external_memory" if job.external is not None else "search.memory"
        raise unsuited(
            key,
            "the Verilog has all memories in block RAM; its port to a memory outside is not built",
            "leave external_memory out and set search.memory=block_ram, on a map that fits: this proves the cycles of"
            " the engine without the accesses, which stay assumed",
        )
    pipelined = parameters.micro_architecture is MicroArchitecture.PIPELINED
    if parameters.display is VgaController.SHARED and pipelined:
        raise unsuited("search.display", "a pipelined search leaves no port to a display", "take copy or none")
    if parameters.display is not VgaController.NONE and not resources.on_screen(problem.shape):
        raise unsuited("search.display", "the map is larger than the screen", "take none")
    if not job.does(TRACK):
        raise unsuited(
            "track",
            "the Verilog tracks the path itself; a circuit that sends its directions to another component is not built",
            "place track where search is placed",
        )
    if problem.task is not Task.FIELD and problem.starts[0] in problem.goals:
        raise unsuited("problem.starts", "two bits a cell cannot say both start and goal", "name another start")


def addresses(cells: NDArray[np.integer], shape: tuple[int, int], parameters: SearchParameters) -> NDArray[np.uint64]:
    """Uint64: the addresses of ``cells``, row × columns + column, in the memories of the circuit."""
    rows, columns = np.divmod(cells.astype(np.uint64), np.uint64(shape[1]))
    stride = shape[1] + 1
    if parameters.address is Address.SIDE_BY_SIDE:
        stride = 1 << index_bits(shape[1])
    return rows * np.uint64(stride) + columns


def stream(problem: Problem) -> NDArray[np.uint64]:
    """Uint64: the map as the circuit takes it. A search for a field starts at its goal and ends at none."""
    words = problem.free.astype(np.uint64)
    if problem.task is Task.FIELD:
        words[problem.goals[0]] = START
    else:
        for goal in problem.goals:
            words[goal] = GOAL
        words[problem.starts[0]] = START
    return words.ravel()


class StateMachineCircuit(CircuitStyle):
    """States Standby, Init, BF and Path, with their memories in block RAM."""

    planner = "breadth_first"
    style = "state_machine"
    laws = resources.LAWS
    screen: Screen = SCREEN

    def circuit(self, job: SearchJob) -> Circuit:
        """The circuit for a map of this size.

        Raises:
            UnsuitedError: as ``refuse`` says.
        """
        refuse(job)
        problem, parameters = job.problem, job.parameters
        bits = resources.address_bits(*problem.shape, parameters.address)
        words = parameters.queue_words or 1 << bits
        shown = SHOWN[parameters.display]
        modules = (SCREEN_TOP, DISPLAY, *MODULES) if shown else (TOP, *MODULES)
        memories = ("ram_1w1r", "ram_2rw")
        return Circuit(
            top=modules[0],
            sources=(
                *(HERE / f"{name}.v" for name in modules),
                *(SHARED / f"{name}.v" for name in (memories if shown == 1 else memories[:1])),
            ),
            parameters={
                "ROWS": problem.rows,
                "COLUMNS": problem.columns,
                "ROW_BITS": index_bits(problem.rows),
                "COLUMN_BITS": index_bits(problem.columns),
                "ADDRESS_BITS": bits,
                "LINEAR": int(parameters.address is Address.LINEAR),
                "CYCLES": timing.EXPANSION_CYCLES[parameters.micro_architecture],
                "QUEUE_WORDS": words,
                "POINTER_BITS": index_bits(words),
                "CHECKED": int(words < problem.free.size),
                **({"SHOWN": shown} if shown else {}),
            },
            stream=Image(2, stream(problem)),
            phases=(INIT, SEARCH, PATH),
            kinds=KINDS,
            event_bits=bits + 2,
            pieces={
                "state machine": tuple(each for each in modules if each != DISPLAY),
                **({"display": (DISPLAY,)} if shown else {}),
            },
            pins=PINS if shown else {},
            notes=(PIXELS,) if shown else (),
        )

    def expected(self, job: SearchJob) -> Expected:
        """Every pop, push and cell of the path; and what a display puts out."""
        refuse(job)
        parameters = job.parameters
        cycles, plan = phase_cycles(StateMachine().work(job))
        begin = cycles[INIT]
        bits = resources.address_bits(*job.problem.shape, parameters.address)
        events = Events.joined(
            (kind, cycle, side.astype(np.uint64) << np.uint64(bits) | addresses(cell, job.problem.shape, parameters))
            for kind, cycle, side, cell in (*_search(plan, parameters, begin), *_path(plan, begin + cycles[SEARCH]))
        )
        end = _overflow(plan, events, parameters)
        if end is not None:
            events.kind[end] = OVERFLOW
            events = Events(events.cycle[: end + 1], events.kind[: end + 1], events.value[: end + 1])
            cycles = {INIT: begin, SEARCH: int(events.cycle[-1]) + 1 - begin}
        if parameters.display is VgaController.NONE:
            return Expected(events, cycles)
        visited = int(np.isin(events.kind, (PUSH, OVERFLOW)).sum())
        tracked = bool((events.kind == PATH_CELL).any())
        pins = shown_pins(job.problem, plan, visited, tracked, sum(cycles.values()), self.screen)
        return Expected(events, cycles, pins=pins)

    def sample(self, seed: int) -> SearchJob:
        """A random design point: see ``random_job``."""
        return random_job(seed)


Part = tuple[int, NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]
"""Events of one kind: the kind; cycle, side and cell (row × columns + column), int64."""


def _search(plan: BreadthFirstPlan, parameters: SearchParameters, begin: int) -> Iterator[Part]:
    """State BF: a pop begins an expansion; its pushes follow side by side; the goal or the empty queue ends it."""
    micro_architecture = parameters.micro_architecture
    each = timing.EXPANSION_CYCLES[micro_architecture]
    pushed = plan.pushed.astype(np.int64)
    pops = np.arange(plan.popped_cells, dtype=np.int64)
    yield POP, begin + each * pops, np.zeros_like(pops), pushed[: plan.popped_cells]
    by = discoverers(plan)
    side = plan.directions.ravel()[pushed[1:]].astype(np.int64) ^ 1
    later = np.array(timing.PUSH_CYCLES[micro_architecture], np.int64)[side]
    yield PUSH, begin + each * by + later, side, pushed[by]
    if expansions(plan) == plan.popped_cells:
        end = np.array([begin + each * plan.popped_cells], np.int64)
        yield EMPTY, end, np.zeros_like(end), pushed[plan.popped_cells - 1 : plan.popped_cells]


def _path(plan: BreadthFirstPlan, begin: int) -> Iterator[Part]:
    """State Path: each cell from the goal back to the start, with the side that led there."""
    if plan.everywhere or not plan.reached:
        return
    rows, columns = plan.path[::-1].T.astype(np.int64)
    cycle = begin + timing.PATH_CYCLES * (np.arange(len(rows), dtype=np.int64) + 1) - 1
    side = plan.directions[rows, columns].astype(np.int64)
    yield PATH_CELL, cycle, np.concatenate(([0], side[:-1])), rows * plan.directions.shape[1] + columns


def _overflow(plan: BreadthFirstPlan, events: Events, parameters: SearchParameters) -> int | None:
    """The index of the first push that finds the queue full; None where each finds room."""
    if parameters.queue_words is None or plan.queue_depth <= parameters.queue_words:
        return None
    waiting = 1 + np.cumsum((events.kind == PUSH).astype(np.int64) - (events.kind == POP))
    return int(np.argmax((events.kind == PUSH) & (waiting > parameters.queue_words)))


CIRCUITS = (StateMachineCircuit(),)
