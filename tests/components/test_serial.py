"""The serial line: frames, exact times, the FIFO, both directions at once, and parity."""

from __future__ import annotations

import math
from dataclasses import fields
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
import simpy
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from link_runs import Ask, Make, run

from codesign.components import Link, LinkErrors, Parity, Serial
from codesign.components.link import damage_probability, parity_miss
from codesign.ground.errors import InputError
from codesign.laws.acts import SerialLaw


def a_line(**settings: Any) -> Make:
    def make(environment: simpy.Environment, **options: Any) -> Link:
        of_law = {key: settings[key] for key in settings if key in {each.name for each in fields(SerialLaw)}}
        others = {key: settings[key] for key in settings if key not in of_law}
        law = SerialLaw(**{"baud": 115_200} | of_law)
        return Serial(environment, "uart", law, **others, **options)

    return make


def ceil_ps(bits: Fraction | int, baud: int) -> int:
    return math.ceil(Fraction(bits) * 10**12 / baud)


@settings(max_examples=examples(200))
@given(
    bits=st.integers(1, 2000),
    baud=st.integers(50, 10**7),
    data_bits=st.integers(5, 9),
    stop_bits=st.sampled_from([1, 1.5, 2, Fraction(3, 2)]),
    parity=st.sampled_from(Parity),
)
def test_a_message_takes_its_frames(bits: int, baud: int, data_bits: int, stop_bits: float, parity: Parity) -> None:
    make = a_line(baud=baud, data_bits=data_bits, stop_bits=stop_bits, parity=parity)
    seen = run(make, [Ask(7, "a", bits)])
    frame = 1 + data_bits + (parity != "none") + Fraction(stop_bits)
    exact = Fraction(-(-bits // data_bits) * frame)
    assert Fraction(seen.link.law.frame_ticks, 2) == frame  # type: ignore[attr-defined]
    assert seen.deliveries[0].time == 7 + ceil_ps(exact, baud)


def test_one_byte_at_115200_baud_takes_ten_bits() -> None:
    assert run(a_line(), [Ask(0, "a", 8)]).deliveries[0].time == 86_805_556


def test_messages_back_to_back_do_not_drift() -> None:
    """1000 messages of one byte end where one of 1000 bytes does, to the picosecond."""
    seen = run(a_line(stop_bits=1.5), [Ask(0, "a", 8)] * 1000)
    one = run(a_line(stop_bits=1.5), [Ask(0, "a", 8000)])
    assert seen.deliveries[999].time == one.deliveries[0].time == ceil_ps(Fraction(10_500), 115_200)
    ends = [ceil_ps(Fraction(21, 2) * (count + 1), 115_200) for count in range(1000)]
    assert [seen.deliveries[index].time for index in range(1000)] == ends
    assert seen.link.busy == seen.deliveries[999].time


def test_a_message_that_comes_as_the_line_falls_idle_begins_then() -> None:
    end = ceil_ps(10, 300)
    seen = run(a_line(baud=300), [Ask(0, "a", 8), Ask(end, "a", 8)])
    assert seen.deliveries[1].time == 2 * end > ceil_ps(20, 300)
    waited = run(a_line(baud=300), [Ask(0, "a", 8), Ask(end - 1, "a", 8)])
    assert waited.deliveries[1].time == ceil_ps(20, 300)


def test_each_direction_has_a_line_of_its_own() -> None:
    seen = run(a_line(between=("a", "b")), [Ask(0, "a", 800), Ask(0, "b", 800)])
    end = ceil_ps(1000, 115_200)
    assert [seen.deliveries[index].time for index in (0, 1)] == [end, end]
    assert (seen.link.busy, seen.link.transferred) == (end, 2 * end)


def test_more_than_two_ends_share_one_line() -> None:
    seen = run(a_line(between=("a", "b", "c")), [Ask(0, "a", 800), Ask(0, "b", 800), Ask(0, "c", 8)])
    ends = [ceil_ps(bits, 115_200) for bits in (1000, 2000, 2010)]
    assert [seen.deliveries[index].time for index in range(3)] == ends


def test_a_line_of_64_senders_sets_the_pace() -> None:
    """Each sends 8 bytes every 20 ms; at 9600 baud 64 of them take 533 ms a round: messages pile up."""
    robots = tuple(f"robot{index}" for index in range(64))
    asks = [Ask(20_000_000_000 * turn, robot, 64, post=True) for turn in range(4) for robot in robots]
    seen = run(a_line(baud=9600, between=(*robots, "a")), asks)
    assert [delivery.time for _, delivery in sorted(seen.deliveries.items())] == [
        ceil_ps(80 * (index + 1), 9600) for index in range(256)
    ]
    assert seen.link.busy == seen.link.now


@pytest.mark.parametrize(("words", "depth"), [(1, 16), (17, 16), (18, 16), (40, 16), (40, 1), (2, 1)])
def test_a_poster_is_held_until_the_rest_fits_the_fifo(words: int, depth: int) -> None:
    seen = run(a_line(fifo_depth=depth), [Ask(5, "a", 8 * words, post=True)])
    # One word is on the wire, ``depth`` are in the FIFO: the sender waits for the frames before to end.
    before = max(words - depth - 1, 0)
    assert seen.free[0] == 5 + ceil_ps(10 * before, 115_200)
    assert seen.deliveries[0].time == 5 + ceil_ps(10 * words, 115_200)


def test_earlier_messages_take_their_place_in_the_fifo() -> None:
    asks = [Ask(index, "a", 8 * words, post=True) for index, words in enumerate((4, 10, 6, 1))]
    seen = run(a_line(fifo_depth=8), asks)
    # Free when no more than 8 of the words up to one's own last have not begun: of 4, of 14, of 20, of 21 words.
    assert seen.free[0] == 0
    assert [seen.free[index] for index in (1, 2, 3)] == [
        ceil_ps(10 * (words - 8 - 1), 115_200) for words in (14, 20, 21)
    ]


@settings(max_examples=examples(150))
@given(words=st.lists(st.integers(1, 12), max_size=8), depth=st.integers(1, 9))
def test_all_words_given_and_not_on_the_wire_fit_the_fifo(words: list[int], depth: int) -> None:
    """Posted at once: message k is free when at most ``depth`` of the words up to its last have not begun."""
    seen = run(a_line(fifo_depth=depth), [Ask(0, "a", 8 * count, post=True) for count in words])
    total = 0
    for index, count in enumerate(words):
        total += count
        begun = total - depth
        assert seen.free[index] == (ceil_ps(10 * (begun - 1), 115_200) if begun > 0 else 0)


def test_what_stands_in_the_fifo_stays_there_when_an_urgent_message_comes() -> None:
    """5 words, of which 4 wait, and 4 more: the FIFO of 8 is full. The 5 urgent ones pass the 4, but not into it."""
    asks = [Ask(0, "a", 40, 1, True), Ask(1, "a", 32, 1, True), Ask(2, "a", 40, 0, True)]
    seen = run(a_line(fifo_depth=8), asks)
    assert seen.free == {0: 0, 1: 1, 2: ceil_ps(50, 115_200)}
    assert [record.name for record in seen.records] == ["0", "2", "1"]


def test_what_waits_for_its_timeout_is_not_in_the_fifo() -> None:
    end, asked = ceil_ps(200, 115_200), 2 * 10**9
    errors = LinkErrors(drop=1.0, retries=1, timeout=10**12)
    asks = [Ask(0, "a", 160, 1, True), Ask(asked, "a", 240, 0, True)]
    seen = run(a_line(fifo_depth=8), asks, errors=errors)
    assert end < asked
    assert seen.free[1] == asked + ceil_ps(10 * (30 - 8 - 1), 115_200)


def test_what_is_sent_again_as_the_line_falls_idle_begins_then() -> None:
    first, second = ceil_ps(10, 300), ceil_ps(20, 300)
    timeout = second - first
    seen = run(
        a_line(baud=300, between=("a", "b", "c")),
        [Ask(0, "a", 8), Ask(0, "b", 8)],
        errors=LinkErrors(drop=1.0, retries=1, timeout=timeout),
    )
    assert seen.deliveries[0].time == second + first + timeout


def test_an_abandoned_message_makes_room() -> None:
    asks = [Ask(0, "a", 8 * 100, interrupt_at=1_000), Ask(1, "a", 8 * 9, post=True)]
    seen = run(a_line(fifo_depth=8), asks)
    assert seen.free[1] == 1_000


@pytest.mark.parametrize(("rate", "frames", "bits"), list(product([0.0, 0.03, 0.5, 1.0], [1, 2], [2, 3, 5])))
def test_parity_misses_what_has_an_even_number_of_wrong_bits_in_every_frame(
    rate: float, frames: int, bits: int
) -> None:
    damaged = missed = 0.0
    for wrong in product(*[range(2)] * (frames * bits)):
        chance = 1.0
        for bit in wrong:
            chance *= rate if bit else 1 - rate
        if any(wrong):
            damaged += chance
            missed += chance * all(sum(wrong[i : i + bits]) % 2 == 0 for i in range(0, len(wrong), bits))
    assert damage_probability(frames * bits, rate) == pytest.approx(damaged)
    assert parity_miss(frames, bits, rate) == pytest.approx(missed / damaged if damaged else 0.0)


def test_parity_of_rare_errors_does_not_cancel_out() -> None:
    """C(9, 2) pairs in each of 10 frames, of 90 bits that may be wrong: 4e-9 at a rate of 1e-9."""
    assert parity_miss(10, 9, 1e-9) == pytest.approx(10 * 36 * 1e-18 / (90 * 1e-9), rel=1e-6)


@pytest.mark.parametrize(
    ("key", "value"), [("baud", 0), ("data_bits", 0), ("start_bits", -1), ("fifo_depth", 0), ("stop_bits", 3)]
)
def test_a_line_that_cannot_be_is_refused(key: str, value: int) -> None:
    with pytest.raises(InputError, match=rf"uart.{key}: {key} of {value}"):
        a_line(**{key: value})(simpy.Environment())
