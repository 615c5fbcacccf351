"""Words of a block RAM: write modes, collisions, and the harmonic node's bit-serial update on two ports."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
import simpy
from component_builds import a_block_ram_on_show, simulate
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from codesign.components import BlockRam, ClockDomain, choose_shape
from codesign.components.block_ram import PORTS, Output, Scan, WriteMode
from codesign.ground.errors import RunError

CLOCK = ClockDomain(100_000_000)
MODES = list(WriteMode)


def a_ram(
    first: WriteMode = WriteMode.WRITE_FIRST,
    second: WriteMode = WriteMode.WRITE_FIRST,
    *,
    depth: int = 64,
    width: int = 18,
) -> BlockRam:
    environment = simpy.Environment()
    environment.run(until=10**12)
    return BlockRam(environment, "ram", CLOCK, depth=depth, width=width, contents=True, write_modes=(first, second))


def test_a_word_written_is_read_from_the_next_cycle_on() -> None:
    ram = a_ram()
    ram.write(0, 0, 5, 77)
    assert ram.read(1, 1, 5) == Output(77)
    assert ram.read(0, 1, 6) == Output(0)
    assert ram.read(0, 9, 5) == Output(77)
    assert ram.accesses == [3, 1]
    assert ram.busy == 3 * 10_000
    assert ram.collisions == 0


@pytest.mark.parametrize(
    ("mode", "shown"), [(WriteMode.READ_FIRST, 3), (WriteMode.WRITE_FIRST, 9), (WriteMode.NO_CHANGE, 7)]
)
def test_what_a_port_shows_while_it_writes(mode: WriteMode, shown: int) -> None:
    ram = a_ram(mode)
    ram.write(1, 0, 1, 3)
    ram.write(1, 1, 2, 7)
    assert ram.read(0, 2, 2) == Output(7)
    assert ram.write(0, 3, 1, 9) == Output(shown)
    assert ram.read(0, 4, 1) == Output(9)


@pytest.mark.parametrize("reads_first", [True, False])
@pytest.mark.parametrize("writer", range(PORTS))
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("other", MODES)
def test_the_other_port_sees_the_old_word_under_read_first_only(
    mode: WriteMode, other: WriteMode, writer: int, reads_first: bool
) -> None:
    """What counts is the mode of the port that writes, whichever access is told first."""
    modes = (mode, other) if writer == 0 else (other, mode)
    ram = a_ram(*modes)
    ram.write(0, 0, 3, 40)
    if reads_first:
        output = ram.read(1 - writer, 1, 3)
        ram.write(writer, 1, 3, 41)
    else:
        ram.write(writer, 1, 3, 41)
        output = ram.read(1 - writer, 1, 3)
    assert output == Output(40, mode is WriteMode.READ_FIRST)
    assert ram.collisions == (mode is not WriteMode.READ_FIRST)
    # The word itself is written in any case.
    assert ram.read(0, 2, 3) == Output(41)


def test_two_writes_of_one_word_leave_it_unknown_until_the_next() -> None:
    ram = a_ram()
    assert [ram.write(0, 0, 8, 1).valid, ram.write(1, 0, 8, 2).valid] == [True, False]
    assert ram.collisions == 1
    assert not ram.read(0, 1, 8).valid
    assert ram.read(1, 1, 9).valid
    ram.write(1, 2, 8, 6)
    assert ram.read(0, 3, 8) == Output(6)
    # The same value from both sides is no collision (UG190).
    ram.write(0, 4, 8, 5)
    ram.write(1, 4, 8, 5)
    assert ram.read(0, 5, 8) == Output(5)
    assert ram.collisions == 1


def test_what_cannot_be_is_refused() -> None:
    ram = a_ram(depth=16, width=4)
    ram.read(0, 3, 1)
    with pytest.raises(RunError, match="port 0 takes a second address in cycle 3"):
        ram.write(0, 3, 2, 1)
    with pytest.raises(RunError, match="16 does not fit a word of 4 bits"):
        ram.write(1, 3, 2, 16)
    with pytest.raises(RunError, match="port 0, word 16"):
        ram.read(0, 4, 16)
    with pytest.raises(RunError, match="port 2, word 1"):
        ram.read(2, 4, 1)
    with pytest.raises(RunError, match="out of order"):
        ram.read(0, 2, 1)
    with pytest.raises(RunError, match="out of order") as caught:
        ram.read(0, -1, 1)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    assert ram.access(3) == 1
    with pytest.raises(RunError, match="3 accesses in cycle 3"):
        ram.access(3)
    books = BlockRam(simpy.Environment(), "books", CLOCK, depth=16, width=4)
    with pytest.raises(RunError, match="contents=True"):
        books.read(0, 0, 0)


def test_a_stream_after_a_single_access_takes_the_other_port() -> None:
    ram = a_ram()
    ram.read(1, 4, 0)
    ram.stream(4, 3, addresses=1)
    assert ram.accesses == [3, 1]
    with pytest.raises(RunError, match="3 accesses in cycle 6"):
        ram.stream(6, 2, addresses=2)


def test_a_display_takes_port_1_in_its_cycles() -> None:
    environment = simpy.Environment()
    ram = BlockRam(environment, "ram", CLOCK, depth=16, width=4, contents=True)
    ram.scanned_by(Scan(2, 1, 4, 2), ClockDomain(50_000_000))
    environment.run(until=CLOCK.edge(32))
    # Pixels 0 and 1 of 8: cycles 0 and 2 of 16.
    with pytest.raises(RunError, match="port 1 takes a second address in cycle 0"):
        ram.read(1, 0, 1)
    ram.read(0, 0, 1)
    ram.read(1, 1, 1)
    ram.read(0, 1, 1)
    assert ram.access(2) == 0
    assert ram.accesses == [3, 5]
    assert ram.busy == (3 + 2) * 10_000


accesses = st.lists(
    st.lists(
        st.tuples(st.integers(0, 1), st.integers(0, 3), st.none() | st.integers(0, 7)),
        min_size=1,
        max_size=2,
        unique_by=lambda access: access[0],
    ),
    max_size=25,
)


@settings(max_examples=examples(200))
@given(accesses, st.sampled_from(MODES), st.sampled_from(MODES))
def test_any_traffic_against_a_table(
    cycles: list[list[tuple[int, int, int | None]]], first: WriteMode, second: WriteMode
) -> None:
    """The rules written out once more, cycle by cycle: (value or None for unknown) of every word."""
    ram = a_ram(first, second, depth=4, width=3)
    words: list[int | None] = [0] * 4
    shown: list[int | None] = [0, 0]
    collisions = 0
    for cycle, asked in enumerate(cycles):
        outputs = {
            port: ram.read(port, cycle, address) if value is None else ram.write(port, cycle, address, value)
            for port, address, value in asked
        }
        expected: dict[int, int | None] = {}
        for port, address, value in asked:
            old, mode = words[address], (first, second)[port]
            expected[port] = old
            if value is not None and mode is WriteMode.WRITE_FIRST:
                expected[port] = value
            if value is not None and mode is WriteMode.NO_CHANGE:
                expected[port] = shown[port]
        writes: dict[int, int | None] = {address: value for _, address, value in asked if value is not None}
        if len(asked) == 2 and asked[0][1] == asked[1][1] and writes:
            (one, _, a), (two, _, b) = asked
            if a is not None and b is not None:
                if a != b:
                    expected, collisions = {one: None, two: None}, collisions + 1
                    writes[asked[0][1]] = None
            else:
                writer, reader = (one, two) if a is not None else (two, one)
                if (first, second)[writer] is not WriteMode.READ_FIRST:
                    expected[reader], collisions = None, collisions + 1
        for port, output in outputs.items():
            assert (output.value if output.valid else None) == expected[port]
            shown[port] = expected[port]
        for address, value in writes.items():
            words[address] = value
    assert ram.collisions == collisions


# ---------------------------------------------------------------------- the harmonic node (Girau et al. 2008)

SOUTHWARD, EASTWARD = 3, 6
NODES = SOUTHWARD * EASTWARD


def serial_update(ram: BlockRam, precision: int, first: int) -> None:
    """One iteration of a 3 × 6 cluster, border 0: bit i of all nodes read, bit i - 2 of all averages written.

    Two full adders add the four neighbours' bits with what is carried, and the sum's bits 0 and 1 are left away.
    """
    carry = np.zeros(NODES, np.int64)
    for cycle in range(precision + 2):
        bits = np.zeros(NODES, np.int64)
        if cycle < precision:
            output = ram.read(0, first + cycle, cycle)
            assert output.valid
            bits = output.value >> np.arange(NODES) & 1
        grid = np.pad(bits.reshape(SOUTHWARD, EASTWARD), 1)
        total = carry + (grid[:-2, 1:-1] + grid[2:, 1:-1] + grid[1:-1, :-2] + grid[1:-1, 2:]).ravel()
        carry = total >> 1
        if cycle >= 2:
            ram.write(1, first + cycle, cycle - 2, int(((total & 1) << np.arange(NODES)).sum()))
    # "There is no more carry equal to 1 when writing the last bit": four p-bit numbers have p + 2 bits.
    assert not carry.any()


def stored(ram: BlockRam, precision: int, cycle: int) -> np.ndarray:
    words = [ram.read(0, cycle + bit, bit).value for bit in range(precision)]
    return sum((word >> np.arange(NODES) & 1) << bit for bit, word in enumerate(words))  # type: ignore[return-value]


@settings(max_examples=60)
@given(st.integers(3, 40), st.integers(1, 4), st.integers(0, 2**32), st.sampled_from(MODES))
def test_bit_serial_averages_from_block_ram_are_those_of_integers(
    precision: int, iterations: int, seed: int, mode: WriteMode
) -> None:
    """floor((N + E + S + W) / 4), in p + 2 cycles an iteration, on two ports, whatever the write mode."""
    values = np.random.Generator(np.random.PCG64([seed])).integers(0, 2**precision, NODES)
    ram = a_ram(mode, mode)
    for bit in range(precision):
        ram.write(0, bit, bit, int(((values >> bit & 1) << np.arange(NODES)).sum()))
    cycle = precision
    for _ in range(iterations):
        serial_update(ram, precision, cycle)
        cycle += precision + 2
        grid = np.pad(values.reshape(SOUTHWARD, EASTWARD), 1)
        values = ((grid[:-2, 1:-1] + grid[2:, 1:-1] + grid[1:-1, :-2] + grid[1:-1, 2:]) // 4).ravel()
    assert stored(ram, precision, cycle).tolist() == values.tolist()
    # Bit i is read while bit i - 2 is written: never the same word, so no write mode is asked for.
    assert ram.collisions == 0


def test_the_third_address_of_the_text_does_not_fit_two_ports() -> None:
    """Section 5.2 reads bit i (LSB first), writes bit i - 2, and reads bit p - 1 - i (MSB first) in one cycle."""
    precision = 16
    ram = a_ram()
    for cycle in range(2):
        ram.read(0, cycle, cycle)
        ram.read(1, cycle, precision - 1 - cycle)
    ram.read(0, 2, 2)
    ram.write(1, 2, 0, 1)
    for port in range(PORTS):
        with pytest.raises(RunError, match=f"port {port} takes a second address in cycle 2"):
            ram.read(port, 2, precision - 3)
    with pytest.raises(RunError, match="3 accesses in cycle 3"):
        ram.stream(3, precision, addresses=3)


@settings(max_examples=60)
@given(st.lists(st.integers(0, 2**12 - 1), min_size=5, max_size=5))
def test_maxima_are_found_lsb_first_on_the_bits_that_are_read_anyway(values: list[int]) -> None:
    """The alternative that fits: a ≥ b from the LSB up, the last bit that differs decides."""
    precision, (here, *neighbours) = 12, values
    ram = a_ram(width=5)
    for bit in range(precision):
        ram.write(0, bit, bit, sum((value >> bit & 1) << node for node, value in enumerate(values)))
    above = [True] * 4
    for bit in range(precision):
        word = ram.read(0, precision + bit, bit).value
        ram.write(1, precision + bit, 32 + bit, 0)
        own = word & 1
        for node in range(4):
            other = word >> (node + 1) & 1
            above[node] = above[node] if own == other else own > other
    assert all(above) == (here >= max(neighbours))
    assert ram.collisions == 0


def ram_at_the_end_of_time() -> BlockRam:
    environment = simpy.Environment()
    environment.run(until=10**9)
    return BlockRam(environment, "ram", CLOCK, depth=1024, width=18)


def test_block_ram_refuses_the_third_access_of_a_cycle() -> None:
    ram = ram_at_the_end_of_time()
    assert (ram.access(7), ram.access(7)) == (0, 1)
    with pytest.raises(RunError, match="3 accesses in cycle 7, the block RAM has 2 ports"):
        ram.access(7)
    assert ram.access(8) == 0
    assert ram.accesses == [2, 1]
    assert ram.busy == CLOCK.edge(9) - CLOCK.edge(7)


def test_block_ram_streams_leave_the_ports_they_do_not_use() -> None:
    ram = ram_at_the_end_of_time()
    ram.stream(3, 10, addresses=1)
    assert ram.access(12) == 1
    with pytest.raises(RunError, match="ports"):
        ram.access(12)
    with pytest.raises(RunError, match="3 accesses in cycle 13"):
        ram.stream(13, 4, addresses=3)
    with pytest.raises(RunError, match="out of order"):
        ram.access(5)
    with pytest.raises(RunError, match="before they happen"):
        ram.access(10**9)
    ram.stream(13, 1, addresses=2)
    assert ram.accesses == [11, 2]
    assert ram.busy == CLOCK.edge(14) - CLOCK.edge(3)


def test_block_ram_words_run_out_at_the_published_limit() -> None:
    """Section 5.4: 4 blocks with p = 255 fill the 1024 words exactly; a fifth does not fit."""
    ram = ram_at_the_end_of_time()
    for block in range(4):
        assert ram.allocate(f"block {block}", 256) == range(256 * block, 256 * block + 256)
    assert ram.words_left == 0
    with pytest.raises(RunError, match="block 4 needs 256 words, 0 of 1024 are left"):
        ram.allocate("block 4", 256)
    with pytest.raises(RunError, match="once for each name"):
        ram.allocate("block 0", 1)


def test_the_deepest_shape_that_is_wide_enough_is_chosen() -> None:
    shapes = [(16384, 1), (8192, 2), (4096, 4), (2048, 9), (1024, 18), (512, 36)]
    assert [choose_shape(shapes, width) for width in (1, 3, 18, 19)] == [(16384, 1), (4096, 4), (1024, 18), (512, 36)]
    with pytest.raises(RunError, match=r"no shape of the block RAM is 37 bits wide\n.*36"):
        choose_shape(shapes, 37)


def test_a_block_ram_on_show_is_busy_with_both() -> None:
    """A pixel a cycle: 4 of 6 in two of three lines; the design drives a port in 3 to 7, both in 9 to 14."""
    ram, _ = simulate(a_block_ram_on_show)
    assert isinstance(ram, BlockRam)
    passed = ram.clock.cycles_by(ram.now)
    shown = {cycle for cycle in range(passed) if cycle % 18 // 6 < 2 and cycle % 6 < 4}
    design = {*range(3, 8), *range(9, 15)}
    assert ram.busy == pytest.approx(len(shown | design) * 10**12 / ram.clock.hz, abs=4)
    # Both ports are driven in 9 to 14: in the cycles that the display takes, the design's stand still.
    lost = len(set(range(9, 15)) & shown)
    assert ram.accesses == [5 + 6 - lost, 6 - lost + len(shown)]
