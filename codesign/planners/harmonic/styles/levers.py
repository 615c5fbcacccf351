"""The levers that make a design fit, each with a computed value."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from codesign.ground.figures import Status, label
from codesign.ground.models import Part
from codesign.planners.harmonic.styles.resources import RAM_WIDTH, Machine, largest_precision, totals, words
from codesign.planners.job import Lever, Line, largest, part_lever

Shape = tuple[int, int]
Precisions = tuple[int, ...]


def block_count(map_shape: Shape, block: Shape) -> int:
    """Blocks that cover a map, partial ones counted."""
    return -(-map_shape[0] // block[0]) * -(-map_shape[1] // block[1])


def fits(machine: Machine, part: Part) -> bool:
    """True if the part has the resources for such a block."""
    return not _short(machine, part)


def _short(machine: Machine, part: Part) -> list[str]:
    """The resources that the part has too few of."""
    budgets = part.resources
    needs = totals(machine, part.family).items()
    return [kind for kind, need in needs if kind in budgets and need > budgets[kind].value]


def largest_block(machine: Machine, part: Part) -> Shape | None:
    """The largest block of about the same proportions, up to the block of ``machine``, that fits the part with borders.

    None if not even one node fits. Demand never falls as a block grows.
    """
    blocks = [_scaled(machine.block, rows) for rows in range(1, machine.rows + 1)]
    return largest(blocks, lambda block: fits(_with_block(machine, block), part))


def _with_block(machine: Machine, block: Shape) -> Machine:
    """The machine with another block, one of several."""
    return replace(machine, rows=block[0], columns=block[1], down=2, across=2)


def resource_levers(
    map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int
) -> dict[str, tuple[Lever, ...]]:
    """Levers for each resource that the part lacks: block, precision, another place for ``decide``, part."""
    short = _short(machine, part)
    if not short:
        return {}
    need = totals(machine, part.family)
    shared = _block_lever(map_shape, machine, precisions, part, depth)
    without = totals(replace(machine, decision=False), part.family)
    by_kind: dict[str, tuple[Lever, ...]] = {}
    for kind in (kind for kind in part.resources if kind in short):
        levers, limit = [shared], part.resources[kind].value
        if kind == "slices" and machine.decision and machine.of_paper(part.family):
            last = _last_within(machine, part, limit)
            if last is not None:
                levers.append(
                    Lever(
                        "relax.schedule",
                        f"end at {last} bits or less (3 slices of the decision module a bit)",
                        {"schedule": _ending(precisions, last)},
                    )
                )
        if machine.decision and without[kind] <= limit:
            spared = f"{need[kind] - without[kind]:,} {label(kind)} of the decision module are spared"
            levers.append(Lever("decide.component", f"another component: {spared}"))
        levers.append(part_lever(kind, need[kind]))
        by_kind[kind] = tuple(levers)
    return by_kind


def _last_within(machine: Machine, part: Part, slices: float) -> int | None:
    """The last precision below the machine's that so many slices hold."""

    def fits(last: int) -> bool:
        return totals(replace(machine, last=last), part.family)["slices"] <= slices

    return largest(range(1, machine.last), fits)


def word_depth_bound(map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int) -> Line:
    """blocks × (p + 1) ≤ words of a block RAM (section 5.4), with levers where the bound is broken."""
    demand = words(block_count(map_shape, machine.block), machine.last, machine.digit_bits)
    return Line.bound(
        name="words of a block RAM",
        demand=demand,
        limit=depth,
        unit="words",
        status=Status.PUBLISHED,
        source="Girau et al. 2008, section 5.4: p bits and a flag for each block, in RAMs of 1K × 18",
        levers=() if demand <= depth else _depth_levers(map_shape, machine, precisions, part, depth),
    )


def _depth_levers(
    map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int
) -> tuple[Lever, ...]:
    precision = machine.last
    blocks = block_count(map_shape, machine.block)
    levers = []
    last = largest_precision(blocks, depth, machine.digit_bits)
    if last >= 1:
        advice = f"end at {last} bits or less with {_counted(blocks)}"
        levers.append(Lever("relax.schedule", advice, {"schedule": _ending(precisions, last)}))
    levers += _larger_block(map_shape, machine, precisions, part, depth)
    levers.append(
        Lever(
            "part",
            f"take one with block RAMs of {words(blocks, precision, machine.digit_bits):,} words of {RAM_WIDTH} bits",
        )
    )
    return tuple(levers)


def _block_lever(map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int) -> Lever:
    smaller = largest_block(_with_block(machine, _clipped(machine.block, map_shape)), part)
    if smaller is None:
        return Lever("relax.block", f"no block fits {part.name}: what stands beside it is too large")
    blocks = block_count(map_shape, smaller)
    last = largest_precision(blocks, depth, machine.digit_bits)
    allowed = f"precision up to {last}" if last >= 1 else "too many for any precision"
    advice = f"at most {smaller[0]} × {smaller[1]} in these proportions fits {part.name}"
    changes = _block_changes(smaller, precisions, last) if last >= 1 else {}
    return Lever("relax.block", f"{advice}: {_counted(blocks)}, {allowed}", changes)


def _larger_block(
    map_shape: Shape, machine: Machine, precisions: Precisions, part: Part, depth: int
) -> tuple[Lever, ...]:
    """The smallest larger block with words that fit, or else the precision of the largest block of the part."""
    block, precision = machine.block, machine.last
    covering = max(map_shape[0], -(-map_shape[1] * block[0] // block[1]))
    widest = largest_block(_with_block(machine, _scaled(block, covering)), part)
    if widest is None:
        return ()
    for rows in range(block[0] + 1, widest[0] + 1):
        shape = _clipped(_scaled(block, rows), map_shape)
        blocks = block_count(map_shape, shape)
        if words(blocks, precision, machine.digit_bits) <= depth:
            advice = f"{shape[0]} × {shape[1]} makes {_counted(blocks)}, and fits {part.name}"
            return (Lever("relax.block", advice, _block_changes(shape, precisions, precision)),)
    widest = _clipped(widest, map_shape)
    blocks = block_count(map_shape, widest)
    last = largest_precision(blocks, depth, machine.digit_bits)
    if last < 1 or blocks >= block_count(map_shape, block):
        return ()
    advice = (
        f"{widest[0]} × {widest[1]}, the largest in these proportions that fits {part.name},"
        f" makes {_counted(blocks)}: precision up to {last}"
    )
    return (Lever("relax.block", advice, _block_changes(widest, precisions, last)),)


def _ending(precisions: Precisions, last: int) -> list[int]:
    """A schedule that ends at ``last`` bits, or where it ended before."""
    return list(precisions) if last >= precisions[-1] else [*(each for each in precisions if each < last), last]


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
