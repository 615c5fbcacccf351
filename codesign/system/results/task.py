"""The task that was asked of a planner, and the time from each request to its answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from codesign.ground.figures import described
from codesign.ground.units import PICOSECONDS_PER_SECOND
from codesign.system.results.model import ResultModel

TaskName = Literal["path", "field", "replan", "robots"]


class TaskFigures(ResultModel):
    """A task, and what it took. A request begins as the map is sent, and ends as the answer is received."""

    task: TaskName = Field(
        description="what was asked; robots: the paths of all robots at once, of a planner with a problem of its own"
    )
    text: str = Field(title="what the planner does", description="what the planner does for it")
    map: str = Field(default="", description="the map, in words")
    question: str = Field(
        default="",
        description="digest of map, goals, starts, task and change: results with one digest were asked the same",
    )
    starts: int = Field(description="starts of the problem")
    reach: float | None = Field(
        default=None,
        title="share of the free cells that reach a goal",
        description="share of the free cells of the whole map with a path to a goal across the sides of cells",
    )
    changed_cells: int | None = Field(default=None, description="cells that change, of task replan")
    plan_time_mean_s: float = Field(title="request to answer, mean", description=described("plan_time_mean_s"))
    plan_time_95_s: float = Field(title="request to answer, 95th percentile", description=described("plan_time_95_s"))
    plan_time_worst_s: float = Field(title="request to answer, worst", description=described("plan_time_worst_s"))
    map_mean_s: float = Field(
        title="until the map is there, mean",
        description="the part of it until the map, or its change, stands in the component that plans, mean, s",
    )
    planning_mean_s: float = Field(
        title="planning, mean", description="the part of it from there until the plan stands, mean, s"
    )
    answer_mean_s: float = Field(
        title="answering, mean", description="the part of it from there until the answer is received, mean, s"
    )
    arrive: Annotated[float | None, Field(title="share of the starts that arrive", description=described("arrive"))] = (
        None
    )


def reach_text(shares: Sequence[float]) -> str:
    """From how much of the free space a path leads to a goal, over one map or several, as a clause.

    >>> reach_text([1.3e-5, 1.0])
    'a path leads to a goal from 0.0013 % to 100 % of the free cells'
    """
    texts = dict.fromkeys(
        ">99.9 %" if 0.999 < share < 1 else f"{100 * share:.3g} %" for share in (min(shares), max(shares))
    )
    return f"a path leads to a goal from {' to '.join(texts)} of the free cells"


def times_of(requests: Sequence[tuple[Any, Any, Any]]) -> dict[str, Any]:
    """The times of a ``TaskFigures``.

    ``requests``: ps for the map, the planning and the answer of each, in any order: whole numbers, or int64 arrays with
    an entry a machine. Each time is then a number, or an array of float64.

    >>> float(times_of([(10**12, 2 * 10**12, 0), (10**12, 4 * 10**12, 0)])["plan_time_mean_s"])
    4.0
    """
    # Requests × parts (× machines). Sums of whole picoseconds: no figure depends on the order of the starts.
    parts = np.array(requests, np.int64)
    totals = parts.sum(axis=1)
    means = parts.sum(axis=0) / len(requests) / PICOSECONDS_PER_SECOND
    return {
        "plan_time_mean_s": totals.sum(axis=0) / len(requests) / PICOSECONDS_PER_SECOND,
        "plan_time_95_s": np.quantile(totals, 0.95, axis=0) / PICOSECONDS_PER_SECOND,
        "plan_time_worst_s": totals.max(axis=0) / PICOSECONDS_PER_SECOND,
        **dict(zip(("map_mean_s", "planning_mean_s", "answer_mean_s"), means, strict=True)),
    }
