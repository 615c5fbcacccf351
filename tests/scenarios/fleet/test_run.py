"""Fleets: times in closed form, conservation of frames, watchdogs, and the same bytes at every granularity."""

from __future__ import annotations

import pickle
from bisect import bisect_right
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.velocity_obstacle_pace import LineLaw, decide_times
from codesign.components import ClockDomain, Granularity
from codesign.inputs import load_platform
from codesign.planners.velocity_obstacle.plan import Avoidance, AvoidParameters, avoid, generate, quality
from codesign.planners.velocity_obstacle.published import Style
from codesign.planners.velocity_obstacle.styles.timing import run_cycles, update_costs
from codesign.records import MessageRecord, MissionRecord, PositionsRecord, Record, TaskRecord
from codesign.system import bind, catalog
from codesign.system.build import Machine, build
from codesign.system.scenarios.fleet import ARRIVED, Flight, fly

PLATFORM = """\
kind: platform
name: boards
components:
  fpga: {{type: fpga, part: XC3S500E-4, clock: {clock}}}
  pc: {{type: processor, clock: 2 GHz, costs: {{{costs}}}, power: {{busy: 60 W, idle: 20 W}}}}
links:
  line: {{{link}, between: [fpga, pc]}}
"""
WORKLOAD = """\
kind: workload
name: fleet
planner: velocity_obstacle
problem:
  robots: {{count: {count}, arrangement: {arrangement}, seed: {seed}}}
scenario: {{type: fleet, {scenario}}}
mapping:
  avoid: {{component: fpga, style: pipelined, {parameters}}}
  {display}
"""
IDEAL = "type: ideal"
SECOND = 10**12
STEP = 10**11
"""The time step by default, ps."""


def serial(baud: int, fifo: int = 16, more: str = "") -> str:
    return f"type: serial, baud: {baud}, fifo_depth: {fifo}{more}"


class Ground:
    """Builds a fleet's machine from texts, in a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def machine(
        self,
        *,
        link: str = IDEAL,
        clock: str = "50 MHz",
        costs: str = "",
        count: int = 4,
        arrangement: str = "circle",
        seed: int = 0,
        scenario: str = "pace: free_running",
        parameters: str = "updates: 60",
        display: str = "display: {component: pc}",
        listeners: tuple[Any, ...] = (),
        granularity: str = "run_ahead",
    ) -> Machine:
        board, robots = self.folder / "board.yaml", self.folder / "robots.yaml"
        board.write_text(PLATFORM.format(clock=clock, costs=costs, link=link), encoding="utf-8")
        text = WORKLOAD.format(
            count=count,
            arrangement=arrangement,
            seed=seed,
            scenario=scenario,
            parameters=parameters,
            display=display,
        )
        robots.write_text(text, encoding="utf-8")
        system = bind(load_platform(board), catalog.load_workload(robots))
        return build(system, listeners, Granularity(granularity))

    def fly(self, **settings: Any) -> Flight:
        return fly(self.machine(**settings))


@pytest.fixture
def ground(tmp_path: Path) -> Ground:
    return Ground(tmp_path)


def planned(count: int = 4, **parameters: Any) -> tuple[Avoidance, AvoidParameters]:
    chosen = AvoidParameters(**{"updates": 60, **parameters})
    return avoid(generate("circle", count), chosen), chosen


def expected_ends(cycles: list[int], hz: int, begin: int, line: LineLaw, robots: int) -> list[Fraction]:
    """When each update of a free-running fleet ends, ps: character by character, with no simulation.

    The sender of message k goes on once all characters but ``fifo_depth`` of those sent so far have begun.
    """
    clock, each, character = ClockDomain(hz), line.characters(robots), line.frame_bits * 10**12 / line.baud
    now, free, begun, ends = Fraction(begin), Fraction(0), [], []
    for amount in cycles:
        edge = clock.cycle_at_or_after(-(-now.numerator // now.denominator))
        decided = Fraction(clock.edge(edge + amount))
        first = max(decided, free)
        begun += [first + character * number for number in range(each)]
        free = first + character * each
        held = len(begun) - line.fifo_depth
        now = max(decided, begun[held - 1]) if held > 0 else decided
        ends.append(now)
    return ends


def test_without_a_line_updates_take_their_slowest_robots_cycles_and_nothing_else(ground: Ground) -> None:
    plan, parameters = planned(updates=1500)
    flight = ground.fly(parameters="updates: 1500")
    clock = ClockDomain(50_000_000)
    cycles = np.cumsum(run_cycles(Style.PIPELINED, plan, parameters).each)
    assert flight.loaded == 0
    assert flight.ends == tuple(clock.edge(int(cycle)) for cycle in cycles)
    assert flight.plan.digest == plan.digest
    figures = flight.figures
    assert (figures.ended, figures.completed, figures.updates) == (ARRIVED, True, plan.updates)
    assert figures.pace == "fpga"
    assert figures.shares == {"fpga": 1.0, "line": 0.0, "time_step": 0.0}
    assert figures.updates_a_second == pytest.approx(plan.updates * 1e12 / flight.ends[-1])
    assert figures.reachable_a_second == pytest.approx(figures.updates_a_second)


def test_each_robot_computes_on_an_fpga_of_its_own_for_its_own_cycles(ground: Ground) -> None:
    machine = ground.machine(count=6)
    flight = fly(machine)
    plan, _ = planned(6)
    cycles = update_costs(Style.PIPELINED, 6, machine.system.planning).of_robot(plan.checks, plan.trials)
    assert cycles.shape == (plan.updates, 6)
    assert len({fpga.name for fpga in flight.fpgas}) == 6
    assert [fpga.busy for fpga in flight.fpgas] == [int(amount) * 20_000 for amount in cycles.sum(axis=0)]
    assert flight.figures.fpga_busy_s == int(cycles.sum()) * 20_000 / SECOND
    assert sum(machine.cycles().values()) == int(cycles[:, 0].sum())


@given(
    baud=st.sampled_from([9600, 115_200, 1_000_000, 3_000_000, 20_000_000]),
    fifo=st.sampled_from([1, 15, 16, 17, 31, 32, 40, 64, 100]),
    mhz=st.sampled_from([1, 5, 50]),
)
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_line_with_a_fifo_holds_the_fleet_as_long_as_its_characters_say(
    ground: Ground, baud: int, fifo: int, mhz: int
) -> None:
    robots, updates = 8, 25
    flight = ground.fly(
        link=serial(baud, fifo), clock=f"{mhz} MHz", count=robots, parameters=f"updates: {updates}"
    )
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
def test_where_the_line_sets_the_pace_updates_follow_each_other_in_the_closed_form(
    ground: Ground, count: int
) -> None:
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


def test_in_real_time_updates_keep_to_the_time_step(ground: Ground) -> None:
    flight = ground.fly(link=serial(115_200), scenario="pace: real_time", parameters="updates: 30")
    load = flight.loaded
    assert flight.ends == tuple(load + STEP * (update + 1) for update in range(30))
    assert load == 4 * 4 * 16 * 10 * 10**12 // (8 * 115_200) + 1  # starts and targets, x and y, rounded up
    figures = flight.figures
    assert (figures.missed_updates, figures.pace, figures.updates_a_second) == (0, "time_step", 10.0)
    assert figures.frames is not None
    assert (figures.frames.made, figures.frames.shown, figures.frames.late) == (30, 30, 0)


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


ERRORS = ", errors: {drop: 0.3, retries: 0, seed: 7}"


@pytest.mark.parametrize("pace", ["free_running", "real_time"])
@pytest.mark.parametrize("more", ["", ERRORS, ", errors: {bit_error_rate: 0.001, retries: 2, timeout: 1 ms}"])
@pytest.mark.parametrize("limit", ["1 h", "500 ms"])
def test_every_frame_is_shown_dropped_skipped_or_under_way(
    ground: Ground, pace: str, more: str, limit: str
) -> None:
    machine = ground.machine(
        link=serial(9600, more=more),
        count=8,
        scenario=f"pace: {pace}, limit: {limit}",
        costs="render_robot: 1 ms",
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


def test_a_frame_is_drawn_robot_by_robot_where_the_processor_has_a_cost_of_it(ground: Ground) -> None:
    plain, drawn = (ground.fly(costs=costs, parameters="updates: 5") for costs in ("", "render_robot: 3 us"))
    assert plain.figures.frames is not None
    assert drawn.figures.frames is not None
    assert plain.figures.frames.age is not None
    assert drawn.figures.frames.age is not None
    assert plain.figures.frames.age.worst_s == 0
    assert drawn.figures.frames.age.median_s >= 4 * 3e-6
    assert plain.ends == drawn.ends


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


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"scenario": "pace: real_time, limit: 2 s"}, "the limit of 2 s of simulated time was reached"),
        ({"scenario": "pace: real_time, events: 300"}, "the limit of 300 events was reached"),
        ({"link": serial(9600, more=", outages: [{begin: 0 s}]")}, "link down"),
        ({"parameters": "updates: 7"}, "after 7 updates 0 of 4 robots have arrived"),
    ],
)
def test_a_fleet_always_ends_with_a_reason_and_its_trace_reaches_up_to_there(
    ground: Ground, settings: dict[str, Any], text: str
) -> None:
    records: list[Record] = []
    flight = ground.fly(listeners=(records.append,), **settings)
    assert text in flight.figures.ended
    assert not flight.figures.completed
    assert flight.figures.updates == flight.plan.updates == len(flight.ends)
    assert flight.events <= 300 or "events" not in str(settings)
    positions = [record for record in records if isinstance(record, PositionsRecord)]
    assert [record.update for record in positions] == list(range(flight.plan.updates + 1))
    missions = [record for record in records if isinstance(record, MissionRecord)]
    assert (missions[-1].event, missions[-1].text) == ("ended", flight.figures.ended)


def test_the_trace_holds_the_planners_run(ground: Ground) -> None:
    records: list[Record] = []
    flight = ground.fly(listeners=(records.append,), parameters="updates: 1500", link=serial(115_200))
    plan, _ = planned(updates=1500)
    positions = [record for record in records if isinstance(record, PositionsRecord)]
    assert [record.time for record in positions] == [0, *flight.ends]
    for record in positions:
        assert np.array_equal(record.positions, plan.cells[record.update, :, ::-1] - 0.5)
    events = [record.event for record in records if isinstance(record, MissionRecord)]
    assert events.count("goal_reached") == 4
    assert events[-1] == "ended"
    messages = [record for record in records if isinstance(record, MessageRecord)]
    assert len(messages) == plan.updates + 1
    assert all(one.time <= other.time for one, other in pairwise(messages))


@pytest.mark.parametrize(("count", "each"), [(8, 8), (9, 1)])
def test_beyond_eight_robots_the_trace_shows_only_whom_the_others_wait_for(
    ground: Ground, count: int, each: int
) -> None:
    records: list[Record] = []
    flight = ground.fly(listeners=(records.append,), count=count, parameters="updates: 10")
    tasks = [record for record in records if isinstance(record, TaskRecord) and record.task == "avoid"]
    assert len(tasks) == 10 * each
    last = {record.end for record in tasks}
    assert set(flight.ends) <= last


def test_contacts_are_told_as_they_come(ground: Ground) -> None:
    records: list[Record] = []
    loose = "updates: 600, detection: published, responsibility: full, margin: 0.0"
    machine = ground.machine(
        listeners=(records.append,), count=8, arrangement="crossing", seed=6, parameters=loose
    )
    flight = fly(machine)
    touched = {
        record.text.split(" touch")[0]
        for record in records
        if isinstance(record, MissionRecord) and record.event == "contact"
    }
    problem: Any = machine.system.problem
    assert len(touched) == quality(problem, flight.plan).collisions > 0


@pytest.mark.parametrize("pace", ["free_running", "real_time"])
@pytest.mark.parametrize("link", [IDEAL, serial(115_200), serial(2_000_000, 3, ERRORS)])
def test_run_ahead_is_visit_by_visit_to_the_byte(ground: Ground, link: str, pace: str) -> None:
    told = []
    for granularity in ("run_ahead", "visit", "run_ahead"):
        records: list[Record] = []
        machine = ground.machine(
            link=link,
            count=6,
            scenario=f"pace: {pace}",
            granularity=granularity,
            listeners=(records.append,),
            costs="render_robot: 20 us",
        )
        flight = fly(machine)
        figures = flight.figures.model_dump()
        told.append(
            (pickle.dumps([repr(vars(one)) for one in records]), figures, machine.cycles(), flight.ends)
        )
    assert told[0] == told[1] == told[2]


def test_watching_changes_nothing(ground: Ground) -> None:
    silent, watched = (
        ground.fly(link=serial(115_200), listeners=listeners) for listeners in ((), ([].append,))
    )
    assert silent.figures == watched.figures
    assert silent.ends == watched.ends


@pytest.mark.parametrize("fifo", [1, 16, 64])
def test_a_faster_line_or_clock_is_never_slower(ground: Ground, fifo: int) -> None:
    def ends(baud: int, mhz: int) -> int:
        return ground.fly(
            link=serial(baud, fifo), clock=f"{mhz} MHz", count=8, parameters="updates: 30"
        ).ends[-1]

    lines = [ends(baud, 5) for baud in (9600, 115_200, 1_000_000, 4_000_000, 40_000_000)]
    clocks = [ends(4_000_000, mhz) for mhz in (1, 5, 10, 20, 40)]
    assert lines == sorted(lines, reverse=True)
    assert clocks == sorted(clocks, reverse=True)
    assert bisect_right(lines[::-1], lines[0]) == len(lines)


def test_a_robot_that_leaves_its_words_ends_the_fleet_there(ground: Ground) -> None:
    """The fleet's run up to that update stands, with the reason, as the planner's run without a clock does."""
    problem, parameters = generate("circle", 32, seed=1), AvoidParameters(range=30.0, width=16)
    plan = avoid(problem, parameters)
    flight = ground.fly(count=32, seed=1, parameters="range: 30.0")
    assert flight.figures.ended == str(plan.departure)
    assert not flight.figures.completed
    assert flight.plan.digest == plan.digest
    assert 100 < flight.figures.updates < 1500
    assert f"in update {flight.figures.updates + 1} " in flight.figures.ended
    assert np.abs(flight.plan.positions).max() < 2**15


@pytest.mark.parametrize("pace", ["free_running", "real_time"])
def test_a_line_that_goes_down_for_good_takes_the_picture_and_no_robot(ground: Ground, pace: str) -> None:
    down = ", outages: [{begin: 300 ms}]"
    flight = ground.fly(
        link=serial(9600, more=down), scenario=f"pace: {pace}", parameters="updates: 1500", count=4
    )
    frames = flight.figures.frames
    assert flight.figures.ended == ARRIVED
    assert frames is not None
    assert frames.shown > 0
    assert frames.dropped["link down"] == frames.made - frames.shown - frames.skipped


def test_free_running_robots_wait_out_an_outage(ground: Ground) -> None:
    whole, cut = (
        ground.fly(link=serial(115_200, more=more), count=8)
        for more in ("", ", outages: [{begin: 40 ms, end: 240 ms}]")
    )
    longest = max(np.diff(cut.ends))
    assert 190 * 10**9 < longest < 210 * 10**9
    assert cut.figures.frames is not None
    assert cut.ends[-1] - whole.ends[-1] == pytest.approx(200 * 10**9, rel=0.05)


@given(
    count=st.sampled_from([4, 8, 16]),
    baud=st.sampled_from([115_200, 3_000_000, 12_000_000, 50_000_000]),
    fifo=st.sampled_from([1, 16, 64]),
)
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_the_rate_that_fpga_and_line_allow_is_a_bound_in_the_long_run(
    ground: Ground, count: int, baud: int, fifo: int
) -> None:
    """Up to what fits the FIFO at the end, which nobody waits for."""
    figures = ground.fly(link=serial(baud, fifo), count=count, arrangement="random").figures
    spared = 2 + fifo // LineLaw(baud).characters(count)
    assert figures.updates - spared <= figures.span_s * figures.reachable_a_second * (1 + 1e-9)


def test_a_short_fifo_and_uneven_decisions_keep_a_fleet_below_that_bound(ground: Ground) -> None:
    short, whole, endless = (
        ground.fly(link=serial(10_000_000, fifo), count=32, arrangement="random").figures
        for fifo in (1, 128, 10_000)
    )
    bound = short.reachable_a_second
    assert short.reachable_a_second == whole.reachable_a_second == endless.reachable_a_second
    assert short.updates_a_second < 0.8 * bound
    assert short.updates_a_second < whole.updates_a_second < 0.99 * bound


LINES_SIDE_BY_SIDE = """\
kind: platform
name: boards
components:
  fpga: {{type: fpga, part: XC3S500E-4, clock: 50 MHz}}
  pc: {{type: processor, clock: 2 GHz, power: {{busy: 60 W, idle: 20 W}}}}
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
  pc: {type: processor, clock: 2 GHz, power: {busy: 60 W, idle: 20 W}}
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
