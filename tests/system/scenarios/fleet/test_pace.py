"""What sets the pace of a fleet: the closed form and its table."""

from __future__ import annotations

import re
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from places import ROOT

from benchmarks.dubey2013_pace import pace_lines, pace_remarks
from benchmarks.velocity_obstacle_pace import LineLaw, baud_needed, decide_times, pace_table
from codesign.planners.velocity_obstacle.plan import AvoidParameters
from codesign.planners.velocity_obstacle.published import Style

BAUDS = st.integers(300, 20_000_000)
DECIDE = st.fractions(Fraction(1, 10**6), Fraction(1))


def test_a_message_takes_its_characters() -> None:
    assert LineLaw(115_200).message(8) == Fraction(32 * 10, 115_200)
    assert LineLaw(9600, data_bits=7, frame_bits=Fraction(21, 2)).message(1) == Fraction(5 * 21, 2 * 9600)


@given(robots=st.integers(2, 64), baud=BAUDS, fifo=st.integers(1, 300), decide=DECIDE)
def test_the_period_lies_between_what_overlaps_and_what_does_not(
    robots: int, baud: int, fifo: int, decide: Fraction
) -> None:
    line = LineLaw(baud, fifo_depth=fifo)
    period, message = line.period(robots, decide), line.message(robots)
    assert max(message, decide) <= period <= message + decide
    assert LineLaw(baud, fifo_depth=fifo + 1).period(robots, decide) <= period
    assert LineLaw(baud + 1, fifo_depth=fifo).period(robots, decide) <= period
    if fifo >= line.characters(robots):
        assert period == max(message, decide)


@given(
    robots=st.integers(2, 64), baud=BAUDS, fifo=st.integers(1, 300), decides=st.lists(DECIDE, min_size=2, max_size=30)
)
def test_the_mean_period_is_that_of_the_updates_and_not_of_the_mean_update(
    robots: int, baud: int, fifo: int, decides: list[Fraction]
) -> None:
    line = LineLaw(baud, fifo_depth=fifo)
    found, later = line.mean_period(robots, decides), decides[1:]
    each = sum((line.period(robots, decide) for decide in later), Fraction(0)) / len(later)
    mean = sum(later, Fraction(0)) / len(later)
    if line.characters(robots) > fifo:
        assert found == each >= line.period(robots, mean)
    else:
        # What the FIFO holds makes up for slow updates: of one message, or of several.
        messages = fifo // line.characters(robots) + 1
        spared = messages * max(decides) / len(later)
        assert max(line.message(robots), mean - spared) <= found <= each
    assert line.mean_period(robots, [max(decides)] * len(decides)) >= found
    assert LineLaw(baud, fifo_depth=fifo + 1).mean_period(robots, decides) <= found


@given(robots=st.integers(2, 64), baud=BAUDS, fifo=st.integers(1, 300), decide=DECIDE)
def test_updates_that_are_all_alike_follow_each_other_in_the_closed_form(
    robots: int, baud: int, fifo: int, decide: Fraction
) -> None:
    line = LineLaw(baud, fifo_depth=fifo)
    found, count = line.mean_period(robots, [decide] * 400), 399
    # Where the message is the shorter, an update more or less may stand in the FIFO at the end.
    slack = (fifo // line.characters(robots) + 1) * line.period(robots, decide) / count
    assert abs(found - line.period(robots, decide)) <= slack
    if line.characters(robots) > fifo:
        assert found == line.period(robots, decide)


@given(robots=st.integers(2, 64), baud=BAUDS, decide=DECIDE)
def test_baud_and_robots_at_which_the_line_begins_to_set_the_pace(robots: int, baud: int, decide: Fraction) -> None:
    needed = baud_needed(robots, decide)
    assert (LineLaw(baud).message(robots) > decide) == (baud < needed)
    most = LineLaw(baud).robots_within(decide)
    assert LineLaw(baud).message(most) <= decide < LineLaw(baud).message(most + 1)


def test_24_robots_fill_9600_baud_in_real_time() -> None:
    assert LineLaw(9600).robots_within(Fraction(1, 10)) == 24
    assert LineLaw(115_200).robots_within(Fraction(1, 10)) == 288


def test_the_table_names_what_is_longer() -> None:
    parameters = AvoidParameters(range=20.0, updates=200)
    rows = pace_table((2, 64), (9600, 115_200, 20_000_000), parameters=parameters)
    assert [(row.robots, row.baud) for row in rows] == [
        (robots, baud) for robots in (2, 64) for baud in (9600, 115_200, 20_000_000)
    ]
    assert [row.pace for row in rows] == ["line"] * 5 + ["fpga"]
    assert [row.in_real_time for row in rows] == [True, True, True, False, True, True]
    for row in rows:
        decides = decide_times(row.robots, Style.PIPELINED, parameters, "random")
        assert len(set(decides)) > 1
        assert row.period == LineLaw(row.baud).mean_period(row.robots, decides)
        assert row.decide == sum(decides) / len(decides)


def test_an_unknown_arrangement_is_refused() -> None:
    with pytest.raises(Exception, match="no arrangement"):
        decide_times(4, Style.PIPELINED, AvoidParameters(), "star")


def test_the_page_shows_the_table_that_the_command_prints() -> None:
    page = (ROOT / "docs" / "velocity_obstacle.md").read_text(encoding="utf-8")
    table = "\n".join(pace_lines())
    assert f"\n\n{table}\n\n" in page
    said = page[page.index(table) :]
    assert "python -m benchmarks.dubey2013_pace" in said
    told = [re.findall(r"\d[\d,]*", line) for line in pace_remarks()]
    assert told == [["64", "12,000,000", "2,349", "2,804"], ["10", "24", "9,600", "288", "115,200"], ["8", "3,200"]]
    assert {"2,349", "2,804", "24", "9,600", "288", "115,200", "3,200"} <= set(re.findall(r"\d[\d,]*\d", said))
