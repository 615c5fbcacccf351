"""The frames of a fleet: what a line carries of its picture, and what becomes of the rest."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fleet_specs import ERRORS, SECOND, Ground, expected_ends, planned, serial
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.velocity_obstacle_pace import LineLaw, decide_times
from codesign.components import Granularity
from codesign.ground.errors import SpecError
from codesign.ground.records import MessageRecord, Record
from codesign.inputs import load_platform
from codesign.planners.velocity_obstacle.plan import AvoidParameters
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.timing import run_cycles
from codesign.system import catalog
from codesign.system.build import build
from codesign.system.scenarios import bind
from codesign.system.scenarios.fleet.scenario import ARRIVED, fly


@pytest.fixture
def ground(tmp_path: Path) -> Ground:
    return Ground(tmp_path)


@given(
    baud=st.sampled_from([9600, 115_200, 1_000_000, 3_000_000, 20_000_000]),
    fifo=st.sampled_from([1, 15, 16, 17, 31, 32, 40, 64, 100]),
    mhz=st.sampled_from([1, 5, 50]),
)
@settings(max_examples=25)
def test_a_line_with_a_fifo_holds_the_fleet_as_long_as_its_characters_say(
    ground: Ground, baud: int, fifo: int, mhz: int
) -> None:
    robots, updates = 8, 25
    flight = ground.fly(link=serial(baud, fifo), clock=f"{mhz} MHz", count=robots, parameters=f"updates: {updates}")
    plan, parameters = planned(robots, updates=updates)
    cycles = run_cycles(Style.PIPELINED, plan, parameters).each.tolist()
    line = LineLaw(baud, fifo_depth=fifo)
    wanted = expected_ends(cycles, mhz * 10**6, flight.loaded, line, robots)
    # The simulation rounds the end of each run of characters up to a picosecond, and may miss a clock edge by it.
    edge = 10**6 // mhz
    assert all(abs(end - want) <= edge + 3 for end, want in zip(flight.ends, wanted, strict=True))
    period = line.period(robots, Fraction(max(cycles), mhz * 10**6))
    assert max(np.diff(flight.ends)) <= period * 10**12 + edge + 3


@pytest.mark.parametrize(
    ("count", "baud", "fifo"),
    [
        (2, 12_000_000, 16),
        (8, 12_000_000, 16),
        (16, 12_000_000, 16),
        (32, 3_000_000, 16),
        (16, 40_000_000, 64),
        (16, 40_000_000, 300),
    ],
)
def test_frames_follow_each_other_on_average_as_the_law_has_it_within_a_clock_period(
    ground: Ground, count: int, baud: int, fifo: int
) -> None:
    """Decisions that differ from update to update, as in the table of docs/velocity_obstacle.md."""
    records: list[Record] = []
    ground.fly(
        link=serial(baud, fifo),
        count=count,
        arrangement="random",
        seed=1,
        parameters="updates: 200, range: 20.0, turn: 135.0",
        listeners=(records.append,),
    )
    begins = [one.begin for one in records if isinstance(one, MessageRecord) and one.name == "coordinates"]
    parameters = AvoidParameters(updates=200, range=20.0, turn=135.0)
    decides = decide_times(count, Style.PIPELINED, parameters, "random")
    line = LineLaw(baud, fifo_depth=fifo)
    law = float(line.mean_period(count, decides) * SECOND)
    found = (begins[-1] - begins[0]) / (len(begins) - 1)
    assert len(begins) == len(decides) == 200
    assert law - 3 <= found <= law + 20_000 + 3
    if line.characters(count) > fifo:
        mean = float(line.period(count, sum(decides, Fraction(0)) / len(decides)) * SECOND)
        assert found > mean, "the law is convex"


@pytest.mark.parametrize("count", [2, 8, 16])
def test_where_the_line_sets_the_pace_updates_follow_each_other_in_the_closed_form(ground: Ground, count: int) -> None:
    flight = ground.fly(link=serial(115_200), count=count)
    figures = flight.figures
    message = LineLaw(115_200).message(count)
    assert message == Fraction(count * 2 * 16 * 10, 8 * 115_200)
    steady = np.diff(flight.ends)[8:]
    if count * 4 > 17:
        assert np.abs(steady - float(message * 10**12)).max() <= 1.0
    assert sum(steady) == pytest.approx(float(message * 10**12 * len(steady)), rel=1e-3)
    assert figures.pace == "line"
    assert figures.reachable_a_second == pytest.approx(float(1 / message))


def test_frames_that_the_line_cannot_take_in_time_are_skipped_and_no_robot_waits(ground: Ground) -> None:
    settings: dict[str, Any] = {
        "count": 8,
        "scenario": "pace: real_time",
        "parameters": "time_step: 50 ms, updates: 50",
    }
    quick, slow = (ground.fly(link=serial(baud), **settings) for baud in (115_200, 4800))
    assert np.diff(quick.ends).tolist() == np.diff(slow.ends).tolist() == [5 * 10**10] * 49
    assert quick.figures.frames is not None
    assert slow.figures.frames is not None
    assert quick.figures.frames.skipped == 0
    # A message takes 66.7 ms, and is taken over once 15 of its characters have begun: about one in four is skipped.
    assert slow.figures.frames.skipped > 8
    assert slow.figures.frames.late > 0
    assert slow.figures.frames.age is not None
    assert slow.figures.frames.age.worst_s > 0.05


@pytest.mark.parametrize("pace", ["free_running", "real_time"])
@pytest.mark.parametrize("more", ["", ERRORS, ", errors: {bit_error_rate: 0.001, retries: 2, timeout: 1 ms}"])
@pytest.mark.parametrize("limit", ["1 h", "500 ms"])
def test_every_frame_is_shown_dropped_skipped_or_under_way(ground: Ground, pace: str, more: str, limit: str) -> None:
    machine = ground.machine(
        link=serial(9600, more=more), count=8, scenario=f"pace: {pace}, limit: {limit}", costs="render_robot: 1 ms"
    )
    flight = fly(machine)
    frames, line = flight.figures.frames, machine.links["line"]
    assert frames is not None
    assert frames.made == frames.shown + sum(frames.dropped.values()) + frames.skipped + frames.under_way
    assert line.sent == line.delivered + sum(line.dropped.values()) + line.in_flight
    loads = 1
    assert line.sent + frames.skipped == frames.made + loads
    if limit == "1 h":
        assert (frames.under_way, line.in_flight) == (0, 0)
        assert frames.dropped == {reason: count for reason, count in line.dropped.items()}
        assert bool(frames.dropped) == bool(more)
        assert bool(line.retransmissions) == ("retries: 2" in more)
    assert sum(flight.figures.shares.values()) == pytest.approx(1.0 if flight.figures.updates else 0.0)


def test_a_frame_is_drawn_robot_by_robot(ground: Ground) -> None:
    plain, drawn = (ground.fly(costs=f"render_robot: {cost}", parameters="updates: 5") for cost in ("0 s", "3 us"))
    assert plain.figures.frames is not None
    assert drawn.figures.frames is not None
    assert plain.figures.frames.age is not None
    assert drawn.figures.frames.age is not None
    assert plain.figures.frames.age.worst_s == 0
    assert drawn.figures.frames.age.median_s >= 4 * 3e-6
    assert plain.ends == drawn.ends


def test_a_processor_that_draws_needs_a_cost_of_it(ground: Ground) -> None:
    with pytest.raises(SpecError, match="pc has no cost of kernel render_robot, which task display is counted in"):
        ground.machine(costs="")
    ground.machine(costs="", scenario="pace: free_running, report: none")


def test_no_frames_where_nobody_wants_them(ground: Ground) -> None:
    machine = ground.machine(link=serial(9600), scenario="pace: free_running, report: none")
    flight = fly(machine)
    assert flight.figures.frames is None
    assert machine.links["line"].sent == 1
    assert flight.figures.pace == "fpga"


def test_frames_go_to_who_asked_where_no_display_is_mapped(ground: Ground) -> None:
    flight = ground.fly(display="")
    assert flight.figures.frames is not None
    assert flight.figures.frames.receiver == "pc"


@pytest.mark.parametrize("pace", ["free_running", "real_time"])
def test_a_line_that_goes_down_for_good_takes_the_picture_and_no_robot(ground: Ground, pace: str) -> None:
    down = ", outages: [{begin: 300 ms}]"
    flight = ground.fly(link=serial(9600, more=down), scenario=f"pace: {pace}", parameters="updates: 1500", count=4)
    frames = flight.figures.frames
    assert flight.figures.ended == ARRIVED
    assert frames is not None
    assert frames.shown > 0
    assert frames.dropped["link down"] == frames.made - frames.shown - frames.skipped


LINES_SIDE_BY_SIDE = """\
kind: platform
name: boards
components:
  fpga: {{type: fpga, part: XC3S500E-4, clock: 50 MHz}}
  pc: {{type: processor, clock: 2 GHz, costs: {{render_robot: 0 s}}, power: {{busy: 60 W, idle: 20 W}}}}
links:
  one: {{type: serial, baud: {one}, fifo_depth: 16, between: [fpga, pc]}}
  other: {{type: serial, baud: {other}, fifo_depth: 16, between: [pc, fpga]}}
"""


@pytest.mark.parametrize(
    ("bauds", "taken"), [((9600, 115_200), "other"), ((115_200, 9600), "one"), ((9600, 9600), "one")]
)
@pytest.mark.parametrize("pace", ["free_running", "real_time"])
def test_of_lines_side_by_side_frames_take_the_faster(
    ground: Ground, bauds: tuple[int, int], taken: str, pace: str
) -> None:
    board, robots = ground.folder / "lines.yaml", ground.folder / "robots.yaml"
    ground.machine(scenario=f"pace: {pace}", parameters="updates: 10", count=8)  # writes the robots
    board.write_text(LINES_SIDE_BY_SIDE.format(one=bauds[0], other=bauds[1]), encoding="utf-8")
    machine = build(bind(load_platform(board), catalog.load_workload(robots)), (), Granularity.RUN_AHEAD)
    figures = fly(machine).figures
    # Starts and targets go the same way.
    assert {name: link.sent for name, link in machine.links.items() if link.sent} == {taken: 11}
    assert figures.reachable_a_second == pytest.approx(float(1 / LineLaw(max(bauds)).message(8)))


TWO_LINES = """\
kind: platform
name: relay
components:
  fpga: {type: fpga, part: XC3S500E-4, clock: 50 MHz}
  relay: {type: processor, clock: 1 GHz, power: {busy: 2 W, idle: 1 W}}
  pc: {type: processor, clock: 2 GHz, costs: {render_robot: 0 s}, power: {busy: 60 W, idle: 20 W}}
links:
  radio: {type: serial, baud: 9600, fifo_depth: 16, between: [relay, pc]}
  wire: {type: serial, baud: 115200, fifo_depth: 16, between: [fpga, relay]}
"""


def test_frames_go_over_every_link_of_the_way(ground: Ground) -> None:
    board, robots = ground.folder / "relay.yaml", ground.folder / "robots.yaml"
    ground.machine(scenario="pace: real_time", parameters="updates: 10", count=4)  # writes the robots
    board.write_text(TWO_LINES, encoding="utf-8")
    machine = build(bind(load_platform(board), catalog.load_workload(robots)), (), Granularity.RUN_AHEAD)
    figures = fly(machine).figures
    assert figures.frames is not None
    assert figures.frames.age is not None
    assert figures.frames.shown == machine.links["radio"].delivered == 10
    both = 16 * 10 * 10**12 / 115_200 + 16 * 10 * 10**12 / 9600
    assert figures.frames.age.median_s == pytest.approx(both / SECOND, abs=3 / SECOND)
    assert figures.reachable_a_second == pytest.approx(9600 / 160)
