"""What every link promises: a new kind of link adds one entry to ``link_runs.ALL``."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import simpy
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from link_runs import ALL, TIMED, Ask, Make, Work, all_errors, an_ideal_link, run

from codesign.components import (
    ABANDONED,
    LINK_DOWN,
    ClockDomain,
    Component,
    Delivery,
    DeliveryOutcome,
    Fpga,
    Granularity,
)
from codesign.ground.errors import RunError
from codesign.ground.records import Record, TaskRecord
from codesign.planners.styles import Step

times = st.integers(0, 4_000_000)
asks = st.lists(
    st.builds(
        Ask,
        at=times,
        sender=st.sampled_from(["a", "a", "b"]),
        bits=st.integers(1, 600),
        priority=st.sampled_from([0, 0, 1]),
        post=st.booleans(),
        interrupt_at=st.one_of(st.none(), times),
    ),
    max_size=10,
)
quiet_asks = asks.map(lambda drawn: [replace(ask, interrupt_at=None) for ask in drawn])
outages = st.lists(
    st.tuples(times, st.one_of(st.none(), st.integers(1, 900_000))).map(
        lambda span: (span[0], None if span[1] is None else span[0] + span[1])
    ),
    max_size=3,
)


@pytest.mark.parametrize("make", ALL)
@settings(max_examples=examples(60))
@given(asks=asks, outages=outages, seed=st.integers(0, 9), until=st.one_of(st.none(), times))
def test_every_message_is_delivered_dropped_or_in_flight(
    make: Make, asks: list[Ask], outages: list[tuple[int, int | None]], seed: int, until: int | None
) -> None:
    """``run`` holds the balance at every event; here, that the account tells what was told to the senders."""
    seen = run(make, asks, until, errors=all_errors(seed), outages=outages)
    link, told = seen.link, seen.records
    if until is None:
        assert link.in_flight == 0
    assert link.delivered == sum(record.outcome == "delivered" for record in told)
    assert sum(link.dropped.values()) == sum(record.outcome == "dropped" for record in told)
    assert link.bits == sum(record.bits for record in told if record.outcome == "delivered")
    for record in told:
        assert (record.reason is None) == (record.outcome == "delivered")
        assert record.time <= record.begin <= record.end
        assert 0 <= record.attempts <= 3
    if until is None:
        assert link.retransmissions == sum(max(record.attempts - 1, 0) for record in told)
        assert link.queued + link.transferred == sum(record.end - record.time for record in told)
    for index, delivery in seen.deliveries.items():
        asked = asks[index].at
        assert delivery.time - asked == delivery.queued + delivery.transferred
        assert min(delivery.queued, delivery.transferred) >= 0
        assert (delivery.outcome is DeliveryOutcome.DROPPED) == (delivery.reason is not None)
    for index, free in seen.free.items():
        assert asks[index].at <= free


@pytest.mark.parametrize("make", ALL)
@settings(max_examples=40)
@given(asks=quiet_asks)
def test_a_sender_s_messages_arrive_in_order_and_the_urgent_never_after_equals(make: Make, asks: list[Ask]) -> None:
    no_late = all_errors(late_share=0.0, retries=50)
    for errors in (None, no_late):
        seen = run(make, asks, errors=errors)
        for sender in ("a", "b"):
            for priority in (0, 1):
                ends = [
                    (ask.at, index, seen.deliveries[index].time)
                    for index, ask in enumerate(asks)
                    if (ask.sender, ask.priority) == (sender, priority)
                ]
                assert all(one[2] <= other[2] for one, other in pairwise(sorted(ends)))


@pytest.mark.parametrize("make", ALL)
def test_it_is_deterministic_and_another_seed_is_another_run(make: Make) -> None:
    asks = [Ask(60_000 * index, "ab"[index % 2], 100 + index, post=index % 3 == 0) for index in range(60)]
    one, again, other = (run(make, asks, errors=all_errors(seed)) for seed in (1, 1, 2))
    assert one.records == again.records
    assert one.deliveries == again.deliveries
    assert one.moments == again.moments
    assert one.records != other.records


@pytest.mark.parametrize("make", ALL)
def test_nobody_listening_changes_nothing_and_builds_nothing(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("a record was emitted")

    asks = [Ask(50_000 * index, "ab"[index % 2], 90) for index in range(9)]
    heard = run(make, asks, errors=all_errors())
    monkeypatch.setattr(Component, "emit", refuse)
    environment = simpy.Environment()
    link = make(environment, errors=all_errors())
    values = [environment.process(later(environment, link, ask, str(i))) for i, ask in enumerate(asks)]
    environment.run()
    assert [value.value for value in values] == [heard.deliveries[index] for index in range(len(asks))]


def later(environment: simpy.Environment, link: Any, ask: Ask, name: str) -> Work:
    yield environment.timeout(ask.at)
    return (yield from link.send(ask.sender, "b" if ask.sender == "a" else "a", name, ask.bits))


@pytest.mark.parametrize("make", TIMED)
@settings(max_examples=40)
@given(asks=quiet_asks, speed=st.integers(2, 7))
def test_a_faster_link_is_never_later(make: Make, asks: list[Ask], speed: int) -> None:
    """Multiples of a clock have its edges among theirs; equals only, as an urgent message that arrives just in
    time for a slow link may be behind a long one on a fast link: that one is later, and rightly so.

    In bursts all messages of one sender, as turns between senders fall otherwise for the same reason.
    """
    equals = [replace(ask, priority=0, sender="a" if "bursts" in make.__name__ else ask.sender) for ask in asks]
    slow, fast = run(make, equals), run(make, equals, speed=speed)
    for index in range(len(equals)):
        assert fast.deliveries[index].time <= slow.deliveries[index].time
        assert fast.deliveries[index].transferred <= slow.deliveries[index].transferred
    for index, free in slow.free.items():
        assert fast.free[index] <= free


@pytest.mark.parametrize("make", TIMED)
@pytest.mark.parametrize("errors", [None, all_errors(bit_error_rate=0.0, drop=0.0, late_share=0.0)])
def test_one_message_on_an_idle_link_takes_its_duration(make: Make, errors: Any) -> None:
    for bits in (1, 31, 32, 33, 127, 128, 129, 1000):
        seen = run(make, [Ask(0, "a", bits)], errors=errors)
        assert seen.deliveries[0].time == seen.link.duration(bits) > 0
        assert seen.deliveries[0].transferred == seen.link.busy == seen.link.duration(bits)
        assert (seen.deliveries[0].queued, seen.deliveries[0].attempts) == (0, 1)


@settings(max_examples=40)
@given(asks=quiet_asks)
def test_an_ideal_link_takes_no_time_and_keeps_the_order(asks: list[Ask]) -> None:
    seen = run(an_ideal_link, asks)
    assert all(seen.deliveries[index].time == ask.at for index, ask in enumerate(asks))
    assert all(seen.free[index] == ask.at for index, ask in enumerate(asks) if ask.post)
    ends = [record.end for record in seen.records]
    assert ends == sorted(ends)
    assert (seen.link.busy, seen.link.duration(10**9)) == (0, 0)
    assert seen.link.bits == sum(ask.bits for ask in asks)


def test_sending_over_an_ideal_link_makes_no_event() -> None:
    """The process that sends goes on at once: nobody else acts in between."""
    environment = simpy.Environment()
    link = an_ideal_link(environment)
    with pytest.raises(StopIteration) as done:
        next(link.send("a", "b", "map", 8))
    assert done.value.value.outcome is DeliveryOutcome.DELIVERED
    assert environment.peek() == float("inf")


@pytest.mark.parametrize("make", TIMED)
@pytest.mark.parametrize("post", [False, True])
def test_an_interrupted_sender_frees_the_link(make: Make, post: bool) -> None:
    cut = 100_000
    asks = [Ask(0, "a", 10_000, post=post, interrupt_at=cut), Ask(10, "a", 32)]
    seen = run(make, asks)
    assert seen.link.dropped == {ABANDONED: 1}
    assert (seen.link.delivered, seen.link.bits) == (1, 32)
    # No more than the edge that a bus waits for, or the end of a burst.
    alone = run(make, [Ask(cut, "a", 32)])
    assert seen.deliveries[1].time == alone.deliveries[0].time
    assert seen.records[0].reason == ABANDONED
    assert (seen.records[0].begin, seen.records[0].end) == (0, cut)
    assert seen.link.busy == cut + alone.link.busy
    assert 0 not in seen.deliveries


@pytest.mark.parametrize("make", ALL)
def test_an_interrupted_sender_in_the_queue_leaves_the_others_as_they_were(make: Make) -> None:
    asks = [Ask(0, "a", 500), Ask(1, "a", 500, interrupt_at=50_000), Ask(2, "a", 32)]
    seen = run(make, asks)
    alone = run(make, [asks[0], asks[2]])
    assert seen.deliveries[2].time == alone.deliveries[1].time
    assert sum(seen.link.dropped.values()) == (make is not an_ideal_link)


def test_the_process_of_a_post_tells_that_it_was_abandoned() -> None:
    environment = simpy.Environment()
    link = TIMED[2](environment)

    def sender() -> Work:
        carrier = yield from link.post("a", "b", "go", 16)
        assert environment.now == 0
        yield environment.timeout(5)
        carrier.interrupt()
        return (yield carrier)

    process = environment.process(sender())
    environment.run()
    delivery = process.value
    assert (delivery.time, delivery.outcome, delivery.reason) == (5, DeliveryOutcome.DROPPED, ABANDONED)
    assert (delivery.transferred, link.dropped) == (5, {ABANDONED: 1})


@pytest.mark.parametrize("make", ALL)
def test_a_message_waits_for_the_end_of_an_outage(make: Make) -> None:
    up = 3_000_000
    seen = run(make, [Ask(0, "a", 64, post=True), Ask(7, "b", 64)], outages=[(0, 10), (10, up)])
    alone = run(make, [Ask(up, "a", 64), Ask(up, "b", 64)])
    assert [seen.deliveries[i].time for i in (0, 1)] == [alone.deliveries[i].time for i in (0, 1)]
    assert (seen.deliveries[0].attempts, seen.link.dropped) == (1, {})
    assert seen.deliveries[0].queued >= up
    assert seen.link.busy == alone.link.busy


@pytest.mark.parametrize("make", ALL)
def test_a_link_that_is_down_for_good_drops_at_once(make: Make) -> None:
    asks = [Ask(100, "a", 64), Ask(100, "a", 64, post=True), Ask(900, "b", 8)]
    seen = run(make, asks, errors=all_errors(), outages=[(100, None)])
    assert [seen.deliveries[index].time for index in range(3)] == [100, 100, 900]
    assert [seen.deliveries[index].attempts for index in range(3)] == [0, 0, 0]
    assert seen.link.dropped == {LINK_DOWN: 3}
    assert {record.reason for record in seen.records} == {LINK_DOWN}
    assert seen.link.busy == 0


@pytest.mark.parametrize("make", TIMED)
def test_a_message_under_way_when_an_outage_begins_is_cut_off(make: Make) -> None:
    asks = [Ask(0, "a", 1000), Ask(0, "a", 32)]
    for_good = run(make, asks, errors=all_errors(), outages=[(50_000, None)])
    assert [for_good.deliveries[index].time for index in (0, 1)] == [50_000, 50_000]
    assert for_good.link.dropped == {LINK_DOWN: 2}
    assert (for_good.link.busy, for_good.deliveries[0].attempts) == (50_000, 1)

    without = run(make, asks, outages=[(50_000, 70_000)])
    alone = run(make, [Ask(70_000, "a", 32)])
    assert without.link.dropped == {LINK_DOWN: 1}
    assert without.deliveries[1].time == alone.deliveries[0].time

    retries = all_errors(bit_error_rate=0.0, drop=0.0, late_share=0.0, checksum_bits=0, retries=1)
    again = run(make, asks[:1], errors=retries, outages=[(50_000, 800_000)])
    later = run(make, [Ask(800_000, "a", 1000)])
    assert again.deliveries[0].time == later.deliveries[0].time
    assert (again.deliveries[0].attempts, again.link.retransmissions) == (2, 1)
    assert again.deliveries[0].transferred == 50_000 + later.deliveries[0].transferred


@pytest.mark.parametrize("make", ALL)
def test_what_no_link_carries_is_refused(make: Make) -> None:
    for bits in (0, -8):
        with pytest.raises(RunError, match=f"link: a message of {bits} bits"):
            next(make(simpy.Environment()).send("a", "b", "map", bits))
    link = make(simpy.Environment(), **({} if "shared" in make.__name__ else {"between": ("a", "b")}))
    if link.between:
        with pytest.raises(RunError, match=r"link: 'hosst' is no end of this link\n.*accepted: a, b"):
            next(link.post("hosst", "b", "map", 8))
    assert (link.sent, link.in_flight) == (0, 0)


@pytest.mark.parametrize("make", ALL)
def test_run_ahead_equals_visit_by_visit_with_a_failing_link_in_play(make: Make) -> None:
    """An FPGA computes while its link carries what it said, with errors and an outage."""

    def told(granularity: Granularity) -> tuple[list[Record], list[Delivery]]:
        environment = simpy.Environment()
        heard: list[Record] = []
        deliveries: list[Delivery] = []
        fpga = Fpga(environment, "fpga", ClockDomain(100_000_000), (heard.append,))
        spans = [(2_000_000, 2_600_000)]
        link = make(environment, listeners=(heard.append,), errors=all_errors(), outages=spans)

        def steps() -> Generator[Step, None, None]:
            yield Step("relax", np.full(50, 3), lambda begin, end, who: TaskRecord(begin, who, "relax", end, 150))

        def speak() -> Work:
            for index in range(12):
                yield from fpga.execute(steps(), granularity)
                carrier = yield from link.post("a", "b", str(index), 40 + index)
                deliveries.append((yield carrier))

        environment.process(speak())
        for index in range(30):
            environment.process(later(environment, link, Ask(130_000 * index, "b", 64), "scan"))
        environment.run()
        return heard, deliveries

    assert told(Granularity.RUN_AHEAD) == told(Granularity.VISIT)
