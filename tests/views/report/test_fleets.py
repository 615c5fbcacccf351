"""What a reader is told of a fleet: collisions first, what became of every frame, what sets the pace."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_samples import FRAMES, SECOND, a_fleet, a_fleet_result, a_result, a_study, spans

from benchmarks.velocity_obstacle_pace import LineLaw
from codesign.ground.records import MapRecord, MissionRecord, PositionsRecord, Record, TaskRecord
from codesign.study.outcomes import Outcomes
from codesign.system.results.result import FleetFigures, Frames, Spread
from codesign.views.report import comparison_table, result_tables, run_pictures, study_table
from codesign.views.report.result_page import result_html
from codesign.views.report.scenario_tables import fleet_tables
from codesign.views.report.sentences import fleet_headline, pace_text
from codesign.views.report.wording import Table


def in_real_time(decide_s: float = 0.001, **changes: Any) -> FleetFigures:
    shares = {"fpga": 10 * decide_s, "line": 0.0, "time_step": 1 - 10 * decide_s}
    return a_fleet(decide_s, period_s=0.1, **({"pace": "time_step", "shares": shares} | changes))


def values(table: Table) -> dict[str, object]:
    return {str(row[0].value): row[1].value for row in table.rows}


def test_collisions_stand_first_in_table_and_headline() -> None:
    table = fleet_tables(a_fleet_result())[0]
    assert [cell.value for cell in table.rows[0]] == ["pairs of robots that collided", 2]
    assert fleet_headline(a_fleet_result())[0] == ("2", "pairs of robots collided")
    assert fleet_headline(a_fleet_result(collisions=1))[0] == ("1", "pair of robots collided")
    assert fleet_headline(a_fleet_result())[1] == ("7 of 8", "robots at their targets")


def test_the_first_rows_of_a_fleet_say_how_it_ended() -> None:
    first = result_tables(a_fleet_result(a_fleet(ended="an update limit", completed=False)))[0]
    assert [row[0].text for row in first.rows[:2]] == ["ended", "all robots at their targets without a contact"]
    assert [row[1].value for row in first.rows[:2]] == ["an update limit", False]


def test_every_number_of_a_fleet_is_told() -> None:
    """A figure that the models gain must be shown, or be left out here on purpose."""
    fleet = a_fleet()
    shown = {cell.value for table in fleet_tables(a_fleet_result(fleet)) for row in table.rows for cell in row}
    told = {name: getattr(fleet, name) for name in FleetFigures.model_fields}
    nested = {name: told.pop(name) for name in ("decide", "period", "frames", "shares", "fpga_utilisation", "pace")}
    told |= {name: getattr(FRAMES, name) for name in Frames.model_fields if name not in ("receiver", "dropped", "age")}
    assert set(told.values()) <= shown
    assert {3, *nested["fpga_utilisation"], *nested["shares"].values()} <= shown
    every = [getattr(span, name) for span in (fleet.decide, fleet.period, FRAMES.age) for name in Spread.model_fields]
    assert set(every) <= shown


def test_frames_are_all_accounted_for() -> None:
    table = next(table for table in fleet_tables(a_fleet_result()) if table.title == "Frames to pc")
    told = {name: value for name, value in values(table).items() if isinstance(value, int)}
    kept = told["shown"] + told["skipped"] + told["dropped: link down"] + told["under way at the end"]
    assert told["made"] == kept == 100


def test_a_fleet_speaks_of_its_run_and_not_of_a_first_plan() -> None:
    tables = result_tables(a_fleet_result())
    words = {cell.text for table in tables for row in table.rows for cell in row}
    assert {"time of the run", "starts and targets loaded", "last update over"} <= words
    words |= {table.title for table in tables}
    assert "Energy of the run" in words
    assert not any("first" in word for word in words if word.lower().startswith(("time", "first", "energy")))
    assert not fleet_tables(a_result())
    assert "time to the first plan" in {row[0].text for row in result_tables(a_result())[0].rows}


def test_what_is_of_one_board_and_what_of_all_is_told_apart() -> None:
    made = a_fleet_result()
    utilisation = {made.component: 0.1, f"{made.component}.block_ram": 0.2, "other": 0.3}
    result = made.model_copy(update={"utilisation": utilisation, "details": {"trials": 7}})
    tables = {table.title: table for table in result_tables(result)}
    assert "Clock cycles by phase, of the first robot's board" in tables
    of_board = {row[0].value: row[0].text for row in tables["Utilisation"].rows}
    assert of_board == {
        "fpga": "fpga (of the first robot's board)",
        "fpga.block_ram": "fpga.block_ram (of the first robot's board)",
        "other": "other",
    }
    assert "trials" in tables["More of this planner"].notes[0]
    assert "all robots" in tables["More of this planner"].notes[0]
    powers = {row[0].text for row in tables["Clock and power"].rows}
    assert {"static power of the FPGA of each board", "dynamic power of the FPGA of each board"} <= powers
    assert tables["Energy of the run"].rows[0][0].text == "FPGAs"
    # Without a fleet, an update takes the cycles of the robot that the others wait for.
    alone = {table.title for table in result_tables(result.model_copy(update={"fleet": None}))}
    assert "Clock cycles by phase, of each update's slowest robot" in alone
    assert "Clock cycles by phase" in {table.title for table in result_tables(a_result())}


def test_what_fpgas_and_line_allow_is_told_as_a_bound() -> None:
    table = fleet_tables(a_fleet_result())[0]
    assert values(table)["updates a second that FPGAs and line allow, at most"] == pytest.approx(50.0)
    assert "would allow 50 updates a second at most" in pace_text(in_real_time(reachable_a_second=50.0))
    described = FleetFigures.model_fields["reachable_a_second"].description
    assert described is not None
    assert "upper bound" in described


def test_a_fleet_whose_frames_nobody_wants_has_no_table_of_them() -> None:
    titles = [table.title for table in fleet_tables(a_fleet_result(a_fleet(message_s=0.0, frames=None)))]
    assert titles == ["Fleet", "Where the time of the updates went", "Times of an update"]
    stood = a_fleet(updates=0, pace=None, span_s=0, updates_a_second=0.0)
    assert pace_text(stood) == ""
    assert "what sets the pace" not in values(fleet_tables(a_fleet_result(stood))[0])


def told_rates(text: str) -> list[float]:
    """The rates of ``Twice the ... gives (about) A (to B) updates a second``."""
    found = re.search(r"Twice the \w+ gives (?:about |up to )?([\d.,]+)(?: to ([\d.,]+))? updates", text)
    assert found is not None, text
    return [float(rate.replace(",", "")) for rate in found.groups() if rate]


@given(st.integers(1, 64), st.sampled_from([9600, 115_200, 921_600]), st.integers(1, 300), st.floats(1e-6, 0.2))
def test_what_twice_the_baud_or_the_clock_gives_is_what_the_closed_form_says(
    robots: int, baud: int, fifo: int, decide: float
) -> None:
    """From the law, a result; from the result, a sentence; what it says of another baud or clock, held to the law."""
    law, seconds = LineLaw(baud, fifo_depth=fifo), Fraction(decide)
    message, period = float(law.message(robots)), float(law.period(robots, seconds))
    text = pace_text(a_fleet(decide, message, period))
    if message > decide * (1 + 1e-9):
        assert text.startswith("the line: ")
        better = 1 / float(LineLaw(2 * baud, fifo_depth=fifo).period(robots, seconds))
        rates = told_rates(text)
        # Told to three digits, and as one number where low and high are within two per cent.
        assert 0.98 * min(rates) <= better <= 1.03 * max(rates)
    elif period < 2 * decide:
        assert text.startswith("the robots' decisions: ")
        better = 1 / float(law.period(robots, seconds / 2))
        assert better <= 1.01 * told_rates(text)[-1]


def test_a_fleet_without_a_line_gains_all_of_a_faster_clock() -> None:
    text = pace_text(a_fleet(0.01, 0.0, frames=None))
    assert told_rates(text) == [200.0]
    assert "up to" not in text


def test_in_real_time_the_time_step_is_told_apart_from_decisions_that_miss_it() -> None:
    assert pace_text(in_real_time()).startswith("the time step of 100 ms, as asked for")
    late = in_real_time(missed_updates=4, decide=spans(1, 2, SECOND // 4))
    assert "4 updates of 100 took longer" in pace_text(late)
    assert "The longest took 2.5 time steps" in pace_text(late)
    # A fleet in real time is a closed loop: at another clock it takes other decisions, which may be late as well.
    assert not re.search(r"none would|with [\d.]+ times the clock", pace_text(late), re.IGNORECASE)


def test_frames_skipped_in_real_time_are_told_with_the_baud_that_shows_all() -> None:
    text = pace_text(in_real_time(reachable_a_second=4.0))
    assert "7 frames of 100 are skipped, as the line takes 250 ms for each: 2.5 times the baud shows all" in text
    assert "skipped" not in pace_text(in_real_time(frames=FRAMES.model_copy(update={"skipped": 0})))


def test_the_page_says_the_sentence_once() -> None:
    html = result_html(a_fleet_result())
    assert "What sets the pace:</b> the line: a message" in html
    assert html.count("Twice the baud") == 1
    assert html.count("all robots stand at their targets") == 1
    assert "Twice the" not in result_html(a_result())


def test_compare_and_study_tables_take_fleets() -> None:
    result = a_fleet_result()
    assert comparison_table([("one", result), ("other", a_fleet_result(collisions=0))]).rows
    assert len(study_table(replace(a_study(points=8), outcomes=Outcomes.of([result] * 8))).rows) == 8


def many_robots(count: int) -> list[Record]:
    records: list[Record] = [MapRecord(0, "map", np.ones((20, 20), bool), np.zeros((0, 2), np.int32), None)]
    records += [TaskRecord(SECOND, f"fpga.robot_{one}", "avoid", 2 * SECOND, 5) for one in range(1, count)]
    records += [TaskRecord(SECOND, "fpga", "avoid", 2 * SECOND, 5)]
    where = np.array([[1.0, -7.0]] * count)
    records += [PositionsRecord(time * SECOND, "fleet", time, where + time) for time in range(3)]
    return [*records, MissionRecord(3 * SECOND, "fleet", "ended", "done")]


@pytest.mark.parametrize(("count", "rows"), [(8, 8), (64, 2)])
def test_the_time_line_of_many_robots_has_one_row_for_all_but_the_first(count: int, rows: int) -> None:
    _, busy = run_pictures(many_robots(count))
    sources = busy.alt.removeprefix("Time line of ").partition(" over ")[0]
    told = [f"fpga.robot_{one}" for one in range(1, 8)] if rows == 8 else ["fpga.robot, any of 63"]
    assert sources == ", ".join(["fpga", *told])
    assert ("share a row" in busy.caption) == (count == 64)


def test_where_robots_leave_the_map_the_picture_follows_them() -> None:
    from codesign.views.report.pictures import _extent, _Layers

    layers = _Layers(np.ones((20, 30), bool), np.zeros((0, 2), np.int32), np.zeros((20, 30), bool))
    assert _extent(layers) == (-0.5, -0.5, 19.5, 29.5)
    layers.lines = [np.array([[3.0, -7.0], [25.0, 4.0]])]
    assert _extent(layers) == (-0.5, -7.5, 25.5, 29.5)


def test_on_the_page_a_table_that_needs_more_than_half_of_it_has_all() -> None:
    from codesign.views.report.result_page import _is_narrow
    from codesign.views.report.wording import left, words

    assert _is_narrow(Table("", left("a", "b", "c"), (words("x" * 20, "y" * 20, "z" * 20),)))
    assert not _is_narrow(Table("", left("a", "b", "c"), (words("x" * 30, "y" * 30, "z" * 30),)))
    assert _is_narrow(Table("", left("a", "b"), (words("x" * 20, "y" * 200),)))
    assert not _is_narrow(Table("", left("a", "b", "c", "d", "e"), ()))
    assert _is_narrow(Table("", left("a", "b", "c"), ()))
