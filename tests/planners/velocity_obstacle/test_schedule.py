"""Schedules of the products of an update: the laws of table II, and the best one."""

from __future__ import annotations

from itertools import pairwise

import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.planners.velocity_obstacle import published
from codesign.planners.velocity_obstacle.plan import AvoidParameters
from codesign.planners.velocity_obstacle.plan.parameters import Detector, Unit
from codesign.planners.velocity_obstacle.styles import Style
from codesign.planners.velocity_obstacle.styles.resources import (
    DETECT,
    UPDATE,
    Task,
    Units,
    makespan,
    module_cycles,
    products,
    schedule,
    trial_cycles,
    trial_schedule,
)
from codesign.planners.velocity_obstacle.styles.timing import cycles_of_trial


@pytest.mark.parametrize("robots", range(2, 65))
def test_the_laws_of_table_ii_come_out_of_the_units(robots: int) -> None:
    parameters = AvoidParameters()
    assert cycles_of_trial(Style.SEQUENTIAL, robots, parameters) == 17 * robots - 10
    assert cycles_of_trial(Style.PIPELINED, robots, parameters) == 10 * robots + 4
    assert cycles_of_trial(Style.HYBRID, robots, parameters) == 17


def test_table_ii_is_met_exactly() -> None:
    for style, listed in published.TABLE_II.items():
        for robots, cycles in listed.items():
            assert cycles_of_trial(style, robots, AvoidParameters()) == cycles


def test_cycles_of_the_modules_come_out_of_their_products() -> None:
    assert (len(products(UPDATE)), len(products(DETECT))) == (6, 9)
    assert module_cycles(UPDATE, Unit.SERIAL) == published.NUMBERS.figures["update_cycles"]
    assert module_cycles(DETECT, Unit.SERIAL) == published.NUMBERS.figures["detect_cycles"]
    assert module_cycles(UPDATE, Unit.PARALLEL) == 2
    assert module_cycles(DETECT, Unit.PARALLEL) == 3
    assert module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT) == 7
    assert module_cycles(DETECT, Unit.SERIAL, Detector.CROSS_PRODUCT, approaching=True) == 9
    assert module_cycles(DETECT, Unit.SERIAL, Detector.PUBLISHED, approaching=True) == 10


def test_other_unit_counts_lie_between_the_published_styles() -> None:
    lanes = [trial_cycles(8, Units(count, count), 7, 10) for count in range(1, 9)]
    assert lanes[0] == 84
    assert lanes[-1] == 17
    assert all(later <= earlier for earlier, later in pairwise(lanes))
    # A second detector alone: the one update unit is then the limit, n updates and the last detection.
    assert trial_cycles(8, Units(1, 2), 7, 10) == 7 * 8 + 10


@settings(max_examples=examples(100))
@given(
    st.integers(2, 20), st.integers(1, 20), st.integers(1, 20), st.integers(1, 12), st.integers(1, 12), st.booleans()
)
def test_a_schedule_keeps_its_rules_and_bounds(
    robots: int, update: int, detect: int, update_cycles: int, detect_cycles: int, shared: bool
) -> None:
    slots = trial_schedule(robots, Units(update, detect, shared), update_cycles, detect_cycles)
    ends = [slot.end for slot in slots]
    for slot in slots:
        assert all(ends[earlier] <= slot.begin for earlier in slot.task.after)
    lanes: dict[tuple[str, int], list[tuple[int, int]]] = {}
    for slot in slots:
        lanes.setdefault((slot.task.unit, slot.unit), []).append((slot.begin, slot.end))
    assert len(lanes) <= (1 if shared else update + detect)
    for busy in lanes.values():
        assert all(first[1] <= second[0] for first, second in pairwise(sorted(busy)))
    length = makespan(slots)
    work = robots * update_cycles, (robots - 1) * detect_cycles
    counts = (1, 1) if shared else (update, detect)
    least = max(update_cycles + detect_cycles, *(-(-one // count) for one, count in zip(work, counts, strict=True)))
    assert least <= length <= sum(work)
    if shared:
        assert length == sum(work)


def test_the_list_schedule_is_the_best_one_for_few_robots() -> None:
    """Against all orders of the updates and detections, tried one by one."""
    from itertools import permutations

    def greedy(order: tuple[int, ...], tasks: list[Task], counts: dict[str, int]) -> int:
        free = {kind: [0] * count for kind, count in counts.items()}
        ends: dict[int, int] = {}
        waiting = list(order)
        while waiting:
            index = next(one for one in waiting if all(earlier in ends for earlier in tasks[one].after))
            waiting.remove(index)
            task = tasks[index]
            lane = min(range(len(free[task.unit])), key=lambda one: free[task.unit][one])
            begin = max([free[task.unit][lane], *(ends[earlier] for earlier in task.after)])
            ends[index] = free[task.unit][lane] = begin + task.cycles
        return max(ends.values())

    for update, detect in ((1, 1), (1, 2), (2, 1), (2, 2)):
        tasks = [slot.task for slot in trial_schedule(4, Units(update, detect), 7, 10)]
        counts = {UPDATE: update, DETECT: detect}
        best = min(greedy(order, tasks, counts) for order in permutations(range(len(tasks))))
        assert makespan(schedule(tasks, counts)) == best
