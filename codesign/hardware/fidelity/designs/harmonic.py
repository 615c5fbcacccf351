"""Harmonic arrays of one block and of several, plain and pipelined."""

from __future__ import annotations

from functools import partial
from typing import Any

from codesign.hardware.fidelity.designs import FEW, ONE, Design, Placed, free_map, scattered_map


def array(rows: int, columns: int, pipeline: int, **parameters: Any) -> Design:
    """One array of ``rows`` × ``columns`` nodes; further parameters make it one of several blocks."""
    common = {"iterations": 6, "schedule": {"first": 7, "step": 8, "last": 63}}
    settings = {"block": (rows, columns), "pipeline": pipeline, **common, **parameters}
    return Design("bit_serial", settings, partial(free_map, rows, columns))


def machine(
    block: tuple[int, int],
    grid: tuple[int, int] = (1, 1),
    pipeline: int = 0,
    schedule: tuple[int, ...] = (15, 31, 63),
    decision: bool = True,
    **parameters: Any,
) -> Design:
    """A block on a map of ``grid`` blocks, with or without its decision module."""
    settings = {"block": block, "pipeline": pipeline, "iterations": 6, "schedule": schedule, **parameters}
    problem = partial(free_map, block[0] * grid[0], block[1] * grid[1])
    job = {} if decision else {"inside": frozenset({"relax", "detect"})}
    return Design("bit_serial", settings, problem, job=job)


SIZES = (6, 6), (6, 12), (12, 12), (12, 24)

CLOCKS = [
    *(Placed(array(*size, pipeline), "LFE5U-85F-8") for size in SIZES for pipeline in (1, 0)),
    *(Placed(array(18, 36, 1), part, ONE) for part in ("LFE5U-85F-8", "LFE5U-85F-6")),
    *(Placed(array(6, 12, pipeline), "LFE5U-85F-6") for pipeline in (1, 0)),
    *(Placed(array(12, 24, pipeline), "LFE5U-85F-6", ONE) for pipeline in (1, 0)),
    # Without a pipeline the path begins at a memory, and nextpnr times no path out of a memory of a Gowin part.
    *(Placed(array(*size, 1), "GW2A-18-7") for size in SIZES[:3]),
    *(
        Placed(array(6, 12, 1, digit_bits=digit_bits, schedule=(47, 63)), "LFE5U-85F-8", FEW)
        for digit_bits in (2, 4, 8)
    ),
    Placed(array(6, 12, 0, digit_bits=2, schedule=(47, 63)), "LFE5U-85F-8", FEW),
    *(Placed(machine((6, 12), (2, 2), pipeline), "LFE5U-85F-8", ONE) for pipeline in (1, 0)),
    Placed(machine((12, 12), (2, 2), 1, decision=False), "LFE5U-85F-8", ONE),
]


def alone(rows: int, columns: int, last: int) -> Design:
    """The decision module by itself, beside the field of a map at ``last`` bits."""
    settings = {"blocks": (1, 1), "iterations": 50, "schedule": (last,)}
    return Design("bit_serial", settings, partial(free_map, rows, columns), "decide")


RESOURCES = [
    machine((6, 6)),
    machine((6, 6), (4, 4), 1, (15, 31)),
    machine((6, 12), (2, 2)),
    machine((6, 12), pipeline=1, schedule=(15, 63, 127), decision=False),
    machine((9, 12), (2, 1)),
    machine((9, 12), (3, 3), 1, (15, 31, 47, 63, 79, 95), iterations=40),
    machine((12, 12), schedule=(255, 1023)),
    machine((12, 12), (2, 2), 1, (63, 127, 255), termination="published"),
    machine((7, 13), (2, 2)),
    machine((12, 18), (1, 3), decision=False, stop="schedule_end"),
    # Held out.
    machine((12, 24)),
    machine((10, 14), (2, 2), 1),
    machine((12, 24), (2, 2), 1, (15, 31, 47, 63, 127)),
    machine((18, 24), (2, 2), schedule=(31, 63)),
    # Digits of several bits; the last two of each are held out.
    *(
        machine(block, grid, pipeline, schedule, digit_bits=digit_bits)
        for digit_bits in (2, 4, 8)
        for block, grid, pipeline, schedule in (
            ((6, 6), (1, 1), 0, (15, 31, 63)),
            ((6, 12), (2, 2), 1, (47, 63, 127)),
            ((12, 12), (1, 1), 1, (47, 63)),
            ((9, 12), (2, 2), 0, (15, 63, 255)),
            ((10, 14), (2, 2), 1, (47, 63)),
            ((12, 24), (1, 1), 0, (15, 31, 63)),
        )
    ),
    *(alone(8, 8, last) for last in (15, 63)),
    alone(16, 20, 31),
    alone(12, 24, 127),
    alone(30, 30, 63),
    alone(64, 64, 31),
    alone(60, 60, 127),
    # Held out.
    alone(24, 36, 63),
    alone(20, 50, 31),
    alone(50, 80, 63),
]

ACTIVITIES = [
    Design(
        "bit_serial",
        {"block": (6, 12), "pipeline": pipeline, "iterations": 6, "schedule": (15, 31)},
        partial(scattered_map, 6 * blocks, 12 * blocks, seed),
        seed=seed,
    )
    for pipeline in (0, 1)
    for blocks, seed in ((1, 1), (1, 2), (2, 3))
]
