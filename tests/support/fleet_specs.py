"""Fleets on a small platform, whose line, clock and count a test chooses."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

from benchmarks.velocity_obstacle_pace import LineLaw
from codesign.components import ClockDomain, Granularity
from codesign.inputs import load_platform
from codesign.planners.velocity_obstacle.plan import Avoidance, AvoidParameters, avoid, generate
from codesign.system import catalog
from codesign.system.build import Machine, build
from codesign.system.scenarios import bind
from codesign.system.scenarios.fleet.scenario import Flight, fly

PLATFORM = """\
kind: platform
name: boards
components:
  fpga: {{type: fpga, part: XC3S500E-4, clock: {clock}}}
  pc: {{type: processor, clock: 2 GHz, costs: {{{costs}}}, power: {{busy: 60 W, idle: 20 W}}}}
links:
  line: {{{link}, between: [fpga, pc]}}
"""


WORKLOAD = """\
kind: workload
name: fleet
planner: velocity_obstacle
problem:
  robots: {{count: {count}, arrangement: {arrangement}, seed: {seed}}}
scenario: {{type: fleet, {scenario}}}
mapping:
  avoid: {{component: fpga, style: pipelined, {parameters}}}
  {display}
"""


IDEAL = "type: ideal"
SECOND = 10**12
STEP = 10**11
"""The time step by default, ps."""


def serial(baud: int, fifo: int = 16, more: str = "") -> str:
    return f"type: serial, baud: {baud}, fifo_depth: {fifo}{more}"


class Ground:
    """Builds a fleet's machine from texts, in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def machine(
        self,
        *,
        link: str = IDEAL,
        clock: str = "50 MHz",
        costs: str = "render_robot: 0 s",
        count: int = 4,
        arrangement: str = "circle",
        seed: int = 0,
        scenario: str = "pace: free_running",
        parameters: str = "updates: 60",
        display: str = "display: {component: pc}",
        listeners: tuple[Any, ...] = (),
        granularity: str = "run_ahead",
    ) -> Machine:
        board, robots = self.folder / "board.yaml", self.folder / "robots.yaml"
        board.write_text(PLATFORM.format(clock=clock, costs=costs, link=link), encoding="utf-8")
        text = WORKLOAD.format(
            count=count, arrangement=arrangement, seed=seed, scenario=scenario, parameters=parameters, display=display
        )
        robots.write_text(text, encoding="utf-8")
        system = bind(load_platform(board), catalog.load_workload(robots))
        return build(system, listeners, Granularity(granularity))

    def fly(self, **settings: Any) -> Flight:
        return fly(self.machine(**settings))


def planned(count: int = 4, **parameters: Any) -> tuple[Avoidance, AvoidParameters]:
    chosen = AvoidParameters(**{"updates": 60, **parameters})
    return avoid(generate("circle", count), chosen), chosen


def expected_ends(cycles: list[int], hz: int, begin: int, line: LineLaw, robots: int) -> list[Fraction]:
    """When each update of a free-running fleet ends, ps: character by character, with no simulation.

    The sender of message k goes on once all characters but ``fifo_depth`` of those sent so far have begun.
    """
    clock, each, character = ClockDomain(hz), line.characters(robots), line.frame_bits * 10**12 / line.baud
    now, free, begun, ends = Fraction(begin), Fraction(0), [], []
    for amount in cycles:
        edge = clock.cycle_at_or_after(-(-now.numerator // now.denominator))
        decided = Fraction(clock.edge(edge + amount))
        first = max(decided, free)
        begun += [first + character * number for number in range(each)]
        free = first + character * each
        held = len(begun) - line.fifo_depth
        now = max(decided, begun[held - 1]) if held > 0 else decided
        ends.append(now)
    return ends


ERRORS = ", errors: {drop: 0.3, retries: 0, seed: 7}"
