"""The parts of a block: clusters, borders, OR trees, and the words of their memories."""

from __future__ import annotations

from collections.abc import Sequence

from codesign.planners.harmonic import published

RAM_WIDTH = published.CLUSTER.nodes
"""Bits a word of the cluster and border RAMs: one bit of each of 18 nodes."""

TREE_GROUP = 288
"""Nodes to a register of the OR trees without a pipeline: 5 levels of 4 inputs."""

PIPELINE_TREE_GROUP = 16
"""Clusters to a register of the OR trees with a pipeline, after a register for each cluster."""

FIELD_MEMORIES = 5
"""Memories of the field of a decision module by itself: a cell and its neighbours are each in another one."""


def cluster_count(rows: int, columns: int) -> int:
    """3×6 clusters that cover a block, the last ones partly empty: one block RAM each.

    >>> cluster_count(36, 66), cluster_count(48, 96), cluster_count(4, 7)
    (132, 256, 4)
    """
    return -(-rows // published.CLUSTER_ROWS) * -(-columns // published.CLUSTER_COLUMNS)


def border_nodes(rows: int, columns: int) -> int:
    """Border nodes around a block, corners left out.

    >>> border_nodes(36, 66)
    204
    """
    return 2 * (rows + columns)


def border_rams(rows: int, columns: int, down: int = 2, across: int = 2) -> int:
    """Block RAMs of the borders, 18 nodes of one side each: each side is read at the address of another block.

    Of the ``down`` × ``across`` blocks of a map, one row has no sides to the north and south that another block reads,
    and one column none to the west and east.

    >>> border_rams(36, 66), border_rams(6, 12), border_rams(48, 96), border_rams(6, 12, 1, 1)
    (12, 4, 18, 0)
    """
    vertical = 2 * -(-columns // RAM_WIDTH) if down > 1 else 0
    return vertical + (2 * -(-rows // RAM_WIDTH) if across > 1 else 0)


def memories(rows: int, columns: int, down: int, across: int) -> int:
    """Block RAMs of clusters and borders of a map of ``down`` × ``across`` blocks."""
    return cluster_count(rows, columns) + border_rams(rows, columns, down, across)


def tree_widths(rows: int, columns: int, pipeline: int = 0) -> list[int]:
    """Registers of each stage of an OR tree over a block, without the registers of its last stage and of the clusters.

    >>> tree_widths(6, 12), tree_widths(48, 96), tree_widths(48, 96, 1)
    ([], [16], [16])
    """
    clusters = cluster_count(rows, columns)
    # Without a pipeline the last register is that of the control. With it each cluster has a register first.
    inputs, group = (clusters, PIPELINE_TREE_GROUP) if pipeline else (RAM_WIDTH * clusters, TREE_GROUP)
    widths = []
    while inputs > group:
        inputs = -(-inputs // group)
        widths.append(inputs)
    return widths


def digits(precision: int, digit_bits: int) -> int:
    """Digits of a value of ``precision`` bits, the lowest one perhaps in part.

    >>> digits(63, 1), digits(63, 2), digits(63, 8)
    (63, 32, 8)
    """
    return -(-precision // digit_bits)


def field_groups(columns: int) -> int:
    """Groups of five columns in a row of the field, the last one partly empty."""
    return -(-columns // FIELD_MEMORIES)


def field_plane(rows: int, columns: int) -> int:
    """Words of one bit that each memory of the field holds for a bit of all cells.

    >>> field_plane(10, 14)
    30
    """
    return rows * field_groups(columns)


def field_rams_a_memory(rows: int, columns: int, precision: int, shapes: Sequence[tuple[int, int]]) -> int:
    """Block RAMs of these shapes for each memory of the field, at ``precision`` bits.

    >>> field_rams_a_memory(60, 60, 127, [(16384, 1), (1024, 18)])
    6
    """
    words = field_plane(rows, columns) * (precision + 1)
    return -(-words // max((depth for depth, _ in shapes), default=1))
