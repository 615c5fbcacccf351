"""Quantities: what is read, what is refused and with which hint; clock edges that never drift."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from codesign.ground.errors import InputError
from codesign.ground.units import (
    MAX_FREQUENCY,
    SCALES,
    Dimension,
    cycles_by,
    edge,
    format_count,
    format_data,
    format_energy,
    format_exact,
    format_frequency,
    format_power,
    format_quantity,
    format_time,
    parse_quantity,
)

frequencies = st.one_of(
    st.integers(1, MAX_FREQUENCY),
    st.sampled_from([1, 3, 7, 33_000_000, 33_333_333, 66_666_666, 150_000_000, 10**9, 2 * 10**9, MAX_FREQUENCY]),
)


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("1 ps", Dimension.TIME, 1),
        ("42.088 ns", Dimension.TIME, 42_088),
        ("100us", Dimension.TIME, 10**8),
        ("100 \N{MICRO SIGN}s", Dimension.TIME, 10**8),
        ("100 \N{GREEK SMALL LETTER MU}s", Dimension.TIME, 10**8),
        ("0 s", Dimension.TIME, 0),
        ("1e3 s", Dimension.TIME, 10**15),
        ("2 min", Dimension.TIME, 120 * 10**12),
        ("1000 h", Dimension.TIME, 3_600_000 * 10**12),
        ("150 MHz", Dimension.FREQUENCY, 150_000_000),
        ("33.333333 MHz", Dimension.FREQUENCY, 33_333_333),
        ("2 GHz", Dimension.FREQUENCY, 2 * 10**9),
        ("5 Mb/s", Dimension.DATA_RATE, 5_000_000),
        ("5 MB/s", Dimension.DATA_RATE, 40_000_000),
        ("1 KiB", Dimension.DATA, 8192),
        ("1 kB", Dimension.DATA, 8000),
        ("1.475 uW", Dimension.POWER, Fraction(1475, 10**9)),
        ("20 mJ", Dimension.ENERGY, Fraction(1, 50)),
        ("5 cm", Dimension.LENGTH, Fraction(1, 20)),
        ("20 mA", Dimension.CURRENT, Fraction(1, 50)),
        ("1.2 V", Dimension.VOLTAGE, Fraction(6, 5)),
        ("2m/s^2", Dimension.ACCELERATION, Fraction(2)),
        ("2 m/s\N{SUPERSCRIPT TWO}", Dimension.ACCELERATION, Fraction(2)),
    ],
)
def test_reads(text: str, dimension: Dimension, value: int | Fraction) -> None:
    parsed = parse_quantity(text, dimension)
    assert parsed == value
    assert isinstance(parsed, int if SCALES[dimension].whole else Fraction)


@pytest.mark.parametrize(
    ("text", "dimension", "message"),
    [
        ("150", Dimension.FREQUENCY, "'150' has no unit"),
        ("1 mhz", Dimension.FREQUENCY, "did you mean MHz?"),
        ("1 mHz", Dimension.FREQUENCY, "did you mean MHz?"),
        ("1 MHZ", Dimension.FREQUENCY, "did you mean MHz?"),
        ("5 mb/s", Dimension.DATA_RATE, "did you mean Mb/s or MB/s?"),
        ("5 MS", Dimension.TIME, "did you mean ms?"),
        ("1.5 ps", Dimension.TIME, "not a whole number of ps"),
        ("0.1 Hz", Dimension.FREQUENCY, "not a whole number of Hz"),
        ("0 MHz", Dimension.FREQUENCY, "is zero"),
        ("-1 ns", Dimension.TIME, "is negative"),
        ("1001 h", Dimension.TIME, "is too large"),
        ("2e12 Hz", Dimension.FREQUENCY, "is too large"),
        ("1e999 W", Dimension.POWER, "is too large"),
        ("1e9999 W", Dimension.POWER, "no unit of power"),
        (".inf s", Dimension.TIME, "not a finite time"),
        ("nan s", Dimension.TIME, "not a finite time"),
        ("infinity Hz", Dimension.FREQUENCY, "not a finite frequency"),
        ("1,5 ms", Dimension.TIME, "is not a time"),
        ("1 MHz 2", Dimension.FREQUENCY, "no unit of frequency"),
        ("", Dimension.TIME, "is not a time"),
        ("", Dimension.ENERGY, "is not an energy"),
        ("-1 B", Dimension.DATA, "is negative\n  hint: an amount of data is at least 0"),
        ("MHz", Dimension.FREQUENCY, "is not a frequency"),
        ("1/3 s", Dimension.TIME, "no unit of time"),
        ("٣ s", Dimension.TIME, "is not a time"),
        ("1" * 100_000 + " s", Dimension.TIME, "is not a time"),
        ("5 m", Dimension.TIME, "accepted units: ps, ns, us, ms, s, min, h"),
    ],
)
def test_refuses(text: str, dimension: Dimension, message: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_quantity(text, dimension)
    assert message in str(caught.value)
    assert len(str(caught.value)) < 300


@given(st.data(), st.sampled_from(list(Dimension)))
def test_exact_text_reads_back(data: st.DataObject, dimension: Dimension) -> None:
    scale = SCALES[dimension]
    least = 0 if scale.zero else 1
    thousandths = data.draw(st.integers(least * 1000, int(scale.most) * 1000))
    value = Fraction(thousandths // 1000) if scale.whole else Fraction(thousandths, 1000)
    assert parse_quantity(format_exact(value, dimension), dimension) == value


@given(st.text(max_size=70), st.sampled_from(list(Dimension)))
def test_any_text_is_read_or_refused(text: str, dimension: Dimension) -> None:
    try:
        parsed = parse_quantity(text, dimension)
    except InputError:
        return
    assert 0 <= parsed <= SCALES[dimension].most


@given(st.integers(0, 10**12), frequencies)
def test_edges_are_exact_and_do_not_drift(cycles: int, hertz: int) -> None:
    time = edge(cycles, hertz)
    # The first whole picosecond not before the true edge: less than 1 ps late, however many cycles.
    assert 0 <= Fraction(time) - Fraction(cycles * 10**12, hertz) < 1
    assert edge(cycles * hertz, hertz) == cycles * 10**12


@given(st.integers(0, 10**12), frequencies)
def test_the_last_edge_is_found_again(cycles: int, hertz: int) -> None:
    assert cycles_by(edge(cycles, hertz), hertz) == cycles
    if cycles:
        assert cycles_by(edge(cycles, hertz) - 1, hertz) == cycles - 1
        assert edge(cycles, hertz) > edge(cycles - 1, hertz)


@given(st.integers(0, 10**18), frequencies)
def test_the_last_edge_is_not_after_the_time(time: int, hertz: int) -> None:
    last = cycles_by(time, hertz)
    assert edge(last, hertz) <= time < edge(last + 1, hertz)


def test_a_sum_of_rounded_cycles_would_drift() -> None:
    assert edge(3_000_000, 150_000_000) == 2 * 10**10
    assert 3_000_000 * edge(1, 150_000_000) == 2 * 10**10 + 10**6


def test_texts_for_humans() -> None:
    assert [format_time(ps) for ps in (0, 1, 999, 1000, 6667, 1_250_000_000, 10**12, 90 * 10**12)] == [
        "0 ps",
        "1 ps",
        "999 ps",
        "1 ns",
        "6.667 ns",
        "1.25 ms",
        "1 s",
        "90 s",
    ]
    assert format_time(999_999) == "1 us"
    assert format_frequency(33_333_333) == "33.33 MHz"
    assert format_power(0.000_0015) == "1.5 uW"
    assert format_energy(1234.5) == "1.234 kJ"
    assert format_energy(4.2e-15) == "0.0042 pJ"
    assert format_data(1_000_000) == "1 Mb"
    assert format_count(1_234_567) == "1,234,567"
    assert format_quantity(12345, Dimension.LENGTH) == "12.35 km"
    assert format_quantity(5_000_000_000, Dimension.FREQUENCY, digits=2) == "5 GHz"


def test_no_exact_text_of_a_third() -> None:
    with pytest.raises(InputError, match="no finite decimal form"):
        format_exact(Fraction(1, 3), Dimension.POWER)
