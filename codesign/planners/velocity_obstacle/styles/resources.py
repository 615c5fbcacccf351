"""The demand of the circuits: lines by unit, as functions of style, number of robots, width and options.

Units, states and rest
    Multipliers, LUTs and flip-flops follow from the RTL of this package: ``multipliers``, and
    ``planners/velocity_obstacle/measured/laws.yaml``.

Table I
    On the paper's family, Spartan-3E, a line of its own has the LUTs of Table I that the RTL of this package does not
    take: the table less the circuit of 2 robots at 16 bits. So the demand meets that table by construction, within the
    half percent of its rounding: 47 LUTs. The line does not grow with the number of robots ("all other parts [...]
    require [...] same amount of resources irrespective of number of robots", section V). A circuit with more than one
    unit of a kind needs all states at once, so it is given the line of the hybrid style.

    The units explain little of the table: the second update unit of the hybrid style takes about a hundred LUTs
    and costs 2,700. Two more such steps would not fit the part with 4 robots, but that design ran. So the
    difference belongs to the style, once, and not to the unit.

Slices
    The mapper packs unrelated logic into one slice only when the part gets full (at 97 %: Xilinx answer record
    2666). Up to there slices are LUT/2 times a ratio that Table I gives for each style. Then they stay at 97 %
    until all slices are packed, LUT/2. So a hybrid design for 4 robots fits. The rule was chosen knowing that: the row
    is not held out.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from codesign.ground.figures import Status
from codesign.ground.models import Part
from codesign.planners.counted import CountedLaws
from codesign.planners.job import Line
from codesign.planners.velocity_obstacle import published
from codesign.planners.velocity_obstacle.plan.parameters import (
    AvoidParameters,
    Detection,
    Detector,
    Responsibility,
    Unit,
)
from codesign.planners.velocity_obstacle.published import FAMILY, PAPER, Style

# Cycles of a circuit from its units and the dependencies of its tasks: list scheduling, twice.
#
# A *unit* (``pos_vel_update``, ``coll_detect``) is scheduled over its multipliers: its products in the order of their
# dependencies, one cycle each, and one more cycle that sums up or compares. A *trial* is scheduled over its units: n
# updates, and n - 1 detections that each need the update of robot 1 and of one other.
#
# The task that heads the longest chain of remaining work is first; ties keep the order of the list. The schedules give
# Table II, and the cycles of circuits that the paper did not build.


@dataclass(frozen=True)
class Task:
    """A piece of work: ``cycles`` on one unit of kind ``unit``, once all of ``after`` (places in the list) are done."""

    name: str
    unit: str
    cycles: int
    after: tuple[int, ...] = ()


@dataclass(frozen=True)
class Slot:
    """The begin of a task, in cycles from 0, and its unit among the units of its kind, from 0."""

    task: Task
    begin: int
    unit: int

    @property
    def end(self) -> int:
        """The cycle after the last."""
        return self.begin + self.task.cycles


def schedule(tasks: Sequence[Task], units: Mapping[str, int]) -> tuple[Slot, ...]:
    """A list schedule of ``tasks``, each after those that stand before it in the list, in the order of the list.

    Never shorter than the longest chain, nor than the work of one kind over its units.
    """
    waiting = [len(task.after) for task in tasks]
    followers: list[list[int]] = [[] for _ in tasks]
    for index, task in enumerate(tasks):
        for earlier in task.after:
            followers[earlier].append(index)
    # urgency(i) = cycles(i) + the largest urgency of what waits for i, from the end of the list back.
    urgency = [0] * len(tasks)
    for index in range(len(tasks) - 1, -1, -1):
        behind = max((urgency[follower] for follower in followers[index]), default=0)
        urgency[index] = tasks[index].cycles + behind
    ready: dict[str, list[tuple[int, int]]] = {kind: [] for kind in units}
    free: dict[str, list[int]] = {kind: list(range(count)) for kind, count in units.items()}
    for index, task in enumerate(tasks):
        if not waiting[index]:
            heapq.heappush(ready[task.unit], (-urgency[index], index))
    running: list[tuple[int, int, int]] = []
    slots: dict[int, Slot] = {}
    # The clock moves from one end of a task to the next: no task can begin in between.
    now = 0
    while len(slots) < len(tasks) or running:
        for kind, queue in ready.items():
            while queue and free[kind]:
                _, index = heapq.heappop(queue)
                slot = Slot(tasks[index], now, heapq.heappop(free[kind]))
                slots[index] = slot
                heapq.heappush(running, (slot.end, index, slot.unit))
        now = running[0][0]
        while running and running[0][0] == now:
            _, index, unit = heapq.heappop(running)
            heapq.heappush(free[tasks[index].unit], unit)
            for follower in followers[index]:
                waiting[follower] -= 1
                if not waiting[follower]:
                    heapq.heappush(ready[tasks[follower].unit], (-urgency[follower], follower))
    return tuple(slots[index] for index in range(len(tasks)))


def makespan(slots: Sequence[Slot]) -> int:
    """Cycles from the first begin to the last end."""
    return max((slot.end for slot in slots), default=0)


UPDATE, DETECT = "pos_vel_update", "coll_detect"
DATAPATH = "datapath"
"""The one unit of the sequential style: it does either module's work, never both at once."""

MULTIPLIER, SUM = "multiplier", "sum"

PRODUCTS: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    # Equations 2a and 2b in x and y: three products an axis.
    UPDATE: tuple((name, ()) for axis in "xy" for name in (f"v{axis} t", f"a{axis} t", f"a{axis} t²/2")),
    # |r|²|V|² - (r·V)² ≥ R²|V|² (equation 4): six products of components, three of what they add up to.
    Detector.PUBLISHED: (
        *((name, ()) for name in ("rx rx", "ry ry", "vx vx", "vy vy", "rx vx", "ry vy")),
        ("r_sq vab_sq", ("rx rx", "ry ry", "vx vx", "vy vy")),
        ("dotp dotp", ("rx vx", "ry vy")),
        ("R_sq vab_sq", ("vx vx", "vy vy")),
    ),
    # (r × V)² ≥ R²|V|²: four products of components, two of what they add up to.
    Detector.CROSS_PRODUCT: (
        *((name, ()) for name in ("vx vx", "vy vy", "rx vy", "ry vx")),
        ("cross cross", ("rx vy", "ry vx")),
        ("R_sq vab_sq", ("vx vx", "vy vy")),
    ),
}
"""Products of each module, named by their factors, with the products that they need (equations 2a, 2b and 4).

``cross_product``: |r|²|V|² - (r·V)² = (r × V)² (Lagrange), the same answer with three products less. Where the
sign of r·V is needed as well (``detection: approaching``), its two products are formed in addition: eight in all. So
are the two of |r|², where it is compared with a ``range``. The published detector has them.
"""

APPROACHING_PRODUCTS = (("rx vx", ()), ("ry vy", ()))
RANGE_PRODUCTS = (("rx rx", ()), ("ry ry", ()))


def products(
    module: str, detector: Detector = Detector.PUBLISHED, approaching: bool = False, ranged: bool = False
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The products that a module forms, each with the products that it needs."""
    listed = PRODUCTS[UPDATE if module == UPDATE else detector]
    if module == UPDATE or detector is Detector.PUBLISHED:
        return listed
    return (*(APPROACHING_PRODUCTS if approaching else ()), *(RANGE_PRODUCTS if ranged else ()), *listed)


@cache
def module_cycles(
    module: str, unit: Unit, detector: Detector = Detector.PUBLISHED, approaching: bool = False, ranged: bool = False
) -> int:
    """Cycles of one run of a module: its products over its multipliers, and one to sum up or compare.

    >>> module_cycles(UPDATE, Unit.SERIAL), module_cycles(DETECT, Unit.SERIAL)
    (7, 10)
    """
    listed = products(module, detector, approaching, ranged)
    place = {name: index for index, (name, _) in enumerate(listed)}
    tasks = [Task(name, MULTIPLIER, 1, tuple(place[earlier] for earlier in needs)) for name, needs in listed]
    tasks.append(Task("compare", SUM, 1, tuple(range(len(tasks)))))
    return makespan(schedule(tasks, {MULTIPLIER: 1 if unit is Unit.SERIAL else len(listed), SUM: 1}))


@dataclass(frozen=True)
class Units:
    """The units of a circuit: how many update, how many detect; ``shared``: one datapath does both in turn."""

    update: int
    detect: int
    shared: bool = False


def trial_schedule(robots: int, units: Units, update_cycles: int, detect_cycles: int) -> tuple[Slot, ...]:
    """One candidate held against all others: n updates, n - 1 detections (figures 2 to 4).

    >>> makespan(trial_schedule(8, Units(1, 1, shared=True), 7, 10)), 17 * 8 - 10
    (126, 126)
    >>> makespan(trial_schedule(8, Units(1, 1), 7, 10)), 10 * 8 + 4
    (84, 84)
    >>> makespan(trial_schedule(8, Units(8, 7), 7, 10))
    17
    """
    # U: pos_vel_update, 7 cycles; D: coll_detect, 10 cycles; n robots.
    #
    # figure 2, sequential   U1 U2 D2 U3 D3 ..          one datapath          7n + 10(n - 1) = 17n - 10
    # figure 3, pipelined    U1 U2 U3 ..                one unit of a kind
    #                              D2 D3 ..                                   14 + 10(n - 1) = 10n + 4
    # figure 4, hybrid       U1 .. Un at once
    #                              D2 .. Dn at once     n and n - 1 units     7 + 10 = 17
    update, detect = (DATAPATH, DATAPATH) if units.shared else (UPDATE, DETECT)
    tasks = [Task(f"{UPDATE} 1", update, update_cycles)]
    for robot in range(2, robots + 1):
        tasks.append(Task(f"{UPDATE} {robot}", update, update_cycles))
        tasks.append(Task(f"{DETECT} {robot}", detect, detect_cycles, (0, len(tasks) - 1)))
    counts = {DATAPATH: 1} if units.shared else {UPDATE: units.update, DETECT: units.detect}
    return schedule(tasks, counts)


@cache
def trial_cycles(robots: int, units: Units, update_cycles: int, detect_cycles: int) -> int:
    """Cycles of one trial: the length of its schedule."""
    return makespan(trial_schedule(robots, units, update_cycles, detect_cycles))


# Multipliers of the circuits as synthesis counts them: a wide product takes several, and adders between them.

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


UPDATES, DETECTIONS, STATES, ARRAY, REST = (
    "pos_vel_update units",
    "coll_detect units",
    "states of the robots",
    "array of velocities",
    "selector, checks, control",
)
"""The lines of the demand that a circuit has modules for."""

LAWS = CountedLaws(
    "velocity_obstacle",
    "circuit",
    {
        each.__name__: each
        for each in (adders, detector_products, product_registers, shared_product, update_products, wide_bits)
    },
)
"""LUT and flip-flops of the circuits, which are given by the parameters of their Verilog, as in ``multipliers``."""

TABLE_I = "Table I beyond the RTL of this package"
"""The line of the demand that no module stands for."""
PUBLISHED_ROBOTS = 2
FULL = 0.97


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
        min(parameters.update_units or usual.update, robots), min(parameters.detect_units or usual.detect, robots - 1)
    )


def rest_style(style: Style, units: Units) -> Style:
    """The style that gives a circuit its rest: hybrid if units of a kind work side by side."""
    return Style.HYBRID if max(units.update, units.detect) > 1 else min(style, Style.PIPELINED, key=_order)


def _order(style: Style) -> int:
    return list(Style).index(style)


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


def structure(style: Style, robots: int, parameters: AvoidParameters) -> dict[str, int]:
    """The parameters of the Verilog that say which units there are and what they form."""
    units = units_of(style, robots, parameters)
    return {
        "WIDTH": parameters.width,
        "ROBOTS": robots,
        "UPDATE_UNITS": units.update,
        "DETECT_UNITS": units.detect,
        "IN_TURN": int(units.shared),
        "PARALLEL": int(parameters.unit is Unit.PARALLEL),
        "CROSS_PRODUCT": int(parameters.detector is Detector.CROSS_PRODUCT),
        "APPROACHING": int(parameters.detection is Detection.APPROACHING),
        "RANGED": int(parameters.range is not None),
        "HALF": int(parameters.responsibility is Responsibility.HALF),
        "DIRECTIONS": parameters.directions,
        "SPEEDS": parameters.speeds,
        "TURNS": parameters.turns,
        "HALVINGS": halvings(parameters),
    }


def halvings(parameters: AvoidParameters) -> int:
    """The number of times that the selector halves an octant: directions // 8 bounds part it into as many and one."""
    return math.ceil(math.log2(parameters.directions // 8 + 1))


def items(
    style: Style, robots: int, parameters: AvoidParameters, part: Part, constants: Mapping[str, int] | None = None
) -> tuple[Line, ...]:
    """All lines of the demand.

    ``constants``: the constant factors, as ``multipliers`` has them; without them a line is for the largest.
    """
    circuit = {**structure(style, robots, parameters), **(constants or {})}
    rest = rest_style(style, units_of(style, robots, parameters))
    lines = list(_circuit_items(circuit, part))
    rams, _ = array_rams(parameters, part)
    text = "x and y of each velocity in a word each, as synthesis counts the RTL of this package"
    lines.append(Line.item(ARRAY, "block_rams", rams, Status.MEASURED, text))
    if part.family == FAMILY:
        listed = published.TABLE_I[rest][1]
        text = f"{listed} % of {published.LUT4_OF_PART:,} LUTs ({PAPER}, Table I, {rest}) less the RTL of this package"
        lines.append(Line.item(TABLE_I, "lut4", beyond_lut4(rest, part), Status.CALIBRATED, text))
    lut4 = sum(item.amount for item in lines if item.resource == "lut4")
    low, high = (sum(item.figure.interval[end] for item in lines if item.resource == "lut4") for end in (0, 1))
    budget = int(part.resources["slices"].value) if "slices" in part.resources else lut4
    source = (
        f"LUT/2 × {slice_ratio(rest):.3f} (Table I, 2 robots, {rest}); from {FULL:.0%} of the part on, unrelated"
        " logic is packed together (Xilinx answer record 2666)"
    )
    status = Status.CALIBRATED if part.family == FAMILY else Status.ASSUMED
    slices, *ends = (slices_of(rest, int(count), budget) for count in (lut4, low, high))
    lines.append(Line.item("slices", "slices", slices, status, source, (ends[0], ends[1])))
    return tuple(lines)


def _circuit_items(circuit: Mapping[str, int], part: Part) -> list[Line]:
    """The lines of the RTL of this package but for its memory."""
    family, own = LAWS.family(part.family)
    status = Status.MEASURED if own else Status.ASSUMED
    text = f"products cut into the digits of a multiplier; as synthesis counts the RTL of this package for {family}"
    formed = {
        UPDATES: multipliers(update_products(circuit), family),
        DETECTIONS: circuit["DETECT_UNITS"] * multipliers(detector_products(circuit), family),
        REST: multipliers([shared_product(circuit)], family),
    }
    lines = []
    for piece, logic in LAWS.lines(circuit, (family, own)).items():
        lines += [line for line in logic if line.amount]
        if formed.get(piece):
            lines.append(Line.item(piece, "multipliers", math.ceil(formed[piece]), status, text))
    return lines


def beyond_lut4(style: Style, part: Part) -> int:
    """LUT4 of Table I that the RTL of this package does not take with 2 robots at 16 bits."""
    listed = published.TABLE_I[style][1] / 100.0 * published.LUT4_OF_PART
    circuit = structure(style, PUBLISHED_ROBOTS, AvoidParameters())
    lines = _circuit_items(circuit, part)
    return round(listed) - sum(each.amount for each in lines if each.resource == "lut4")
