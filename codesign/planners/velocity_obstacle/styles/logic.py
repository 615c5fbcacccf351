"""LUT and flip-flops of the circuits: lines fitted to syntheses of the RTL of this package, by family.

A circuit is given by the parameters of its Verilog, as in ``multipliers``. The rows stand in ``measured``; those of
``HELD_OUT`` enter no fit.
"""

from __future__ import annotations

from functools import cache
from math import ceil

from codesign.figures import Status
from codesign.part import Part
from codesign.planners.demand import Line
from codesign.planners.measured import Fit, ResourceRow, family_of, fit_rows, resource_rows
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.multipliers import (
    Structure,
    adders,
    detector_products,
    shared_product,
    update_products,
    wide_bits,
)

UPDATES, DETECTIONS, STATES, ARRAY, REST = (
    "pos_vel_update units",
    "coll_detect units",
    "states of the robots",
    "array of velocities",
    "selector, checks, control",
)
"""The lines of the demand that a circuit has modules for."""

HELD_OUT = {(5, 22, 0), (6, 14, 0), (8, 15, 0)}
"""Robots, width and ``CROSS_PRODUCT`` of the syntheses that no line is fitted to."""
SIMILAR = "xc3se"
"""The family that stands for one without rows: LUT of four inputs with a carry chain."""
STORE_DEPTH = 16
"""Words of a LUT used as memory: the states of 16 robots take no more LUTs than those of one."""
LEAST_STORE_DEPTH = 6
"""Words from which synthesis takes LUTs as memory in Xilinx parts of four-input LUTs; registers below. Elsewhere two
are enough."""
DIRECTION_BOUNDS = 16
"""Words of the table of bounds between directions that one LUT a bit holds."""


def held_out(circuit: Structure) -> bool:
    """Whether the fits leave a synthesis out."""
    return (
        not circuit["PARALLEL"]
        and (circuit["ROBOTS"], circuit["WIDTH"], circuit["CROSS_PRODUCT"]) in HELD_OUT
    )


@cache
def rows() -> tuple[ResourceRow, ...]:
    """The syntheses of all styles."""
    return tuple(row for style in Style for row in resource_rows("velocity_obstacle", style.value))


def family_of_rows(part: Part) -> tuple[str, bool]:
    """The family of rows that counts for a part, and whether it is the part's own."""
    return _family(part.family)


@cache
def _family(part_family: str) -> tuple[str, bool]:
    family, own = family_of(part_family)
    return (family, own) if any(row.family == family for row in rows()) else (SIMILAR, False)


def _update_terms(circuit: Structure, family: str, resource: str) -> tuple[float, ...]:
    width, others = circuit["WIDTH"], circuit["UPDATE_UNITS"] - 1
    sums = adders(update_products(circuit), family)
    if circuit["PARALLEL"]:
        return width, others * width, sums if resource == "lut4" else 1 + others
    return 1, width, others, others * width, *([sums] if resource == "lut4" else [])


def _detect_terms(circuit: Structure, family: str, resource: str) -> tuple[float, ...]:
    wide, crossed, units = wide_bits(circuit), circuit["CROSS_PRODUCT"], circuit["DETECT_UNITS"]
    products = detector_products(circuit)
    ranged, sums = circuit["RANGED"], adders(products, family)
    terms: tuple[float, ...]
    if not circuit["PARALLEL"]:
        terms = 1, wide, crossed, crossed * wide, ranged * wide, *([sums] if resource == "lut4" else [])
    elif resource == "flip_flops":
        # A register of each product. Those of components have the width of their sum.
        terms = (
            1,
            sum(bits if max(pair) == wide else min(bits, wide) for pair in products for bits in [sum(pair)]),
        )
    else:
        # Differences of the operands, sums of products and a comparison of twice the width.
        formed = 2 + (4 + circuit["APPROACHING"] + 2 * ranged if crossed else 7 + ranged)
        terms = 1, formed * wide, sums
    return tuple(units * term for term in terms)


def _state_terms(circuit: Structure, family: str, _resource: str) -> tuple[float, ...]:
    width, units, depth = circuit["WIDTH"], circuit["UPDATE_UNITS"], _rounds(circuit)
    xilinx = family.startswith("xc") and family != "xc7"
    if depth == 1 or (xilinx and depth < LEAST_STORE_DEPTH):
        # Registers, and multiplexers among them.
        return units * width * depth, units * width * (depth - 1), 0
    # Memories of the Xilinx families are a bit wide, others two of each component.
    even = width if xilinx else 2 * ceil(width / 2)
    return 0, 0, units * even * ceil(depth / STORE_DEPTH)


def _rest_terms(circuit: Structure, family: str, resource: str) -> tuple[float, ...]:
    width, units, robots = circuit["WIDTH"], circuit["UPDATE_UNITS"], circuit["ROBOTS"]
    detectors = circuit["DETECT_UNITS"]
    keeps = _rounds(circuit) > 1
    # Detectors that take several robots choose among the update units.
    chosen = max(0, min(detectors, robots - 1 - detectors)) * (units - 1)
    if resource == "flip_flops":
        return 1, width, keeps * width, units, detectors
    bounds = max(1, 2 ** circuit["HALVINGS"] // DIRECTION_BOUNDS) - 1
    return (
        1,
        width,
        adders([shared_product(circuit)], family),
        units + detectors,
        chosen * width,
        circuit["HALF"] * width,
        (1 - circuit["PARALLEL"]) * width,
        bounds * width,
    )


def _rounds(circuit: Structure) -> int:
    """Robots of the first update unit."""
    return -(-circuit["ROBOTS"] // circuit["UPDATE_UNITS"])


TERMS = {UPDATES: _update_terms, DETECTIONS: _detect_terms, STATES: _state_terms, REST: _rest_terms}
"""The variables of each line."""


@cache
def line(family: str, piece: str, resource: str, parallel: int) -> Fit:
    """The law of a piece and a resource in a family of rows; units that are serial and parallel have their own."""
    by_unit = piece in (UPDATES, DETECTIONS)
    taken = [row for row in rows() if not by_unit or row.variables["PARALLEL"] == parallel]
    return fit_rows(taken, family, piece, resource, lambda row: TERMS[piece](row, family, resource), held_out)


def counted(piece: str, resource: str, circuit: Structure, part: Part) -> Line:
    """LUT or flip-flops of a piece."""
    family, own = family_of_rows(part)
    law = line(family, piece, resource, circuit["PARALLEL"])
    amount = max(0, round(law.value(TERMS[piece](circuit, family, resource))))
    off = f"{law.mean:.1%} off on circuits held out" if law.held_out else f"{law.mean:.1%} off"
    source = f"synthesis of the RTL of this package for {family}; {off}"
    # Rows of parallel units are few: the LUT of their update units miss by up to a fifth.
    known = own and not (circuit["PARALLEL"] and piece == UPDATES)
    status = Status.CALIBRATED if known else Status.ASSUMED
    return Line.item(piece, resource, amount, status, source, law.ends(amount, own))
