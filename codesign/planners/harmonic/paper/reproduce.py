"""The reproduction of Girau, Boumaza, Scherrer and Torres-Huitzil (2008)."""

from __future__ import annotations

from codesign.planners.harmonic.paper.settings import HarmonicSettings
from codesign.planners.reproduction import Progress, Reproduction, silent

QUICK = "A quick run: fewer and smaller maps than those of the full one, whose figures may differ."


def harmonic(
    quick: bool = False, progress: Progress = silent, settings: HarmonicSettings | None = None
) -> Reproduction:
    """Every row of the paper that the model can be compared with, with plots and findings.

    Args:
        quick: fewer and smaller maps: seconds instead of a minute or two.
        progress: called with a line for each part of the work.
        settings: of the runs; by default as published.
    """
    settings = settings or HarmonicSettings()
    from codesign.planners.harmonic.paper.figures import (
        BLOCKS_A_SIDE,
        CONSECUTIVE,
        LABYRINTH_SEEDS,
        figure_3,
        figure_4,
        figure_5,
        figure_6,
        figure_rows,
    )
    from codesign.planners.harmonic.paper.findings import figure_findings, law_findings
    from codesign.planners.harmonic.paper.speed import measurements, speed_findings, speed_rows
    from codesign.planners.harmonic.paper.tables import table_rows
    from codesign.planners.harmonic.paper.theory import count_maps, theory_findings, theory_rows

    speed = measurements(quick, progress, settings.maze_seeds)
    laws = (*table_rows(), *speed_rows(speed))
    estimates = count_maps(quick, progress)
    seeds = settings.labyrinth_seeds or (LABYRINTH_SEEDS[:1] if quick else LABYRINTH_SEEDS)
    sides = (1, 2, 4) if quick else BLOCKS_A_SIDE
    figures = (
        figure_3((1, 2, 4) if quick else (1, 2, 3, 4, 6, 8), progress),
        figure_4((1, 2, 4) if quick else (1, 2, 3, 4, 6, 8), progress),
        figure_5(sides, (1, 4, 16, 256) if quick else CONSECUTIVE, seeds, progress),
        figure_6(sides[1:], progress),
    )
    bits, iterations, still, shares = figures
    return Reproduction(
        paper="Girau, Boumaza, Scherrer, Torres-Huitzil 2008, Block-synchronous harmonic control",
        rows=(*laws, *theory_rows(estimates), *figure_rows(*figures)),
        figures=(bits, iterations, still.plot, shares),
        findings=(
            *law_findings(laws),
            *speed_findings(speed),
            *theory_findings(estimates),
            *figure_findings(*figures),
        ),
        note=QUICK if quick else "",
    ).with_settings(settings)
