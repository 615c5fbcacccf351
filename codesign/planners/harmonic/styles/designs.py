"""The parameters that are worth a try: blocks that fit the part, and precisions that rise until the plan serves."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from codesign.ground.models import Part
from codesign.planners.harmonic.styles.resources import Machine, block_count, fits, largest_precision, word_depth
from codesign.planners.styles import Designs

FIRST, STEP = 15, 16
"""Bits of the first stage, and bits added from stage to stage."""

LAST = (15, 31, 47, 63, 95, 127, 191, 255, 383, 511, 767, 1023)
"""Fractional bits of the last stage, in the order in which they are tried."""

WORD = 63
"""The last precision of values in one machine word."""

SIDES = (8, 12, 16, 24, 32, 48, 64, 96, 128)
MOST_BLOCKS = 3
"""The number of blocks that are tried, the largest that fit. All parts share the sides, so also the stages."""

VISITS = (8, 32)
"""Most iterations of a visit."""

BEYOND = (
    f"schedules other than {FIRST}, {FIRST + STEP}, {FIRST + 2 * STEP} ... bits, other than {VISITS[0]} or {VISITS[1]}"
    " iterations a visit, promoted blocks, other ends of a run"
)
"""The designs that no style proposes."""


def host_designs(last: int) -> Designs:
    """The whole map as one block, at the last precisions up to ``last``."""
    return (tuple(_design({"blocks": [1, 1]}, VISITS[0], bits) for bits in LAST if bits <= last),)


def block_designs(map_shape: tuple[int, int], part: Part, decision: bool) -> Designs:
    """Chains of rising precision for the largest squares, cut to the map, with a precision that fits the part.

    Where no block fits, the design that is short of the least: the smallest block of all.
    """
    rows, columns = map_shape
    shapes = dict.fromkeys((min(side, rows), min(side, columns)) for side in SIDES)
    fitting = []
    for block in reversed(shapes):
        machines = (machine(map_shape, block, last, decision) for last in lasts_of(map_shape, block, part))
        lasts = [each.last for each in machines if fits(each, part)]
        if lasts:
            fitting.append((block, lasts))
    smallest = next(iter(shapes)), [LAST[0]]
    return tuple(
        block_chain(block, iterations, lasts)
        for block, lasts in fitting[:MOST_BLOCKS] or [smallest]
        for iterations in VISITS
    )


def lasts_of(map_shape: tuple[int, int], block: tuple[int, int], part: Part) -> list[int]:
    """The last precisions whose words a block RAM holds, of all blocks of the map."""
    most = largest_precision(block_count(map_shape, block), word_depth(part))
    return [last for last in LAST if last <= most]


def block_chain(block: tuple[int, int], iterations: int, lasts: Iterable[int]) -> tuple[dict[str, Any], ...]:
    """The designs of a block at rising last precisions."""
    return tuple(_design({"block": list(block)}, iterations, last) for last in lasts)


def machine(map_shape: tuple[int, int], block: tuple[int, int], last: int, decision: bool) -> Machine:
    """The circuit of a design: as many blocks as cover the map, and as many stages as its schedule has."""
    down, across = (-(-cells // nodes) for cells, nodes in zip(map_shape, block, strict=True))
    stages = len(range(FIRST, last, STEP)) + 1
    return Machine(*block, last, decision, down, across, stages=stages)


def _design(partition: dict[str, Any], iterations: int, last: int) -> dict[str, Any]:
    return {**partition, "iterations": iterations, "schedule": {"first": FIRST, "step": STEP, "last": last}}
