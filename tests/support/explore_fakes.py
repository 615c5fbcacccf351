"""Stand-ins for the simulation, in a module of their own because worker processes import it."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES
from codesign.inputs import Exploration, Workload
from codesign.planners.interface import Quality
from codesign.study.space import DesignPoint
from codesign.system.results.mission import Mission, MissionEnergy
from codesign.system.results.result import Reason, ResourceUse, Result, Times


def result(
    *, seconds: float = 1.0, slices: int = 10, share: float = 1.0, path: float | None = 1.0, fits: bool = True
) -> Result:
    """A result with these figures; where it does not fit, one without a run."""
    use = ResourceUse(resource="slices", demand=slices, budget=100, gap=max(0, slices - 100), items=())
    head: dict[str, Any] = {
        "platform": "bench",
        "workload": "maze",
        "planner": "harmonic",
        "style": "bit_serial",
        "component": "fpga",
        "part": None,
        "parameters": {"relax": {"block": (36, 66)}},
        "resources": (use,),
    }
    if not fits:
        gap = Reason(
            kind="resource", name="slices", demand=slices, limit=100, gap=slices - 100, unit="", levers=("shrink",)
        )
        return Result(**head, feasible=False, reasons=(gap,))
    quality = Quality(
        reachable_cells=100,
        planned_cells=100,
        local_maxima=0,
        share_reaching_goal=share,
        starts=4,
        starts_arrived=4,
        path_length_ratio_mean=path,
        path_length_ratio_worst=path,
        clearance_mean=1.5,
        clearance_least=1.0,
        wrong_cells=0,
    )
    time_ = Times(map_loaded_s=0.0, planned_s=seconds, first_plan_s=seconds)
    return Result(**head, feasible=True, time=time_, quality=quality, precision=7)


def mission(*, seconds: float = 60.0, reached: bool = True, **changes: Any) -> Mission:
    """A mission with these figures; one that did not reach its goals says that the way was blocked."""
    figures: dict[str, Any] = {
        "ended": "reached" if reached else "no way for 30 s",
        "reached": reached,
        "mission_time_s": seconds,
        "goals_reached": int(reached),
        "plans": 4,
        "replans": 3,
        "replan_latency_median_s": 0.01,
        "replan_latency_95_s": 0.02,
        "replan_latency_worst_s": 0.03,
        "distance_m": 12.0,
        "shortest_m": 10.0,
        "distance_ratio": 1.2,
        "clearance_least_m": 0.15,
        "clearance_mean_m": 0.6,
        "turns": 600,
        "missed_deadlines": 2,
        "safety_stops": 1,
        "contacts": 0,
        "driving_s": 50.0,
        "waiting_s": 1.0,
        "known_share": 0.75,
        "energy": MissionEnergy(
            fpga_j=1, processors_j=2, links_j=3, memories_j=4, robot_j=5 * seconds, mission_energy_j=10 + 5 * seconds
        ),
        "account": {},
    }
    return Mission(**(figures | changes))


class Fake:
    """Computes a point from its axes: ``seconds``, ``slices``, ``share`` are figures, ``do`` what else it does.

    ``at``: what to do at a point, by index, whatever its axes say. A line for each point goes to ``log``, so
    that tests see who computed what, in any process.
    """

    def __init__(self, log: Path | None = None, at: dict[int, str] | None = None) -> None:
        self.log = log
        self.at = at or {}

    def __call__(self, point: DesignPoint) -> Result:
        axes = {name.rpartition(".")[2]: value for name, value in point.axes.items()}
        if self.log is not None:
            with self.log.open("a", encoding="utf-8") as file:
                file.write(f"{point.index} {os.getpid()}\n")
        match self.at.get(point.index, axes.get("do")):
            case "refuse":
                raise InputError("a block of 9 × 9 nodes on a map of 3 × 3 cells", "relax.block", "make it smaller")
            case "fail":
                raise ZeroDivisionError("no way")
            case "die":
                os._exit(9)
            case "crash":
                os.kill(os.getpid(), signal.SIGSEGV)
            case "kill":
                os.kill(os.getpid(), signal.SIGKILL)
            case "kill once":
                if computed(self.log).count(point.index) == 1:
                    os.kill(os.getpid(), signal.SIGKILL)
            case "interrupt":
                raise KeyboardInterrupt
            case "meet":
                self._meet()
            case "sleep":
                time.sleep(60)
        slices = axes.get("slices", 10 + point.index % 7)
        seconds = axes.get("seconds", 1.0 / (1 + point.index))
        return result(seconds=seconds, slices=slices, share=axes.get("share", 1.0), fits=slices <= 100)

    def _meet(self) -> None:
        """Wait until another process has computed a point too; a minute at most."""
        assert self.log is not None, "processes meet in the log"
        for _ in range(600):
            if len({line.split()[-1] for line in self.log.read_text(encoding="utf-8").splitlines()}) > 1:
                return
            time.sleep(0.1)


def computed(log: Path | None) -> list[int]:
    """The indices of the points that were computed, in the order they were begun."""
    if log is None or not log.exists():
        return []
    return [int(line.split()[0]) for line in log.read_text(encoding="utf-8").splitlines()]


# Valid names of axes, which only the stand-in for the simulation reads.
AXES = {"bench.slices": [10, 50, 2000], "bench.share": [0.5, 1.0], "bench.seconds": [1.0, 1e-3]}
OBJECTIVES = (FIGURES["first_plan_s"], FIGURES["slices"])


def exploring(workload: Workload, axes: dict[str, list[Any]], **more: Any) -> Workload:
    section = Exploration(axes=axes, **({"objectives": OBJECTIVES} | more))
    return workload.model_copy(update={"explore": section})
