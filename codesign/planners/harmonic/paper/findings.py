"""What the rows and figures of Girau et al. (2008) come to, in words that are computed from them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from statistics import fmean

from codesign.figures import Status
from codesign.planners.harmonic.paper.figures import (
    StillBlocks,
    bits_a_doubling,
    node_power,
    partitioned,
    plateau,
)
from codesign.planners.harmonic.styles import timing
from codesign.planners.reproduction import Plot, Row, Use

SOON = 0.2
"""Share of a run within which Figure 6 must have come to its level to agree with "rapidly"."""


def law_findings(rows: Sequence[Row]) -> tuple[str, ...]:
    """How the laws fare on rows that they were not fitted to, those that rest on an assumption among them."""
    fitted = sum(one.use is Use.FITTED for one in rows)
    held_out = [one for one in rows if one.use is Use.HELD_OUT and one.error is not None]
    assumed = [one for one in held_out if one.status is Status.ASSUMED]
    known = [one for one in held_out if one.status is not Status.ASSUMED]
    worst = max(known, key=_miss)
    exact = sum(one.error == 0 for one in known)
    cluster = max(_miss(one) for one in known if one.table == "Table 2")
    misses = "; ".join(f"{one.quantity} {one.error:+.0%}" for one in assumed)
    return (
        f"Laws were fitted to {fitted} rows; {len(held_out)} other rows have numbers on both sides. {len(assumed)} of"
        " them rest on an assumption, as neither the paper's mazes nor the cost of its software are published, and"
        f" miss by {min(map(_error, assumed)):+.0%} to {max(map(_error, assumed)):+.0%}: {misses}. The other"
        f" {len(known)} need none: {exact} are met exactly, Table 2 within {cluster:.1%}, and the worst is"
        f" {worst.quantity} ({worst.error:+.0%}). Most of the exact ones restate a count of the text: they show"
        " that a law is written down right, and predict nothing.",
        "The clock law goes through three published clocks by choice of its form (residual"
        f" {timing.clock_fit().residual:.3f} ns), and misses the fourth, held out, by {timing.clock_miss():+.0%}:"
        " trust it no further than twice that.",
    )


def _error(one: Row) -> float:
    return one.error or 0.0


def _miss(one: Row) -> float:
    return abs(_error(one))


def figure_findings(bits: Plot, iterations: Plot, still: StillBlocks, shares: Plot) -> tuple[str, ...]:
    """What agrees with the paper's words on Figures 3 to 6, and what does not, from the data."""
    return (
        _bits_finding(bits),
        _iterations_finding(iterations),
        _blocks_finding(still),
        _shares_finding(shares),
        f"The published termination ends {still.wrong} of the {still.runs} runs of Figure 5 with wrong bits, so the"
        " curves are of runs that end only when no bit changes.",
    )


def _bits_finding(plot: Plot) -> str:
    halves = {curve.name: bits_a_doubling(curve) for curve in plot.series}
    slower = [
        f"{name} ({first:.1f} to {last:.1f})" for name, (first, last) in halves.items() if last <= first
    ]
    faster = [f"{name} ({first:.1f} to {last:.1f})" for name, (first, last) in halves.items() if last > first]
    return (
        f"Figure 3, {plot.published}: bits that a doubling of L adds, first half to last, do not grow for"
        f" {_listed(slower)}; they grow for {_listed(faster)}."
    )


def _iterations_finding(plot: Plot) -> str:
    powers = {series.name: node_power(series) for series in plot.series}
    listed = ", ".join(f"{2**power:.2f} ({name}, exponent {power:.2f})" for name, power in powers.items())
    most, least = max(powers, key=powers.__getitem__), min(powers, key=powers.__getitem__)
    growth = (
        "slower than linear everywhere" if max(powers.values()) < 1 else "not slower than linear everywhere"
    )
    return (
        f"Figure 4, {plot.published}: twice the nodes take so many times the iterations: {listed}; linear would be 2."
        f" So the growth is {growth}: closest to it in the environment {most}, farthest from it in {least}, where ten"
        f" times the nodes take {10 ** powers[least]:.1f} times the iterations."
    )


def _blocks_finding(still: StillBlocks) -> str:
    curves = partitioned(still)
    faster = [series.name for series in curves if max(series.y) > 1]
    falls = [series.name for series in curves if series.y[-1] < max(series.y)]
    best = [max(series.y) for series in curves]
    order = "falls" if all(a >= b for a, b in itertools.pairwise(best)) else "does not fall steadily"
    return (
        "Figure 5: blocks take fewer iterations than one synchronous run at some I for"
        f" {_listed(faster)} (best ratio {max(best):.2f}), and the ratio is past its best at the largest I"
        f" for {_listed(falls)}, as in the paper; with more blocks the best ratio {order}, where the paper"
        " sees larger blocks gain more."
    )


def _shares_finding(plot: Plot) -> str:
    levels = [plateau(series) for series in plot.series]
    begins, ends = [begin for begin, _ in levels], [end for _, end in levels]
    means = [fmean(series.y) for series in plot.series]
    rises = all(a <= b for a, b in itertools.pairwise(means))
    soon = max(begins) <= SOON
    return (
        f'Figure 6, "rapidly reaches a constant value": {"agrees" if soon else "does not agree"}, Î/I is within a tenth'
        f" of its median from {min(begins):.0%} to {max(begins):.0%} of the sweeps on, by the number of blocks (soon:"
        f' by {SOON:.0%}). "Until convergence": {"agrees" if min(ends) == 1 else "does not agree"}, it leaves that'
        f" level at {min(ends):.0%} to {max(ends):.0%}, when most blocks are still. The smaller the blocks, the more"
        f" iterations: {'agrees' if rises else 'does not agree'}, the mean of Î/I goes from {means[0]:.2f} with the"
        f" largest blocks to {means[-1]:.2f} with the smallest. The paper gives neither its maze nor I."
    )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) if names else "none"
