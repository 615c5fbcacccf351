"""Results, studies and reproductions made up for the tests of the report package, with no run behind them."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np

from codesign.ground.figures import FIGURES, Figure, Status
from codesign.inputs.constraint import Constraint
from codesign.planners.interface import Quality, RobotsQuality
from codesign.planners.reproduction import Finding, Reproduction, Row, Use
from codesign.study.outcomes import Outcomes
from codesign.study.study import Study
from codesign.system.results.mission import Account, Bottleneck, LatencyShare, LinkUse, Mission, MissionEnergy
from codesign.system.results.result import (
    Clock,
    Energy,
    FleetFigures,
    Frames,
    Power,
    Reason,
    ResourceItem,
    ResourceUse,
    Result,
    Spread,
    StageUse,
    TaskFigures,
    Times,
    times_of,
)

OBJECTIVES = (
    FIGURES["first_plan_s"],
    FIGURES["slices"],
    FIGURES["block_rams"],
    FIGURES["energy_j"],
    FIGURES["share_reaching_goal"],
)
LAW = "Girau et al. 2008, Tables 1 to 3"


BUDGET = 33_792

CLOCK = Clock(
    hz=150_000_000,
    limit=Figure(value=151e6, unit="Hz", status=Status.CALIBRATED, source="three clocks", low=140e6, high=165e6),
)
POWER = Power(
    static=Figure(value=0.6, unit="W", status=Status.ASSUMED, source="datasheet", low=0.3, high=1.2),
    dynamic=Figure(value=0.71, unit="W", status=Status.ASSUMED, source="FPGA 2002", low=0.71, high=0.71),
)
QUALITY: dict[str, Any] = {
    "reachable_cells": 4800,
    "planned_cells": 4700,
    "local_maxima": 12,
    "starts": 64,
    "starts_arrived": 63,
    "path_length_ratio_mean": 1.0312,
    "path_length_ratio_worst": 1.2,
    "clearance_mean": 1.7,
    "clearance_least": 0.5,
    "turning_mean": 120.0,
    "wrong_cells": 3,
}


def a_result(
    *,
    slices: int = 31_500,
    time_s: float = 0.00321,
    share: float = 0.98765,
    energy: float = 0.0042,
    feasible: bool = True,
    **changes: Any,
) -> Result:
    """A result with all figures, or one that does not fit and has none that a run would give."""
    over = slices > BUDGET
    fields: dict[str, Any] = {
        "platform": "virtex2-pci",
        "workload": "labyrinth",
        "planner": "harmonic",
        "style": "bit_serial",
        "component": "fpga",
        "part": "XC2V6000-4",
        "parameters": {
            "relax": {
                "block": [36, 66],
                "blocks": None,
                "iterations": 6,
                "schedule": {"first": 7, "step": 8, "last": 15},
                "termination": "sound",
            },
            "decide": {},
        },
        "blocks": 4,
        "feasible": feasible and not over,
        "reasons": (_too_many(slices),) if over else (),
        "resources": _resources(slices),
        "clock": CLOCK,
        "power": POWER,
    }
    if not over:
        fields |= _run(time_s, share, energy)
    return Result(**(fields | changes))


def a_mission(**changes: Any) -> Mission:
    """The figures of a drive that reached its goal, with everything that can be told."""
    fields: dict[str, Any] = {
        "ended": "reached",
        "reached": True,
        "mission_time_s": 100.0,
        "goals_reached": 1,
        "plans": 5,
        "replans": 4,
        "replan_latency_median_s": 0.012,
        "replan_latency_95_s": 0.2,
        "replan_latency_worst_s": 0.25,
        "distance_m": 36.0,
        "shortest_m": 30.0,
        "distance_ratio": 1.2,
        "clearance_least_m": 0.05,
        "clearance_mean_m": 0.61,
        "turns": 1000,
        "missed_deadlines": 2,
        "safety_stops": 1,
        "contacts": 0,
        "driving_s": 80.0,
        "waiting_s": 1.5,
        "known_share": 0.75,
        "energy": MissionEnergy(
            fpga_j=50.0, processors_j=200.0, links_j=0.5, memories_j=0.0, robot_j=1749.5, mission_energy_j=2000.0
        ),
        "account": {
            "host": Account(compute_s=2.0, transfer_s=0.0, wait_s=0.5, idle_s=98.0),
            "fpga": Account(compute_s=1.0, transfer_s=0.0, wait_s=0.0, idle_s=99.0),
            "uart": Account(compute_s=0.0, transfer_s=40.0, wait_s=12.0, idle_s=60.0),
        },
        "latency": (
            LatencyShare(kind="transfer", where="uart", seconds=0.5, share=0.8),
            LatencyShare(kind="compute", where="fpga", seconds=0.125, share=0.2),
        ),
        "control": (LatencyShare(kind="wait", where="host", seconds=0.25, share=1.0),),
        "bottleneck": Bottleneck(name="uart", kind="transfer", share=0.8, text="a faster line would help"),
    }
    return Mission(**(fields | changes))


LINKS = {
    "uart": LinkUse(
        sent=1010, delivered=1000, dropped={"link down": 7, "damaged after 4 attempts": 2}, in_flight=1,
        retransmissions=31, undetected=0, late=3, bits=64_000, utilisation=0.4, queued_s=12.0,
    )
}  # fmt: skip


def a_mission_result(**changes: Any) -> Result:
    """The result of such a drive."""
    places = {"sense": "robot", "load": "host", "relax": "fpga", "decide": "fpga", "command": "host"}
    return a_result(**({"mission": a_mission(), "links": LINKS, "places": places} | changes))


def _too_many(slices: int) -> Reason:
    return Reason(
        kind="resource",
        name="slices",
        demand=slices,
        limit=BUDGET,
        gap=slices - BUDGET,
        unit="",
        levers=("block: at most 36×66 fits", "part: XC4VLX160"),
    )


def _resources(slices: int) -> tuple[ResourceUse, ...]:
    return (
        ResourceUse(
            resource="slices",
            demand=slices,
            budget=BUDGET,
            gap=max(0, slices - BUDGET),
            items=(
                ResourceItem(name="nodes", figure=Figure(slices - 844, "1", Status.PUBLISHED, LAW)),
                ResourceItem(name="control", figure=Figure(844, "1", Status.PUBLISHED, LAW)),
            ),
        ),
        ResourceUse(
            resource="block_rams",
            demand=144,
            budget=144,
            gap=0,
            items=(ResourceItem(name="clusters", figure=Figure(144, "1", Status.CALIBRATED, "fit of 5.4")),),
        ),
    )


def _run(time_s: float, share: float, energy: float) -> dict[str, Any]:
    """What a run gives."""
    first = {"stage": 0, "precision": 7, "sweeps": 5, "visits": 20, "iterations": 110, "cycles": 990}
    last = {"stage": 1, "precision": 15, "sweeps": 9, "visits": 36, "iterations": 204, "cycles": 3468}
    return {
        "time": Times(map_loaded_s=0.0003, planned_s=time_s - 2e-6, first_plan_s=time_s),
        "cycles": {"load": 9504, "relax": 435_000, "decide": 1_022},
        "stages": (StageUse(**first, local_maxima=41), StageUse(**last, local_maxima=0)),
        "precision": 15,
        "energy": Energy(fpga_j=energy * 0.75, processors_j=energy * 0.25, energy_j=energy),
        "utilisation": {"fpga": 0.91, "pci": 0.0934, "host": 0.00001},
        "quality": Quality(share_reaching_goal=share, **QUALITY),
    }


def a_task(**changes: Any) -> TaskFigures:
    """What was asked of a plan, and its times."""
    figures: dict[str, Any] = {
        "task": "path",
        "text": "one plan serves every start",
        "map": "maze of 72 × 132 cells, goal (3, 128)",
        "question": "a" * 16,
        "starts": 64,
        "arrive": 1.0,
        **times_of([(10**9, 4 * 10**9, 10**9), (10**9, 6 * 10**9, 10**9)]),
    }
    return TaskFigures(**{**figures, **changes})


def a_study(points: int = 24, **changes: Any) -> Study:
    """So many points, a multiple of 8, over four axes, of which one is fixed; the largest blocks do not fit."""
    blocks = [[12, 22], [24, 44], [36, 66], [48, 88]]
    schedules = [{"first": 7, "step": 8, "last": 63}, [15, 31]]
    sides = max(1, -(-points // (len(blocks) * len(schedules))))
    iterations = [1 + 5 * number for number in range(sides)]
    axes: dict[str, tuple[Any, ...]] = {
        "relax.block": tuple(blocks),
        "relax.iterations": tuple(iterations),
        "relax.schedule": tuple(schedules),
        "fpga.part": ("XC2V6000-4",),
    }
    outcomes = []
    for values in itertools.product(*axes.values()):
        block, count, schedule, _part = values
        cells = block[0] * block[1]
        last = 63 if isinstance(schedule, dict) else 31
        result = a_result(
            slices=13 * cells + 3 * last + 1500,
            time_s=(24_000_000_000 // (1 + cells // 400) + 90_000_000 * abs(count - 11)) * last // 31 / 1e12,
            share=1 - 1 / (last + count),
            energy=0.004 * last / 31 * (1 + cells / 3000),
        )
        outcomes.append(result)
    fields: dict[str, Any] = {
        "platform": "virtex2-pci",
        "workload": "labyrinth",
        "axes": axes,
        "objectives": OBJECTIVES,
        "constraints": (Constraint(figure=FIGURES["share_reaching_goal"], at_least=0.9),),
        "outcomes": Outcomes.of(outcomes),
    }
    return Study(**(fields | changes))


def a_hopeless_study() -> Study:
    """The designs of ``a_study`` with the largest blocks: none fits."""
    study = a_study()
    axes = {**study.axes, "relax.block": study.axes["relax.block"][3:]}
    return replace(study, axes=axes, outcomes=study.outcomes.chosen(np.arange(18, 24)))


CALIBRATED, FITTED, HELD_OUT = Status.CALIBRATED, Use.FITTED, Use.HELD_OUT
ROWS = (
    Row("Table 3", "slices of 4,608 nodes", 59_914, 59_914, 0.0, "", CALIBRATED, LAW, FITTED),
    Row("Table 3", "flip-flops of 4,608 nodes", 50_699, 50_699, 0.0, "", CALIBRATED, LAW, FITTED),
    Row("Section 5.4", "speed-up at 128 bits", 100, 97.4, -0.026, "", CALIBRATED, LAW, HELD_OUT, "flat software cost"),
    Row("Section 5.4", "clock of a 48×96 block", 150e6, None, None, "Hz", Status.ASSUMED, "none found", HELD_OUT),
)


def a_reproduction(**changes: Any) -> Reproduction:
    """A paper held against the model: two rows that are met, one by 2.6 %, one that cannot be held."""
    fields: dict[str, Any] = {
        "paper": "Girau 2008, Block-synchronous harmonic control",
        "rows": ROWS,
        "figures": (),
        "findings": (Finding("Tables 1 to 3 are met exactly.", {"rows": "12"}),),
    }
    return Reproduction(**(fields | changes))


SECOND = 10**12


def spans(median: int, share_95: int, worst: int) -> Spread:
    """Spans given in ps."""
    return Spread(median_s=median / SECOND, share_95_s=share_95 / SECOND, worst_s=worst / SECOND)


FRAMES = Frames(
    receiver="pc", bits=256, made=100, skipped=7, dropped={"link down": 3}, shown=88, late=5, under_way=2,
    age=spans(11, 12, 13),
)  # fmt: skip


def a_fleet(
    decide_s: float = 0.001, message_s: float = 0.02, period_s: float | None = None, **changes: Any
) -> FleetFigures:
    """A free-running fleet of 100 updates, by its mean times in s."""
    period = max(decide_s, message_s) if period_s is None else period_s
    fields: dict[str, Any] = {
        "robots": 8,
        "fpgas": 8,
        "ended": "all robots stand at their targets",
        "completed": True,
        "updates": 100,
        "span_s": 100 * period,
        "robots_s": 10.0,
        "arrived_s": 90 * period,
        "time_step_s": 0.1,
        "decide": spans(101, 102, 103),
        "period": spans(201, 202, 203),
        "updates_a_second": 1 / period,
        "reachable_a_second": 1 / max(decide_s, message_s),
        "pace": "line" if period > 2 * decide_s else "fpga",
        "shares": {"fpga": decide_s / period, "line": 1 - decide_s / period, "time_step": 0.0},
        "missed_updates": 0,
        "frames": FRAMES,
        "fpga_busy_s": 12345 / SECOND,
        "fpga_utilisation": (0.011, 0.022),
    }
    return FleetFigures(**(fields | changes))


def a_fleet_result(fleet: FleetFigures | None = None, collisions: int = 2) -> Result:
    quality = RobotsQuality(8, 7, 100, collisions, -0.25, 12.5, 31, 1.1, 1.3)
    fleet = a_fleet() if fleet is None else fleet
    return a_result(planner="velocity_obstacle", fleet=fleet, quality=quality, stages=None)
