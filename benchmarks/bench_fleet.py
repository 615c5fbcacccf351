"""Fleets: 64 robots with an FPGA each and a serial line, beside the same events in plain SimPy and in desmod."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from benchmarks.fleet_twins import DesmodFleet, Pattern, PlainFleet, count_events
from codesign.components import Granularity
from codesign.inputs import load_platform
from codesign.planners.velocity_obstacle.plan import avoid
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.timing import update_costs
from codesign.system import catalog
from codesign.system.build import build
from codesign.system.scenarios import bind
from codesign.system.scenarios.fleet.scenario import fly
from codesign.views.trace.listeners import McapListener

MOST_SECONDS = 10.0
"""What 64 robots × 500 updates may take."""
ALIKE = 1e-9
"""What the twins' ends may differ by: they round each message on the line to a picosecond, and drift."""
UPDATES = 500
REPEATS = 3
CASES = (("robots-8-fleet", 8), ("robots-64", 16), ("robots-64", 64))


def bound(name: str, robots: int) -> Any:
    workload = catalog.load_workload(name)
    avoid = workload.mapping["avoid"]
    parameters = avoid.parameters.model_copy(update={"updates": UPDATES})
    mapping = workload.mapping | {"avoid": avoid.model_copy(update={"parameters": parameters})}
    given = workload.problem.robots.model_copy(update={"count": robots})
    scenario = workload.scenario.model_copy(update={"pace": "free_running"})
    changed = {"mapping": mapping, "problem": workload.problem.model_copy(update={"robots": given})}
    return bind(load_platform("nexys2-serial"), workload.model_copy(update={**changed, "scenario": scenario}))


def pattern_of(system: Any, loaded: int) -> Pattern:
    """The same robots, line and display as numbers."""
    plan = avoid(system.problem, system.planning)
    costs = update_costs(Style(system.architecture.style), system.problem.count, system.planning)
    line, display = system.platform.links["serial"], system.platform.components["pc"]
    robots = system.problem.count
    return Pattern(
        cycles=costs.of_robot(plan.checks, plan.trials).tolist(),
        cycle=10**12 // system.clock,
        baud=int(line.baud.value),
        characters=robots * 4,
        fifo=int(line.fifo_depth.value),
        load=loaded,
        render=int(display.costs["render_robot"].value) * robots,
    )


def best(call: Callable[[], tuple[int, int]]) -> tuple[float, int, int]:
    """The shortest of several times, s; events, and the last simulated picosecond."""
    times = []
    for _ in range(REPEATS):
        begin = perf_counter()
        told = call()
        times.append(perf_counter() - begin)
    return (min(times), *told)


def run() -> list[dict[str, Any]]:
    """Fleets with and without a trace, and the twins."""
    rows = []
    for name, robots in CASES:
        system = bound(name, robots)
        loads: list[int] = []

        def own(listener: Any = None, system: Any = system, loads: list[int] = loads) -> tuple[int, int]:
            machine = build(system, () if listener is None else (listener,), Granularity.RUN_AHEAD)
            flight = fly(machine)
            loads.append(flight.loaded)
            return flight.events, machine.now

        def traced(own: Any = own) -> tuple[int, int]:
            with TemporaryDirectory() as folder, McapListener(Path(folder) / "fleet.mcap") as listener:
                told: tuple[int, int] = own(listener)
                return told

        own()
        pattern = pattern_of(system, loads[0])

        def twin(kind: Any, pattern: Pattern = pattern) -> tuple[int, int]:
            fleet = kind(pattern)
            events = count_events(fleet.environment)
            return events, int(fleet.environment.now)

        cases: list[tuple[str, Callable[[], tuple[int, int]]]] = [
            ("codesign, planner included", own),
            ("codesign, with an MCAP trace", traced),
            ("plain SimPy, events alone", lambda: twin(PlainFleet)),
            ("desmod, events alone", lambda: twin(DesmodFleet)),
        ]
        first, ended = None, 0
        for what, call in cases:
            seconds, events, end = best(call)
            first, ended = (seconds, end) if first is None else (first, ended)
            updates = len(pattern.cycles)
            assert abs(end - ended) <= ALIKE * ended, f"{what} ends at {end} ps, the fleet at {ended} ps"
            rows.append(
                {
                    "fleet": f"{robots} robots × {updates} updates",
                    "simulated by": what,
                    "s": f"{seconds:.2f}",
                    "share of 10 s": f"{seconds / MOST_SECONDS:.0%}",
                    "events": f"{events:,}",
                    "10³ events/s": f"{events / seconds / 1e3:.0f}",
                    "time over codesign's": f"{seconds / first:.2f}",
                }
            )
    return rows
