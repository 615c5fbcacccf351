"""The levers that make a design fit, each with a computed value."""

from __future__ import annotations

from typing import Any

from codesign.figures import Status, label
from codesign.part import Part
from codesign.planners.demand import Lever, Line, short_resources
from codesign.planners.harmonic.styles.resources import (
    RAM_WIDTH,
    decision_slices,
    items,
    largest_precision,
    totals,
    words,
)

Shape = tuple[int, int]
Precisions = tuple[int, ...]


def block_grid(map_shape: Shape, block: Shape) -> tuple[int, int]:
    """Blocks down and across that cover a map, partial ones counted."""
    return -(-map_shape[0] // block[0]), -(-map_shape[1] // block[1])


def block_count(map_shape: Shape, block: Shape) -> int:
    """Blocks that cover a map, partial ones counted."""
    down, across = block_grid(map_shape, block)
    return down * across


def fits(block: Shape, precision: int, part: Part, decision: bool = True) -> bool:
    """Whether the part has the resources for such a block with borders, with or without the decision module."""
    return not short_resources(items(*block, precision, decision), part)


def largest_block(block: Shape, precision: int, part: Part, decision: bool = True) -> Shape | None:
    """The largest block of about the same proportions, up to ``block``, that fits the part; None: not even one node.

    Demand never falls as a block grows, so bisection is exact.
    """
    low, high = 0, block[0]
    while low < high:
        middle = (low + high + 1) // 2
        if fits(_scaled(block, middle), precision, part, decision):
            low = middle
        else:
            high = middle - 1
    return _scaled(block, low) if low else None


def resource_levers(
    map_shape: Shape, block: Shape, precisions: Precisions, part: Part, depth: int, decision: bool = True
) -> dict[str, tuple[Lever, ...]]:
    """Levers for each resource that the part lacks: block, precision, another place for ``decide``, part."""
    precision = precisions[-1]
    grid = block_grid(map_shape, block)
    need = totals(*block, precision, decision, grid)
    short = short_resources(items(*block, precision, decision, grid), part)
    if not short:
        return {}
    shared = _block_lever(map_shape, block, precisions, part, depth, decision)
    without = totals(*block, precision, False, grid)
    by_kind: dict[str, tuple[Lever, ...]] = {}
    for kind in (kind for kind in part.resources if kind in short):
        levers = [shared]
        if kind == "slices" and decision:
            spare = part.resources[kind].value - (need[kind] - decision_slices(precision))
            last = int((spare - decision_slices(0)) // 3)
            if last >= 1:
                levers.append(
                    Lever(
                        "relax.schedule",
                        f"end at {last} bits or less (3 slices of the decision module a bit)",
                        {"schedule": _ending(precisions, last)},
                    )
                )
        if without[kind] <= part.resources[kind].value:
            spared = f"{need[kind] - without[kind]:,} {label(kind)} of the decision module are spared"
            levers.append(Lever("decide.component", f"another component: {spared}"))
        levers.append(Lever("part", f"take one with at least {need[kind]:,} {label(kind)}"))
        by_kind[kind] = tuple(levers)
    return by_kind


def word_depth_bound(
    map_shape: Shape, block: Shape, precisions: Precisions, part: Part, depth: int, decision: bool = True
) -> Line:
    """blocks × (p + 1) ≤ words of a block RAM (section 5.4), with levers where the bound is broken."""
    precision = precisions[-1]
    blocks = block_count(map_shape, block)
    return Line.bound(
        name="words of a block RAM",
        demand=words(blocks, precision),
        limit=depth,
        unit="words",
        status=Status.PUBLISHED,
        source="Girau et al. 2008, section 5.4: p bits and a flag for each block, in RAMs of 1K × 18",
        levers=()
        if words(blocks, precision) <= depth
        else _depth_levers(map_shape, block, precisions, part, depth, decision),
    )


def _depth_levers(
    map_shape: Shape, block: Shape, precisions: Precisions, part: Part, depth: int, decision: bool
) -> tuple[Lever, ...]:
    precision = precisions[-1]
    blocks = block_count(map_shape, block)
    levers = []
    last = largest_precision(blocks, depth)
    if last >= 1:
        advice = f"end at {last} bits or less with {_counted(blocks)}"
        levers.append(Lever("relax.schedule", advice, {"schedule": _ending(precisions, last)}))
    levers += _larger_block(map_shape, block, precisions, part, depth, decision)
    levers.append(
        Lever("part", f"take one with block RAMs of {words(blocks, precision):,} words of {RAM_WIDTH} bits")
    )
    return tuple(levers)


def _block_lever(
    map_shape: Shape, block: Shape, precisions: Precisions, part: Part, depth: int, decision: bool
) -> Lever:
    precision = precisions[-1]
    smaller = largest_block(_clipped(block, map_shape), precision, part, decision)
    if smaller is None:
        return Lever("relax.block", f"no block fits {part.name}: what stands beside it is too large")
    blocks = block_count(map_shape, smaller)
    last = largest_precision(blocks, depth)
    allowed = f"precision up to {last}" if last >= 1 else "too many for any precision"
    advice = f"at most {smaller[0]} × {smaller[1]} in these proportions fits {part.name}"
    changes = _block_changes(smaller, precisions, last) if last >= 1 else {}
    return Lever("relax.block", f"{advice}: {_counted(blocks)}, {allowed}", changes)


def _larger_block(
    map_shape: Shape, block: Shape, precisions: Precisions, part: Part, depth: int, decision: bool
) -> tuple[Lever, ...]:
    """The smallest larger block with words that fit, or else the precision of the largest block of the part."""
    precision = precisions[-1]
    covering = max(map_shape[0], -(-map_shape[1] * block[0] // block[1]))
    largest = largest_block(_scaled(block, covering), precision, part, decision)
    if largest is None:
        return ()
    for rows in range(block[0] + 1, largest[0] + 1):
        shape = _clipped(_scaled(block, rows), map_shape)
        blocks = block_count(map_shape, shape)
        if words(blocks, precision) <= depth:
            advice = f"{shape[0]} × {shape[1]} makes {_counted(blocks)}, and fits {part.name}"
            return (Lever("relax.block", advice, _block_changes(shape, precisions, precision)),)
    largest = _clipped(largest, map_shape)
    blocks = block_count(map_shape, largest)
    last = largest_precision(blocks, depth)
    if last < 1 or blocks >= block_count(map_shape, block):
        return ()
    advice = (
        f"{largest[0]} × {largest[1]}, the largest in these proportions that fits {part.name},"
        f" makes {_counted(blocks)}: precision up to {last}"
    )
    return (Lever("relax.block", advice, _block_changes(largest, precisions, last)),)


def _ending(precisions: Precisions, last: int) -> list[int]:
    """A schedule that ends at ``last`` bits, or where it ended before."""
    return (
        list(precisions) if last >= precisions[-1] else [*(each for each in precisions if each < last), last]
    )


def _block_changes(block: Shape, precisions: Precisions, last: int) -> dict[str, Any]:
    """The parameters of a block with the precisions that its words allow."""
    return {"block": list(block), "blocks": None, "schedule": _ending(precisions, last)}


def _clipped(block: Shape, map_shape: Shape) -> Shape:
    return min(block[0], map_shape[0]), min(block[1], map_shape[1])


def _counted(blocks: int) -> str:
    return "1 block" if blocks == 1 else f"{blocks} blocks"


def _scaled(block: Shape, rows: int) -> Shape:
    """The block with ``rows`` rows and columns in proportion, at least one."""
    return rows, max(1, rows * block[1] // block[0])
