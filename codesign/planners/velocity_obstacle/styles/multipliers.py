"""Multipliers of the circuits as synthesis counts them: a wide product takes several, and adders between them.

A circuit is given by the parameters of its Verilog, by name. ``RADIUS``, ``STEP`` and ``HALF_SQUARE`` are constant
factors of parallel units: bits that are always 0 take no multiplier. They may be left out; then the counts are the
most of all constants.

Factors, signs included: w bits in an update, w + 1 of a position and a velocity relative to each other, 2w + 2 of |r|²,
|V|² and r·V, one more with ``half`` for the last five. The first serial update unit, target check, selector,
acceleration check and PID control share one product of w + 1 bits. Of the update units only the first takes an
acceleration.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

Structure = Mapping[str, int]
"""Parameters of the Verilog of a circuit, by name."""
Factors = tuple[int, int]
"""The bits of both factors of a product, signs included."""


@dataclass(frozen=True)
class Block:
    """A multiplier of a family, and how synthesis cuts wider products for it.

    ``bits``: of both factors, the wider first. ``digit``: bits that a cut takes off. ``least``: bits of both factors
    and of the product below which LUTs or the next block form it. ``count``: multipliers of 18 × 18 bits that it is.
    """

    bits: Factors
    digit: int
    least: tuple[int, int, int]
    count: float = 1


XILINX = (Block((18, 18), 17, (2, 2, 9)),)
BLOCKS: Mapping[str, Sequence[Block]] = {
    "xc7": (Block((25, 18), 17, (2, 2, 9)),),
    "ecp5": (Block((18, 18), 18, (2, 2, 0)),),
    "gowin": (Block((36, 36), 36, (22, 22, 0), 4), Block((18, 18), 18, (10, 4, 0)), Block((9, 9), 9, (4, 4, 0), 0.5)),
}
"""The multipliers of each family of rows as Yosys uses them; ``XILINX`` elsewhere."""


def product_multipliers(factors: Factors, family: str) -> float:
    """Multipliers of a product in a family of rows.

    >>> [product_multipliers((bits, bits), "xc3se") for bits in (18, 19, 35, 37, 39, 51)]
    [1, 3, 4, 8, 9, 9]
    >>> [product_multipliers((bits, bits), "gowin") for bits in (18, 19, 35, 39, 42)]
    [1, 1, 4, 4, 8.5]
    """
    return _cut(max(factors), min(factors), BLOCKS.get(family, XILINX))[0]


def adder_bits(factors: Factors, family: str) -> int:
    """Bits of the adders between the multipliers of a product, and of those that form short digits of LUTs.

    >>> adder_bits((18, 18), "xc3se"), adder_bits((24, 24), "xc3se"), adder_bits((24, 24), "gowin")
    (0, 70, 0)
    """
    return _cut(max(factors), min(factors), BLOCKS.get(family, XILINX))[1]


def _cut(a: int, b: int, blocks: Sequence[Block]) -> tuple[float, int]:
    """Multipliers and bits of adders of a product of a × b bits."""
    # Schoolbook multiplication: the first factor is cut into digits, then the second.
    if not blocks:
        return 0, a * b
    block = blocks[0]
    if a < block.least[0] or b < block.least[1] or a + b < block.least[2]:
        return _cut(max(a, b), min(a, b), blocks[1:])
    for wide, other, most, first in ((a, b, block.bits[0], True), (b, a, block.bits[1], False)):
        if wide > most:
            cuts = -(-(wide - most) // block.digit)
            digits = [block.bits[1]] * cuts + [wide - cuts * block.digit]
            parts = [_cut(*((bits, other) if first else (other, bits)), blocks) for bits in digits]
            sums = sum(a + b - block.digit * place for place in range(1, cuts + 1))
            return sum(count for count, _ in parts), sums + sum(bits for _, bits in parts)
    return block.count, 0


def constant_bits(value: int) -> int:
    """Bits of a constant factor with its sign, without its trailing zeros; 0 of a power of two, which is a shift.

    >>> [constant_bits(value) for value in (121 << 12, 64, 7)]
    [8, 0, 4]
    """
    odd = value // (value & -value) if value else 1
    return 0 if odd == 1 else odd.bit_length() + 1


def wide_bits(circuit: Structure) -> int:
    """Bits of |r|², |V|² and r·V with their sign."""
    return 2 * circuit["WIDTH"] + 2 + circuit["HALF"]


def detector_products(circuit: Structure) -> list[Factors]:
    """The products that a detector forms at once: the widest one of a serial detector."""
    wide = wide_bits(circuit)
    if not circuit["PARALLEL"]:
        return [(wide, wide)]
    position = circuit["WIDTH"] + 1
    velocity = position + circuit["HALF"]
    radius = min(wide, constant_bits(circuit["RADIUS"] ** 2)) if "RADIUS" in circuit else wide
    crossed, ranged = circuit["CROSS_PRODUCT"], circuit["RANGED"]
    return [
        *[(velocity, velocity)] * 2,
        *[(position, position)] * (2 if ranged or not crossed else 0),
        *[(position, velocity)] * (2 if circuit["APPROACHING"] or not crossed else 0),
        *[(position, velocity)] * (2 if crossed else 0),
        (wide, radius),
        *[(wide, wide)] * (1 if crossed else 2),
    ]


def product_registers(circuit: Structure) -> int:
    """Flip-flops of the products of a parallel detector. Those of components have the width of their sum."""
    wide = wide_bits(circuit)
    return sum(sum(pair) if max(pair) == wide else min(sum(pair), wide) for pair in detector_products(circuit))


def update_products(circuit: Structure) -> list[Factors]:
    """The products that all update units form at once; the first serial unit has none of its own."""
    width, others = circuit["WIDTH"], circuit["UPDATE_UNITS"] - 1
    if not circuit["PARALLEL"]:
        return [(width, width)] * others
    step, half_square = (
        min(width, constant_bits(circuit[name])) if name in circuit else width for name in ("STEP", "HALF_SQUARE")
    )
    return [*[(width, step)] * (4 + 2 * others), *[(width, half_square)] * 2]


def shared_product(circuit: Structure) -> Factors:
    """The factors of the product that the first serial update unit and all modules outside the trial share."""
    return circuit["WIDTH"] + 1, circuit["WIDTH"] + 1


def multipliers(products: Iterable[Factors], family: str) -> float:
    """Multipliers of several products, each by itself."""
    return sum(product_multipliers(factors, family) for factors in products)


def adders(products: Iterable[Factors], family: str) -> int:
    """Bits of the adders of several products."""
    return sum(adder_bits(factors, family) for factors in products)
