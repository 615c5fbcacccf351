"""Cycles and clock of the bit-serial circuit.

Cycles
    An iteration takes p + 2 (section 5.4) for any block: the bits pass serially, and the write address
    follows two cycles behind the read address. The same pass finds the local maxima, least significant bit
    first.

    The paper counts nothing else. In our own RTL the end of a visit adds 1 cycle to change the block, and the latency
    of the OR tree that detects a changed bit. Within a block the next iteration starts before the tree has answered: at
    worst it repeats an iteration that changed nothing. So the circuit waits only when it leaves a block or a stage
    ends, and with one block only at the end of a stage. A tree over N nodes is log4 N levels of 4-input LUT deep, 4
    levels to a pipeline stage: 2 stages for 4,608 nodes, in the middle of the 1 to 3 of synthesis at 150 MHz.

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
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

from codesign.figures import Figure, Status, weakest
from codesign.part import Part
from codesign.planners.clock_law import on_family
from codesign.planners.harmonic import published

LEVELS_A_PIPELINE_STAGE = 4

FORMS: dict[str, Callable[[float], float]] = {
    "log2 N": math.log2,
    "N^(1/4)": lambda nodes: nodes**0.25,
    "N^(1/2)": math.sqrt,
}
"""The forms that were tried for the growth of the clock period."""


def iteration_cycles(precision: int) -> int:
    """Clock cycles of one iteration at ``precision`` bits: p + 2 (section 5.4)."""
    # cycle     0    1    2    3   ..   p - 1   p         p + 1
    # reads     b_0  b_1  b_2  b_3 ..   b_p-1                       bit i of the four neighbours, lowest first
    # sum       s_0  s_1  s_2  s_3 ..   s_p-1   s_p       s_p+1     two bits longer than its terms
    # writes              h_0  h_1 ..   h_p-3   h_p-2     h_p-1     h_i = s_i+2: the division by 4 is the delay
    return precision + 2


def or_tree_stages(nodes: int) -> int:
    """Pipeline stages of the OR tree over a block.

    >>> or_tree_stages(1), or_tree_stages(18), or_tree_stages(4608)
    (0, 1, 2)
    """
    # An OR of 4 inputs a level: 4^levels bits come together.
    levels = 0
    while 4**levels < nodes:
        levels += 1
    return -(-levels // LEVELS_A_PIPELINE_STAGE)


def switch_cycles(nodes: int, blocks: int) -> int:
    """Cycles between two visits: none with one block only (see the module)."""
    return 0 if blocks == 1 else 1 + or_tree_stages(nodes)


def stage_end_cycles(nodes: int) -> int:
    """Cycles between two stages: the test for a local maximum, and the change of precision."""
    # One cycle for the decision of ``Control``, after the tree of ``Cvg`` (section 5.2) has answered.
    return 1 + or_tree_stages(nodes)


def load_cycles(cells: int, blocks: int, precision: int) -> int:
    """Cycles to load a map: clear p + 1 words for each block in all RAMs at once, then one cell a cycle.

    Assumed. In section 5.2 one node at a time is selected (Sel) and gets its constant (Sat).
    """
    return blocks * (precision + 1) + cells


def load_start_cycles(cells: int, clusters: int, blocks: int, precision: int) -> int:
    """Cycles to load a map and its start values: a word of 18 bits of the RAM of one cluster each cycle.

    Assumed, as ``load_cycles``: p + 1 words of every cluster for each block, one RAM after the other.
    """
    return clusters * blocks * (precision + 1) + cells


def reload_cycles(cells: int) -> int:
    """Cycles to load a map where the values of the last plan stay: one cell a cycle, nothing to clear. Assumed."""
    return cells


def decision_cycles(precision: int) -> int:
    """Cycles of one decision: 17p + 10.

    Assumed. The module "acts as a sequential program" (section 5.3), with room for three words of p bits: p +
    2 to read the node and its four neighbours and subtract them serially, 2p for each of four squares on one
    serial multiplier, 2p + 1 to add and compare each of the four triangles, and 4 between these steps.
    """
    return (precision + 2) + 4 * 2 * precision + 4 * (2 * precision + 1) + 4


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
    slope = sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)) / sum(
        (a - mean_x) ** 2 for a in x
    )
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


def clock_limit(rows: int, columns: int, part: Part) -> Figure:
    """The fastest clock of a design on a part, Hz: the limit of its size, or of the block RAM where that is lower.

    The law of the size is one line for all parts and grades: three points cannot distinguish them. On another family
    than theirs its interval is wider (``on_family``).
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
    return on_family(limit, part, *FITTED)
