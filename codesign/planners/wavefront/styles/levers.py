"""The levers that make an array fit: a tile, a narrower register, another part."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from codesign.ground.figures import Status
from codesign.ground.models import Part
from codesign.planners.job import Lever, Line, part_lever, short_resources

Shape = tuple[int, int]
ItemsOf = Callable[[Shape], tuple[Line, ...]]


def largest_tile(items_of: ItemsOf, map_shape: Shape, part: Part) -> Shape | None:
    """The largest square, cut to the map, with an array that fits the part; None: not even one node fits.

    The nodes' demand grows with the side, but the memories' demand falls by steps, so every side is tried from the
    largest down, in steps of an eighth above 128.
    """
    side = max(map_shape)
    while side >= 1:
        shape = min(side, map_shape[0]), min(side, map_shape[1])
        if not short_resources(items_of(shape), part):
            return shape
        side = side - 1 if side <= 128 else side * 7 // 8
    return None


@dataclass(frozen=True)
class Alternatives:
    """Other designs for the same problem: whole-map arrays by style, tiled arrays by tile, a narrower register.

    ``spare_bits``: bits of the register, and the smaller number that is enough; or None.
    """

    whole: Mapping[str, tuple[Line, ...]]
    tiled: ItemsOf
    map_shape: Shape
    spare_bits: tuple[int, int] | None


def resource_levers(items: tuple[Line, ...], part: Part, other: Alternatives) -> dict[str, tuple[Lever, ...]]:
    """For each resource that the part lacks: a style or a tile that fits it, a narrower register, another part."""
    short = short_resources(items, part)
    if not short:
        return {}
    shared = [
        Lever("propagate.style", f"{style} fits {part.name}", axes={"propagate.style": style})
        for style, array in other.whole.items()
        if not short_resources(array, part)
    ]
    tile = largest_tile(other.tiled, other.map_shape, part)
    if tile is not None:
        axes = {"propagate.style": "tiled", "propagate.tile": list(tile)}
        text = f"style tiled with [{tile[0]}, {tile[1]}] fits {part.name}"
        shared.append(Lever("propagate.tile", text, axes=axes))
    if not shared:
        shared.append(Lever("propagate.style", f"no style and no tile fits {part.name}"))
    if other.spare_bits is not None:
        asked, enough = other.spare_bits
        axis, text = "propagate.register_bits", f"{enough} are enough, {asked} are asked for"
        shared.append(Lever(axis, text, axes={axis: enough}))
    return {kind: (*shared, part_lever(kind, need)) for kind, need in short.items()}


def register_bound(needed: int, given: int, largest: int) -> Line:
    """Registers hold potentials up to the largest, and infinity."""
    levers: tuple[Lever, ...] = ()
    if given < needed:
        levers = (
            Lever(
                "propagate.register_bits",
                f"at least {needed} bits hold {largest} and infinity, {largest + 1}",
                axes={"propagate.register_bits": needed},
            ),
            Lever("problem", f"a map whose largest potential is at most {2**given - 2}"),
        )
    return Line.bound(
        name="register",
        demand=needed,
        limit=given,
        unit="bits",
        status=Status.MEASURED,
        source=f"the largest potential of this problem is {largest}; one value more is infinity",
        levers=levers,
    )
