"""From a speed to a rate and back: the closed form, what binds, questions that cannot be asked, and the first line."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from advice_boards import CELLS, Run, board
from hypothesis import given
from hypothesis import strategies as st

from codesign.ground.errors import InputError
from codesign.study import advice

BODY = {"--range": "4m", "--brake": "2m/s^2"}
AMOUNTS = st.floats(1e-2, 1e2)


def motion_of(**given_options: str | None) -> Any:
    names = ("speed", "sight", "brake", "sensor", "delay")
    return advice.parse_motion(*(given_options.get(name) for name in names))


def closed_form(sight: float, brake: float, reaction: float) -> float:
    return brake * (math.sqrt(reaction**2 + 2 * sight / brake) - reaction)


@given(st.floats(0.05, 0.95), AMOUNTS, AMOUNTS, st.one_of(st.none(), st.floats(0.1, 1e3)), st.floats(0, 1))
def test_the_plan_that_a_speed_leaves_gives_that_speed_back(
    share: float, sight: float, brake: float, sensor: float | None, delay: float
) -> None:
    """Of all speeds up to the one that sensor and body allow."""
    options = {"sight": f"{sight} m", "brake": f"{brake} m/s^2", "delay": f"{delay:.9f} s"}
    options |= {"sensor": f"{sensor} Hz"} if sensor else {}
    speed = share * motion_of(**options).most_mps
    asked = motion_of(speed=f"{speed} m/s", **options)
    needs = advice.parse_needs(None, motion=asked)
    driven = asked.driven(needs.period_s, None, None)
    # Between one and two periods of the sensor no plan uses all of the time.
    assert driven.speed_mps >= speed * (1 - 1e-6)
    if not sensor or not 1 / sensor <= asked.reaction_s - 1 / sensor - delay <= 2 / sensor:
        assert driven.speed_mps == pytest.approx(speed, rel=1e-6)
    late = asked.driven(needs.period_s * 1.01, None, None)
    assert late.speed_mps < driven.speed_mps
    assert closed_form(sight, brake, driven.reaction_s) == pytest.approx(driven.speed_mps, rel=1e-5)


def test_the_question_of_the_page_by_hand() -> None:
    needs = advice.parse_needs(None, motion=motion_of(speed="1.5m/s", sight="4m", brake="2m/s^2"))
    # 4 / 1.5 - 1.5 / 4 s to react; back to back, the obstacle is in the second plan.
    assert needs.motion is not None
    assert needs.motion.reaction_s == pytest.approx(4 / 1.5 - 1.5 / 4)
    assert needs.period_s == pytest.approx((4 / 1.5 - 1.5 / 4) / 2)
    with_sensor = motion_of(speed="1.5m/s", sight="4m", brake="2m/s^2", sensor="0.5 Hz", delay="100 ms")
    assert with_sensor.plan_s == pytest.approx(4 / 1.5 - 1.5 / 4 - 2 - 0.1)


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        ({}, "--rate: nothing says how quick a plan has to be"),
        ({"--speed": "1m/s"}, "--speed: the speed of a robot follows from the distance that its sensor sees too"),
        ({"--speed": "1m/s", "--range": "4m"}, "--speed: the speed of a robot follows from the deceleration"),
        ({"--brake": "1m/s^2"}, "--brake: the speed of a robot follows from the distance"),
        ({"--rate": "1Hz", "--sensor": "1Hz"}, "--sensor: the speed of a robot follows from the distance"),
        ({"--delay": "1s"}, "--delay: the speed of a robot follows from the distance"),
        ({**BODY, "--rate": "1Hz", "--speed": "1m/s"}, "--rate: --speed asks for 533.3 mHz, so both ask for a rate"),
        ({**BODY, "--range": "0m"}, "--range: '0m' is zero"),
        ({**BODY, "--brake": "0 m/s^2"}, "--brake: '0 m/s^2' is zero"),
        ({**BODY, "--brake": "-1 m/s^2"}, "--brake: '-1 m/s^2' is negative"),
        ({**BODY, "--speed": "0 m/s"}, "--speed: '0 m/s' is zero"),
        ({**BODY, "--speed": "1e-300 m/s"}, "--speed: '1e-300 m/s' is too small"),
        ({**BODY, "--range": "4"}, "--range: '4' has no unit"),
        ({**BODY, "--sensor": "0 Hz"}, "--sensor: '0 Hz' is zero"),
        ({**BODY, "--speed": "4m/s"}, "no reaction is quick enough: from 4 m/s the robot brakes over 4 m"),
        ({**BODY, "--speed": "3.9m/s", "--sensor": "10Hz"}, "--sensor: the sensor binds, no board helps: at 3.9 m/s"),
        ({**BODY, "--speed": "3.9m/s", "--delay": "1s"}, "--delay: the delay binds, no board helps: at 3.9 m/s"),
    ],
)
def test_a_motion_that_cannot_be_asked_is_a_fault_with_a_remedy(
    hwsw: Run, corridor: Path, options: dict[str, str], fault: str
) -> None:
    words = [word for pair in options.items() for word in pair]
    result = hwsw("advise", corridor, "--goal", "0,0", "--boards", "zynq", *words)
    assert result.exit_code == 2, result.output
    assert fault in result.output
    assert "hint: " in result.output


REMEDIES = {
    "speed": (r"a speed below ([0-9.e+-]+) m/s", "m/s", 0.98),
    "sight": (r"a range above ([0-9.e+-]+) m,", "m", 1.02),
    "brake": (r"brakes above ([0-9.e+-]+) m/s\^2", "m/s^2", 1.02),
    "sensor": (r"a sensor above ([0-9.e+-]+) (m?k?M?Hz)", "", 1.02),
}


@given(st.floats(0.5, 50), st.floats(0.5, 50), st.floats(0.5, 20), st.floats(0.5, 100), st.floats(0, 0.2))
def test_each_remedy_that_is_named_makes_the_question_one_that_can_be_met(
    speed: float, sight: float, brake: float, sensor: float, delay: float
) -> None:
    options = {"speed": f"{speed} m/s", "sight": f"{sight} m", "brake": f"{brake} m/s^2"}
    options |= {"sensor": f"{sensor} Hz", "delay": f"{delay:.6f} s"}
    try:
        assert motion_of(**options).plan_s > 0
        return
    except InputError as refused:
        hint = f"{refused.hint},"
    assert "a speed below" in hint
    assert "a range above" in hint
    for name, (pattern, unit, beyond) in REMEDIES.items():
        for value, *units in (
            re.findall(pattern, hint) if name == "sensor" else [(v,) for v in re.findall(pattern, hint)]
        ):
            mended = {**options, name: f"{float(value) * beyond} {unit or units[0]}"}
            assert motion_of(**mended).plan_s > 0


def answer_of(hwsw: Run, corridor: Path, boards: list[Path], **options: str) -> tuple[int, Any]:
    words = [word for name, value in options.items() for word in (f"--{name}", value)]
    place = ("--goal", "0,0", "--start", f"0,{CELLS - 1}")
    result = hwsw("advise", corridor, *place, "--boards", ",".join(map(str, boards)), *words, "--json")
    assert result.exit_code in (0, 3), result.output
    return result.exit_code, json.loads(result.stdout)


def test_every_board_has_the_speed_of_its_plan_and_says_what_binds(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    """A plan looks at 100 cells: it takes 0.1 ms, 100 ms and 1 s."""
    boards = [board(tmp_path, name, cost) for name, cost in (("quick", 1), ("middling", 1000), ("slow", 10_000))]
    code, answer = answer_of(hwsw, corridor, boards, range="4m", brake="2m/s^2", speed="3m/s")
    assert (code, answer["recommended"]) == (0, answer["boards"][0]["board"])
    wanted = 4 / 3 - 3 / 4
    for each in answer["boards"]:
        time, driven = each["design"]["trial"]["time_s"], answer["driven"][each["board"]]
        assert driven["speed_mps"] == pytest.approx(closed_form(4, 2, 2 * time))
        assert driven["speed_low_mps"] < driven["speed_mps"] < driven["speed_high_mps"]
        assert each["suffices"] == (2 * time <= wanted) == (driven["speed_mps"] >= 3)
        assert driven["binds"] == ("body" if driven["speed_mps"] >= 3.6 else "compute")
    assert {driven["binds"] for driven in answer["driven"].values()} == {"body", "compute"}
    assert answer["needs"]["rate_hz"] == pytest.approx(2 / wanted)
    best = answer["driven"][answer["recommended"]]["speed_mps"]
    assert f"With {answer['recommended']} the robot may drive {best:.3g} m/s" in answer["driving"]


def test_without_a_speed_the_board_that_comes_near_to_the_body_suffices(
    hwsw: Run, corridor: Path, tmp_path: Path
) -> None:
    boards = [board(tmp_path, "quick", 1), board(tmp_path, "slow", 10_000)]
    _, answer = answer_of(hwsw, corridor, boards, range="4m", brake="2m/s^2")
    for each in answer["boards"]:
        assert each["suffices"] == (answer["driven"][each["board"]]["speed_mps"] >= 0.9 * 4)
    assert [each["suffices"] for each in answer["boards"]] == [True, False]
    slow = answer_of(hwsw, corridor, boards, range="4m", brake="2m/s^2", sensor="0.2Hz")[1]
    assert {driven["binds"] for driven in slow["driven"].values()} == {"sensor"}


def test_a_rate_may_have_the_speeds_beside_it_and_does_not_move(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    boards = [board(tmp_path, "quick", 1)]
    _, plain = answer_of(hwsw, corridor, boards, rate="100 Hz")
    _, beside = answer_of(hwsw, corridor, boards, rate="100 Hz", range="4m", brake="2m/s^2")
    assert (plain["driving"], plain["driven"]) == ("", {})
    assert beside["verdict"] == plain["verdict"]
    assert set(beside["driven"]) == {"quick"}


def test_what_was_not_asked_is_named_and_what_was_is_not(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    boards = [board(tmp_path, "quick", 1)]
    options = {"range": "4m", "brake": "2m/s^2", "speed": "1m/s"}
    question = answer_of(hwsw, corridor, boards, **options)[1]["question"]
    assert "not asked, so counted as 0: the period of the sensor (--sensor) and other delays (--delay)" in question
    question = answer_of(hwsw, corridor, boards, **options, sensor="10Hz", delay="0s")[1]["question"]
    assert "not asked" not in question
    assert "the sensor scans at 10 Hz; other delays take 0" in question


def test_the_first_line_is_the_question_as_it_was_understood(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    quick = board(tmp_path, "quick", 1)
    words = ("advise", corridor, "--goal", "0,3", "--rate", "10 Hz", "--boards", quick)
    lines = hwsw(*words, "--resolution", "20 cm").stdout.splitlines()
    _, answer = answer_of(hwsw, corridor, [quick], rate="10 Hz", resolution="20 cm", price="90 USD")
    assert answer["goals"] == [{"row": 0, "column": 0, "x_m": 0.1, "y_m": 0.1}]
    assert (answer["cell_m"], answer["rows"], answer["columns"]) == (0.2, 1, CELLS)
    assert lines[0] == (
        f"Asked: a path within 100 ms (10 Hz) on corridor.txt, 1 × {CELLS} cells of 20 cm (0.2 × 20 m), to cell (0, 3),"
        " its middle at {x: 0.7 m, y: 0.1 m}; a path leads to a goal from 100 % of the free cells; 64 starts, drawn."
    )
    assert lines[1].startswith("quick suffices: ")
    assert "; 1 start; at most 90 USD" in answer["question"]
