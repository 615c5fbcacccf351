"""How fast the relaxation is simulated: against the simulated FPGA, other kernels, precision and size of the map."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from codesign.maps.generate import rooms
from codesign.planners.harmonic import Field, Stage, StageEnd, kernels, relax, stage_cost
from codesign.planners.harmonic.arguments import check_arguments
from codesign.planners.harmonic.engine import Engine
from codesign.planners.harmonic.layout import LANES, addresses, make_layout, make_state

CLOCK = 150e6
GOAL = (20, 20)


def row(
    case: str, seconds: float, iterations: int, nodes: int, simulated: float | None = None, note: str = ""
) -> Any:
    """One line of the table. ``nodes``: of a block."""
    return {
        "case": case,
        "wall ms": f"{seconds * 1e3:.2f}",
        "real-time factor": "" if simulated is None else f"{simulated / seconds:.2f}",
        "ns an iteration": f"{seconds / iterations * 1e9:.0f}",
        "1e9 nodes/s": f"{iterations * nodes / seconds / 1e9:.2f}",
        "note": note,
    }


def best_of(count: int, run: Callable[[], Any]) -> tuple[float, Any]:
    """The shortest wall time of several runs, and what the last gave."""
    shortest, result = float("inf"), None
    for _ in range(count):
        begin = time.perf_counter()
        result = run()
        shortest = min(shortest, time.perf_counter() - begin)
    return shortest, result


def real_time(
    name: str, free: NDArray[np.bool_], block: tuple[int, int], iterations: int, schedule: range
) -> Any:
    """The whole run: simulated time is that of the iterations, p + 2 cycles each."""
    seconds, result = best_of(
        3, lambda: relax(free, [GOAL], block=block, iterations=iterations, schedule=schedule)
    )
    blocks = -(-free.shape[0] // block[0]) * -(-free.shape[1] // block[1])
    bits = "..".join(str(p) for p in dict.fromkeys((schedule[0], schedule[-1])))
    case = f"{name}: {blocks} blocks of {block[0]}×{block[1]}, p = {bits}, I = {iterations}"
    nodes = block[0] * block[1]
    return row(case, seconds, result.total_iterations, nodes, result.total_cycles / CLOCK)


@njit(cache=True)
def _limb_iteration(values, movable, top, bottom, left, right, out):
    """One iteration of a block in 64-bit limbs (rows × columns × limbs with a frame); whether a bit changed."""
    changed = False
    low, half = np.uint64(0xFFFFFFFF), np.uint64(32)
    for i in range(top, bottom):
        for j in range(left, right):
            if not movable[i, j]:
                continue
            carry, previous = np.uint64(0), np.uint64(0)
            for limb in range(values.shape[2]):
                n, s = values[i - 1, j, limb], values[i + 1, j, limb]
                w, e = values[i, j - 1, limb], values[i, j + 1, limb]
                first = (n & low) + (s & low) + (w & low) + (e & low) + carry
                second = (n >> half) + (s >> half) + (w >> half) + (e >> half) + (first >> half)
                total = second << half | first & low
                carry = second >> half
                if limb > 0:
                    out[i - top, j - left, limb - 1] = previous >> np.uint64(2) | total << np.uint64(62)
                previous = total
            out[i - top, j - left, values.shape[2] - 1] = previous >> np.uint64(2) | carry << np.uint64(62)
    for i in range(top, bottom):
        for j in range(left, right):
            if movable[i, j]:
                for limb in range(values.shape[2]):
                    changed |= values[i, j, limb] != out[i - top, j - left, limb]
                    values[i, j, limb] = out[i - top, j - left, limb]
    return changed


def _numpy_iteration(
    values: Any, movable: Any, top: int, bottom: int, left: int, right: int, _out: Any
) -> bool:
    """The same in plain numpy, digits of 32 bits in int64 (digits × rows × columns with a frame)."""
    inside = np.s_[:, top:bottom, left:right]
    total = (
        values[:, top - 1 : bottom - 1, left:right]
        + values[:, top + 1 : bottom + 1, left:right]
        + values[:, top:bottom, left - 1 : right - 1]
        + values[:, top:bottom, left + 1 : right + 1]
    )
    for digit in range(len(total) - 1):
        total[digit + 1] += total[digit] >> 32
    total &= 0xFFFFFFFF
    total[:-1] = total[:-1] >> 2 | (total[1:] & 3) << 30
    total[-1] >>= 2
    total *= movable[top:bottom, left:right]
    total += values[inside] * ~movable[top:bottom, left:right]
    changed = bool((total != values[inside]).any())
    values[inside] = total
    return changed


def _stage_by(iterate: Any, values: Any, movable: Any, block: tuple[int, int], most: int, sweeps: int) -> int:
    """Some sweeps of visits by one of the kernels above; the iterations made."""
    rows, columns = movable.shape[0] - 2, movable.shape[1] - 2
    out = np.empty((*block, values.shape[-1]), np.uint64)
    count = 0
    for _ in range(sweeps):
        for top in range(1, rows + 1, block[0]):
            for left in range(1, columns + 1, block[1]):
                for _ in range(most):
                    count += 1
                    bottom, right = min(top + block[0], rows + 1), min(left + block[1], columns + 1)
                    if not iterate(values, movable, top, bottom, left, right, out):
                        break
    return count


def compared(block: tuple[int, int], most: int) -> list[Any]:
    """The stage from 247 to 255 bits, by bit planes, by limbs and by numpy, all three exact."""
    free = rooms(72, 132, room=(35, 43), door=4, seed=1).free
    settings: dict[str, Any] = {"block": block, "iterations": most}
    before = relax(free, [GOAL], schedule=range(7, 248, 8), **settings).field
    seconds, (stage, after) = best_of(5, lambda: stage_cost(free, [GOAL], before, 255, **settings))
    nodes = block[0] * block[1]
    ours = seconds / stage.iterations
    lines = [row("p = 255, one stage: bit planes", seconds, stage.iterations, nodes)]
    start = before.shifted(255)
    movable = np.pad(free, 1)
    movable[GOAL[0] + 1, GOAL[1] + 1] = False
    limbs = np.pad(start.limbs, ((1, 1), (1, 1), (0, 0)))
    _stage_by(_limb_iteration, limbs.copy(), movable, block, most, 1)
    begin = time.perf_counter()
    count = _stage_by(_limb_iteration, limbs, movable, block, most, stage.sweeps)
    seconds = time.perf_counter() - begin
    assert count == stage.iterations
    assert Field(limbs[1:-1, 1:-1].copy(), 255) == after
    ratio = f"{seconds / count / ours:.0f} times the bit planes"
    lines.append(row("p = 255, one stage: numba, 4 limbs", seconds, count, nodes, note=ratio))
    digits = np.moveaxis(
        np.pad(start.limbs.view(np.uint32), ((1, 1), (1, 1), (0, 0))).astype(np.int64), 2, 0
    ).copy()
    begin = time.perf_counter()
    count = _stage_by(_numpy_iteration, digits, movable, block, most, 3)
    seconds = time.perf_counter() - begin
    ratio = f"{seconds / count / ours:.0f} times the bit planes"
    lines.append(row("p = 255, three sweeps: plain numpy", seconds, count, nodes, note=ratio))
    return lines


def by_precision() -> list[Any]:
    """The same step of 8 bits at four precisions."""
    free = rooms(72, 132, room=(35, 43), door=4, seed=1).free
    settings: dict[str, Any] = {"block": (36, 66), "iterations": 16}
    lines = []
    for precision in (63, 255, 511, 1023):
        before = relax(free, [GOAL], schedule=range(7, precision - 7, 8), **settings).field
        arguments = check_arguments(
            free, [GOAL], schedule=[precision], termination="sound", start=before, **settings
        )
        engine = Engine(arguments)
        begin = time.perf_counter()
        stages = [item.stage for item in engine.run(0, precision) if isinstance(item, StageEnd)]
        seconds = time.perf_counter() - begin
        case = f"72×132, 4 blocks, stage from {precision - 8} to {precision} bits"
        simulated = stages[0].cycles / CLOCK
        lines.append(row(case, seconds, stages[0].iterations, 36 * 66, simulated))
    return lines


def by_size() -> list[Any]:
    """One block of ever more closed rooms of 64×64 cells, each with its goal: the same iterations at any size."""
    room = np.ones((64, 64), bool)
    room[0] = room[:, 0] = False
    lines = []
    for side in (64, 128, 256, 512, 1024):
        count = side // 64
        free = np.tile(room, (count, count))
        goals = [(64 * i + 20, 64 * j + 20) for i in range(count) for j in range(count)]
        before = relax(
            free, goals, block=(side, side), iterations=64, schedule=[8], record_visits=False
        ).field
        arguments = check_arguments(
            free, goals, block=(side, side), iterations=64, schedule=[16], termination="sound", start=before
        )

        def run(arguments: Any = arguments) -> Stage:
            items = Engine(arguments).run(0, 16)
            return next(item.stage for item in items if isinstance(item, StageEnd))

        seconds, stage = best_of(3, run)
        lines.append(row(f"{side}×{side} in one block, p = 16", seconds, stage.iterations, side * side))
    return lines


@njit
def _again(layout, state, count):
    for _ in range(count):
        kernels._iterate(layout, state, 0, 0, 1, 0, False)


def iteration_alone() -> list[Any]:
    """The inner loop alone, all nodes of a 96×48 block active, by the bits of the steps."""
    block = (96, 48)
    layout = make_layout(block, block, 64)
    state = make_state(layout, False)
    state.mask[layout.first : layout.first + block[0]] = (1 << block[1]) - 1
    generator = np.random.default_rng(0)
    many, lines = 20_000, []
    for width in (1, 2, 4, 8):
        planes = state.ring[: (width + 2) * layout.plane].reshape(width + 2, layout.plane)
        planes[:] = generator.integers(0, 1 << 63, planes.shape, dtype=np.uint64) & state.mask
        state.ring_width[layout.first // LANES : (layout.first + block[0]) // LANES] = width
        _again(layout, addresses(state), 1)
        seconds, _ = best_of(5, lambda: _again(layout, addresses(state), many))
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
        real_time("XC4VLX160", virtex4, (96, 48), 16, range(63, 64)),
    ]
    return [*lines, *compared((36, 66), 16), *by_precision(), *by_size(), *iteration_alone()]


if __name__ == "__main__":
    for line in run():
        print("  ".join(f"{value:>12}" if key != "case" else f"{value:<58}" for key, value in line.items()))
