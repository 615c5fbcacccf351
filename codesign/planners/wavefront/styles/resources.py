"""The demand of the arrays: nodes, memories, read-out, tracker and control.

Flip-flops and memories follow from the sizes exactly (``layout``). LUT are what synthesis counts of the RTL of this
package, by family: sums of terms of the sizes, fitted to some arrays and held against others
(``planners/wavefront/measured/resources.json``).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from codesign.figures import Status
from codesign.part import Part
from codesign.planners.breadth_first.styles.resources import block_rams
from codesign.planners.demand import Line
from codesign.planners.measured import Fit, ResourceRow, family_of, fit_rows, resource_rows
from codesign.planners.wavefront.published import PAPER
from codesign.planners.wavefront.styles.layout import ArrayLayout, side_bits

HELD_OUT = {(10, 9), (6, 9), (16, 9), (16, 16), (6, 5), (5, 4), (5, 5)}
"""Sizes (rows, columns) of arrays that no LUT are fitted to."""
HELD_OUT_IN_TILES = {(48, 48), (20, 36), (28, 28), (100, 60), (20, 8), (12, 18), (16, 12)}
"""Sizes of maps in tiles that no LUT are fitted to."""
SIMILAR = "ecp5"
"""The family that stands for one without rows: LUT of four inputs with a carry chain."""
LUT_INPUTS = {"xc7": 6}
"""Inputs of a LUT, where they are not four."""
WIDE_NUMBER = 5
"""Bits of a row or column from which on a line that selects it takes more than a LUT of four inputs."""
NODES, MEMORIES, READ_OUT, TRACKER, CONTROL = "nodes", "memories", "read-out", "tracker", "control"


def held_out(variables: Mapping[str, int]) -> bool:
    """Whether a row with these parameters of the top module is left out of the fits."""
    sizes = HELD_OUT_IN_TILES if "TILE_ROWS" in variables else HELD_OUT
    return (variables["ROWS"], variables["COLUMNS"]) in sizes


def _node_terms(layout: ArrayLayout) -> tuple[float, ...]:
    """The terms of a node: the options that it has, and the bits that each of them handles."""
    corners, silence, extra = not layout.corner_cutting, not layout.waits, bool(layout.extra)
    if layout.adders:
        # Sums have a bit more than the register, whatever its width: synthesis drops those that are constant. A carry
        # cell of the ECP5 adds two bits, so an odd number takes a bit more.
        bits = layout.bits
        return 1, bits, bits % 2, corners, layout.safe, layout.chain * (bits + 1), extra * (bits + 1)
    if layout.shared:
        registers = layout.bits + layout.obstacle_bits
        return 1, registers, layout.element_cells, corners, silence, layout.safe, extra
    kept = layout.safe and not layout.chain
    return 1, corners, silence, corners and silence, kept, layout.chain, layout.chain * layout.bits, extra


def _read_out_terms(layout: ArrayLayout, inputs: int) -> tuple[float, ...]:
    """The terms of the words that are selected: potentials unless a chain brings them, y where a start ends a wave.

    A bit of one of n words is an AND of each with its line, and an OR: 2n inputs, which LUT of i inputs bring down to
    one, i - 1 each.
    """
    down, columns = layout.down, layout.shape[1]
    selects = (not layout.chain) + layout.waits
    bits = layout.word * (not layout.chain) + layout.waits
    trees = [-(-(2 * count - 1) // (inputs - 1)) for count in (down, columns)]
    wide = sum(count for count in (down, columns) if side_bits(count) >= WIDE_NUMBER)
    return bits * (columns * trees[0] + trees[1]), selects * (down + columns), selects * wide


def _tracker_terms(layout: ArrayLayout) -> tuple[float, ...]:
    extra = bool(layout.extra) and not layout.safe
    return (
        *(1, layout.bits, layout.address, not layout.corner_cutting, layout.safe, layout.distance_bits),
        *(extra, extra * layout.bits, layout.local),
    )


def _control_terms(layout: ArrayLayout, inputs: int) -> tuple[float, ...]:
    """The terms of all else. An OR over all nodes ends the updates of adders, or a wave that waits for no start."""
    silence = (layout.adders or not layout.waits) * -(-(layout.nodes - 1) // (inputs - 1))
    return (
        *(1, layout.counter, layout.address, layout.word, silence),
        *(layout.chain, layout.safe, layout.safe and layout.chain, layout.adders, layout.shared),
    )


def _terms(piece: str, layout: ArrayLayout, family: str) -> tuple[float, ...]:
    """The variables of the LUT of a piece."""
    inputs = LUT_INPUTS.get(family, 4)
    match piece:
        case "nodes":
            return tuple(layout.nodes * term for term in _node_terms(layout))
        case "read-out":
            return _read_out_terms(layout, inputs)
        case "tracker":
            return _tracker_terms(layout)
        case _:
            return _control_terms(layout, inputs)


def _kind(layout: ArrayLayout) -> tuple[bool, bool]:
    """Nodes of one kind share a law."""
    return layout.adders, layout.shared


@cache
def _rows() -> tuple[tuple[ResourceRow, ArrayLayout], ...]:
    styles = "delay_line", "adder_comparator", "tiled"
    rows = (row for style in styles for row in resource_rows("wavefront", style))
    return tuple((row, ArrayLayout.of_row(row.variables)) for row in rows)


@cache
def law(piece: str, kind: tuple[bool, bool], family: str) -> Fit:
    """The LUT of a piece in a family of rows; ``kind``: of its nodes, which alone differ by it.

    All arrays have the same tracker, those of a tile among them.
    """
    if piece == TRACKER:
        rows = [row for row, layout in _rows() if layout.tracked]
    else:
        whole = [(row, layout) for row, layout in _rows() if row.style != "tiled"]
        rows = [row for row, layout in whole if piece != NODES or _kind(layout) == kind]

    def terms(variables: Mapping[str, int]) -> tuple[float, ...]:
        return _terms(piece, ArrayLayout.of_row(variables), family)

    return fit_rows(rows, family, piece, "lut4", terms, held_out)


def family_with_rows(part: Part, kind: tuple[bool, bool]) -> tuple[str, bool]:
    """The family of rows for a part, and whether it is its own: one with rows of this ``kind`` of nodes to fit to."""
    return _family(part.family, kind)


@cache
def _family(part_family: str, kind: tuple[bool, bool]) -> tuple[str, bool]:
    family, own = family_of(part_family)
    fitted = (
        row
        for row, layout in _rows()
        if row.style != "tiled" and _kind(layout) == kind and not held_out(row.variables)
    )
    if any(row.family == family for row in fitted):
        return family, own
    return SIMILAR, False


def lut4(piece: str, layout: ArrayLayout, family: str) -> int:
    """LUT of a piece in a family of rows.

    >>> layout = ArrayLayout((256, 256), 11)
    >>> lut4("nodes", layout, "ecp5") / layout.nodes
    5.0
    """
    return round(law(piece, _kind(layout), family).value(_terms(piece, layout, family)))


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
    family, _ = family_with_rows(part, _kind(layout))
    return -(-max(round(lut4(NODES, layout, family) / layout.nodes), layout.node_flip_flops) // 2)


def array_items(layout: ArrayLayout, part: Part) -> tuple[Line, ...]:
    """The demand of an array for a map: nodes, memories, read-out, tracker, control.

    A slice has two LUT and two flip-flops. Nodes share none; the read-out also takes the LUT that they leave.
    """
    family, own = family_with_rows(part, _kind(layout))
    pieces = [piece for piece in (NODES, READ_OUT, TRACKER, CONTROL) if piece != TRACKER or layout.tracked]
    luts = {piece: lut4(piece, layout, family) for piece in pieces}
    ends = {piece: law(piece, _kind(layout), family).ends(luts[piece], own) for piece in pieces}
    slices, *least_and_most = (
        _slices(layout, counts)
        for counts in (luts, *({piece: ends[piece][end] for piece in pieces} for end in (0, 1)))
    )
    status = Status.CALIBRATED if own else Status.ASSUMED
    lines = []
    for piece in pieces:
        off = law(piece, _kind(layout), family).mean
        counted = f"synthesis of the RTL of this package for {family}; on sizes held out {off:.1%} off"
        packed = "two LUT and two flip-flops a slice, none shared by nodes"
        of_slices = min(each[piece] for each in least_and_most), max(each[piece] for each in least_and_most)
        lines.append(Line.item(piece, "slices", slices[piece], Status.ASSUMED, packed, of_slices))
        lines.append(Line.item(piece, "lut4", luts[piece], status, counted, ends[piece]))
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
