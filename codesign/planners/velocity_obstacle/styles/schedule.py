"""Cycles of a circuit from its units and the dependencies of its tasks: list scheduling, twice.

A *unit* (``pos_vel_update``, ``coll_detect``) is scheduled over its multipliers: its products in the order of their
dependencies, one cycle each, and one more cycle that sums up or compares. A *trial* is scheduled over its units: n
updates, and n - 1 detections that each need the update of robot 1 and of one other.

The task that heads the longest chain of remaining work is first; ties keep the order of the list. The schedules give
Table II, and the cycles of circuits that the paper did not build.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from codesign.planners.velocity_obstacle.plan.parameters import Detector, Unit


@dataclass(frozen=True)
class Task:
    """A piece of work: ``cycles`` on one unit of kind ``unit``, once all of ``after`` (places in the list) are done."""

    name: str
    unit: str
    cycles: int
    after: tuple[int, ...] = ()


@dataclass(frozen=True)
class Slot:
    """The begin of a task, in cycles from 0, and its unit among the units of its kind, from 0."""

    task: Task
    begin: int
    unit: int

    @property
    def end(self) -> int:
        """The cycle after the last."""
        return self.begin + self.task.cycles


def schedule(tasks: Sequence[Task], units: Mapping[str, int]) -> tuple[Slot, ...]:
    """A list schedule of ``tasks``, each after those that stand before it in the list, in the order of the list.

    Never shorter than the longest chain, nor than the work of one kind over its units.
    """
    waiting = [len(task.after) for task in tasks]
    followers: list[list[int]] = [[] for _ in tasks]
    for index, task in enumerate(tasks):
        for earlier in task.after:
            followers[earlier].append(index)
    # urgency(i) = cycles(i) + the largest urgency of what waits for i, from the end of the list back.
    urgency = [0] * len(tasks)
    for index in range(len(tasks) - 1, -1, -1):
        behind = max((urgency[follower] for follower in followers[index]), default=0)
        urgency[index] = tasks[index].cycles + behind
    ready: dict[str, list[tuple[int, int]]] = {kind: [] for kind in units}
    free: dict[str, list[int]] = {kind: list(range(count)) for kind, count in units.items()}
    for index, task in enumerate(tasks):
        if not waiting[index]:
            heapq.heappush(ready[task.unit], (-urgency[index], index))
    running: list[tuple[int, int, int]] = []
    slots: dict[int, Slot] = {}
    # The clock moves from one end of a task to the next: no task can begin in between.
    now = 0
    while len(slots) < len(tasks) or running:
        for kind, queue in ready.items():
            while queue and free[kind]:
                _, index = heapq.heappop(queue)
                slot = Slot(tasks[index], now, heapq.heappop(free[kind]))
                slots[index] = slot
                heapq.heappush(running, (slot.end, index, slot.unit))
        now = running[0][0]
        while running and running[0][0] == now:
            _, index, unit = heapq.heappop(running)
            heapq.heappush(free[tasks[index].unit], unit)
            for follower in followers[index]:
                waiting[follower] -= 1
                if not waiting[follower]:
                    heapq.heappush(ready[tasks[follower].unit], (-urgency[follower], follower))
    return tuple(slots[index] for index in range(len(tasks)))


def makespan(slots: Sequence[Slot]) -> int:
    """Cycles from the first begin to the last end."""
    return max((slot.end for slot in slots), default=0)


UPDATE, DETECT = "pos_vel_update", "coll_detect"
DATAPATH = "datapath"
"""The one unit of the sequential style: it does either module's work, never both at once."""

MULTIPLIER, SUM = "multiplier", "sum"

PRODUCTS: dict[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    # Equations 2a and 2b in x and y: three products an axis.
    UPDATE: tuple((name, ()) for axis in "xy" for name in (f"v{axis} t", f"a{axis} t", f"a{axis} t²/2")),
    # |r|²|V|² - (r·V)² ≥ R²|V|² (equation 4): six products of components, three of what they add up to.
    Detector.PUBLISHED: (
        *((name, ()) for name in ("rx rx", "ry ry", "vx vx", "vy vy", "rx vx", "ry vy")),
        ("r_sq vab_sq", ("rx rx", "ry ry", "vx vx", "vy vy")),
        ("dotp dotp", ("rx vx", "ry vy")),
        ("R_sq vab_sq", ("vx vx", "vy vy")),
    ),
    # (r × V)² ≥ R²|V|²: four products of components, two of what they add up to.
    Detector.CROSS_PRODUCT: (
        *((name, ()) for name in ("vx vx", "vy vy", "rx vy", "ry vx")),
        ("cross cross", ("rx vy", "ry vx")),
        ("R_sq vab_sq", ("vx vx", "vy vy")),
    ),
}
"""Products of each module, named by their factors, with the products that they need (equations 2a, 2b and 4).

``cross_product``: |r|²|V|² - (r·V)² = (r × V)² (Lagrange), the same answer with three products less. Where the
sign of r·V is needed as well (``detection: approaching``), its two products are formed in addition: eight in all. So
are the two of |r|², where it is compared with a ``range``. The published detector has them.
"""

APPROACHING_PRODUCTS = (("rx vx", ()), ("ry vy", ()))
RANGE_PRODUCTS = (("rx rx", ()), ("ry ry", ()))


def products(
    module: str, detector: Detector = Detector.PUBLISHED, approaching: bool = False, ranged: bool = False
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The products that a module forms, each with the products that it needs."""
    listed = PRODUCTS[UPDATE if module == UPDATE else detector]
    if module == UPDATE or detector is Detector.PUBLISHED:
        return listed
    return (*(APPROACHING_PRODUCTS if approaching else ()), *(RANGE_PRODUCTS if ranged else ()), *listed)


@cache
def module_cycles(
    module: str, unit: Unit, detector: Detector = Detector.PUBLISHED, approaching: bool = False, ranged: bool = False
) -> int:
    """Cycles of one run of a module: its products over its multipliers, and one to sum up or compare.

    >>> module_cycles(UPDATE, Unit.SERIAL), module_cycles(DETECT, Unit.SERIAL)
    (7, 10)
    """
    listed = products(module, detector, approaching, ranged)
    place = {name: index for index, (name, _) in enumerate(listed)}
    tasks = [Task(name, MULTIPLIER, 1, tuple(place[earlier] for earlier in needs)) for name, needs in listed]
    tasks.append(Task("compare", SUM, 1, tuple(range(len(tasks)))))
    return makespan(schedule(tasks, {MULTIPLIER: 1 if unit is Unit.SERIAL else len(listed), SUM: 1}))


@dataclass(frozen=True)
class Units:
    """The units of a circuit: how many update, how many detect; ``shared``: one datapath does both in turn."""

    update: int
    detect: int
    shared: bool = False


def trial_schedule(robots: int, units: Units, update_cycles: int, detect_cycles: int) -> tuple[Slot, ...]:
    """One candidate held against all others: n updates, n - 1 detections (figures 2 to 4).

    >>> makespan(trial_schedule(8, Units(1, 1, shared=True), 7, 10)), 17 * 8 - 10
    (126, 126)
    >>> makespan(trial_schedule(8, Units(1, 1), 7, 10)), 10 * 8 + 4
    (84, 84)
    >>> makespan(trial_schedule(8, Units(8, 7), 7, 10))
    17
    """
    # U: pos_vel_update, 7 cycles; D: coll_detect, 10 cycles; n robots.
    #
    # figure 2, sequential   U1 U2 D2 U3 D3 ..          one datapath          7n + 10(n - 1) = 17n - 10
    # figure 3, pipelined    U1 U2 U3 ..                one unit of a kind
    #                              D2 D3 ..                                   14 + 10(n - 1) = 10n + 4
    # figure 4, hybrid       U1 .. Un at once
    #                              D2 .. Dn at once     n and n - 1 units     7 + 10 = 17
    update, detect = (DATAPATH, DATAPATH) if units.shared else (UPDATE, DETECT)
    tasks = [Task(f"{UPDATE} 1", update, update_cycles)]
    for robot in range(2, robots + 1):
        tasks.append(Task(f"{UPDATE} {robot}", update, update_cycles))
        tasks.append(Task(f"{DETECT} {robot}", detect, detect_cycles, (0, len(tasks) - 1)))
    counts = {DATAPATH: 1} if units.shared else {UPDATE: units.update, DETECT: units.detect}
    return schedule(tasks, counts)


@cache
def trial_cycles(robots: int, units: Units, update_cycles: int, detect_cycles: int) -> int:
    """Cycles of one trial: the length of its schedule."""
    return makespan(trial_schedule(robots, units, update_cycles, detect_cycles))
