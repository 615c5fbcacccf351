"""Levers of a mission: the values of the design that change its time, found by runs with one value moved.

The place where time is spent does not show what would save it: a robot that drives all the time may take a detour
because a plan comes late. So each lever is run, and only the result of its run is reported.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from codesign.ground import interrupts
from codesign.ground.errors import CodesignError
from codesign.ground.figures import Figure
from codesign.ground.units import Dimension, format_quantity
from codesign.inputs import Platform, Workload
from codesign.inputs.components import FpgaComponent, MemoryComponent, RobotComponent
from codesign.inputs.edit import SCENARIO, design_point
from codesign.inputs.scenario import WhenBusy
from codesign.system.bind import System
from codesign.system.results.mission import LIVELOCK, Bottleneck, LeverRun, Mission
from codesign.system.results.result import Result
from codesign.system.scenario import LeverProgress
from codesign.system.scenarios.drive.tasks import drive_of

FACTOR = 2
"""The factor of a lever: twice as fast, or half as long."""

HELPS = 0.01
"""Least share of a mission's time that a lever must save to be reported as a help. Assumed."""

_LISTED = 3


@dataclass(frozen=True)
class MissionLever:
    """One value of a design point to be moved.

    - ``path``: the axis. ``before``, ``after``: in words, with units. ``value``: as YAML would have it.
    - ``refused``: why it cannot be moved, "" where it can.
    """

    path: str
    before: str
    after: str = ""
    value: Any = None
    refused: str = ""


def levers_of(system: System, result: Result) -> tuple[MissionLever, ...]:
    """The levers of a design point: clocks, costs of hosts and rates of links that it uses, its robot, its replanning.

    ``result``: of its mission.
    """
    mission = result.mission
    assert mission is not None, "the caller looks"
    levers = list(drive_levers(system, result))
    scenario = drive_of(system.workload)
    if scenario.replan.when_busy is WhenBusy.RESTART:
        path, after = f"{SCENARIO}.replan.when_busy", WhenBusy.FINISH.value
        levers.append(MissionLever(path, WhenBusy.RESTART.value, after, after))
    if mission.broken_off_in_a_row >= LIVELOCK:
        path = f"{SCENARIO}.control_period"
        levers.append(_double(path, scenario.control_period, Dimension.TIME, "ps"))
    return tuple(levers)


def drive_levers(system: System, result: Result) -> Iterator[MissionLever]:
    """The levers that move how fast components and links work, of any run."""
    yield from _of_components(system, result)
    yield from _of_links(system, result)


def with_levers(
    result: Result, system: System, run: Callable[[Platform, Workload], Result], progress: LeverProgress | None = None
) -> Result:
    """The result with its levers run; as it is, where it holds no mission.

    Where a signal ends the command meanwhile (``interrupts``), the result has the levers that were run before it.

    Args:
        result: of ``system``.
        system: the design point.
        run: simulates another design point.
        progress: takes how many levers are done, of how many, and which comes next.
    """
    mission = result.mission
    if mission is None:
        return result
    levers = levers_of(system, result)
    runs = []
    for done, lever in enumerate(levers):
        if progress is not None:
            progress(done, len(levers), lever.path)
        try:
            runs.append(_run(lever, system, run))
        except KeyboardInterrupt:
            # A command that a signal ends keeps its mission, which is done; it raises again after its report.
            if interrupts.struck() is None:
                raise
            break
    if progress is not None:
        progress(len(levers), len(levers), "")
    runs.sort(key=lambda run: (run.refused is not None, not run.reached, run.mission_time_s or 0.0, run.path))
    moved = {"levers": tuple(runs), "bottleneck": _pace(mission, tuple(runs))}
    return result.model_copy(update={"mission": mission.model_copy(update=moved)})


def _run(lever: MissionLever, system: System, run: Callable[[Platform, Workload], Result]) -> LeverRun:
    refused = lever.refused
    mission: Mission | None = None
    if not refused:
        try:
            moved = run(*design_point(system.platform, system.workload, {lever.path: lever.value}, "lever: "))
        except CodesignError as wrong:
            refused = str(wrong)
        else:
            mission = moved.mission
            refused = "; ".join(map(str, moved.reasons))
    names: dict[str, Any] = {"path": lever.path, "before": lever.before, "after": lever.after or None}
    if mission is None:
        return LeverRun(**names, refused=refused)
    return LeverRun(
        **names,
        reached=mission.reached,
        mission_time_s=mission.mission_time_s,
        mission_energy_j=mission.energy.mission_energy_j,
        missed_deadlines=mission.missed_deadlines,
        ended=mission.ended,
    )


def _pace(mission: Mission, runs: tuple[LeverRun, ...]) -> Bottleneck | None:
    """The bottleneck, from the runs of its levers; the observation alone where none was run."""
    seen, tried = mission.bottleneck, [run for run in runs if run.mission_time_s is not None]
    if seen is None or not tried:
        return seen
    helpful = [run for run in tried if _helps(mission, run)]
    if not helpful:
        names = ", ".join(f"{run.path} {run.before} → {run.after}" for run in tried)
        what = "ends the mission earlier" if mission.reached else "makes the mission reach its goals"
        text = f"{seen.text}. None of the levers that were run {what}: {names}"
        return seen.model_copy(update={"text": text})
    savings = "; ".join(_saving(mission, run) for run in helpful[:_LISTED])
    others = f"{len(helpful)} of the {len(tried)} levers that were run, one at a time, help"
    first = helpful[0]
    assert first.mission_time_s is not None, "it was run"
    name = first.path if first.path.startswith(SCENARIO) else first.path.partition(".")[0]
    share = max(0.0, 1.0 - first.mission_time_s / mission.mission_time_s)
    return Bottleneck(name=name, kind="lever", share=share, text=f"{savings}. {others}. Seen: {seen.text}")


def _helps(mission: Mission, run: LeverRun) -> bool:
    """True if the mission ends earlier, or reaches goals that it did not reach."""
    if not run.reached or run.mission_time_s is None:
        return False
    return not mission.reached or run.mission_time_s < (1.0 - HELPS) * mission.mission_time_s


def _saving(mission: Mission, run: LeverRun) -> str:
    without = f"{mission.mission_time_s:.4g} s" if mission.reached else f"no end in {mission.mission_time_s:.4g} s"
    return f"{run.path} {run.before} → {run.after}: {run.mission_time_s:.4g} s in place of {without}"


def _of_components(system: System, result: Result) -> Iterator[MissionLever]:
    used, platform = set(system.placement.places.values()), system.platform
    fpgas, robots = platform.of(FpgaComponent), platform.of(RobotComponent)
    for name in (name for name in platform.components if name in used):
        if name in fpgas:
            yield _fpga_clock(system, result, name, fpgas[name])
        elif name in robots:
            yield from _of_robot(name, robots[name])
        elif costs := platform.components[name].kernels:
            halved = {kernel: int(cost.value) // FACTOR for kernel, cost in costs.items()}
            if any(halved.values()):
                value = {kernel: f"{cost} ps" for kernel, cost in halved.items()}
                yield MissionLever(f"{name}.costs", "as declared", "halved", value)


def _of_robot(name: str, spec: RobotComponent) -> Iterator[MissionLever]:
    for key, figure in spec.kinematics:
        if isinstance(figure, Figure):
            path, faster = f"{name}.kinematics.{key}", FACTOR * float(figure.value)
            before, after = (f"{each:.4g} {figure.unit}" for each in (figure.value, faster))
            yield MissionLever(path, before, after, f"{faster!r} {figure.unit}")


def _fpga_clock(system: System, result: Result, name: str, spec: FpgaComponent) -> MissionLever:
    """Twice the clock, or as near to that as part, design and memory allow."""
    clock = int(spec.clock.value)
    limits = [spec.chip.block_ram_clock.interval[1]]
    if result.clock is not None:
        limits.append(result.clock.limit.value)
    limits += [memory.clock.value for memory in system.platform.of(MemoryComponent).values() if memory.beside == name]
    faster = min(FACTOR * clock, math.floor(min(limits)))
    path, before = f"{name}.clock", format_quantity(clock, Dimension.FREQUENCY)
    if faster <= clock:
        return MissionLever(path, before, refused=f"{before} is the most that part, design and memory allow")
    return MissionLever(path, before, format_quantity(faster, Dimension.FREQUENCY), f"{faster} Hz")


def _of_links(system: System, result: Result) -> Iterator[MissionLever]:
    for name, link in system.platform.links.items():
        if result.links is None or not result.links[name].sent:
            continue
        if key := link.law.lever(link):
            figure: Figure = getattr(link, key)
            path, value = f"{name}.{key}", int(figure.value)
            if figure.unit == "Hz":
                yield _double(path, value, Dimension.FREQUENCY, "Hz")
            else:
                yield MissionLever(path, f"{value:,}", f"{FACTOR * value:,}", FACTOR * value)


def _double(path: str, value: int, dimension: Dimension, unit: str) -> MissionLever:
    """A quantity of so many whole units, times ``FACTOR``."""
    before, after = (format_quantity(each, dimension) for each in (value, FACTOR * value))
    return MissionLever(path, before, after, f"{FACTOR * value} {unit}")
