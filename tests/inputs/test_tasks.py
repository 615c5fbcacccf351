"""Tasks that a user adds: each fault at its place, with its remedy, and no second one that only follows from it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import Result

Run = Callable[..., Result]

WORKLOAD = """\
kind: workload
name: added
planner: harmonic
problem:
  map: {generate: rooms, rows: 40, columns: 60, room: [8, 8]}
  goals: [[4, 10]]
tasks:
  - TASK
mapping:
  relax: {component: fpga, block: [20, 30], iterations: 6, schedule: [7, 15]}
  log: {component: host}
"""

BREAK = "  hint: break it where one of them can go on without the other\n"
TASKS = "accepted: command, decide, detect, load, lower_bound, relax"


def written(folder: Path, task: str) -> Path:
    file = folder / "w.yaml"
    file.write_text(WORKLOAD.replace("TASK", task.replace("; ", "\n  - ")), encoding="utf-8")
    return file


@pytest.mark.parametrize(
    ("task", "expected"),
    [
        (
            "{name: log, after: decide, kernel: log_line}",
            "8:24: tasks[0].after: 'decide' is not a mapping\n"
            "  hint: write {decide: 128}: each task, and the bits that it sends\n",
        ),
        (
            "{name: log, after: [load, decide], kernel: log_line}",
            "8:24: tasks[0].after: a list is not a mapping\n"
            "  hint: write {load: 128}: each task, and the bits that it sends\n",
        ),
        (
            "{name: log, after: {decde: 8}, kernel: log_line}",
            f"8:25: tasks[0].after.decde: there is no task 'decde'\n  hint: did you mean decide? {TASKS}\n",
        ),
        # A task of another scenario.
        (
            "{name: log, after: {sense: 8}, kernel: log_line}",
            f"8:25: tasks[0].after.sense: there is no task 'sense'\n  hint: {TASKS}\n",
        ),
        (
            "{name: log, after: {decide: 8}, kernel: log_line}; {name: log, after: {load: 8}, kernel: x}",
            "9:12: tasks[1].name: there is a task 'log' already\n  hint: give each task a name of its own\n",
        ),
        (
            "{name: log, after: {decide: 8}, kernel: x}; {name: detect, after: {load: 8}, kernel: x}",
            "9:12: tasks[1].name: there is a task 'detect' already\n  hint: give each task a name of its own\n",
        ),
        (
            "{name: log, after: {decide: 8, log: 9}, kernel: log_line}",
            "8:36: tasks[0].after.log: tasks wait for each other in a circle: log -> log\n" + BREAK,
        ),
        (
            "{name: log, after: {load: 8, b: 9}, kernel: x}; {name: a, after: {log: 8}, kernel: x}; "
            "{name: b, after: {relax: 1, a: 8}, kernel: x}",
            "9:23: tasks[1].after.log: tasks wait for each other in a circle: log -> a -> b -> log\n" + BREAK,
        ),
        (
            "{name: log, after: {decide: 8}, kernl: log_line}",
            "8:5: tasks[0].kernel: missing\n  hint: add this key\n"
            "w.yaml:8:37: tasks[0].kernl: unknown key\n"
            "  hint: did you mean kernel? accepted: after, kernel, name, units\n",
        ),
        (
            "{nme: log, after: {decide: 8}, kernel: x}",
            "8:5: tasks[0].name: missing\n  hint: add this key\n"
            "w.yaml:8:6: tasks[0].nme: unknown key\n"
            "  hint: did you mean name? accepted: after, kernel, name, units\n",
        ),
        ("3", "8:5: tasks[0]: 3 is not a mapping\n  hint: write a mapping\n"),
    ],
)
def test_each_fault_stands_at_its_place_and_alone(hwsw: Run, tmp_path: Path, task: str, expected: str) -> None:
    written(tmp_path, task)
    told = hwsw("check", "./w.yaml")
    assert told.exit_code == 2
    assert told.output.replace("./", "") == f"w.yaml:{expected}"


@pytest.mark.parametrize("tasks", ["tasks: 3\n", "tasks: {name: log}\n"])
def test_tasks_that_are_no_list(hwsw: Run, tmp_path: Path, tasks: str) -> None:
    text = written(tmp_path, "TASK").read_text(encoding="utf-8").replace("tasks:\n  - TASK\n", tasks)
    (tmp_path / "w.yaml").write_text(text, encoding="utf-8")
    told = hwsw("check", "./w.yaml")
    assert told.exit_code == 2
    assert told.output.count("w.yaml") == 1
    assert "is not a list" in told.output


def test_a_task_after_one_that_is_not_done(hwsw: Run, tmp_path: Path) -> None:
    """It is there, but the mapping does not place it: told where the platform is known."""
    file = written(tmp_path, "{name: log, after: {lower_bound: 8}, kernel: log_line}")
    assert hwsw("check", file).exit_code == 0
    told = hwsw("check", "virtex4-pci", file)
    assert told.exit_code == 2
    assert "8:25: tasks[0].after.lower_bound: task lower_bound is done only where it is mapped" in told.output
    assert "add lower_bound: {component: NAME} to the mapping" in told.output


def test_a_task_of_a_variants_planner_may_be_followed(hwsw: Run, tmp_path: Path) -> None:
    """It is told where that variant is not the one that runs."""
    file = written(tmp_path, "{name: log, after: {track: 8}, kernel: harmonic_decision}")
    wave = "{planner: wavefront, mapping: {propagate: {component: fpga}, log: {component: host}}}"
    file.write_text(file.read_text(encoding="utf-8") + f"variants:\n  wave: {wave}\n", encoding="utf-8")
    assert hwsw("check", file).exit_code == 0
    told = hwsw("run", "virtex4-pci", file)
    assert told.exit_code == 2
    assert "8:25: tasks[0].after.track: there is no task 'track'" in told.output
    assert hwsw("run", "virtex4-pci", file, "--set", "workload.variant=wave").exit_code == 0


def test_a_faulty_scenario_makes_no_fault_of_its_tasks(hwsw: Run, tmp_path: Path) -> None:
    file = written(tmp_path, "{name: log, after: {sense: 8}, kernel: log_line}")
    text = file.read_text(encoding="utf-8") + "  sense: {component: robot}\n"
    file.write_text(text + "scenario: {type: drive, knwon: all}\n", encoding="utf-8")
    told = hwsw("check", file)
    assert told.exit_code == 2
    assert "hint: did you mean known?" in told.output
    assert told.output.count("w.yaml") == 1
