"""Cycles and clock of the bit-serial circuit.

Cycles
    All are counted in the RTL of this package (``rtl``), and ``hwsw verify`` holds them against it edge by edge.

    An iteration takes p + 2 (section 5.4) for any block: the bits pass serially, and the write address
    follows behind the read address. The same pass finds the local maxima, least significant bit first.

    The paper counts nothing else. The OR trees over the block answer during the next pass whether an iteration changed
    a bit. A visit of I iterations does not wait for the answer: the next block begins at once. A visit that ends
    early, with an iteration that changed nothing, has begun another pass, and drops it: ``dropped_pass_cycles``. With
    one block that pass is the first iteration of the next visit, and is dropped only where the stage ends.

    With digits of d bits a cycle, the ⌈p/d⌉ digits of p bits take ⌈p/d⌉ + 2 cycles. A node divides by 4 within one
    digit and the next, and still reads the flags of the next pass in a cycle of their own.

    Raising the precision moves no data: words are addressed from their most significant bit, and the bits
    below have been zero since the memory was cleared.

Clock
    The period grows with the block. There are only three published clocks, on two parts in two speed grades. They fix a
    line over the fourth root of N, the form with the smallest residuals among log N, N^(1/4) and N^(1/2). That is an
    interpolation, chosen after seeing the points. One published clock is held out, the estimate of 150 MHz for the
    36×66 block. The interval of the law is twice its error there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache

from codesign.ground.figures import Figure, Status, weakest
from codesign.ground.models import Part
from codesign.planners.clock_law import Placement, Registers, on_family
from codesign.planners.harmonic import published
from codesign.planners.harmonic.styles.resources import digits, field_plane, tree_widths, words
from codesign.planners.measured import clock_rows

PREPARATION_CYCLES = 3
"""Cycles before the first slot of a read-out or a decision: block, address, and the slot in which flags are read."""

READ_OUT_BITS = 64
"""The most bits of a row of nodes that one cycle of the read-out shows."""

FORMS: dict[str, Callable[[float], float]] = {
    "log2 N": math.log2,
    "N^(1/4)": lambda nodes: nodes**0.25,
    "N^(1/2)": math.sqrt,
}
"""The forms that were tried for the growth of the clock period."""


def iteration_cycles(precision: int, digit_bits: int = 1) -> int:
    """Clock cycles of one iteration at ``precision`` bits: p + 2 (section 5.4); ⌈p/d⌉ + 2 with digits of d bits.

    >>> [iteration_cycles(63, digit_bits) for digit_bits in (1, 2, 4, 8)]
    [65, 34, 18, 10]
    """
    # cycle     0    1    2    3   ..   p - 1   p         p + 1
    # reads     b_0  b_1  b_2  b_3 ..   b_p-1                       bit i of the four neighbours, lowest first
    # sum       s_0  s_1  s_2  s_3 ..   s_p-1   s_p       s_p+1     two bits longer than its terms
    # writes              h_0  h_1 ..   h_p-3   h_p-2     h_p-1     h_i = s_i+2: the division by 4 is the delay
    # Digits of d bits: digit j of the result is bits 2 and up of s_j, and bits 0 and 1 of s_j+1 above them.
    return digits(precision, digit_bits) + 2


def or_tree_stages(rows: int, columns: int, pipeline: int = 0) -> int:
    """Pipeline stages of the OR trees over a block.

    >>> or_tree_stages(6, 12), or_tree_stages(48, 96), or_tree_stages(6, 12, 1), or_tree_stages(48, 96, 1)
    (1, 2, 2, 3)
    """
    return 1 + pipeline + len(tree_widths(rows, columns, pipeline))


def stream_delay(pipeline: int) -> int:
    """Cycles from the read address of a bit to the bit on the streams: the registers of memory and stream."""
    return 1 + 2 * pipeline


def answer_cycles(rows: int, columns: int, pipeline: int = 0) -> int:
    """Cycles from the end of the read addresses of a pass to the answer of the OR trees."""
    # Without a pipeline the answer is used in the cycle in which the last stage computes it.
    return stream_delay(pipeline) + or_tree_stages(rows, columns, pipeline) + pipeline


def dropped_pass_cycles(rows: int, columns: int, pipeline: int = 0) -> int:
    """Cycles of a pass that has begun in vain: S + 2 with S stages of the OR tree; with a pipeline S + 5.

    >>> dropped_pass_cycles(6, 12), dropped_pass_cycles(48, 96), dropped_pass_cycles(6, 12, 1)
    (3, 4, 7)
    """
    return answer_cycles(rows, columns, pipeline) + 1


def least_precision(rows: int, columns: int, pipeline: int = 0, digit_bits: int = 1) -> int:
    """The least bits of a stage: the answer for a pass comes before the next one ends.

    >>> least_precision(6, 12), least_precision(6, 12, 0, 4), least_precision(6, 12, 1, 8)
    (2, 5, 41)
    """
    return digit_bits * (answer_cycles(rows, columns, pipeline) - 1) + 1


def load_cycles(memories: int, blocks: int, precision: int, digit_bits: int = 1) -> int:
    """Cycles to load a map: clear p + 1 words for each block in all RAMs at once, then two words a RAM for each block.

    The two words are the flags and the highest bits of 18 nodes. ``memories``: RAMs of clusters and borders. With
    digits of d bits they are d RAMs each, which take their words together, and ⌈p/d⌉ + 1 words are cleared.
    """
    return words(blocks, precision, digit_bits) + reload_cycles(memories, blocks)


def load_start_cycles(memories: int, blocks: int, precision: int) -> int:
    """Cycles to load a map and its start values: a word of the RAM of one cluster or border each cycle.

    Assumed: p + 1 words of every RAM for each block, one RAM after the other.
    """
    return memories * blocks * (precision + 1)


def reload_cycles(memories: int, blocks: int) -> int:
    """Cycles to load a map where the values of the last plan stay: two words a RAM for each block, nothing to clear.

    Assumed for a map that keeps old values; counted as the end of ``load_cycles``.
    """
    return 2 * memories * blocks


def decision_cycles(precision: int, pipeline: int = 0, digit_bits: int = 1) -> int:
    """Cycles of one decision: p + 8, with a pipeline p + 11. One takes the position, p + 2 read the bits."""
    # With a pipeline the bits around the robot have a register between their selection and the comparisons.
    reads = iteration_cycles(precision, digit_bits)
    return 1 + PREPARATION_CYCLES + reads + stream_delay(pipeline) + pipeline + 1


def lone_decision_cycles(precision: int) -> int:
    """Cycles of one decision of the module by itself: p + 7. One takes the position, p + 2 read the bits."""
    # The registers: the position and addresses, the memory and its output, the five bits, the result.
    return 1 + precision + 2 + 4


def field_load_cycles(shape: tuple[int, int], precision: int) -> int:
    """Cycles to load the field of a module by itself: the precision, then five columns of a row a cycle, bit by bit."""
    return 1 + field_plane(*shape) * (precision + 1)


def read_cycles(rows: int, columns: int, blocks: int, precision: int, pipeline: int = 0, digit_bits: int = 1) -> int:
    """Cycles to read the field out: the cycles of an iteration for each row of a block, or for 64 bits of it."""
    passes = read_passes(rows, columns, blocks, digit_bits)
    reads = passes * iteration_cycles(precision, digit_bits)
    return PREPARATION_CYCLES + reads + stream_delay(pipeline) + 1


def read_out_columns(digit_bits: int = 1) -> int:
    """The most nodes of a row that one cycle of the read-out shows, a digit of each."""
    return READ_OUT_BITS // digit_bits


def read_passes(rows: int, columns: int, blocks: int, digit_bits: int = 1) -> int:
    """Passes of a read-out: one for each row of each block, and for each ``read_out_columns`` of it."""
    return blocks * rows * -(-columns // read_out_columns(digit_bits))


@dataclass(frozen=True)
class ClockFit:
    """period = offset + slope × form(N), ns, by least squares over the published clocks.

    ``residuals``: ns, fitted less published, in the order of ``POINTS``.
    """

    form: str
    offset: float
    slope: float
    residuals: tuple[float, ...]

    def clock(self, nodes: int) -> float:
        """Hz for a block of ``nodes``."""
        return 1e9 / (self.offset + self.slope * FORMS[self.form](nodes))

    @property
    def residual(self) -> float:
        """Root of the mean square residual, ns."""
        return math.sqrt(sum(value**2 for value in self.residuals) / len(self.residuals))


FITTED = "Virtex-II", "Virtex-4"
"""The families of the published clocks."""

POINTS = (published.NODE, published.CLUSTER, published.BLOCK)
"""The published clocks that the law is fitted to."""


def fit_clock(form: str) -> ClockFit:
    """The least-squares line of one form."""
    grow = FORMS[form]
    # Least squares: slope = Σ (x - x̄)(y - ȳ) / Σ (x - x̄)², offset = ȳ - slope · x̄, with y the period in ns.
    x = [grow(point.nodes) for point in POINTS]
    y = [1e9 / point.clock for point in POINTS]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)) / sum((a - mean_x) ** 2 for a in x)
    offset = mean_y - slope * mean_x
    return ClockFit(form, offset, slope, tuple(offset + slope * a - b for a, b in zip(x, y, strict=True)))


@cache
def clock_fit() -> ClockFit:
    """The fit with the smallest residual."""
    return min((fit_clock(form) for form in FORMS), key=lambda fit: fit.residual)


@cache
def clock_miss() -> float:
    """Relative error of the law on the held-out clock: 150 MHz for 36×66 nodes."""
    nodes = published.WHOLE_DESIGN_ROWS * published.WHOLE_DESIGN_COLUMNS
    # Section 5.4: "an estimated clock frequency of 150 MHz". It was not measured, so it serves as the point held out.
    return clock_fit().clock(nodes) / published.ESTIMATED_CLOCK - 1


def registers(
    rows: int, columns: int, pipeline: int, digit_bits: int = 1, options: frozenset[str] = frozenset()
) -> Registers:
    """The variables of the clock of a block: its pipeline, its nodes, the bits of its digits, and its ``options``."""
    return Registers(f"relax.pipeline {pipeline}", rows * columns, math.log2(digit_bits), options)


def options(blocks: int, *, decides: bool, sound: bool) -> frozenset[str]:
    """The options of the circuit of a block: borders, no decision module, the published termination."""
    words = {"several blocks": blocks > 1, "no decision module": not decides, "published termination": not sound}
    return frozenset(word for word, present in words.items() if present)


@cache
def placements() -> tuple[Placement, ...]:
    """The blocks that were placed and routed."""
    return tuple(Placement(row, _registers_of(row.variables)) for row in clock_rows("harmonic", "bit_serial"))


def _registers_of(top: Mapping[str, int]) -> Registers:
    sound, decides = bool(top["SOUND"]), bool(top["DECISION"])
    chosen = options(top["DOWN"] * top["ACROSS"], decides=decides, sound=sound)
    return registers(top["ROWS"], top["COLUMNS"], top["PIPELINE"], top.get("DIGIT_BITS", 1), chosen)


def clock_limit(
    rows: int, columns: int, part: Part, pipeline: int = 0, digit_bits: int = 1, chosen: frozenset[str] = frozenset()
) -> Figure:
    """The fastest clock of a design on a part, Hz: the limit of its size, or of the block RAM where that is lower.

    The published law of the size is one line for all parts and grades, and for either pipeline: three points cannot
    distinguish them. On other families than theirs, blocks were placed and routed (``on_family``). ``chosen``: of
    ``options``.
    """
    # Three points leave one degree of freedom, too little for a statistical interval. So the interval is twice the
    # error on the held-out clock.
    fit, margin = clock_fit(), 2 * abs(clock_miss())
    law = fit.clock(rows * columns)
    ram = part.block_ram_clock
    ram_low, ram_high = ram.interval
    text = (
        f"period {fit.offset:.2f} ns + {fit.slope:.3f} ns × {fit.form} over the clocks of Tables 1 to 3 of"
        f" {published.PAPER}, ±{margin:.0%} (twice the miss on the"
        " held-out clock); parts and speed grades not told apart"
    )
    if ram.value < law:
        text = f"block RAM of {part.full_name}: {ram.source}"
    limit = Figure(
        value=min(law, ram.value),
        unit="Hz",
        status=weakest(Status.CALIBRATED, ram.status) if ram.value < law else Status.CALIBRATED,
        source=text,
        low=min(law * (1 - margin), ram_low),
        high=min(law * (1 + margin), ram_high),
    )
    return on_family(
        limit, part, *FITTED, registers=registers(rows, columns, pipeline, digit_bits, chosen), placements=placements()
    )
