"""What a law of the clock says of a family of chips that it was not fitted to.

The laws of this package are fitted to clocks that papers published for Virtex-II, Virtex-II Pro, Virtex-4 and
Spartan-3E. Designs of the same styles, placed and routed by open tools (Yosys 0.70, nextpnr 0.11.1; our RTL), say how
far the laws carry:

    part              design                        placed        law       placed / law
    LFE5U-85F-8       harmonic 6 × 12, plain         89.9 MHz     263 MHz   0.34
    LFE5U-85F-8       harmonic 12 × 24, plain        89.4 MHz     225 MHz   0.40
    LFE5U-85F-6       breadth-first 100 × 100        75 MHz       185 MHz   0.41
    LFE5U-85F-8       harmonic 6 × 12, registered   187.1 MHz     263 MHz   0.71
    GW2A-18-7         harmonic 6 × 12, plain        194.6 MHz     263 MHz   0.74
    LFE5U-85F-8       harmonic 12 × 24, registered  180.5 MHz     225 MHz   0.80
    GW2A-18-7         harmonic 6 × 12, registered   282.8 MHz     263 MHz   1.08

"Registered": the neighbours' stream, the sum and the output of the memory have a register each, which costs 4
flip-flops a node and no cycle of an iteration. So the pipeline decides, which is no variable of these laws.
"""

from __future__ import annotations

from codesign.figures import Figure, Status
from codesign.part import Part

LEAST_SHARE, MOST_SHARE = 1 / 3, 1.1
"""Of the law's value, on a family that it was not fitted to: the table above, rounded outwards."""

LEAST_SHARE_OF = {"iCE40 UltraPlus": 1 / 8}
"""Of families that are made for low power: its LUT take about three times as long as those of an iCE40 HX. Assumed."""

MEASURED = (
    "designs of these styles placed by open tools reach 0.34 to 1.08 of such laws on LFE5U and GW2A"
    " (75 MHz for 185, 90 for 263), other families are not measured"
)


def on_family(limit: Figure, part: Part, *fitted: str) -> Figure:
    """The clock limit (Hz) of a law on a part: as it is on the ``fitted`` families, else with a wider interval.

    The value stays. The low end is at most a third of it (an eighth on an iCE40 UltraPlus). The high end is at least
    1.1 times the value, but no further than the clock limit of the block RAM.

    >>> from codesign.figures import Figure, Status
    >>> ram = Figure(200, "Hz", Status.PUBLISHED, "data sheet")
    >>> part = Part(name="LFE5U-85F", family="ECP5", speed_grade="-8", resources={}, block_ram_shapes=(),
    ...     block_ram_clock=ram, static_power=ram, dynamic_power=ram)
    >>> law = Figure(150, "Hz", Status.CALIBRATED, "a fit", 120, 180)
    >>> on_family(law, part, "Virtex-4").interval, on_family(law, part, "ECP5").interval
    ((50.0, 180), (120, 180))
    """
    if part.family in fitted:
        return limit
    low, high = limit.interval
    return Figure(
        value=limit.value,
        unit=limit.unit,
        status=Status.ASSUMED,
        source=f"{limit.source}; fitted to {' and '.join(fitted)}, not to {part.family}: {MEASURED}",
        low=min(low, limit.value * LEAST_SHARE_OF.get(part.family, LEAST_SHARE)),
        high=max(high, min(limit.value * MOST_SHARE, part.block_ram_clock.interval[1])),
    )
