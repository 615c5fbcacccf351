from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.components import ClockDomain
from codesign.ground.errors import InputError

clocks = st.integers(1, 10**12).map(ClockDomain)
counts = st.integers(0, 10**13)


@given(clocks, counts)
def test_an_edge_is_its_exact_time_rounded_up(clock: ClockDomain, cycle: int) -> None:
    late = clock.edge(cycle) - Fraction(cycle * 10**12, clock.hz)
    assert 0 <= late < 1


@given(clocks, counts)
def test_edges_rise_and_the_counts_invert_them(clock: ClockDomain, cycle: int) -> None:
    edge = clock.edge(cycle)
    assert clock.edge(cycle + 1) > edge
    assert clock.cycles_by(edge) == clock.cycle_at_or_after(edge) == cycle
    assert clock.next_edge(edge) == edge


@given(clocks, st.integers(0, 10**18))
def test_counts_bracket_any_moment(clock: ClockDomain, time: int) -> None:
    before, after = clock.cycles_by(time), clock.cycle_at_or_after(time)
    assert clock.edge(before) <= time < clock.edge(before + 1)
    assert clock.edge(after) >= time
    assert after == 0 or clock.edge(after - 1) < time
    assert after - before in (0, 1)


def test_150_mhz_does_not_drift_in_an_hour() -> None:
    clock = ClockDomain(150_000_000)
    assert clock.edge(150_000_000 * 3600) == 3600 * 10**12
    assert clock.duration(1) == 6667
    assert clock.duration(1, first=1) == 6667
    assert clock.duration(1, first=2) == 6666


@pytest.mark.parametrize("hz", [0, -1, 10**12 + 1, 1.5, True, "1"])
def test_a_clock_that_is_none_is_refused(hz: object) -> None:
    with pytest.raises(InputError, match="hint: give a whole number of hertz"):
        ClockDomain(hz)  # type: ignore[arg-type]
