"""The bus: its law, its queue, and its turns between bursts against a model without events."""

from __future__ import annotations

import pytest
import simpy
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from link_runs import Ask, a_bus, a_bus_in_bursts, run

from codesign.components import Arbitration, Bus, ClockDomain, LinkErrors
from codesign.ground.errors import InputError, RunError
from codesign.laws.acts import BusLaw

CLOCK = ClockDomain(33_000_000)


def test_messages_queue_and_each_begins_at_an_edge() -> None:
    # 1000 bits: 32 words, 8 bursts of 3 + 4 cycles; 1 bit: 1 burst of 3 + 1; 33 bits: 2 words, 3 + 2.
    asks = [Ask(0, "a", 1000), Ask(100_000, "b", 1), Ask(200_000, "a", 33), Ask(CLOCK.edge(70) + 1, "a", 32)]
    seen = run(a_bus, asks)
    assert isinstance(seen.link, Bus)
    assert [seen.link.ticks(ask.bits) for ask in asks] == [56, 4, 5, 4]
    assert [(record.begin, record.end) for record in seen.records] == [
        (0, CLOCK.edge(56)),
        (CLOCK.edge(56), CLOCK.edge(60)),
        (CLOCK.edge(60), CLOCK.edge(65)),
        (CLOCK.edge(71), CLOCK.edge(75)),
    ]
    assert seen.link.busy == CLOCK.edge(65) + CLOCK.edge(75) - CLOCK.edge(71)
    assert seen.link.queued == sum(record.begin - record.time for record in seen.records)
    assert (seen.link.delivered, seen.link.bits) == (4, 1066)


def test_the_checksum_takes_its_words() -> None:
    seen = run(a_bus, [Ask(0, "a", 32)], errors=LinkErrors(checksum_bits=16))
    assert seen.deliveries[0].time == CLOCK.edge(5)
    assert seen.link.bits == 32


def test_a_poster_goes_on_when_the_bus_has_taken_its_message() -> None:
    seen = run(a_bus, [Ask(0, "b", 32), Ask(0, "a", 32, post=True), Ask(0, "a", 32, post=True)])
    assert seen.free == {1: CLOCK.edge(8), 2: CLOCK.edge(12)}
    # What comes late has left the bus: its sender does not wait for it.
    late = LinkErrors(late_share=1.0, late_delay=10**9)
    seen = run(a_bus, [Ask(0, "a", 32, post=True)], errors=late)
    assert (seen.free[0], seen.deliveries[0].time) == (CLOCK.edge(4), CLOCK.edge(4) + 10**9)


def test_an_urgent_message_is_next_but_breaks_nothing_off() -> None:
    asks = [Ask(0, "a", 320, 1), Ask(10, "b", 32, 1), Ask(20, "a", 32, 0)]
    seen = run(a_bus, asks)
    assert [record.name for record in seen.records] == ["0", "2", "1"]
    assert seen.deliveries[0].time == CLOCK.edge(19)


def test_in_bursts_an_urgent_message_waits_for_one_burst_at_most() -> None:
    # Asked for within the second burst of a long message: 7 cycles a burst.
    asks = [Ask(0, "a", 32 * 400, 1), Ask(CLOCK.edge(9), "b", 32, 0), Ask(CLOCK.edge(9), "a", 32, 0)]
    seen = run(a_bus_in_bursts, asks)
    assert [seen.deliveries[index].time for index in (1, 2)] == [CLOCK.edge(18), CLOCK.edge(22)]
    assert seen.deliveries[0].time == CLOCK.edge(700 + 8)
    assert seen.deliveries[0].transferred == CLOCK.edge(14) + CLOCK.edge(708) - CLOCK.edge(22)


def test_a_message_alone_makes_few_events_whatever_its_bursts() -> None:
    counts = []
    for words in (4, 40_000):
        seen = run(a_bus_in_bursts, [Ask(0, "a", 32 * words)])
        counts.append(len(seen.moments))
    assert counts[0] == counts[1]


asks = st.lists(
    st.builds(
        Ask,
        # Edges of 1 MHz, and moments beside them: ties are common.
        at=st.integers(0, 40).map(lambda half: half * 500_000),
        sender=st.sampled_from("abc"),
        bits=st.integers(1, 9),
        priority=st.sampled_from([0, 1, 1]),
    ),
    max_size=8,
)


@settings(max_examples=examples(300))
@given(asks=asks, setup=st.integers(0, 2), burst=st.integers(1, 3))
def test_bursts_equal_a_model_that_chooses_before_every_burst(asks: list[Ask], setup: int, burst: int) -> None:
    clock = ClockDomain(1_000_000)

    def make(environment: simpy.Environment, **options: object) -> Bus:
        law = BusLaw(clock.hz, width=1, burst_words=burst, setup_cycles=setup)
        return Bus(environment, "link", law, arbitration=Arbitration.BURST, **options)  # type: ignore[arg-type]

    asks = sorted(asks, key=lambda ask: ask.at)
    seen = run(make, asks)

    left = {index: ask.bits for index, ask in enumerate(asks)}
    served = dict.fromkeys("abc", 0)
    ends: dict[int, int] = {}
    time = services = 0
    while left:
        time = clock.next_edge(max(time, min(asks[index].at for index in left)))
        waiting = [index for index in left if asks[index].at <= time]
        heads = {
            sender: min((i for i in waiting if asks[i].sender == sender), key=lambda i: (asks[i].priority, i))
            for sender in {asks[i].sender for i in waiting}
        }
        chosen = min(heads.values(), key=lambda i: (asks[i].priority, served[asks[i].sender], i))
        words = min(burst, left[chosen])
        time += (setup + words) * 1_000_000
        services += 1
        served[asks[chosen].sender] = services
        left[chosen] -= words
        if not left[chosen]:
            ends[chosen] = time
            del left[chosen]
    assert {index: delivery.time for index, delivery in seen.deliveries.items()} == ends
    total = sum(seen.link.ticks(ask.bits) for ask in asks)
    assert seen.link.busy == total * 1_000_000


def test_an_outage_that_begins_as_a_message_ends_does_it_no_harm() -> None:
    for make in (a_bus, a_bus_in_bursts):
        outages = [(CLOCK.edge(56), None)]
        seen = run(make, [Ask(0, "a", 1000), Ask(0, "b", 32 * 400)], outages=outages)
        if make is a_bus:
            assert seen.deliveries[0].reason is None
            assert seen.deliveries[1].attempts == 0
        alone = run(make, [Ask(0, "a", 1000)], outages=outages)
        assert alone.deliveries[0].reason is None
        one_less = run(make, [Ask(0, "a", 1000)], outages=[(CLOCK.edge(56) - 1, None)])
        assert one_less.deliveries[0].reason == "link down"


def test_in_bursts_an_outage_damages_the_message_that_waits_between_its_own() -> None:
    """Two long messages take turns; the outage falls into a burst of the second."""
    asks = [Ask(0, "a", 32 * 40), Ask(0, "b", 32 * 40)]
    errors = LinkErrors(retries=1, timeout=10)
    seen = run(a_bus_in_bursts, asks, errors=errors, outages=[(CLOCK.edge(10), CLOCK.edge(20))])
    assert [seen.deliveries[index].attempts for index in (0, 1)] == [2, 2]
    assert sorted(delivery.time for delivery in seen.deliveries.values()) == [
        CLOCK.edge(20 + 133),
        CLOCK.edge(20 + 140),
    ]
    assert seen.link.busy == CLOCK.edge(10) + CLOCK.edge(160) - CLOCK.edge(20)


def test_in_bursts_an_outage_while_a_message_waits_for_its_edge_damages_it() -> None:
    """The second gives up within its burst; before the edge at which the first goes on, the bus is down and up."""
    given_up = CLOCK.edge(9) + 10
    asks = [Ask(0, "a", 32 * 40), Ask(0, "b", 32 * 40, interrupt_at=given_up)]
    outages = [(given_up + 10, given_up + 20)]
    seen = run(a_bus_in_bursts, asks, outages=outages)
    assert seen.deliveries[0].reason == "link down"
    assert run(a_bus_in_bursts, asks).deliveries[0].time == CLOCK.edge(10 + 63)


@pytest.mark.parametrize(("key", "value"), [("width", 0), ("setup_cycles", -1), ("burst_words", 0)])
def test_a_bus_that_cannot_be_is_refused(key: str, value: int) -> None:
    numbers = {"width": 32, "setup_cycles": 0, "burst_words": 16, key: value}
    with pytest.raises(InputError, match=rf"pci.{key}: {key} of {value}"):
        Bus(simpy.Environment(), "pci", BusLaw(CLOCK.hz, **numbers))
    with pytest.raises(RunError, match="link: a message of 0 bits"):
        a_bus(simpy.Environment()).duration(0)
