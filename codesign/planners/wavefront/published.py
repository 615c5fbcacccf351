"""The figures that Möller and Paschke (1998) publish of their circuit, as printed.

All figures of the paper are of one map of 256 × 256 nodes. The map itself is a picture, not data.
"""

from __future__ import annotations

PAPER = "Möller and Paschke 1998"

SIDE = 256
"""Nodes a side of the map of every example."""

CLOCK = 20_000_000
"""Hz: "with only 20 MHz assumed as the basic clock"."""

STOP_POTENTIAL = 1355
STOP_CYCLE = 1356
PLAN_SECONDS = 68e-6
SOFTWARE_SECONDS = 63e-3
"""s: "approx. 63 ms", improved Dijkstra algorithm in C on a 133 MHz Pentium PC."""
SOFTWARE_CLOCK = 133_000_000
SPEED_UP = 1000

OBSTACLE_CYCLES = 768
OBSTACLE_SECONDS = 38e-6
"""The wave from all obstacles: "the maximal distance in an empty map (length of the diagonal line)"."""

DELAY_ELEMENTS = 3
ADDERS, COMPARATORS = 8, 8
"""Of a node of Hassoun and Sanghvi (1990), the paper's reference [4]."""

RIVAL = "Sudha and Mohan 2011"
RIVAL_PART = "XC4VFX12"
RIVAL_CYCLES_A_PIXEL = 1.035
RIVAL_CLOCK = 375_000_000
"""Hz: an array for a few cells an element, which takes 1.035 cycles a pixel at that clock."""
