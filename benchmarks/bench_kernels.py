"""How fast the relaxation is simulated: against the simulated FPGA, other kernels, precision and size of the map."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from benchmarks.other_kernels import compiled_visits, digits_of_32_bits, node_by_node, plane_by_plane, visits
from codesign.maps.generate import rooms
from codesign.planners.harmonic.plan import Field, Stage, StageEnd, relax
from codesign.planners.harmonic.plan.arguments import check_arguments
from codesign.planners.harmonic.plan.engine import Engine
from codesign.planners.harmonic.plan.kernels import iterate
from codesign.planners.harmonic.plan.layout import addresses, make_layout, make_state

CLOCK = 150e6
GOAL = (20, 20)


def row(case: str, seconds: float, iterations: int, nodes: int, simulated: float | None = None, note: str = "") -> Any:
    """One line of the table. ``nodes``: of a block."""
    return {
        "case": case,
        "ms of a core": f"{seconds * 1e3:.2f}",
        "real-time factor": "" if simulated is None else f"{simulated / seconds:.2f}",
        "ns an iteration": f"{seconds / iterations * 1e9:.0f}",
        "1e9 nodes/s": f"{iterations * nodes / seconds / 1e9:.2f}",
        "note": note,
    }


def best_of(count: int, run: Callable[[], Any]) -> tuple[float, Any]:
    """The shortest time of several runs, and what the last gave.

    Time of the one thread that runs: wall time on a core of its own, whatever else the machine does meanwhile.
    """
    shortest, result = float("inf"), None
    for _ in range(count):
        begin = time.thread_time()
        result = run()
        shortest = min(shortest, time.thread_time() - begin)
    return shortest, result


def real_time(name: str, free: NDArray[np.bool_], block: tuple[int, int], iterations: int, schedule: range) -> Any:
    """The whole run: simulated time is that of the iterations, p + 2 cycles each."""
    seconds, result = best_of(7, lambda: relax(free, [GOAL], block=block, iterations=iterations, schedule=schedule))
    blocks = -(-free.shape[0] // block[0]) * -(-free.shape[1] // block[1])
    bits = "..".join(str(p) for p in dict.fromkeys((schedule[0], schedule[-1])))
    case = f"{name}: {blocks} blocks of {block[0]}×{block[1]}, p = {bits}, I = {iterations}"
    nodes = block[0] * block[1]
    return row(case, seconds, result.total_iterations, nodes, result.total_cycles / CLOCK)


def compared(block: tuple[int, int], most: int) -> list[Any]:
    """The stage from 247 to 255 bits, by bit planes, by limbs and by numpy: all exact, without reading the start.

    They run in turns, seven times, so that what else the machine does meets all of them.
    """
    free = rooms(72, 132, room=(35, 43), door=4, seed=1).free
    settings: dict[str, Any] = {"block": block, "iterations": most}
    before = relax(free, [GOAL], schedule=range(7, 248, 8), **settings).field
    _, stage, after = _stage(free, before, 255, settings)
    arguments = check_arguments(free, [GOAL], schedule=[255], termination="sound", start=before, **settings)
    by_node = np.pad(before.shifted(255).limbs, ((1, 1), (1, 1), (0, 0)))
    by_plane = np.moveaxis(by_node, 2, 0).copy()
    digits = np.moveaxis(by_node.view(np.uint32), 2, 0).astype(np.int64)
    movable = np.pad(arguments.movable, 1)
    mask = np.where(movable, ~np.uint64(0), np.uint64(0))
    rest = block, most, stage.sweeps
    contenders: tuple[tuple[str, Callable[[], Any], Callable[[Any], int]], ...] = (
        ("one stage: bit planes", lambda: Engine(arguments), lambda engine: _run(engine, 255).stage.iterations),
        (
            "one stage: limbs, plane by plane",
            by_plane.copy,
            lambda values: compiled_visits(plane_by_plane, values, mask, *rest, False),
        ),
        (
            "one stage: limbs, node by node",
            by_node.copy,
            lambda values: compiled_visits(node_by_node, values, mask, *rest, True),
        ),
        (
            "three sweeps: plain numpy",
            digits.copy,
            lambda values: visits(digits_of_32_bits, values, movable, block, most, 3, False),
        ),
    )
    seconds, counts = [np.inf] * len(contenders), [0] * len(contenders)
    states: list[Any] = [None] * len(contenders)
    for _ in range(7):
        for index, (_, prepare, run) in enumerate(contenders):
            state = states[index] = prepare()
            once, counts[index] = best_of(1, partial(run, state))
            seconds[index] = min(seconds[index], once)
    assert counts[:3] == [stage.iterations] * 3
    for end in (np.moveaxis(states[1], 0, 2), states[2]):
        assert Field(np.ascontiguousarray(end[1:-1, 1:-1]), 255) == after
    each = [time / count for time, count in zip(seconds, counts, strict=True)]
    notes = ["", *(f"{time / each[0]:.0f} times the bit planes" for time in each[1:])]
    nodes = block[0] * block[1]
    return [
        row(f"p = 255, {name}", time, count, nodes, note=note)
        for (name, _, _), time, count, note in zip(contenders, seconds, counts, notes, strict=True)
    ]


def by_precision() -> list[Any]:
    """The same step of 8 bits at five precisions: the visits alone, and what the stage takes besides them.

    What it takes besides is that of a stage that finds nothing to do at the same precision: shifts of the planes,
    wide values at its end, local maxima.
    """
    free = rooms(72, 132, room=(35, 43), door=4, seed=1).free
    settings: dict[str, Any] = {"block": (36, 66), "iterations": 16}
    lines = []
    for precision in (63, 127, 255, 511, 1023):
        before = relax(free, [GOAL], schedule=range(7, precision - 7, 8), **settings).field
        seconds, stage, after = _stage(free, before, precision, settings)
        idle, _, _ = _stage(free, after, precision, settings)
        case = f"72×132, 4 blocks, visits from {precision - 8} to {precision} bits"
        simulated = stage.cycles / CLOCK
        note = f"besides, once: {idle * 1e3:.2f} ms"
        lines.append(row(case, seconds - idle, stage.iterations, 36 * 66, simulated, note))
    return lines


def _run(engine: Engine, precision: int) -> StageEnd:
    """One stage of an engine, to its end."""
    return next(item for item in engine.run(0, precision) if isinstance(item, StageEnd))


def _stage(free: NDArray[np.bool_], start: Field, precision: int, settings: Any) -> tuple[float, Stage, Field]:
    """The shortest of 25 runs of one stage, without reading the start; what it made, and the field it left."""
    arguments = check_arguments(free, [GOAL], schedule=[precision], termination="sound", start=start, **settings)
    shortest = np.inf
    for _ in range(25):
        engine = Engine(arguments)
        seconds, end = best_of(1, partial(_run, engine, precision))
        shortest = min(shortest, seconds)
    return shortest, end.stage, end.field


def by_size() -> list[Any]:
    """One block of ever more closed rooms of 64×64 cells, each with its goal: the same iterations at any size."""
    room = np.ones((64, 64), bool)
    room[0] = room[:, 0] = False
    lines = []
    for side in (64, 128, 256, 512, 1024):
        count = side // 64
        free = np.tile(room, (count, count))
        goals = [(64 * i + 20, 64 * j + 20) for i in range(count) for j in range(count)]
        before = relax(free, goals, block=(side, side), iterations=64, schedule=[8], record_visits=False).field
        arguments = check_arguments(
            free, goals, block=(side, side), iterations=64, schedule=[16], termination="sound", start=before
        )

        seconds, end = best_of(5, lambda arguments=arguments: _run(Engine(arguments), 16))
        stage = end.stage
        lines.append(row(f"{side}×{side} in one block, p = 16", seconds, stage.iterations, side * side))
    return lines


@njit
def _again(layout, state, count):
    for _ in range(count):
        iterate(layout, state, 0, state.residual, state.ring, False)


def iteration_alone() -> list[Any]:
    """The inner loop alone, all nodes of a 96×48 block active, by the bits of the steps."""
    block = (96, 48)
    layout = make_layout(block, block, 64)
    state = make_state(layout, False)
    state.mask[layout.first : layout.first + block[0]] = (1 << block[1]) - 1
    generator = np.random.default_rng(0)
    many, lines = 20_000, []
    for width in (1, 2, 4, 8):
        planes = state.residual[: (width + 2) * layout.plane].reshape(width + 2, layout.plane)
        planes[:] = generator.integers(0, 1 << 63, planes.shape, dtype=np.uint64) & state.mask
        state.turn_width[:] = state.read_width[:] = width
        _again(layout, addresses(state), 1)
        seconds, _ = best_of(15, lambda: _again(layout, addresses(state), many))
        cost = f"{seconds / many * 1e9 / 12 / width:.1f} ns a bit and vector"
        case = f"an iteration alone, 96×48, steps of {width} bits"
        lines.append(row(case, seconds, many, block[0] * block[1], note=cost))
    return lines


def run() -> list[dict[str, str]]:
    """All lines of the table."""
    virtex2 = rooms(72, 132, room=(35, 43), door=4, seed=1).free
    virtex4 = rooms(384, 192, room=(47, 47), door=6, seed=1).free
    relax(virtex2, [GOAL], block=(36, 66), iterations=6, schedule=[7])
    lines = [
        real_time("XC2V6000", virtex2[:36, :66], (36, 66), 6, range(7, 256, 8)),
        *(real_time("XC2V6000", virtex2, (36, 66), i, range(7, 256, 8)) for i in (6, 16, 64)),
        *(real_time("XC4VLX160", virtex4, (96, 48), i, range(7, 64, 8)) for i in (6, 16, 64)),
        *(real_time("XC4VLX160", virtex4, (96, 48), i, range(63, 64)) for i in (6, 16)),
    ]
    return [*lines, *compared((36, 66), 16), *by_precision(), *by_size(), *iteration_alone()]


if __name__ == "__main__":
    for line in run():
        print("  ".join(f"{value:>12}" if key != "case" else f"{value:<58}" for key, value in line.items()))
