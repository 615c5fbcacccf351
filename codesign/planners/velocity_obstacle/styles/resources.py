"""The demand of the circuits: items by unit, as functions of style, number of robots and width.

Units
    An earlier synthesis at 16 bits, not of the RTL of this package (LUT4, flip-flops): one unit of a module with one
    multiplier (serial) or one for each product (parallel). LUTs and flip-flops at other widths in proportion: assumed.

Rest
    Selector, checks, PID control, state of the robots, control. The rest is Table I less the units with 2 robots. So
    the law meets that table by construction, within the half percent of its rounding: 47 LUTs.
    It does not grow with the number of robots ("all other parts [...] require [...] same amount of resources
    irrespective of number of robots", section V). A circuit with more than one unit of a kind needs all states at
    once, so it is given the rest of the hybrid style.

    The units explain little of the table: the second update unit of the hybrid style should cost 122 LUTs
    and costs 2,700. Two more such steps would not fit the part with 4 robots, but that design ran. So the
    difference belongs to the style, once, and not to the unit.

Multipliers
    A product takes a multiplier of 18 × 18 bits for each pair of digits of 17 bits. Where two last digits are short,
    synthesis multiplies them in LUTs. The widest factors of a detector, |r|², |V|² and r·V, have 2w + 2 bits with their
    sign, one more with ``half``: 4 multipliers at 16 bits, 8 at 17, 9 at 24. The laws equal the rows of
    ``measured``, which count the RTL of this package. Target check, selector, acceleration check and PID control
    share one product of w + 1 bits. Of the update units only the first takes an acceleration.

Slices
    The mapper packs unrelated logic into one slice only when the part gets full (at 97 %: Xilinx answer record
    2666). Up to there slices are LUT/2 times a ratio that Table I gives for each style. Then they stay at 97 %
    until all slices are packed, LUT/2. So a hybrid design for 4 robots fits. At the ratio of 2 robots it would
    miss by 39 slices. The design ran, and the rule was chosen knowing that: the row is not held out.
"""

from __future__ import annotations

import math

from codesign.figures import Status
from codesign.part import Part
from codesign.planners.demand import Line
from codesign.planners.velocity_obstacle import published
from codesign.planners.velocity_obstacle.plan.parameters import (
    AvoidParameters,
    Detection,
    Detector,
    Responsibility,
    Unit,
)
from codesign.planners.velocity_obstacle.published import FAMILY, PAPER, Style
from codesign.planners.velocity_obstacle.styles.schedule import DETECT, UPDATE, Units, products

UPDATES, DETECTIONS, STATES, ARRAY, REST = (
    "pos_vel_update units",
    "coll_detect units",
    "states of the robots",
    "array of velocities",
    "selector, checks, control",
)
"""The lines of the demand."""

UNIT_WIDTH = 16
MEASURED: dict[tuple[str, Unit], tuple[int, int]] = {
    (UPDATE, Unit.SERIAL): (122, 100),
    (UPDATE, Unit.PARALLEL): (96, 304),
    (DETECT, Unit.SERIAL): (779, 180),
    (DETECT, Unit.PARALLEL): (675, 382),
}
"""LUT4 and flip-flops of one unit at 16 bits, by an earlier synthesis."""
DIGIT_BITS, LEAST_PRODUCT_BITS = 17, 9
"""Bits of a factor that a multiplier of 18 × 18 bits takes beside its sign; products below these bits take LUTs."""
STORE_DEPTH = 16
"""Words of a LUT used as memory: the states of 16 robots take no more LUTs than those of one."""
STATE_COMPONENTS = 4
FULL = 0.97

SYNTHESIS = "an earlier synthesis at 16 bits, not of the RTL of this package"


def default_units(style: Style, robots: int) -> Units:
    """The units of a style as published (figures 2 to 4)."""
    if style is Style.SEQUENTIAL:
        return Units(1, 1, shared=True)
    if style is Style.PIPELINED:
        return Units(1, 1)
    return Units(robots, robots - 1)


def units_of(style: Style, robots: int, parameters: AvoidParameters) -> Units:
    """The units of a circuit, at most as many as its tasks. A sequential circuit has one of each in turn."""
    usual = default_units(style, robots)
    if usual.shared:
        return usual
    return Units(
        min(parameters.update_units or usual.update, robots),
        min(parameters.detect_units or usual.detect, robots - 1),
    )


def rest_style(style: Style, units: Units) -> Style:
    """The style that gives a circuit its rest: hybrid if units of a kind work side by side."""
    return Style.HYBRID if max(units.update, units.detect) > 1 else min(style, Style.PIPELINED, key=_order)


def _order(style: Style) -> int:
    return list(Style).index(style)


def unit_lut4(module: str, unit: Unit, width: int) -> int:
    """LUT4 of one unit."""
    return math.ceil(MEASURED[module, unit][0] * width / UNIT_WIDTH)


def unit_flip_flops(module: str, unit: Unit, width: int) -> int:
    """Flip-flops of one unit."""
    return math.ceil(MEASURED[module, unit][1] * width / UNIT_WIDTH)


def rest_lut4(style: Style) -> float:
    """LUT4 of all but the units: Table I less the units of 2 robots."""
    # rest = Table I - (updates · LUT of an update + detections · LUT of a detection), for 2 robots at 16 bits.
    units = default_units(style, 2)
    listed = published.TABLE_I[style][1] / 100.0 * published.LUT4_OF_PART
    return listed - sum(
        count * MEASURED[module, Unit.SERIAL][0]
        for module, count in ((UPDATE, units.update), (DETECT, units.detect))
    )


def slice_ratio(style: Style) -> float:
    """Slices over LUT/2 of Table I."""
    # A slice has two LUTs: slices = ratio · LUT / 2, both of them given in percent of the part.
    slices, luts, _ = published.TABLE_I[style]
    return 2.0 * slices * published.SLICES_OF_PART / (luts * published.LUT4_OF_PART)


def slices_of(style: Style, lut4: int, budget: int) -> int:
    """Slices of a design on a part with ``budget`` of them."""
    # slices
    #   97 % |     _______/       ratio · LUT / 2 up to 97 % of the part; then flat, as unrelated logic is packed
    #        |    /               together; then LUT / 2, with every slice full
    #        |   /
    #        +--------------- LUT
    related = math.ceil(slice_ratio(style) * lut4 / 2.0)
    full = math.floor(FULL * budget)
    return related if related <= full else max(full, math.ceil(lut4 / 2))


def digits(bits: int) -> list[int]:
    """The bits of the digits that a number of ``bits`` bits, sign included, is multiplied in, the last with its sign.

    >>> digits(18), digits(35), digits(37)
    ([18], [17, 18], [17, 17, 3])
    """
    return [bits] if bits <= DIGIT_BITS + 1 else [DIGIT_BITS, *digits(bits - DIGIT_BITS)]


def product_multipliers(a: int, b: int) -> int:
    """18 × 18 multipliers of a product of two numbers of a and b bits, signs included.

    >>> [product_multipliers(bits, bits) for bits in (18, 19, 35, 37, 39, 51)]
    [1, 3, 4, 8, 9, 9]
    """
    # Schoolbook multiplication in digits of 17 bits. Synthesis forms a product of two short last digits of LUTs.
    return sum(first + second >= LEAST_PRODUCT_BITS for first in digits(a) for second in digits(b))


def factor_bits(parameters: AvoidParameters) -> dict[str, int]:
    """Bits of each factor of a detector's products, signs left out.

    Speeds are bounded as vectors. So a relative velocity is below 2^w as a vector where the others are passive, and
    below 2^(w + 1) where it is 2v' - v - v2.
    """
    width, half = parameters.width, parameters.responsibility is Responsibility.HALF
    velocity = width + half
    # A sum of two products takes a bit more than one of them: |r|² = x² + y², r·V = x vx + y vy, r × V = x vy - y vx.
    return {
        **dict.fromkeys(("rx", "ry"), width),
        **dict.fromkeys(("vx", "vy"), velocity),
        **dict.fromkeys(("dotp", "cross"), width + velocity + 1),
        "r_sq": 2 * width + 1,
        "vab_sq": 2 * width + 1 + half,
        "R_sq": 2 * width,
    }


def unit_multipliers(module: str, parameters: AvoidParameters) -> int:
    """Multipliers of one unit: of its widest product where it is serial, of all of them where it is parallel."""
    approaching, ranged = parameters.detection is Detection.APPROACHING, parameters.range is not None
    width, half = parameters.width, parameters.responsibility is Responsibility.HALF
    # |r|², |V|² and r·V have words of one width in the circuit, 2w + 1 bits and their sign, one more with ``half``.
    words = {**dict.fromkeys(("rx", "ry"), width + 1), **dict.fromkeys(("vx", "vy"), width + 1 + half)}
    wide = width if module == UPDATE else 2 * width + 2 + half
    counts = [
        product_multipliers(
            *(words.get(factor, wide) if module == DETECT else wide for factor in name.split())
        )
        for name, _ in products(module, parameters.detector, approaching, ranged)
    ]
    return max(counts) if parameters.unit is Unit.SERIAL else sum(counts)


def update_multipliers(count: int, parameters: AvoidParameters) -> int:
    """Multipliers of ``count`` update units. Only the first takes an acceleration; the others form v t alone."""
    first = unit_multipliers(UPDATE, parameters)
    others = first if parameters.unit is Unit.SERIAL else first // 3
    return first + (count - 1) * others


def rest_multipliers(width: int) -> int:
    """Multipliers of the one product that target check, selector, acceleration check and PID control share."""
    return product_multipliers(width + 1, width + 1)


def array_rams(parameters: AvoidParameters, part: Part) -> tuple[int, int]:
    """Block RAMs of the array of velocities, x and y side by side, and the depth that one of them has."""
    # The widest shape of block RAM that is deep enough for a velocity a word.
    words = parameters.speeds * parameters.directions
    shapes = [shape for shape in part.block_ram_shapes if shape[0] >= words] or [max(part.block_ram_shapes)]
    depth, width = max(shapes, key=lambda shape: shape[1])
    return 2 * -(-parameters.width // width), depth


def ram_width(words: int) -> int:
    """Bits of a word of the block RAM that is deep enough for ``words``.

    Virtex and Spartan-3 parts have the same shapes, of 18 kbit: 1 bit at 16,384 words, 18 at 1,024. Parity bits serve
    words of 9 bits and more.

    >>> [ram_width(words) for words in (640, 1024, 1025, 5120, 32_768)]
    [18, 18, 9, 2, 1]
    """
    shapes = ((512, 36), (1024, 18), (2048, 9), (4096, 4), (8192, 2))
    return next((width for depth, width in shapes if words <= depth), 1)


def items(style: Style, robots: int, parameters: AvoidParameters, part: Part) -> tuple[Line, ...]:
    """All lines of the demand."""
    units = units_of(style, robots, parameters)
    rest = rest_style(style, units)
    lines: list[Line] = []
    for module, count in ((UPDATE, units.update), (DETECT, units.detect)):
        lines += _unit_items(module, count, parameters, part)
    if parameters.range is not None:
        text = "a LUT for each bit of |r|², beside the detector's own comparison"
        amount = units.detect * factor_bits(parameters)["r_sq"]
        lines.append(Line.item(f"{units.detect} × range", "lut4", amount, Status.ASSUMED, text))
    lines += _rest_items(rest, robots, parameters, part)
    rams, _ = array_rams(parameters, part)
    lines.append(
        Line.item(
            "array of velocities",
            "block_rams",
            rams,
            Status.ASSUMED,
            "x and y of each velocity in a word each",
        )
    )
    lut4 = sum(item.amount for item in lines if item.resource == "lut4")
    budget = int(part.resources["slices"].value) if "slices" in part.resources else lut4
    source = (
        f"LUT/2 × {slice_ratio(rest):.3f} (Table I, 2 robots, {rest}); from {FULL:.0%} of the part on, unrelated"
        " logic is packed together (Xilinx answer record 2666)"
    )
    lines.append(Line.item("slices", "slices", slices_of(rest, lut4, budget), Status.CALIBRATED, source))
    return tuple(lines)


def _multiplier_law(part: Part) -> tuple[Status, str]:
    """Status and source of a count of multipliers."""
    law = "a multiplier for each product of digits of 17 bits, but of LUTs where both are short"
    if part.family == FAMILY:
        return Status.MEASURED, f"{law}; RTL of this package, Yosys"
    return Status.ASSUMED, f"{law}; as counted for {FAMILY}"


def _unit_items(module: str, count: int, parameters: AvoidParameters, part: Part) -> list[Line]:
    name = f"{count} × {module}"
    as_measured = parameters.width == UNIT_WIDTH and parameters.detector is Detector.PUBLISHED
    status = Status.CALIBRATED if as_measured else Status.ASSUMED
    source = (
        SYNTHESIS if as_measured else f"{SYNTHESIS}; in proportion to the width, the same for either detector"
    )
    multipliers = (
        update_multipliers(count, parameters)
        if module == UPDATE
        else count * unit_multipliers(module, parameters)
    )
    unit, width = parameters.unit, parameters.width
    return [
        Line.item(name, "lut4", count * unit_lut4(module, unit, width), status, source),
        Line.item(name, "flip_flops", count * unit_flip_flops(module, unit, width), status, source),
        Line.item(name, "multipliers", multipliers, *_multiplier_law(part)),
    ]


def _rest_items(rest: Style, robots: int, parameters: AvoidParameters, part: Part) -> list[Line]:
    name = "selector, checks, control, states"
    listed = published.TABLE_I[rest][1]
    law = f"{listed} % of {published.LUT4_OF_PART:,} LUTs ({PAPER}, Table I, {rest}) less its units"
    lut4 = round(rest_lut4(rest))
    lines = [
        Line.item(name, "lut4", lut4, Status.CALIBRATED, law),
        Line.item(
            name, "flip_flops", lut4, Status.ASSUMED, "one for each LUT of the rest; nothing is published"
        ),
        Line.item(name, "multipliers", rest_multipliers(parameters.width), *_multiplier_law(part)),
    ]
    stores = -(-robots // STORE_DEPTH) - 1
    if stores:
        amount = stores * 2 * STATE_COMPONENTS * parameters.width
        text = "two LUTs for each bit of the states of 16 robots more, as dual-port memory"
        lines.append(
            Line.item(f"states of robots beyond {STORE_DEPTH}", "lut4", amount, Status.ASSUMED, text)
        )
    return lines
