"""One question, one verdict: closed answers on tiny catalogues, and the printed command."""

from __future__ import annotations

import json
import shlex
from itertools import islice
from pathlib import Path

import jsonschema
import pytest
from advice_boards import CELLS, FABRIC, Run, asked, board, by_name, powered

from codesign.planners.styles import Architecture
from codesign.study import advice
from codesign.study.advice import write_design
from codesign.study.advice.candidates import Board, Candidate, arrangements_of
from codesign.study.advice.trials import Laboratory
from codesign.system import catalog


def test_the_board_of_least_power_that_is_fast_enough_is_named(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    quick = board(tmp_path, "quick", 1, busy=20, idle=10)
    middle = board(tmp_path, "middle", 10)
    slow = board(tmp_path, "slow", 1000, busy=1, idle=0.5)
    code, answer = asked(hwsw, corridor, [quick, middle, slow], "100 Hz")
    assert (code, answer["recommended"]) == (0, "middle")
    boards = by_name(answer)
    times = {name: each["design"]["trial"]["time_s"] for name, each in boards.items()}
    assert times == pytest.approx(
        {name: CELLS * cost for name, cost in (("quick", 1e-6), ("middle", 1e-5), ("slow", 1e-3))}
    )
    # 1 ms of 10 busy at 2 W, the rest idle at 1 W.
    assert boards["middle"]["design"]["mean_power_w"] == pytest.approx(0.1 * 2 + 0.9 * 1)
    assert boards["middle"]["margin"] == pytest.approx(10)
    (short,) = boards["slow"]["shortfalls"]
    assert (short["need"], short["demand"]) == ("rate", pytest.approx(0.1))
    verdict = answer["verdict"]
    assert verdict.startswith("middle suffices: breadth_first (software on its cpu) answers in 1 ms (500 us to 2 ms)")
    assert "10 times faster than 100 Hz asks; holds at every value" in verdict
    assert "no board of less power of its components does, at any value inside the declared intervals (of " in verdict
    assert "; the nearest is slow (price not known, 1 W): a plan takes 100 ms, 10 times the 10 ms" in verdict
    assert "(too slow at every value inside the declared intervals)" in verdict
    assert (answer["witness"], answer["witness_certainty"]["state"]) == ("slow", "fails")
    assert (answer["proof"]["state"], answer["proof"]["boards"]) == ("proved", 1)


def test_a_verdict_that_an_interval_decides_names_the_figure_and_its_value(
    hwsw: Run, corridor: Path, tmp_path: Path
) -> None:
    code, answer = asked(hwsw, corridor, [board(tmp_path, "close", 80)], "100 Hz")
    assert code == 0
    assert answer["certainty"]["rate"]["state"] == "depends"
    assert answer["certainty"]["rate"]["decides"]["flips_at"] == pytest.approx(100e-6)
    assert "depends on close's cpu.costs.breadth_first_cell, and changes at 100 us" in answer["verdict"]
    assert "; of the designs that were looked at, none is at every value inside the intervals; " in answer["verdict"]
    sure = board(tmp_path, "sure", 10, busy=20, idle=10)
    _, answer = asked(hwsw, corridor, [tmp_path / "close.yaml", sure], "100 Hz")
    assert answer["recommended"] == "close"
    assert (
        "; sure (price not known, 11 W) is at every value, with breadth_first (software on its cpu); "
        in answer["verdict"]
    )


def test_the_clock_that_a_circuit_reaches_is_an_input_of_its_time(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    fabric = tmp_path / "fabric.yaml"
    fabric.write_text(FABRIC, encoding="utf-8")
    verdicts = {}
    for rate in ("10 kHz", "20 kHz", "50 kHz", "100 kHz", "200 kHz", "400 kHz", "1 MHz"):
        code, answer = asked(hwsw, corridor, [fabric], rate)
        (row,) = answer["boards"]
        certainty = answer["certainty"] or answer["witness_certainty"]
        low, high = certainty["time_low_s"], certainty["time_high_s"]
        period = 1 / answer["needs"]["rate_hz"]
        # The same cycles at the ends of the clock's interval.
        assert low < row["design"]["trial"]["time_s"] < high
        state = "holds" if high <= period else "fails" if low > period else "depends"
        assert certainty["state"] == state
        verdicts[rate] = state
        clock = certainty["least_clock_hz"]
        if state == "holds":
            assert f"down to a clock of {clock / 1e6:.3g}" in answer["verdict"]
            assert code == 0
        if state == "depends":
            assert "depends on the clock that its circuit reaches (fabric's fpga.clock)" in answer["verdict"]
            (need,) = (each for each in certainty["needs"] if each["need"] == "rate")
            assert need["changes_at"] == pytest.approx(clock, rel=1e-3)
            assert need["low"] < clock <= need["high"]
    assert set(verdicts.values()) == {"holds", "depends", "fails"}


def test_the_printed_command_reproduces_the_figure(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    fabric = tmp_path / "fabric.yaml"
    fabric.write_text(FABRIC, encoding="utf-8")
    for more in ((), ("--write", tmp_path / "design")):
        _, answer = asked(hwsw, corridor, [fabric], "1 kHz", *more)
        (winner,) = answer["boards"]
        # The clock of the board is above what the circuit reaches, so it is lowered.
        assert winner["design"]["settings"]["fpga.clock"].endswith("kHz")
        program, *words = shlex.split(answer["command"])
        assert program == "hwsw"
        result = hwsw(*words, "--json")
        assert result.exit_code == 0, result.output
        run = json.loads(result.stdout)
        assert run["task"]["plan_time_worst_s"] == winner["design"]["trial"]["time_s"]
        assert run["planner"] == winner["design"]["planner"]
    assert (tmp_path / "design" / "fabric.yaml").is_file()


def test_where_no_board_suffices_each_need_says_by_how_much(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    boards = [
        powered(board(tmp_path, "slow", 1000, busy=1, idle=0.5), 0.5),
        powered(board(tmp_path, "hungry", 1, busy=20, idle=10), 10),
    ]
    code, answer = asked(hwsw, corridor, boards, "100 Hz", "--power", "5 W")
    assert (code, answer["recommended"], answer["command"]) == (3, None, None)
    verdict = answer["verdict"]
    assert verdict.startswith("No board suffices at any value inside the declared intervals: ")
    assert "the rate excludes slow (a plan takes 100 ms, 10 times the 10 ms that 100 Hz leaves" in verdict
    assert "the power excludes hungry (it draws 10 W, 5 W more than 5 W" in verdict
    assert "Each need alone is met, the rate by hungry; the power by slow, but no board meets all" in verdict
    assert all(each["shortfalls"] for each in answer["boards"])


@pytest.mark.parametrize(("cost", "perhaps"), [(90, None), (110, True), (190, True), (210, False)])
def test_that_no_board_suffices_is_held_against_the_intervals_too(
    hwsw: Run, corridor: Path, tmp_path: Path, cost: float, perhaps: bool | None
) -> None:
    """The interval of a cost is half to double: a board of 110 us a cell plans in 5.5 to 22 ms."""
    _, answer = asked(hwsw, corridor, [board(tmp_path, "close", cost)], "100 Hz")
    (only,) = answer["boards"]
    assert only["suffices"] == (perhaps is None)
    assert bool(only["perhaps"]) == bool(perhaps)
    if perhaps is not None:
        own = "at the figures' own values" if perhaps else "at any value inside the declared intervals"
        assert answer["verdict"].startswith(f"No board suffices {own}: ")
        assert ("Not sure, as they may at other values: close (its time of a plan" in answer["verdict"]) == perhaps


@pytest.mark.parametrize(
    ("memory", "fits", "perhaps"), [(100, False, True), (90, False, False), (900, True, False), (700, True, None)]
)
def test_memory_that_its_bytes_a_cell_decide(
    hwsw: Run, corridor: Path, tmp_path: Path, memory: int, fits: bool, perhaps: bool | None
) -> None:
    """100 cells take 600 bytes, 100 to 800."""
    small = board(tmp_path, "small", 1)
    text = small.read_text(encoding="utf-8").replace("clock: 1 GHz", f"clock: 1 GHz\n    memory: {memory} B")
    small.write_text(text, encoding="utf-8")
    code, answer = asked(hwsw, corridor, [small], "100 Hz")
    assert code == (0 if fits else 3)
    if fits:
        assert answer["certainty"]["fit"]["fits"] == ("yes" if perhaps is False else "uncertain")
        depends = f"whether it fits depends on memory of the processor, 100 to 800 bytes against {memory} bytes"
        assert (depends in answer["verdict"]) == (perhaps is None)
        assert (f"it changes at {memory} bytes" in answer["verdict"]) == (perhaps is None)
    else:
        assert bool(answer["boards"][0]["perhaps"]) == perhaps


def test_a_verdict_about_power_needs_that_of_the_whole_board(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    """Components are a part of a board: more than the limit is sure, less says nothing."""
    chips = board(tmp_path, "chips", 10, busy=2, idle=1)
    code, answer = asked(hwsw, corridor, [chips], "100 Hz", "--power", "3 W")
    assert code == 3
    assert "its power at its input (board.power) is not known" in answer["boards"][0]["perhaps"]
    assert answer["verdict"].startswith("No board suffices at the figures' own values")
    code, answer = asked(hwsw, corridor, [chips], "100 Hz", "--power", "1.04 W")
    assert (code, answer["boards"][0]["perhaps"]) == (3, "")
    powered(chips, 2.5)
    code, answer = asked(hwsw, corridor, [chips], "100 Hz", "--power", "3 W")
    design = answer["boards"][0]["design"]
    # Planning adds 1 W for a tenth of the time.
    assert (design["mean_power_w"], design["input_power_w"]) == pytest.approx((1.1, 2.6))
    assert (code, answer["recommended"]) == (0, "chips")
    assert asked(hwsw, corridor, [chips], "100 Hz", "--power", "2.4 W")[0] == 3


def test_a_second_question_simulates_nothing_but_the_winner(
    hwsw: Run, corridor: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    boards = [board(tmp_path, "quick", 1), board(tmp_path, "slow", 1000)]
    _, first = asked(hwsw, corridor, boards, "100 Hz")
    assert first["simulated"] > 0
    runs: list[object] = []
    result = Laboratory.result
    monkeypatch.setattr(Laboratory, "result", lambda self, each, *more: runs.append(each) or result(self, each, *more))
    _, second = asked(hwsw, corridor, boards, "120 Hz")
    assert (second["simulated"], second["kept"]) == (0, first["simulated"] + first["kept"])
    # The winner is run once more; quick is the cheaper of the two, so there is no next one.
    assert len(runs) <= 2
    corridor.write_text("." * (CELLS + 1) + "\n", encoding="utf-8")
    assert asked(hwsw, corridor, boards, "500 Hz")[1]["simulated"] > 0


def test_what_the_budget_does_not_reach_is_said(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    fabric = tmp_path / "fabric.yaml"
    fabric.write_text(FABRIC, encoding="utf-8")
    code, answer = asked(hwsw, corridor, [fabric], "1 Hz", "--budget", "0")
    assert code == 4, "it is not proved that no board suffices"
    (left,) = answer["not_searched"]
    assert left.endswith(" or more on fabric")
    searched = answer["proof"]["searched"]
    assert (answer["proof"]["state"], searched["complete"]) == ("not proved", False)
    assert searched["designs"] == searched["left"] > 20
    place = ("--goal", "0,0", "--rate", "1 Hz", "--boards", fabric, "--budget", "0")
    output = hwsw("advise", corridor, *place).output
    verdict = "No board was found to suffice, and the budget was spent before all their designs were looked at"
    assert output.splitlines()[1].startswith(verdict)
    assert "Designs not looked at, as the budget was spent: " in output
    assert "none of its designs was searched within the budget" in output


def test_an_answer_is_what_its_schema_says(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    schema = json.loads(hwsw("schema", "advice").stdout)
    for rate in ("100 Hz", "100 kHz"):
        _, answer = asked(hwsw, corridor, [board(tmp_path, "quick", 1)], rate, "--price", "20 USD")
        jsonschema.validate(answer, schema, jsonschema.Draft202012Validator)
    assert "its price is not known" in answer["verdict"] or "the rate" in answer["verdict"]


def chains_of(board: Board, question: advice.Question) -> list[list[Candidate]]:
    """The designs of the families that every arrangement begins with."""
    return [
        [each.candidate(design) for design in family.chain]
        for each in arrangements_of(board, question.problem, question.needs)
        for family in islice(each.families(), 20)
        if family.chain
    ]


def test_a_style_that_proposes_no_designs_is_tried_with_the_samples_of_its_plug_in(
    corridor: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    section = advice.problem_section(corridor, ["0,0"], [], advice.parse_needs("10 Hz"))
    question = advice.ask(advice.parse_needs("10 Hz"), section, corridor)
    for plug_in in catalog.plug_ins():
        for style in plug_in.styles:
            monkeypatch.setattr(type(style), "designs", Architecture.designs)
            monkeypatch.setattr(type(style), "families", Architecture.families)
    chains = chains_of(advice.boards_of(["zynq"])[0], question)
    assert {len(chain) for chain in chains} == {1}
    blocks = [each.parameters for (each,) in chains if each.planner.name == "harmonic"]
    sample = {"block": (12, 16), "iterations": 6, "schedule": (7, 15, 23)}
    assert sample in blocks
    chosen = next(each for (each,) in chains if each.parameters == sample)
    written = catalog.load_workload(write_design(chosen, question, tmp_path / "design"))
    assert written.mapping["relax"].parameters.precisions == (7, 15, 23)
    planners = {"breadth_first", "grid_search", "harmonic", "relaxation", "wavefront"}
    assert {chain[0].planner.name for chain in chains} == planners


def server_map(folder: Path) -> Path:
    """A map of map_server: 40 × 40 unknown cells around a free hall of 6 × 10 cells of 0.5 m, with a pillar."""
    image = folder / "hall.pgm"
    rows = [bytearray([205] * 40) for _ in range(40)]
    for row in range(20, 26):
        rows[row][10:20] = bytes([254] * 10)
    rows[22][14] = 0
    image.write_bytes(b"P5\n40 40\n255\n" + b"".join(map(bytes, rows)))
    path = folder / "hall.yaml"
    path.write_text(
        "image: hall.pgm\nresolution: 0.5\norigin: [-10.0, -10.0, 0.0]\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        encoding="utf-8",
    )
    return path


def test_a_map_of_a_robot_is_cropped_and_inflated_and_its_goal_is_in_metres(hwsw: Run, tmp_path: Path) -> None:
    hall, quick = server_map(tmp_path), board(tmp_path, "quick", 1)
    # The cell in row 23, column 17: (17.5 - 20, 16.5 - 20) × 0.5 m from the origin of the frame.
    words = ("advise", hall, "--goal", "-1.25,-1.75", "--rate", "10 Hz", "--boards", quick, "--json")
    plain = json.loads(hwsw(*words).stdout)
    assert (plain["rows"], plain["columns"], plain["free_cells"]) == (6, 10, 59)
    inflated = json.loads(hwsw(*words, "--clearance", "0.5 m").stdout)
    assert inflated["free_cells"] < plain["free_cells"]
    blocked = hwsw("advise", hall, "--goal", "-2.75,-1.25", "--rate", "10 Hz", "--boards", quick)
    assert (blocked.exit_code, "on an obstacle" in blocked.output) == (2, True)
    unknown = hwsw("advise", hall, "--goal", "5.0,5.0", "--rate", "10 Hz", "--boards", quick)
    assert (unknown.exit_code, "in unknown space" in unknown.output) == (2, True)
    assert "hint: the nearest free cell is" in unknown.output


def test_every_style_of_every_planner_on_a_map_is_searched(corridor: Path, tmp_path: Path) -> None:
    needs = advice.parse_needs("10 Hz")
    section = advice.problem_section(corridor, ["0,0"], [], needs)
    question = advice.ask(needs, section, corridor)
    (zynq,) = advice.boards_of(["zynq"])
    chains = chains_of(zynq, question)
    styles = {(chain[0].planner.name, chain[0].style.style) for chain in chains}
    assert styles >= {
        ("breadth_first", "state_machine"),
        ("harmonic", "bit_serial"),
        ("harmonic", "software_limbs"),
        ("relaxation", "sequential"),
        ("wavefront", "tiled"),
        ("wavefront", "software"),
    }
    assert {chain[0].placement for chain in chains} == {"host", "fabric", "split"}
    for chain in chains:
        bits = [each.bits for each in chain]
        assert bits == sorted(bits)
