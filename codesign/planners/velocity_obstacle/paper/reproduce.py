"""Dubey, Pradhan, Krishna and Roy Chowdhury (2013), held against the model."""

from __future__ import annotations

from codesign.planners.reproduction import Progress, Reproduction
from codesign.planners.velocity_obstacle.paper.settings import VelocityObstacleSettings

QUICK = "A quick run: fewer seeds than those of the full one, whose counts differ."


def velocity_obstacle(
    quick: bool = False, progress: Progress | None = None, settings: VelocityObstacleSettings | None = None
) -> Reproduction:
    """Every row of the paper that the model can be held against, with plots and findings.

    Args:
        quick: fewer seeds for the simulated runs.
        progress: gets a line on each step of the computation.
        settings: of the runs; by default as published.
    """
    settings = settings or VelocityObstacleSettings()
    from codesign.planners.velocity_obstacle.paper.runs import (
        agreement,
        paths_plot,
        run_findings,
        run_rows,
        single_runs,
        tallies,
    )
    from codesign.planners.velocity_obstacle.paper.tables import (
        cycles_plot,
        power_plot,
        table_findings,
        table_rows,
    )

    runs = single_runs(progress)
    counted = tallies(quick, progress, settings.seeds)
    verdicts = agreement(quick, progress)
    return Reproduction(
        paper="Dubey, Pradhan, Krishna, Roy Chowdhury 2013, Collision avoidance using acceleration velocity obstacles",
        rows=(*table_rows(), *run_rows(runs, verdicts)),
        figures=(cycles_plot(), power_plot(), paths_plot(runs[8])),
        findings=(*table_findings(), *run_findings(runs, counted, verdicts)),
        note=QUICK if quick else "",
    ).with_settings(settings)
