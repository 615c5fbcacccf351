"""The demand of the arrays: nodes, memories, read-out, tracker and control.

Flip-flops and memories follow from the sizes exactly (``layout``). LUT are what synthesis counts of the RTL of this
package, by family: sums of terms of the sizes, fitted to some arrays and held against others
(``planners/wavefront/measured/laws.yaml``).
"""

from __future__ import annotations

from collections.abc import Mapping

from codesign.ground.figures import Status
from codesign.ground.models import Part
from codesign.planners.breadth_first.styles.resources import block_rams
from codesign.planners.counted import CountedLaws
from codesign.planners.job import Line
from codesign.planners.wavefront.published import PAPER
from codesign.planners.wavefront.styles.layout import ArrayLayout, side_bits

NODES, MEMORIES, READ_OUT, TRACKER, CONTROL = "nodes", "memories", "read-out", "tracker", "control"


LAWS = CountedLaws("wavefront", "array", {"side_bits": side_bits}, ArrayLayout.of_row)
"""The LUT of each piece, of an ``ArrayLayout``."""


def lut4(piece: str, layout: ArrayLayout, family: str) -> int:
    """LUT of a piece in a family of rows.

    >>> layout = ArrayLayout((256, 256), 11)
    >>> lut4("nodes", layout, "ecp5") / layout.nodes
    5.0
    """
    return round(LAWS.value(piece, "lut4", layout, family))


def flip_flops(piece: str, layout: ArrayLayout) -> int:
    """Flip-flops of a piece, exact."""
    counts = {
        NODES: layout.nodes * layout.node_flip_flops,
        TRACKER: layout.tracker_flip_flops,
        CONTROL: layout.control_flip_flops,
    }
    return counts.get(piece, 0)


def node_slices(layout: ArrayLayout, part: Part) -> int:
    """Slices of a node of two LUT and two flip-flops each, not shared with other nodes."""
    family, _ = LAWS.family(part.family)
    return -(-max(round(lut4(NODES, layout, family) / layout.nodes), layout.node_flip_flops) // 2)


def array_items(layout: ArrayLayout, part: Part) -> tuple[Line, ...]:
    """The demand of an array for a map: nodes, memories, read-out, tracker, control.

    A slice has two LUT and two flip-flops. Nodes share none; the read-out also takes the LUT that they leave.
    """
    pieces = [piece for piece in (NODES, READ_OUT, TRACKER, CONTROL) if piece != TRACKER or layout.tracked]
    luts = {piece: line for piece, (line,) in LAWS.lines(layout, LAWS.family(part.family), *pieces).items()}
    slices, *least_and_most = (
        _slices(layout, counts)
        for counts in (
            {piece: line.amount for piece, line in luts.items()},
            *({piece: int(line.figure.interval[end]) for piece, line in luts.items()} for end in (0, 1)),
        )
    )
    lines = []
    for piece in pieces:
        packed = "two LUT and two flip-flops a slice, none shared by nodes"
        of_slices = min(each[piece] for each in least_and_most), max(each[piece] for each in least_and_most)
        lines.append(Line.item(piece, "slices", slices[piece], Status.ASSUMED, packed, of_slices))
        lines.append(luts[piece])
        if registers := flip_flops(piece, layout):
            exact = "every register of the RTL of this package, as synthesis counts them"
            exact += f"; {PAPER}, Figure 2 has one less a node: Z" * (piece == NODES and not layout.adders)
            lines.append(Line.item(piece, "flip_flops", registers, Status.MEASURED, exact))
    return (*lines, *_memory_items(layout, part))


def _slices(layout: ArrayLayout, luts: Mapping[str, int]) -> dict[str, int]:
    """Slices of each piece of so many LUT."""
    slices = {piece: -(-max(count, flip_flops(piece, layout)) // 2) for piece, count in luts.items()}
    each = max(round(luts[NODES] / layout.nodes), layout.node_flip_flops)
    slices[NODES] = layout.nodes * -(-each // 2)
    slices[READ_OUT] = max(0, -(-(luts[NODES] + luts[READ_OUT]) // 2) - slices[NODES])
    return slices


def _memory_items(layout: ArrayLayout, part: Part) -> tuple[Line, ...]:
    """The memories of elements, or those that a chain fills."""
    sets, shapes = layout.memories
    if not sets:
        return ()
    rams = sets * sum(block_rams(words, width, part) for words, width in shapes)
    of = " and ".join(f"{words:,} words of {width} bits" for words, width in shapes)
    law = f"{sets:,} × {of}, as synthesis counts the RTL of this package"
    return (Line.item(MEMORIES, "block_rams", rams, Status.MEASURED, law),)
