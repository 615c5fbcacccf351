"""What would make an array fit: the tile that does, the register that is enough, the part it takes."""

from __future__ import annotations

from collections.abc import Callable

from codesign.architectures.interface import Bound, Item, Lever
from codesign.architectures.wavefront.resources import totals
from codesign.figures import Status
from codesign.spec.part import Part

Shape = tuple[int, int]
ItemsOf = Callable[[Shape], tuple[Item, ...]]


def short_resources(items: tuple[Item, ...], part: Part) -> dict[str, int]:
    """What each resource that the part lacks is asked for."""
    return {
        kind: need
        for kind, need in totals(items).items()
        if kind in part.resources and need > part.resources[kind].value
    }


def largest_tile(items_of: ItemsOf, map_shape: Shape, part: Part) -> Shape | None:
    """The largest square, cut to the map, whose array fits the part; None: not even one node.

    The nodes' demand grows with the side, but that of the memories falls by steps, so every side is tried from the
    largest down, by halves first where only nodes matter.
    """
    side = max(map_shape)
    while side >= 1:
        shape = min(side, map_shape[0]), min(side, map_shape[1])
        if not short_resources(items_of(shape), part):
            return shape
        side = side - 1 if side <= 128 else side * 7 // 8
    return None


def resource_levers(
    items: tuple[Item, ...],
    part: Part,
    tiled_items: ItemsOf,
    map_shape: Shape,
    spare_bits: tuple[int, int] | None,
) -> dict[str, tuple[Lever, ...]]:
    """For each resource that the part lacks: a tiled array that fits it, a narrower register, another part.

    ``spare_bits``: bits of the register and the fewer that are enough, or None.
    """
    short = short_resources(items, part)
    if not short:
        return {}
    tile = largest_tile(tiled_items, map_shape, part)
    shared = [
        Lever("propagate.style", f"no tile of style tiled fits {part.name} either")
        if tile is None
        else Lever("propagate.style", f"tiled, with tile [{tile[0]}, {tile[1]}] or smaller, fits {part.name}")
    ]
    if spare_bits is not None:
        shared.append(
            Lever("propagate.register_bits", f"{spare_bits[1]} are enough, {spare_bits[0]} are asked for")
        )
    return {
        kind: (*shared, Lever("part", f"take one with at least {need:,} {kind.replace('_', ' ')}"))
        for kind, need in short.items()
    }


def register_bound(needed: int, given: int, largest: int) -> Bound:
    """Registers hold potentials up to the largest, and infinity."""
    levers: tuple[Lever, ...] = ()
    if given < needed:
        levers = (
            Lever(
                "propagate.register_bits",
                f"at least {needed} bits hold {largest} and infinity, {largest + 1}",
            ),
            Lever("problem", f"a map whose largest potential is at most {2**given - 2}"),
        )
    return Bound(
        name="register",
        demand=needed,
        limit=given,
        unit="bits",
        status=Status.MEASURED,
        source=f"the largest potential of this problem is {largest}; one value more is infinity",
        levers=levers,
    )
