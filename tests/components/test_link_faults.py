"""Errors and outages: what becomes of a message, how long it takes, how often, and from which seed."""

from __future__ import annotations

import math
import pickle
from collections import Counter
from itertools import product
from typing import Any

import numpy as np
import pytest
import simpy
from hypothesis import given
from hypothesis import strategies as st
from link_runs import ALL, TIMED, Ask, Make, Work, a_bus, a_serial_line, all_errors, an_ideal_link, run

from codesign.components import Delivery, DeliveryOutcome, Link, LinkErrors, Parity
from codesign.components.link import (
    MAX_RETRIES,
    Luck,
    Outage,
    Outages,
    damage_probability,
    wrong_behind_parity,
    wrong_bits,
)
from codesign.ground.errors import InputError

MANY = 4000


def send_many(make: Make, bits: int, **options: Any) -> tuple[Link, list[Delivery]]:
    """``MANY`` messages, one after another."""
    environment = simpy.Environment()
    link = make(environment, **options)
    deliveries: list[Delivery] = []

    def sender() -> Work:
        for index in range(MANY):
            deliveries.append((yield from link.send("a", "b", str(index), bits)))

    environment.process(sender())
    environment.run()
    return link, deliveries


def near(count: int, probability: float, of: int = MANY) -> bool:
    """Within five standard deviations of a binomial distribution."""
    return abs(count - of * probability) <= 5 * math.sqrt(of * probability * (1 - probability)) + 1


@pytest.mark.parametrize("make", ALL)
def test_a_share_of_messages_is_damaged_and_found(make: Make) -> None:
    """1 - (1 - 1e-3)^(100 + 20) = 11.3 %; a checksum of 20 bits misses one in a million of these."""
    link, _ = send_many(make, 100, errors=LinkErrors(bit_error_rate=1e-3, checksum_bits=20, seed=4))
    assert near(link.dropped["damaged after 1 attempt"], 1 - 0.999**120)
    assert link.delivered + sum(link.dropped.values()) == MANY
    assert link.undetected == 0


def test_a_short_checksum_misses_its_share() -> None:
    errors = LinkErrors(bit_error_rate=1e-2, checksum_bits=2, seed=4)
    link, deliveries = send_many(an_ideal_link, 100, errors=errors)
    damaged = 1 - 0.99**102
    assert near(link.undetected, damaged / 4)
    assert near(sum(link.dropped.values()), damaged * 3 / 4)
    assert sum(delivery.damaged for delivery in deliveries) == link.undetected
    assert all(delivery.outcome is DeliveryOutcome.DELIVERED for delivery in deliveries if delivery.damaged)


def test_without_a_checksum_damaged_messages_arrive_damaged() -> None:
    link, deliveries = send_many(a_bus, 100, errors=LinkErrors(bit_error_rate=1e-2, retries=3, seed=4))
    assert link.delivered == MANY
    assert link.retransmissions == 0
    assert near(link.undetected, 1 - 0.99**100)
    assert {delivery.attempts for delivery in deliveries} == {1}


def test_parity_finds_most_of_what_is_damaged() -> None:
    """One frame of 8 bits and parity: it misses 2, 4, 6 and 8 wrong bits of 9."""
    rate = 0.05
    errors = LinkErrors(bit_error_rate=rate, seed=4)
    link, _ = send_many(a_serial_line, 8, errors=errors, frame={"parity": Parity.EVEN})
    even = sum(math.comb(9, wrong) * rate**wrong * (1 - rate) ** (9 - wrong) for wrong in (2, 4, 6, 8))
    assert near(link.undetected, even)
    assert near(sum(link.dropped.values()), 1 - (1 - rate) ** 9 - even)


@pytest.mark.parametrize("rate", [0.02, 0.3, 0.6, 1.0])
@pytest.mark.parametrize(("frames", "bits"), [(1, 4), (2, 3), (3, 2)])
def test_wrong_bits_are_drawn_as_often_as_they_come(rate: float, frames: int, bits: int) -> None:
    """Against every pattern of bits, of those that are damaged, and of those that parity does not see."""
    whole, unseen = Counter[Any](), Counter[Any]()
    for pattern in product(*[range(2)] * (frames * bits)):
        chance = math.prod(rate if bit else 1 - rate for bit in pattern)
        wrong = tuple(place for place, bit in enumerate(pattern) if bit)
        if wrong and chance:
            whole[wrong] += chance
            if all(sum(pattern[first : first + bits]) % 2 == 0 for first in range(0, frames * bits, bits)):
                unseen[tuple(divmod(place, bits) for place in wrong)] += chance
    random = np.random.default_rng(3)
    for chances, draw in (
        (whole, lambda: wrong_bits(random, frames * bits, rate)),
        (unseen, lambda: wrong_behind_parity(random, frames, bits, rate)),
    ):
        if chances:
            drawn = Counter(draw() for _ in range(MANY))
            assert drawn.keys() <= chances.keys()
            assert all(near(drawn[wrong], chance / chances.total()) for wrong, chance in chances.items())


def test_attempts_follow_a_geometric_distribution() -> None:
    link, deliveries = send_many(a_bus, 64, errors=LinkErrors(drop=0.3, retries=2, timeout=5, seed=9))
    attempts = Counter(delivery.attempts for delivery in deliveries if delivery.reason is None)
    for count in (1, 2, 3):
        assert near(attempts[count], 0.7 * 0.3 ** (count - 1))
    assert near(link.dropped["lost after 3 attempts"], 0.3**3)
    assert link.retransmissions == sum(delivery.attempts - 1 for delivery in deliveries)


def test_late_messages_come_later_and_hold_nobody() -> None:
    errors = LinkErrors(late_share=0.25, late_delay=10**9, seed=1)
    link, deliveries = send_many(a_bus, 64, errors=errors)
    assert near(link.late, 0.25)
    # One after another: the total is that of the transfers and of the delays, each rounded up to its edge.
    assert sum(delivery.queued >= 10**9 for delivery in deliveries) == link.late

    every = LinkErrors(late_share=1.0, late_delay=10**9)
    seen = run(a_bus, [Ask(0, "a", 64), Ask(0, "a", 64)], errors=every)
    punctual = run(a_bus, [Ask(0, "a", 64), Ask(0, "a", 64)])
    assert [seen.deliveries[i].time - 10**9 for i in (0, 1)] == [punctual.deliveries[i].time for i in (0, 1)]
    assert seen.link.late == 2


@pytest.mark.parametrize("make", TIMED)
def test_each_failed_attempt_is_followed_by_the_timeout(make: Make) -> None:
    timeout = 3 * 10**6
    seen = run(make, [Ask(0, "a", 320)], errors=LinkErrors(drop=1.0, retries=3, timeout=timeout))
    delivery = seen.deliveries[0]
    assert (delivery.outcome, delivery.reason) == (DeliveryOutcome.DROPPED, "lost after 4 attempts")
    assert (delivery.attempts, seen.link.retransmissions, seen.link.undetected) == (4, 3, 0)
    duration = seen.link.duration(320)
    # Retransmissions on a bus begin at an edge again, which moves its duration by up to 1 ps.
    edges = delivery.time - 4 * (duration + timeout)
    assert -4 <= edges < 4 * 30_304
    assert seen.link.busy == delivery.transferred
    assert abs(delivery.transferred - 4 * duration) <= 4
    assert seen.records[0].begin == 0

    once = run(make, [Ask(0, "a", 320)], errors=LinkErrors(bit_error_rate=1.0, checksum_bits=64, timeout=9))
    # Without retries nobody waits for a timeout.
    assert once.deliveries[0].time == once.link.duration(320)
    assert once.deliveries[0].reason == "damaged after 1 attempt"


def test_in_a_timeout_others_go_on_and_one_s_own_messages_wait() -> None:
    errors = LinkErrors(drop=1.0, retries=1, timeout=10**9)
    seen = run(a_bus, [Ask(0, "a", 64), Ask(0, "a", 64), Ask(0, "b", 64)], errors=errors)
    begins = {record.name: record.begin for record in seen.records}
    assert begins["2"] == seen.link.duration(64)
    assert begins["1"] > 2 * 10**9 > begins["2"]


@pytest.mark.parametrize("make", ALL)
def test_the_fate_of_a_message_does_not_hang_on_the_speed_of_the_link(make: Make) -> None:
    asks = [Ask(200_000 * index, "ab"[index % 2], 64 + index) for index in range(80)]
    slow, fast = (run(make, asks, errors=all_errors(), speed=speed) for speed in (1, 5))
    for index in range(len(asks)):
        one, other = slow.deliveries[index], fast.deliveries[index]
        assert (one.reason, one.attempts, one.damaged) == (other.reason, other.attempts, other.damaged)
    assert (slow.link.late, slow.link.dropped) == (fast.link.late, fast.link.dropped)
    assert slow.link.dropped
    assert slow.link.late


def test_two_links_of_one_seed_have_streams_of_their_own() -> None:
    errors = all_errors()
    assert Luck(errors, "uart").draw() == Luck(errors, "uart").draw()
    assert Luck(errors, "uart").draw() != Luck(errors, "pci").draw()


@given(st.integers(0, 10**6), st.floats(0, 1))
def test_the_probability_of_damage(bits: int, rate: float) -> None:
    chance = damage_probability(bits, rate)
    assert 0 <= chance <= 1
    assert damage_probability(bits + 1, rate) >= chance
    assert chance == pytest.approx(1 - (1 - rate) ** bits, abs=1e-9)


def test_rare_errors_are_not_rounded_away() -> None:
    assert damage_probability(100, 1e-18) == pytest.approx(1e-16)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("bit_error_rate", -0.1),
        ("drop", 1.5),
        ("late_share", math.nan),
        ("retries", -1),
        ("retries", MAX_RETRIES + 1),
        ("timeout", -1),
        ("checksum_bits", -2),
        ("seed", -1),
    ],
)
def test_errors_that_cannot_be_are_refused(key: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"errors\.{key}") as caught:
        LinkErrors(**{key: value})  # type: ignore[arg-type]
    assert pickle.loads(pickle.dumps(caught.value)).args == caught.value.args


spans = st.lists(
    st.tuples(st.integers(0, 40), st.one_of(st.none(), st.integers(1, 12))).map(
        lambda span: (span[0], None if span[1] is None else span[0] + span[1])
    ),
    max_size=5,
)


@given(spans)
def test_outages_are_down_when_any_of_them_is(given_spans: list[tuple[int, int | None]]) -> None:
    outages = Outages(given_spans)
    down = [any(b <= t and (e is None or t < e) for b, e in given_spans) for t in range(60)]
    assert [outages.at(time) is not None for time in range(60)] == down
    begins = [t for t in range(60) if down[t] and (t == 0 or not down[t - 1])]
    for begin in range(0, 60, 7):
        first = outages.between(begin, 59)
        assert (None if first is None else first.begin) == next((b for b in begins if begin < b < 59), None)
    for time in range(60):
        outage = outages.at(time)
        if outage is not None and outage.end is not None:
            assert not (outage.end < 60 and down[outage.end])


def test_outages_that_cannot_be_are_refused() -> None:
    assert Outages([(5, None), (0, 5)]).at(0) == Outage(0, None)
    for span in ((5, 5), (6, 5), (-1, 3)):
        with pytest.raises(InputError, match="outages"):
            Outages([span])
