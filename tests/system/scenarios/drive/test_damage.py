"""Damage that nobody notices does harm: wrong bits are read, and acted upon."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from causality import check_causality
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from link_runs import ALL, Ask, Make, run
from mission_specs import POINT, Ground
from numpy.typing import NDArray

from codesign.components import LinkErrors, Parity, Serial
from codesign.components.command import Command
from codesign.components.link import damage_probability, parity_miss, wrong_behind_parity, wrong_bits
from codesign.components.path import Polyline
from codesign.components.sensor import NOTHING_SEEN, RadiusSensor, RangeScan, RaySensor
from codesign.ground.records import BeliefRecord, CommandRecord, MessageRecord, Record
from codesign.laws.acts import SerialLaw
from codesign.planners.interface import Problem
from codesign.system import Result
from codesign.system.chain import CHANGE_BITS, GOAL, OBSTACLE, SentMap, states
from codesign.views.report import render_text
from codesign.views.report.scenario_tables import links_table

MANY = 4000


@settings(max_examples=60)
@given(bits=st.integers(1, 300), rate=st.sampled_from([1e-9, 1e-4, 0.01, 0.3, 1.0]), seed=st.integers(0, 99))
def test_wrong_bits_are_bits_of_the_message(bits: int, rate: float, seed: int) -> None:
    found = wrong_bits(np.random.default_rng(seed), bits, rate)
    assert 1 <= len(found) <= bits
    assert list(found) == sorted(set(found))
    assert 0 <= found[0] <= found[-1] < bits
    assert rate < 1 or len(found) == bits


@pytest.mark.parametrize(("bits", "rate"), [(8, 0.1), (40, 1e-3), (5, 0.5)])
def test_wrong_bits_are_those_of_a_message_that_is_damaged(bits: int, rate: float) -> None:
    """Each bit is wrong with probability rate / P(damaged), by Bayes, wherever it stands."""
    random = np.random.default_rng(3)
    counts = Counter(bit for _ in range(MANY) for bit in wrong_bits(random, bits, rate))
    expected = MANY * rate / damage_probability(bits, rate)
    for bit in range(bits):
        assert abs(counts[bit] - expected) <= 5 * math.sqrt(expected)


@pytest.mark.parametrize(("frames", "frame_bits", "rate"), [(1, 2, 0.5), (3, 9, 0.05), (40, 9, 1e-4)])
def test_what_parity_misses_has_an_even_number_of_wrong_bits_a_frame(frames: int, frame_bits: int, rate: float) -> None:
    random = np.random.default_rng(5)
    several = 0
    for _ in range(MANY // 4):
        found = wrong_behind_parity(random, frames, frame_bits, rate)
        by_frame = Counter(frame for frame, _ in found)
        assert found
        assert all(count % 2 == 0 for count in by_frame.values())
        assert all(0 <= frame < frames and 0 <= place < frame_bits for frame, place in found)
        assert len(set(found)) == len(found)
        several += len(by_frame) > 1
    # Of all that is missed, what harms one frame alone; from the two closed forms of one frame and of all.
    one = parity_miss(1, frame_bits, rate) * damage_probability(frame_bits, rate)
    all_of = parity_miss(frames, frame_bits, rate) * damage_probability(frames * frame_bits, rate)
    alone = frames * one * (1 - rate) ** (frame_bits * (frames - 1)) / all_of
    assert abs(several / (MANY // 4) - (1 - alone)) <= 0.05


@pytest.mark.parametrize("make", ALL)
def test_what_is_wrong_does_not_hang_on_the_speed_of_the_link(make: Make) -> None:
    errors = LinkErrors(bit_error_rate=0.01, seed=7)
    asks = [Ask(200_000 * index, "ab"[index % 2], 64 + index) for index in range(60)]
    slow, fast = (run(make, asks, errors=errors, speed=speed) for speed in (1, 5))
    wrong = [[each.deliveries[index].wrong for index in range(60)] for each in (slow, fast)]
    assert wrong[0] == wrong[1]
    assert [bool(each) for each in wrong[0]] == [slow.deliveries[index].damaged for index in range(60)]
    assert sum(map(bool, wrong[0])) == slow.link.undetected == sum(slow.link.unnoticed.values())
    assert [record.damaged for record in sorted(slow.records, key=lambda one: int(one.name))] == [
        slow.deliveries[index].damaged for index in range(60)
    ]


def test_behind_parity_only_bits_of_the_message_count() -> None:
    def make(environment: Any, **options: Any) -> Serial:
        return Serial(environment, "link", SerialLaw(10**6, parity=Parity.EVEN), **options)

    seen = run(make, [Ask(0, "a", 13)] * 300, errors=LinkErrors(bit_error_rate=0.3, seed=1))
    missed = [each for each in seen.deliveries.values() if each.damaged]
    assert len(missed) > 10
    assert {bit for each in missed for bit in each.wrong} == set(range(13))


# What wrong bits make of each message.

FREE = np.ones((12, 15), np.bool_)
FREE[4, 9] = FREE[8, 2] = FREE[0] = False
HERE = (5.2, 4.1)


@settings(max_examples=80)
@given(st.sets(st.integers(0, 24 * 16 - 1), max_size=8), st.sampled_from([0.05, 0.1, 1.0]))
def test_a_scan_of_rays_read_wrong(wrong: set[int], metres: float) -> None:
    sensor = RaySensor(6.0, 24, metres)
    right, read = sensor.scan(FREE, HERE), sensor.misread(FREE, HERE, sorted(wrong))
    assert disjoint(read)
    if not wrong:
        assert read.same_as(right)
    rays = {bit // 16 for bit in wrong}
    others = np.array([ray for ray in range(24) if ray not in rays])
    kept = RaySensor.scan(_Some(6.0, 24, metres, others), FREE, HERE)
    # What the other rays show blocked stays so, and what they show free is nothing but blocked by a wrong one.
    assert cells(kept.blocked) <= cells(read.blocked)
    assert cells(kept.free) <= cells(read.free) | cells(read.blocked)


class _Some(RaySensor):
    """Some of the rays of a sensor."""

    def __init__(self, reach: float, rays: int, metres: float, chosen: NDArray[np.int64]) -> None:
        super().__init__(reach, rays, metres)
        object.__setattr__(self, "chosen", chosen)

    @property
    def directions(self) -> NDArray[np.float64]:  # type: ignore[override]
        return RaySensor(self.range_cells, self.rays).directions[self.chosen]  # type: ignore[attr-defined]


def cells(some: NDArray[np.int64]) -> set[tuple[int, int]]:
    return {(int(row), int(column)) for row, column in some}


def disjoint(scan: RangeScan) -> bool:
    return not cells(scan.free) & cells(scan.blocked)


def test_a_range_read_wrong_moves_the_obstacle_along_the_ray() -> None:
    """From (5, 4) along the row; the wall at column 9 stands 4.5 cells off, 450 mm: 0b111000010."""
    free = np.ones((11, 30), np.bool_)
    free[:, 9] = False
    sensor = RaySensor(20.0, 4, 0.1)
    assert sensor._word(free, (5.0, 4.0), 0) == 450
    farther = sensor.misread(free, (5.0, 4.0), [9])  # 450 + 512 mm: 9.62 cells
    assert {cell for cell in cells(farther.blocked) if cell[0] == 5} == {(5, 14)}
    assert (5, 9) in cells(farther.free)
    nearer = sensor.misread(free, (5.0, 4.0), [8])  # 450 - 256 mm: 1.94 cells
    assert {cell for cell in cells(nearer.blocked) if cell[0] == 5} == {(5, 6)}
    beyond = sensor.misread(free, (5.0, 4.0), [13])  # 8,642 mm: farther than it sees
    assert {cell for cell in cells(beyond.free) if cell[0] == 5} == {(5, column) for column in range(25)}
    # A ray to the left meets nothing within the map.
    assert sensor._word(free, (5.0, 4.0), 2) == NOTHING_SEEN


@settings(max_examples=60)
@given(st.sets(st.integers(0, 130), max_size=9))
def test_a_scan_of_cells_read_wrong(wrong: set[int]) -> None:
    sensor = RadiusSensor(6.0)
    right, read = sensor.scan(FREE, HERE), sensor.misread(FREE, HERE, sorted(wrong))
    assert disjoint(read)
    assert cells(read.free) | cells(read.blocked) == cells(right.free) | cells(right.blocked)
    turned = (cells(read.free) & cells(right.blocked)) | (cells(read.blocked) & cells(right.free))
    assert len(turned) <= len(wrong)
    assert sensor.misread(FREE, HERE, []).same_as(right)


def test_a_command_read_wrong() -> None:
    command = Command(Polyline([(5, 4), (5, 8), (9, 8)]), 3.0, 0.1)  # 300 mm: 0b100101100
    far = command.misread([9])
    assert far is not None
    assert far.end == pytest.approx(8.12)
    assert far.path is command.path
    near = command.misread([8])
    assert near is not None
    assert near.end == pytest.approx(0.44)
    quarter = command.misread([32 + 30])
    assert quarter is not None
    assert quarter.path.points == pytest.approx(np.array([(5, 4), (9, 4), (9, 0)]))
    assert (quarter.path.length, quarter.end) == (pytest.approx(8.0), 3.0)
    # How fast it may drive at most the robot knows itself, and no way is longer for being told so.
    assert command.misread([64, 95]) is None
    assert Command(command.path, 8.0, 0.1).misread([20]) is None


PROBLEM = Problem(np.ones((4, 6), np.bool_), ((3, 5),), ((0, 0),))
BITS = 2 * 24


def test_a_whole_map_read_wrong() -> None:
    sent = SentMap()
    message = sent.message(PROBLEM, BITS)
    assert (message.whole, message.bits) == (True, BITS)
    read = message.misread((2 * 7,))
    assert read is not None
    held = sent.take(read, PROBLEM)
    assert not held.free[1, 1]
    assert held.free.sum() == 23
    assert held.goals == PROBLEM.goals
    # The sender knows nothing of it: nothing changed, and the cell stays as it was read.
    again = sent.message(PROBLEM, BITS)
    assert (len(again.cells), again.bits) == (0, CHANGE_BITS)
    assert not sent.take(again, PROBLEM).free[1, 1]
    assert again.misread((3,)) is None


def test_changes_read_wrong() -> None:
    sent = SentMap()
    assert sent.take(sent.message(PROBLEM, 10**4), PROBLEM) is PROBLEM
    free = PROBLEM.free.copy()
    free[2, 3] = free[2, 4] = False
    changed = Problem(free, ((3, 4),), PROBLEM.starts)
    message = sent.message(changed, 10**4)
    assert message.cells.tolist() == [[2, 3], [2, 4], [3, 4], [3, 5]]
    assert message.bits == 4 * CHANGE_BITS
    # The row of the first, the column of the second out of the map, the state of the third.
    read = message.misread((0, CHANGE_BITS + 16 + 12, 2 * CHANGE_BITS + 32))
    assert read is not None
    held = sent.take(read, changed)
    assert held.free[2, 3]
    assert not held.free[3, 3]
    assert held.free[2, 4]
    assert states(changed)[3, 4] == GOAL
    assert states(held)[3, 4] == OBSTACLE
    assert held.goals == ()


# Missions.


def noisy(ground: Ground, seed: int, rate: float, checksum: int, **more: Any) -> tuple[Result, list[Record]]:
    errors = {"bit_error_rate": rate, "checksum_bits": checksum, "retries": 5, "timeout": "1 ms", "seed": seed}
    links = {name: {"errors": errors} for name in ("uart", "pci")}
    wanted: dict[str, Any] = {"known": "none", "limit": "20 s", "patience": "3 s"}
    return ground.watched(platform={"links": links}, **(wanted | more))


@pytest.mark.parametrize(
    "placement",
    [
        "breadth-first",
        pytest.param("wavefront", marks=pytest.mark.slow),
        pytest.param("harmonic", marks=pytest.mark.slow),
    ],
)
def test_a_link_without_a_checksum_does_not_improve_a_noisy_mission(tmp_path: Path, placement: str) -> None:
    """Over seeds: fewer missions reach their goals, or with more contacts, or later; none is better by more than what
    is sent again takes."""
    ground, figures = Ground(tmp_path), []
    for checksum in (0, 32):
        runs = [noisy(ground, seed, 1e-3, checksum, placement=placement) for seed in range(5)]
        missions = [result.mission for result, _ in runs if result.mission is not None]
        assert len(missions) == len(runs)
        times = [one.mission_time_s if one.reached else 20.0 for one in missions]
        figures.append((sum(not one.reached for one in missions), sum(one.contacts for one in missions), sum(times)))
    bare, checked = figures
    assert bare[0] >= checked[0]
    assert bare[1] >= checked[1]
    assert bare[2] > checked[2]


def test_one_plan_is_judged_by_the_map_that_it_is_of(tmp_path: Path) -> None:
    """Without a drive nothing is acted upon; the damage is said to be ignored."""
    errors = {"bit_error_rate": 0.01, "checksum_bits": 0}
    once = {"scenario": {"=": {"type": "plan_once"}}}
    result = Ground(tmp_path).run(platform={"links": {"pci": {"errors": errors}}}, workload=once)
    assert result.links is not None
    use = result.links["pci"]
    assert use.undetected == sum(use.ignored_damage.values()) > 0
    assert result.quality is not None


@pytest.mark.parametrize("granularity", ["run_ahead", "visit"])
def test_damage_changes_what_is_acted_upon(tmp_path: Path, granularity: str) -> None:
    ground = Ground(tmp_path)
    result, records = noisy(ground, 1, 1e-3, 0, granularity=granularity)
    check_causality(result, records)
    assert result.links is not None
    uart, pci = result.links["uart"], result.links["pci"]
    told = [record for record in records if isinstance(record, MessageRecord) and record.damaged]
    for name, use in result.links.items():
        mine = Counter(record.name for record in told if record.source == name)
        assert sum(mine.values()) == use.undetected
        # What harmed nothing is some of it, and not all.
        assert all(0 < count <= mine[message] for message, count in use.ignored_damage.items())
    harmed = uart.undetected + pci.undetected - sum(uart.ignored_damage.values()) - sum(pci.ignored_damage.values())
    assert harmed > 10
    sound = noisy(ground, 1, 0.0, 0, granularity=granularity)[1]
    for kind in (BeliefRecord, CommandRecord):
        assert len([one for one in records if type(one) is kind]) != len([one for one in sound if type(one) is kind])
    text = render_text(links_table(result.links))
    assert "taken for what was sent: what wrong bits in it do is not simulated, or they mean nothing" in text


def test_damage_is_equal_at_every_granularity(tmp_path: Path) -> None:
    ground = Ground(tmp_path)
    for placement in ("breadth-first", "harmonic"):
        runs = [
            noisy(ground, 2, 5e-4, 0, placement=placement, granularity=each, limit="8 s")
            for each in ("run_ahead", "visit")
        ]
        assert runs[0][0] == runs[1][0]
        assert len(runs[0][1]) == len(runs[1][1])


CORRIDOR = "\n".join(["#" * 16, "." * 16, "#" * 16])


def test_a_damaged_command_can_drive_the_robot_against_an_obstacle(tmp_path: Path) -> None:
    """In a known corridor, which no sound command leaves; most commands are damaged."""
    ground = Ground(tmp_path)
    wanted: dict[str, Any] = {"text": CORRIDOR, "start": (1, 1), "goals": [(1, 14)], "limit": "20 s"}
    # One that turns at once, and drives 1.5 cells until the next command.
    wanted |= {"control_period": "300 ms", "deadline": "600 ms"}
    near = {"components": {"robot": {"sensor": {"=": {"type": "radius", "range": "0.1 m"}}}}}
    contacts, sound = 0, ground.run(platform=[POINT, near], **wanted).mission
    assert sound is not None
    assert (sound.reached, sound.contacts) == (True, 0)
    for seed in range(12):
        errors = {"links": {"uart": {"errors": {"bit_error_rate": 0.03, "checksum_bits": 0, "seed": seed}}}}
        mission = ground.run(platform=[POINT, near, errors], **wanted).mission
        assert mission is not None
        contacts += mission.contacts
    assert contacts > 3


@settings(max_examples=examples(10), derandomize=True)
@given(
    placement=st.sampled_from(["breadth-first", "harmonic", "harmonic-warm", "relaxation-sor", "wavefront"]),
    rate=st.sampled_from([1e-4, 1e-3, 1e-2, 0.3]),
    seed=st.integers(0, 5),
    sensor=st.sampled_from(["rays", "radius"]),
    explore=st.booleans(),
)
def test_a_drive_survives_whatever_is_read_wrong(
    tmp_path: Path, placement: str, rate: float, seed: int, sensor: str, explore: bool
) -> None:
    """It ends with a reason, causal as ever; the robot is in no obstacle of the true map."""
    seen = {"=": {"type": "radius", "range": "0.4 m"}} if sensor == "radius" else {}
    errors = {"bit_error_rate": rate, "checksum_bits": 0, "seed": seed}
    platform = [
        {"links": {name: {"errors": errors} for name in ("uart", "pci")}},
        {"components": {"robot": {"sensor": seen}}},
    ]
    result, records = Ground(tmp_path).watched(
        placement, platform=platform, known="none", limit="6 s", purpose="explore" if explore else "reach",
        replan={"trigger": "change"},
    )  # fmt: skip
    assert result.mission is not None
    assert result.mission.ended
    check_causality(result, records)
