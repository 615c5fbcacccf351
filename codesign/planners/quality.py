"""The quality of plans, as planners judge it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from codesign.ground.figures import described


@dataclass(frozen=True)
class Quality:
    """The quality of a plan.

    A plan need not cover every cell that leads to a goal: a wave is stopped, a search ends. Shares and local maxima
    count over the cells that it covers, ``planned_cells``. The plan says nothing about the other cells. A figure that
    does not apply to the planner is None. A length is None where no start arrives. A ratio is below 1 where a
    continuous path is shorter than the shortest path on the grid.
    """

    reachable_cells: Annotated[
        int, Field(description="free cells that the planner's own moves lead to a goal, goals left out")
    ]
    planned_cells: Annotated[
        int,
        Field(
            title="reachable cells that the plan covers",
            description="reachable cells that the plan covers: fewer where a wave was stopped, or a search ended,"
            " before it came to all of them",
        ),
    ]
    local_maxima: Annotated[
        int | None, Field(title="covered cells with no way up (local maxima)", description=described("local_maxima"))
    ]
    share_reaching_goal: Annotated[
        float | None,
        Field(title="share of covered cells that reach the goal", description=described("share_reaching_goal")),
    ]
    starts: Annotated[int, Field(description="starts tried")]
    starts_arrived: Annotated[int, Field(description="starts from which following the plan arrived")]
    path_length_ratio_mean: Annotated[
        float | None,
        Field(
            title="path length over the shortest, mean",
            description="length of the path over that of the shortest 8-connected path that cuts no corner; mean over"
            " the starts that arrived and that such a path joins to a goal",
        ),
    ]
    path_length_ratio_worst: Annotated[
        float | None, Field(title="path length over the shortest, worst", description="the same, worst")
    ]
    clearance_mean: Annotated[float | None, Field(title="clearance, mean", description=described("clearance_mean"))]
    clearance_least: Annotated[
        float | None,
        Field(title="clearance, least", description="the same, least, cells", json_schema_extra={"unit": "cells"}),
    ]
    wrong_cells: Annotated[int | None, Field(title="cells with a wrong value", description=described("wrong_cells"))]
    optimal_length_mean: Annotated[
        float | None,
        Field(
            title="shortest path by the .scen file, mean",
            description="length of the shortest 8-connected path by the .scen file that goals and starts are from, mean"
            " over the starts, cells",
        ),
    ] = None
    optimal_length_error: Annotated[
        float | None,
        Field(
            title="shortest path against the .scen file, at most",
            description="difference of the shortest 8-connected path on this map and that length, the largest over the"
            " starts, cells: 0.005 or less on the map of the file",
        ),
    ] = None
    cells_leading_nowhere: Annotated[
        int | None,
        Field(
            title="cells that lead nowhere", description="planned cells from which following the plan does not arrive"
        ),
    ] = None
    warnings: Annotated[tuple[str, ...], Field(description="facts that qualify these figures, each with a remedy")] = ()


@dataclass(frozen=True)
class RobotsQuality:
    """The quality of the paths of several robots."""

    robots: Annotated[int, Field(description="robots")]
    robots_arrived: Annotated[int, Field(description="robots that reached their targets")]
    updates: Annotated[
        int,
        Field(
            title="updates of the velocities",
            description="updates of the velocities, until all arrived or the run was given up",
        ),
    ]
    collisions: Annotated[int, Field(title="pairs of robots that collided", description=described("collisions"))]
    closest_approach: Annotated[float, Field(description=described("closest_approach"))]
    time_to_targets_s: Annotated[
        float | None,
        Field(
            title="time until the last arrived, by the robots' clock",
            description=described("time_to_targets_s", "; None where none did"),
        ),
    ]
    velocity_changes: Annotated[
        int, Field(title="changes of velocity", description="updates at which a robot left the velocity it had")
    ]
    path_length_ratio_mean: Annotated[
        float | None,
        Field(
            title="path length over the shortest, mean",
            description="length of the path driven over that of the straight line, mean over the robots that arrived",
        ),
    ]
    path_length_ratio_worst: Annotated[
        float | None, Field(title="path length over the shortest, worst", description="the same, worst")
    ]
    shortfall: Annotated[
        str | None,
        Field(
            description="the robots that did not arrive, with the reason, or the value that left its word; None where"
            " all arrived"
        ),
    ] = None
    remedy: Annotated[
        str | None,
        Field(
            description="parameters with which a trial run brought all robots to their targets; None where no trial did"
        ),
    ] = None
