from __future__ import annotations

import tracemalloc
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.ground.memo import Memo, approximate_bytes


def test_an_answer_is_computed_once() -> None:
    memo = Memo()
    calls = []
    for _ in range(3):
        assert memo.get(("a", 1), lambda: calls.append(1) or "answer") == "answer"
    assert calls == [1]
    assert (memo.hits, memo.misses, len(memo)) == (2, 1, 1)


def test_none_is_an_answer() -> None:
    memo = Memo()
    memo.get(("none",), lambda: None)
    assert memo.get(("none",), lambda: 1) is None


def test_the_least_recently_used_goes_first() -> None:
    memo = Memo(max_bytes=3 * 8192)
    for name in ("first", "second"):
        memo.get((name,), lambda: np.zeros(1024))
    memo.get(("first",), lambda: pytest.fail("is kept"))
    memo.get(("third",), lambda: np.zeros(1024))
    memo.get(("first",), lambda: pytest.fail("was used later than the second"))
    with pytest.raises(LookupError):
        memo.get(("second",), lambda: {}["recomputed"])


def test_what_is_too_large_is_handed_back_but_not_kept() -> None:
    memo = Memo(max_bytes=1000)
    memo.get(("small",), lambda: 1)
    assert memo.get(("large",), lambda: np.zeros(1000)).size == 1000
    assert len(memo) == 1


def test_nothing_is_kept_of_a_computation_that_raises() -> None:
    memo = Memo()
    with pytest.raises(ZeroDivisionError):
        memo.get(("x",), lambda: 1 // 0)
    assert memo.get(("x",), lambda: 2) == 2


def test_a_computation_may_use_the_memo_even_for_its_own_key() -> None:
    memo = Memo()
    assert memo.get(("x",), lambda: memo.get(("y",), lambda: 1) + memo.get(("x",), lambda: 5)) == 6
    assert len(memo) == 2
    assert memo.held_bytes == sum(size for _, size in memo._kept.values())


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 400)), max_size=60))
def test_it_never_holds_more_than_its_bound_and_never_answers_wrong(asked: list[tuple[int, int]]) -> None:
    memo = Memo(max_bytes=4000)
    for key, size in asked:
        assert memo.get((key, size), lambda size=size: bytes(size)) == bytes(size)
        assert memo.held_bytes <= 4000
        assert memo.held_bytes == sum(held for _, held in memo._kept.values())


@dataclass(frozen=True, slots=True)
class Slotted:
    array: object


def test_bytes_count_buffers_views_objects_and_slots() -> None:
    array = np.zeros(10_000)
    assert approximate_bytes(array) >= 80_000
    assert approximate_bytes(array[::1000]) >= 80_000
    assert approximate_bytes(Slotted(array)) >= 80_000
    assert approximate_bytes((array, array)) < 90_000
    assert approximate_bytes([bytes(1000)] * 50) < 2500
    large = np.array([1 << 1000 << index for index in range(100)], dtype=object)
    assert approximate_bytes(large) >= 100 * 150


def test_bytes_agree_with_the_allocator() -> None:
    tracemalloc.start()
    before, _ = tracemalloc.get_traced_memory()
    value = {index: [float(index), str(index) * 10, {"key": (index, index + 0.5)}] for index in range(1000, 3000)}
    after, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert approximate_bytes(value) == pytest.approx(after - before, rel=0.25)
