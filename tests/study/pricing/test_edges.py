"""Clock edges of many clocks at once, against those of one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from codesign.ground.errors import RunError
from codesign.ground.units import MAX_FREQUENCY, cycles_by, edge
from codesign.study.pricing.machines import Clocks

HERTZ = st.integers(1, MAX_FREQUENCY)


@example([(5 * 10**11 + 1, 10**9), (3, 10)])
@given(st.lists(st.tuples(HERTZ, st.integers(0, 10**7)), min_size=1, max_size=8))
def test_edges_are_those_of_single_clocks(pairs: list[tuple[int, int]]) -> None:
    clocks = Clocks(np.array([hertz for hertz, _ in pairs], np.int64))
    # The longest time of 64 bits is four months: a cycle of a slow clock may lie beyond it.
    cycles = [min(cycle, 10**5 * hertz) for hertz, cycle in pairs]
    edges = clocks.edge(np.array(cycles, np.int64))
    assert edges.tolist() == [edge(cycle, hertz) for (hertz, _), cycle in zip(pairs, cycles, strict=True)]


@example([(10**12 - 1, 10**16), (3, 10**12), (7, 0)])
@given(st.lists(st.tuples(HERTZ, st.integers(0, 10**16)), min_size=1, max_size=8))
def test_the_first_edge_at_or_after_a_time(pairs: list[tuple[int, int]]) -> None:
    clocks = Clocks(np.array([hertz for hertz, _ in pairs], np.int64))
    found = clocks.at_or_after(np.array([time for _, time in pairs], np.int64))
    assert found.tolist() == [cycles_by(time - 1, hertz) + 1 if time else 0 for hertz, time in pairs]


def test_a_time_beyond_64_bits_is_refused() -> None:
    with pytest.raises(RunError, match="beyond 2\\^62 ps"):
        Clocks(np.array([1], np.int64)).edge(np.array([10**7], np.int64))
