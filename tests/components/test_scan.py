"""The display's cycles in closed form against a pixel-by-pixel and cycle-by-cycle reference."""

from __future__ import annotations

from collections.abc import Generator
from fractions import Fraction
from itertools import pairwise
from math import ceil
from typing import Any

import numpy as np
import pytest
import simpy
from examples import examples
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from codesign.components import ClockDomain, Fpga, Granularity, PreemptedError
from codesign.components.block_ram import BlockRam, Claims, Scan, scaled
from codesign.components.display import SVGA_65, VGA, VgaDisplay
from codesign.ground.errors import InputError, RunError
from codesign.ground.records import Record, TaskRecord
from codesign.planners.styles import Step

HZ = [20_000_000, 25_000_000, 25_175_000, 40_000_000, 65_000_000, 100_000_000, 150_000_000]


@st.composite
def scans(draw: st.DrawFn) -> Scan:
    columns, rows = draw(st.integers(1, 9)), draw(st.integers(1, 5))
    window = draw(st.none() | st.tuples(st.integers(1, rows), st.integers(1, columns)))
    blank = draw(st.tuples(st.integers(0, 6), st.integers(0, 3)))
    return Scan(
        columns, rows, columns + blank[0], rows + blank[1], window=window, pixels_a_word=draw(st.integers(1, 4))
    )


def requests_of(scan: Scan, pixels: int) -> list[tuple[int, int]]:
    """(line since time 0, pixel edge) of every word asked for, by walking over the pixels."""
    found = []
    for pixel in range(pixels):
        line, column = divmod(pixel, scan.total_columns)
        rows, columns = scan.fetched
        if line % scan.total_rows < rows and column < columns and column % scan.pixels_a_word == 0:
            found.append((line, pixel))
    return found


def taken_of(scan: Scan, pixel_hz: int, hz: int, cycles: int) -> set[int]:
    """Cycles that a display takes of a memory that answers every cycle, one word after the other."""
    ratio = Fraction(hz, pixel_hz)
    words = requests_of(scan, ceil(cycles / ratio) + 1)
    gaps = [later - earlier for (_, earlier), (_, later) in pairwise(requests_of(scan, 3 * scan.pixels_a_frame))]
    if min(gaps, default=scan.total_columns) * ratio >= 1:
        cells = [ceil(pixel * ratio) for _, pixel in words]
        assert len(set(cells)) == len(cells)
        return set(cells)
    taken: set[int] = set()
    for line in {line for line, _ in words}:
        begin = line * scan.total_columns
        most = min(scan.words_a_line, int(scan.total_columns * ratio))
        run = range(ceil(begin * ratio), ceil(begin * ratio) + most)
        assert taken.isdisjoint(run)
        # The last word of a line comes before the next line begins.
        assert not most or run[-1] + 1 <= ceil((begin + scan.total_columns) * ratio)
        taken |= set(run)
    return taken


def claims_of(scan: Scan, pixel_hz: int, hz: int) -> Claims:
    try:
        return Claims(scan, ClockDomain(pixel_hz), ClockDomain(hz))
    except RunError:
        assume(False)
        raise


@settings(max_examples=examples(200))
@given(scans(), st.sampled_from(HZ), st.sampled_from(HZ))
def test_claims_are_those_of_the_pixels(scan: Scan, pixel_hz: int, hz: int) -> None:
    claims = claims_of(scan, pixel_hz, hz)
    taken = taken_of(scan, pixel_hz, hz, 400)
    expected = [sum(cycle < before for cycle in taken) for before in range(400)]
    assert claims.before(np.arange(400, dtype=np.int64)).tolist() == expected
    assert claims.between(17, 301) == expected[301] - expected[17]


@settings(max_examples=examples(150))
@given(
    scans(),
    st.sampled_from(HZ),
    st.sampled_from(HZ),
    st.integers(0, 60),
    st.lists(st.integers(1, 9), min_size=1, max_size=12),
)
def test_work_ends_where_a_walk_over_the_cycles_says(
    scan: Scan, pixel_hz: int, hz: int, first: int, units: list[int]
) -> None:
    claims = claims_of(scan, pixel_hz, hz)
    work = np.cumsum(units, dtype=np.int64)
    ends = claims.ends(first, work).tolist()
    taken = taken_of(scan, pixel_hz, hz, ends[-1] + 2)
    walked: list[int] = []
    done, cycle = 0, first
    while len(walked) < len(units):
        done += cycle not in taken
        cycle += 1
        if done == work[len(walked)]:
            walked.append(cycle)
    assert ends == walked


def test_work_waits_for_the_end_of_a_dense_line() -> None:
    """One clock for pixels and memory: 800 of 1,000 cycles are the display's, two lines of three."""
    claims = Claims(Scan(800, 2, 1000, 3), ClockDomain(10**8), ClockDomain(10**8))
    ends = claims.ends(0, np.array([1, 2, 200, 201, 401, 1400, 1401], np.int64))
    assert ends.tolist() == [801, 802, 1000, 1801, 2001, 3000, 3801]
    assert claims.ends(799, np.array([1], np.int64)).tolist() == [801]


@given(st.integers(0, 40), st.integers(0, 6))
@settings(max_examples=60)
def test_a_burst_takes_the_beginning_of_every_line(first: int, burst: int) -> None:
    scan = Scan(8, 3, 10, 5)
    claims = Claims(scan, ClockDomain(50_000_000), ClockDomain(75_000_000), burst=burst, words=4)
    # 10 pixels are 15 cycles: 3 of 5 lines begin with `burst` cycles that are taken.
    taken = {15 * line + k for line in range(60) if line % 5 < 3 for k in range(burst)}
    assert claims.between(first, first + 200) == sum(first <= cycle < first + 200 for cycle in taken)
    assert claims.words == 4


def test_frames_of_a_real_display_are_counted_far_from_time_0() -> None:
    """Ten minutes of 640 × 480, closed form: whole frames and the words of each."""
    frame = 800 * 525
    claims = Claims(VGA, ClockDomain(25_175_000), ClockDomain(150_000_000))
    hour = 3600 * 150_000_000
    frames = 3600 * 25_175_000 / frame
    assert claims.between(0, hour) == pytest.approx(frames * 640 * 480, abs=640 * 480)
    assert VGA.requests_before(10**9 * frame + 801) == 10**9 * 640 * 480 + 641
    with pytest.raises(RunError, match="runs beyond"):
        claims.ends(0, np.array([2**61], np.int64))


def test_the_papers_display_has_its_refresh_rate() -> None:
    assert 59 <= 65e6 / SVGA_65.pixels_a_frame <= 61
    assert 59 <= 25.175e6 / VGA.pixels_a_frame <= 61


@given(st.integers(-(10**15), 10**15), st.integers(1, 10**9), st.integers(1, 10**9))
def test_scaling_is_exact(cycles: int, numerator: int, denominator: int) -> None:
    assume(abs(cycles) * numerator // denominator < 2**62)
    found = scaled(np.array([cycles], np.int64), numerator, denominator)[0]
    assert int(found) == cycles * numerator // denominator


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"columns": 0}, "columns"),
        ({"total_columns": 7}, "total_columns"),
        ({"total_rows": 1}, "total_rows"),
        ({"window": (5, 1)}, "window"),
        ({"window": (1, 9)}, "window"),
        ({"pixels_a_word": 0}, "pixels_a_word"),
    ],
)
def test_a_scan_that_cannot_be_is_refused(change: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError, match=key):
        Scan(**{"columns": 8, "rows": 4, "total_columns": 10, "total_rows": 5, **change})


def test_a_display_that_leaves_nothing_is_refused() -> None:
    scan = Scan(8, 4, 8, 4)
    with pytest.raises(RunError, match="takes every cycle"):
        Claims(scan, ClockDomain(10**8), ClockDomain(10**8))
    with pytest.raises(RunError, match="too little in common"):
        Claims(scan, ClockDomain(999_999_999_989), ClockDomain(10**10))
    with pytest.raises(RunError, match="longer than a line"):
        Claims(scan, ClockDomain(10**8), ClockDomain(10**8), burst=9, words=4)


# ---------------------------------------------------------------------- an FPGA beside a display


def steps_of(units: list[list[int]], addresses: int) -> Generator[Step, None, None]:
    for index, cycles in enumerate(units):
        array = np.array(cycles, np.int64)

        def record(begin: int, end: int, source: str, name: str = f"step {index}") -> TaskRecord:
            return TaskRecord(begin, source, name, end, 0)

        yield Step("bf", array, record, addresses)


def beside(
    granularity: Granularity,
    units: list[list[int]],
    addresses: int,
    scan: Scan | None,
    pixel_hz: int = 65_000_000,
    ticks: int = 0,
) -> tuple[list[tuple[int, Record]], BlockRam, Fpga, int]:
    environment = simpy.Environment()
    clock = ClockDomain(150_000_000)
    said: list[tuple[int, Record]] = []

    def hear(record: Record) -> None:
        said.append((int(environment.now), record))

    ram = BlockRam(environment, "ram", clock, depth=1024, width=1)
    if scan is not None:
        VgaDisplay(environment, "screen", ClockDomain(pixel_hz), scan, memory=ram)
    fpga = Fpga(environment, "fpga", clock, (hear,), ram)

    def neighbour() -> Generator[simpy.Event, Any, None]:
        for _ in range(ticks):
            yield environment.timeout(13_334)
            said.append((int(environment.now), Record(int(environment.now), "tick")))

    environment.process(fpga.execute(steps_of(units, addresses), granularity))
    environment.process(neighbour())
    environment.run()
    return said, ram, fpga, int(environment.now)


units = st.lists(st.lists(st.integers(1, 7), min_size=1, max_size=6), min_size=1, max_size=4)


@settings(max_examples=80)
@given(units, st.integers(0, 2), scans(), st.sampled_from(HZ))
def test_an_fpga_beside_a_display_is_the_same_at_both_granularities(
    batches: list[list[int]], addresses: int, scan: Scan, pixel_hz: int
) -> None:
    claims_of(scan, pixel_hz, 150_000_000)
    runs = [beside(granularity, batches, addresses, scan, pixel_hz, 8) for granularity in Granularity]
    (visit, ram, fpga, end), (ahead, other_ram, other, other_end) = runs
    assert visit == ahead
    assert (ram.accesses, ram.busy, fpga.busy, fpga.phases, end) == (
        other_ram.accesses,
        other_ram.busy,
        other.busy,
        other.phases,
        other_end,
    )
    assert ram.busy <= end


@settings(max_examples=80)
@given(units, scans(), st.sampled_from(HZ))
def test_each_access_of_the_display_takes_one_cycle_of_a_design_on_both_ports(
    batches: list[list[int]], scan: Scan, pixel_hz: int
) -> None:
    claims_of(scan, pixel_hz, 150_000_000)
    _, ram, fpga, _ = beside(Granularity.RUN_AHEAD, batches, 2, scan, pixel_hz)
    work = sum(map(sum, batches))
    taken = taken_of(scan, pixel_hz, 150_000_000, 10 * work + 400)
    free = [cycle for cycle in range(10 * work + 400) if cycle not in taken]
    assert fpga.phases["bf"].cycles == free[work - 1] + 1
    lost = fpga.phases["bf"].cycles - work
    # Port 0 is the design's alone, port 1 serves both.
    assert ram.accesses == [work, work + lost]
    assert lost == sum(cycle < fpga.phases["bf"].cycles for cycle in taken)


@pytest.mark.parametrize("addresses", [0, 1])
def test_a_design_that_leaves_a_port_notices_no_display(addresses: int) -> None:
    batches = [[14] * 40, [3]]
    alone = beside(Granularity.RUN_AHEAD, batches, addresses, None)
    shown = beside(Granularity.RUN_AHEAD, batches, addresses, VGA, 25_175_000)
    assert alone[0] == shown[0]
    assert alone[3] == shown[3]
    assert shown[1].accesses[0] == alone[1].accesses[0]
    assert shown[1].accesses[1] > alone[1].accesses[1]


def test_a_display_costs_its_share_of_a_long_search() -> None:
    """65-MHz pixels on a 150-MHz port: 13 of 30 cycles while a line is drawn, 800 of 1344 pixels, 600 of 806 lines."""
    work = 60_000_000
    _, _, fpga, _ = beside(Granularity.RUN_AHEAD, [[work]], 2, SVGA_65, 65_000_000)
    share = Fraction(13, 30) * Fraction(800 * 600, 1344 * 806)
    assert fpga.phases["bf"].cycles == pytest.approx(float(work / (1 - share)), rel=0.005)


@pytest.mark.parametrize("granularity", Granularity)
@given(at=st.integers(0, 400_000), announced=st.booleans())
@settings(max_examples=40)
def test_interrupted_beside_a_display_the_units_done_are_told(
    granularity: Granularity, at: int, announced: bool
) -> None:
    scan = Scan(5, 2, 7, 3)
    environment = simpy.Environment()
    clock = ClockDomain(150_000_000)
    ram = BlockRam(environment, "ram", clock, depth=1024, width=1)
    VgaDisplay(environment, "screen", ClockDomain(65_000_000), scan, memory=ram)
    fpga = Fpga(environment, "fpga", clock, (), ram)
    caught: list[PreemptedError] = []

    def work() -> Generator[simpy.Event, Any, None]:
        try:
            yield from fpga.execute(steps_of([[3] * 10], 2), granularity)
        except PreemptedError as preempted:
            caught.append(preempted)

    process = environment.process(work())

    def obstacle() -> Generator[simpy.Event, Any, None]:
        yield environment.timeout(at)
        if process.is_alive:
            process.interrupt("obstacle")

    if announced:
        environment.process(obstacle())
    elif at:
        environment.run(until=at)
        if process.is_alive:
            process.interrupt("obstacle")
    environment.run()
    assert ram.claims is not None
    ends = [clock.edge(int(end)) for end in ram.claims.ends(0, np.arange(3, 31, 3, dtype=np.int64))]
    for preempted in caught:
        assert preempted.units == sum(end <= at for end in ends)
        assert ram.accesses[0] == preempted.cycles - ram.claims.between(0, preempted.cycles)
    if announced or at:
        assert bool(caught) == (at <= ends[-1])


# ---------------------------------------------------------------------- the display's own account


def test_a_display_counts_frames_words_and_what_it_sees() -> None:
    environment = simpy.Environment()
    scan = Scan(8, 4, 10, 5, window=(2, 6), pixels_a_word=4)
    display = VgaDisplay(environment, "screen", ClockDomain(10**6), scan)
    environment.run(until=50 * 10**6 * 3 + 10**6)
    assert display.frames == 3
    # Three frames of 2 lines of 2 words; the fourth has begun with one.
    assert display.accesses(0, display.now) == 3 * 4 + 1
    assert display.accesses(10**6, 5 * 10**6) == 1
    assert display.accesses(4 * 10**6, 4 * 10**6) == 0
    assert display.busy == (3 * 32 + 1) * 10**6
    assert (display.starved, display.port_cycles, display.port_share) == (0, 0, 0.0)


@given(st.lists(st.integers(0, 400_000), min_size=2, max_size=6), scans(), st.sampled_from(HZ))
@settings(max_examples=80)
def test_accesses_of_spans_add_up(moments: list[int], scan: Scan, pixel_hz: int) -> None:
    clock = ClockDomain(pixel_hz)
    display = VgaDisplay(simpy.Environment(), "screen", clock, scan)
    moments = sorted(moments)
    times = [clock.edge(pixel) for _, pixel in requests_of(scan, clock.cycles_by(400_000) + 2)]
    for begin, end in pairwise(moments):
        assert display.accesses(begin, end) == sum(begin <= time < end for time in times)


def test_a_memory_too_slow_starves_the_display() -> None:
    """Pixels at 65 MHz, words at 20 MHz: of the 8 words of a line of 20 pixels six come in its time."""
    environment = simpy.Environment()
    ram = BlockRam(environment, "ram", ClockDomain(20_000_000), depth=1024, width=8)
    display = VgaDisplay(environment, "screen", ClockDomain(65_000_000), Scan(8, 2, 20, 4), memory=ram)
    environment.run(until=ClockDomain(65_000_000).edge(2 * 80 + 23))
    assert display.starved == 5 * 2
    assert display.port_cycles == 5 * 6
    assert display.port_share == pytest.approx(30 / ram.clock.cycles_by(ram.now))
    assert ram.accesses == [0, 30]
    assert ram.busy == 30 * 50_000
    wider = Scan(8, 2, 20, 4, pixels_a_word=4)
    quick = VgaDisplay(environment, "other", ClockDomain(65_000_000), wider)
    assert quick.starved == 0


def test_one_display_a_memory_from_the_beginning() -> None:
    environment = simpy.Environment()
    ram = BlockRam(environment, "ram", ClockDomain(10**8), depth=16, width=1)
    VgaDisplay(environment, "screen", ClockDomain(10**6), VGA, memory=ram)
    with pytest.raises(RunError, match="two displays"):
        VgaDisplay(environment, "second", ClockDomain(10**6), VGA, memory=ram)
    other = BlockRam(environment, "other", ClockDomain(10**8), depth=16, width=1)
    environment.run(until=5)
    with pytest.raises(RunError, match="too late"):
        VgaDisplay(environment, "late", ClockDomain(10**6), VGA, memory=other)
