"""Statements about Girau et al. (2008), each with the figures of the run that it rests on."""

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
from codesign.planners.reproduction import Finding, Plot, Row, Use

SOON = 0.2
"""The share of a run within which Figure 6 has to reach its level to agree with "rapidly"."""
MET = 0.2
"""The largest error with which the model meets a row."""


def law_findings(rows: Sequence[Row]) -> tuple[Finding, ...]:
    """The errors of the laws on rows that they were not fitted to. Some of these rest on an assumption."""
    held_out = [row for row in rows if row.use is Use.HELD_OUT and row.error is not None]
    assumed = [row for row in held_out if row.status is Status.ASSUMED]
    unassumed = [row for row in held_out if row.status is not Status.ASSUMED]
    worst = max(map(_miss, unassumed))
    figures = {
        "fitted rows": str(sum(row.use is Use.FITTED for row in rows)),
        "other rows": str(len(held_out)),
        "rows that rest on an assumption": str(len(assumed)),
        **{row.quantity: f"{row.error:+.0%}" for row in assumed},
        "rows that need none": str(len(unassumed)),
        "of these exact": str(sum(row.error == 0 for row in unassumed)),
        "worst of Table 2": f"{max(_miss(row) for row in unassumed if row.table == 'Table 2'):.1%}",
        "worst of these": f"{worst:.0%}",
    }
    clock = {"residual": f"{timing.clock_fit().residual:.3f} ns", "miss": f"{timing.clock_miss():+.0%}"}
    return (
        Finding("The laws meet the rows that need no assumption.", figures, worst < MET),
        Finding("The clock law misses the one clock that it has not seen.", clock, timing.clock_miss() > 0.1),
    )


def _miss(row: Row) -> float:
    return abs(row.error or 0.0)


def figure_findings(bits: Plot, iterations: Plot, still: StillBlocks, shares: Plot) -> tuple[Finding, ...]:
    """The words of the paper on Figures 3 to 6, compared with the runs."""
    return (
        _bits_finding(bits),
        _iterations_finding(iterations),
        *_blocks_findings(still),
        *share_findings(shares),
        Finding(
            "The published termination ends runs with wrong bits.",
            {"wrong runs": str(still.wrong), "runs": str(still.runs)},
            still.wrong > 0,
        ),
    )


def _bits_finding(plot: Plot) -> Finding:
    halves = {curve.name: bits_a_doubling(curve) for curve in plot.series}
    return Finding(
        "The bits that a doubling of L adds grow in the empty environment only.",
        {name: f"{first:.1f} to {last:.1f}" for name, (first, last) in halves.items()},
        [name for name, (first, last) in halves.items() if last > first] == ["empty"],
    )


def _iterations_finding(plot: Plot) -> Finding:
    powers = {series.name: node_power(series) for series in plot.series}
    figures = {f"iterations for twice the nodes, {name}": f"{2**power:.2f}" for name, power in powers.items()}
    figures |= {f"exponent, {name}": f"{power:.2f}" for name, power in powers.items()}
    figures["iterations for ten times the nodes, least"] = f"{10 ** min(powers.values()):.1f}"
    statement = "Iterations grow slower than linearly with the number of nodes."
    return Finding(statement, figures, max(powers.values()) < 1)


def _blocks_findings(still: StillBlocks) -> tuple[Finding, ...]:
    curves = partitioned(still)
    best = [max(series.y) for series in curves]
    return (
        Finding(
            "Blocks take fewer iterations than one synchronous run at some I, and gain less at the largest I.",
            {"best ratio": f"{max(best):.2f}"},
            min(best) > 1 and all(series.y[-1] < max(series.y) for series in curves),
        ),
        Finding(
            "The best ratio does not fall steadily with the number of blocks.",
            {series.name: f"{most:.2f}" for series, most in zip(curves, best, strict=True)},
            not all(a >= b for a, b in itertools.pairwise(best)),
        ),
    )


def share_findings(plot: Plot) -> tuple[Finding, ...]:
    """The claims of the paper on Figure 6, one by one."""
    levels = [plateau(series) for series in plot.series]
    begins, ends = [begin for begin, _ in levels], [end for _, end in levels]
    means = [fmean(series.y) for series in plot.series]
    return (
        Finding(
            "The share of iterations Î/I comes to its level soon.",
            {"earliest": f"{min(begins):.0%}", "latest": f"{max(begins):.0%}"},
            max(begins) <= SOON,
        ),
        Finding(
            "Î/I leaves that level before the end.",
            {"earliest": f"{min(ends):.0%}", "latest": f"{max(ends):.0%}"},
            min(ends) < 1,
        ),
        Finding(
            "Smaller blocks do not take more iterations.",
            {"mean Î/I, largest blocks": f"{means[0]:.2f}", "mean Î/I, smallest blocks": f"{means[-1]:.2f}"},
            not all(a <= b for a, b in itertools.pairwise(means)),
        ),
    )
