"""The files of ``--write``: designs, circuits and missions of an answer, and the commands that go on from there."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
import yaml
from advice_boards import FABRIC, Run, asked, board, by_name

from codesign.system import catalog

SHIPPED = ("pynq-z2", "raspberry-pi-4")
CELLS = ("--resolution", "0.1 m")


def written(
    hwsw: Run, corridor: Path, folder: Path, *more: object, boards: tuple[str, ...] = SHIPPED, rate: str = "10 Hz"
) -> dict[str, Any]:
    """The boards of an answer by name; its files are in ``folder``."""
    _, answer = asked(hwsw, corridor, [Path(name) for name in boards], rate, "--write", folder, *more)
    return by_name(answer)


def commands(folder: Path) -> list[list[str]]:
    lines = (folder / "commands.sh").read_text(encoding="utf-8").splitlines()
    return [shlex.split(line) for line in lines if line and not line.startswith("#")]


def read(path: str | Path) -> Any:
    return yaml.safe_load(Path(path).read_text(encoding="utf-8"))


def test_every_command_of_an_answer_runs_and_comes_to_its_figures(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    folder = tmp_path / "way on"
    boards = written(hwsw, corridor, folder, *CELLS)
    times = {}
    for program, *words in commands(folder):
        assert program == "hwsw"
        result = hwsw(*words, *([] if words[0] == "rtl" else ["--json"]))
        assert result.exit_code == 0, (words, result.output)
        if words[0] == "run":
            times[words[2]] = json.loads(result.stdout)
    for each in boards.values():
        for workload, design in ((each["workload"], each["design"]), (each["circuit_workload"], each["circuit"])):
            if workload is not None:
                assert times[workload]["task"]["plan_time_worst_s"] == design["trial"]["time_s"]
        assert times[each["mission_workload"]]["mission"]["reached"]
    assert boards["raspberry-pi-4"]["circuit"] is None
    assert (boards["pynq-z2"]["design"]["placement"], boards["pynq-z2"]["circuit"]["placement"]) == ("host", "fabric")
    assert list((folder / "pynq-z2-rtl").glob("*.v"))


def test_the_files_are_the_answer(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    """Each row stands before its commands, in the order of the answer, and the JSON is the one that is printed."""
    folder = tmp_path / "files"
    _, answer = asked(hwsw, corridor, [Path(name) for name in SHIPPED], "10 Hz", "--write", folder, *CELLS)
    assert json.loads((folder / "answer.json").read_text(encoding="utf-8")) == answer
    names = {"answer.json", "commands.sh", "pynq-z2-circuit.yaml"}
    names |= {f"{name}{end}.yaml" for name in SHIPPED for end in ("", "-robot", "-mission")}
    assert {path.name for path in folder.iterdir()} == names
    text = (folder / "commands.sh").read_text(encoding="utf-8")
    places = [text.index(f"\n# {each['board']}: ") for each in answer["boards"]]
    assert places == sorted(places)
    for each in answer["boards"]:
        for key in ("command", "circuit_command", "rtl_command", "mission_command"):
            assert each[key] is None or f"\n{each[key]}\n" in text
    assert "# raspberry-pi-4: 55 USD, breadth_first (software on its host), a plan takes " in text
    assert "# The best circuit that was tried on it: " in text
    # The same question may write again.
    written(hwsw, corridor, folder, *CELLS)


def test_the_circuit_beside_software_is_tried_from_all_starts(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    """A search tries most designs from the farthest start alone; the circuit's time is that of its run."""
    words = ("advise", corridor, "--goal", "0,50", "--boards", "pynq-z2", "--write", tmp_path / "all", "--json")
    for rate in ("10 Hz", "150 kHz"):
        answer = json.loads(hwsw(*words, "--rate", rate).stdout)
        (row,) = answer["boards"]
        assert (row["circuit"]["trial"]["starts"], answer["starts"] > 1) == (answer["starts"], True)
        run = json.loads(hwsw(*shlex.split(row["circuit_command"])[1:], "--json").stdout)
        assert run["task"]["plan_time_worst_s"] == row["circuit"]["trial"]["time_s"]


def test_the_circuit_that_is_recommended_is_written_once(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    (row,) = written(hwsw, corridor, tmp_path / "one", *CELLS, "--on", "fabric", boards=("pynq-z2",)).values()
    assert row["circuit"] == row["design"]
    assert (row["circuit_workload"], row["circuit_command"]) == (row["workload"], row["command"])
    assert row["rtl_command"].startswith(f"hwsw rtl pynq-z2 {row['workload']} --set ")
    assert not (tmp_path / "one" / "pynq-z2-circuit.yaml").exists()


def test_a_circuit_that_does_not_suffice_says_what_it_falls_short_of(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    """Software suffices, and the map takes too long over the SPI to the FPGA."""
    (row,) = written(hwsw, corridor, tmp_path / "short", boards=("icebreaker",), rate="100 kHz").values()
    assert (row["suffices"], row["design"]["placement"], row["circuit"]["placement"]) == (True, "host", "fabric")
    assert [short["need"] for short in row["circuit_shortfalls"]] == ["rate"]
    text = (tmp_path / "short" / "commands.sh").read_text(encoding="utf-8")
    (line,) = (line for line in text.splitlines() if line.startswith("# The best circuit"))
    assert ", does not suffice: a plan takes " in line


def test_a_style_without_a_circuit_in_verilog_has_no_command_for_it(
    hwsw: Run, corridor: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none() -> Mapping[Any, Any]:
        return {}

    monkeypatch.setattr(catalog, "circuits", none)
    (row,) = written(hwsw, corridor, tmp_path / "none", boards=("pynq-z2",)).values()
    assert (row["rtl_command"], row["circuit"]["style"]) == (None, "state_machine")
    assert "has no circuit in Verilog" in row["no_rtl"]
    text = (tmp_path / "none" / "commands.sh").read_text(encoding="utf-8")
    assert f"# No RTL: {row['no_rtl']}\n" in text
    assert "hwsw rtl" not in text


def test_a_mission_has_the_robot_of_the_question(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    words = ("--goal", "0,0", "--start", "0,50", "--boards", "raspberry-pi-4,arty-a7", *CELLS, "--json")
    body = ("--range", "6 m", "--brake", "3 m/s^2", "--sensor", "20 Hz")
    for name, speed in (("asked", ("--speed", "1.25 m/s")), ("allowed", ())):
        result = hwsw("advise", corridor, *words, *body, *speed, "--write", tmp_path / name)
        assert result.exit_code == 0, result.output
        answer = json.loads(result.stdout)
        assert not any(each.startswith("Missions: ") for each in answer["remarks"])
        for each in by_name(answer).values():
            components = read(each["mission_platform"])["components"]
            # The robot of a board that has one is replaced, so that missions differ in the board alone.
            (robot,) = (part for part in components.values() if part["type"] == "robot")
            assert robot["sensor"]["range"]["value"] == "6 m"
            assert robot["kinematics"]["acceleration"]["value"] == "3 m/s^2"
            driven = 1.25 if speed else answer["driven"][each["board"]]["speed_mps"]
            assert float(robot["kinematics"]["speed"]["value"].split()[0]) == pytest.approx(driven, rel=1e-8)
            workload = read(each["mission_workload"])
            assert workload["problem"]["starts"] == [[0, 50]]
            assert workload["scenario"] == {"type": "drive", "robot": "robot", "control_period": "50000000000 ps"}
            checked = hwsw("check", each["mission_platform"], each["mission_workload"])
            assert checked.exit_code == 0, checked.output
    assert "asked for: --speed" in (tmp_path / "asked" / "arty-a7-robot.yaml").read_text(encoding="utf-8")


def test_a_robot_that_nobody_asked_for_is_named_as_assumed(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    words = ("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--boards", "raspberry-pi-4", *CELLS)
    result = hwsw(*words, "--write", tmp_path / "assumed")
    assert "Missions: assumed is the robot of zynq: speed 0.5 m/s (--speed), range 4 m (--range)" in result.stdout
    assert f"files and commands: {tmp_path / 'assumed' / 'commands.sh'}" in result.stdout
    kinematics = read(tmp_path / "assumed" / "raspberry-pi-4-robot.yaml")["components"]["robot"]["kinematics"]
    assert kinematics["speed"]["status"] == "assumed"
    assert kinematics["speed"]["source"] == "not asked for; that of the robot of zynq"


def test_a_mission_that_cannot_be_is_not_written_and_says_why(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    fabric = tmp_path / "fabric.yaml"
    fabric.write_text(FABRIC, encoding="utf-8")
    no_scale = written(hwsw, corridor, tmp_path / "no", boards=("raspberry-pi-4",))["raspberry-pi-4"]
    assert no_scale["no_mission"] == "the map does not say how large a cell is"
    no_cost = written(hwsw, corridor, tmp_path / "cost", *CELLS, boards=(str(fabric),))["fabric"]
    assert "has no cost of kernel" in no_cost["no_mission"]
    for folder, row in (("no", no_scale), ("cost", no_cost)):
        assert (row["mission_platform"], row["mission_workload"], row["mission_command"]) == (None, None, None)
        assert f"# No mission: {row['no_mission']}\n" in (tmp_path / folder / "commands.sh").read_text(encoding="utf-8")
        assert not list((tmp_path / folder).glob("*-mission.yaml"))


def test_a_part_beside_the_file_of_a_board_keeps_it_from_a_mission(hwsw: Run, corridor: Path, tmp_path: Path) -> None:
    """In another folder the same name would mean another part, or none."""
    hosts = tmp_path / "hosts"
    hosts.mkdir()
    shipped = Path(catalog.__file__).parents[2] / "platforms"
    text = (shipped / "hosts" / "cortex-a72.yaml").read_text(encoding="utf-8")
    (hosts / "cortex-a72.yaml").write_text(f"{text}\n", encoding="utf-8")
    own = tmp_path / "own.yaml"
    own.write_text("kind: platform\nname: own\ncomponents: {host: {type: processor, host: cortex-a72}}\n")
    row = written(hwsw, corridor, tmp_path / "way", *CELLS, boards=(str(own),))["own"]
    assert "beside the file of the board" in row["no_mission"]


@pytest.mark.parametrize("name", ["answer.json", "commands.sh", *(f"quick{end}.yaml" for end in ("", "-circuit"))])
def test_a_file_of_another_kind_is_refused_before_the_search(
    hwsw: Run, corridor: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("searched")

    monkeypatch.setattr("codesign.study.advice.search", never)
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / name).write_text("{mine: 1}\n", encoding="utf-8")
    words = ("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--boards", board(tmp_path, "quick", 1))
    result = hwsw(*words, "--write", folder)
    assert (result.exit_code, "would replace a file that is not " in result.output) == (2, True), result.output
    assert "hint: name another file, or add --force" in result.output
    assert [(path.name, path.read_text(encoding="utf-8")) for path in folder.iterdir()] == [(name, "{mine: 1}\n")]


def test_the_platform_of_a_mission_is_no_workload_of_a_board_of_its_name(
    hwsw: Run, corridor: Path, tmp_path: Path
) -> None:
    """A mission's platform may be asked about; its file is not overwritten by that answer."""
    written(hwsw, corridor, tmp_path, *CELLS, boards=("raspberry-pi-4",))
    robot = tmp_path / "raspberry-pi-4-robot.yaml"
    text = robot.read_text(encoding="utf-8").replace("name: raspberry-pi-4\n", "name: raspberry-pi-4-robot\n", 1)
    robot.write_text(text, encoding="utf-8")
    words = ("advise", corridor, "--goal", "0,0", "--rate", "10 Hz", "--write", tmp_path)
    result = hwsw(*words, "--boards", robot)
    assert (result.exit_code, "a file that is not a workload of hwsw advise" in result.output) == (2, True)
    result = hwsw(*words, "--boards", f"raspberry-pi-4,{robot}")
    assert (result.exit_code, "two boards share this file" in result.output) == (2, True)
