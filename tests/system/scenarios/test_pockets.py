"""Goals in pockets of a map: refused unless asked for, told beside every verdict, and paid for with the whole map."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from hypothesis import given, settings
from hypothesis import strategies as st

import codesign
from codesign import maps
from codesign.ground.errors import SpecError
from codesign.study import advice
from codesign.study.advice.candidates import arrangements_of
from codesign.study.advice.trials import Laboratory
from codesign.system.bind import plannable
from codesign.system.scenarios import scenario_of

Run = Callable[..., Result]
CLAUSE = "a path leads to a goal from {} % of the free cells"
WORKLOAD = """\
kind: workload
name: hall
planner: breadth_first
problem:
  map: {{file: hall.txt}}
  goals: [{goal}]
  starts: {{count: 3}}
{more}mapping:
  search: {{component: host, style: software}}
"""


def hall(rows: int = 30, columns: int = 40) -> str:
    """A free hall, and a walled-in pocket of 2 × 2 cells at (1, 1)."""
    cells = np.ones((rows, columns), bool)
    cells[:4, :4] = False
    cells[1:3, 1:3] = True
    return maps.to_text(maps.OccupancyGrid(cells))


def written(folder: Path, goal: str = "[1, 1]", reach: str | None = None, more: str = "") -> Path:
    (folder / "hall.txt").write_text(hall())
    keys = "" if reach is None else f"  reach: {reach}\n"
    path = folder / "hall.yaml"
    path.write_text(WORKLOAD.format(goal=goal, more=keys + more))
    return path


SHARE = 100 * 4 / (30 * 40 - 12)
"""Of the free cells of the hall, those in the pocket."""


@pytest.mark.parametrize(
    "command",
    [
        ("check", "raspberry-pi-4", "hall.yaml"),
        ("run", "raspberry-pi-4", "hall.yaml"),
        ("explore", "raspberry-pi-4", "hall.yaml", "--axis", "host.power.busy=3W,4W"),
        ("compare", "raspberry-pi-4:hall.yaml", "--map", "hall.txt", "--goal", "1,1", "--start", "2,2"),
        ("explain", "raspberry-pi-4", "hall.yaml"),
        ("advise", "hall.txt", "--goal", "1,1", "--rate", "10Hz", "--boards", "raspberry-pi-4"),
    ],
    ids=lambda command: command[0],
)
def test_a_goal_in_a_pocket_is_refused_unless_it_is_asked_for(hwsw: Run, command: tuple[str, ...]) -> None:
    """The refusal names the place, the share and the remedy; the answer to who asks for it has the share."""
    written(Path())
    refused = hwsw(*command)
    assert refused.exit_code in (1, 2), refused.output
    assert f"from 4 of 1,188 free cells ({SHARE:.3g} %)" in refused.stderr
    assert "largest part is (1, 4)" in refused.stderr
    assert "--reach" in refused.stderr
    option = "--goal" in command
    assert ("--goal" if option else "hall.yaml:6:10") in refused.stderr
    written(Path(), reach="0")
    taken = hwsw(*command, *(("--reach", "0") if option else ()))
    assert taken.exit_code in (0, 3), taken.output
    assert CLAUSE.format(f"{SHARE:.3g}") in " ".join(taken.output.split())


def test_a_report_has_the_share_of_its_study(hwsw: Run) -> None:
    written(Path(), reach="0")
    study = hwsw("explore", "raspberry-pi-4", "hall.yaml", "--axis", "host.power.busy=3W,4W", "--store", "study.db")
    assert study.exit_code == 0, study.output
    report = hwsw("report", "study.db")
    assert report.exit_code == 0, report.output
    assert CLAUSE.format(f"{SHARE:.3g}") in " ".join(report.output.split())


def test_a_map_that_all_of_leads_to_the_goal_has_no_remark(hwsw: Run) -> None:
    written(Path(), "[10, 10]")
    (Path() / "hall.txt").write_text("." * 20 + "\n" + "\n".join("." * 20 for _ in range(19)) + "\n")
    done = hwsw("run", "raspberry-pi-4", "hall.yaml", "--json")
    assert json.loads(done.stdout)["task"]["reach"] == 1.0
    assert "path leads to a goal" not in hwsw("run", "raspberry-pi-4", "hall.yaml").output


@given(
    st.integers(2, 12), st.integers(2, 12), st.floats(0.0, 0.8), st.integers(0, 1000),
    st.sampled_from([0.0, 0.1, 0.5, 0.9, 1.0]), st.sampled_from(["none", "free", "reachable"]),
)  # fmt: skip
@settings(max_examples=100, deadline=None)
def test_the_share_is_that_of_the_free_cells_of_the_whole_map(
    rows: int, columns: int, density: float, seed: int, least: float, crop: str
) -> None:
    """Against a flood by hand, on maps with pockets; cropping changes nothing; below ``reach`` it is refused."""
    grid = maps.random_obstacles(rows, columns, density=density, seed=seed)
    free = {(int(row), int(column)) for row, column in np.argwhere(grid.free)}
    if len(free) < 2:
        return
    goal = sorted(free)[seed % len(free)]
    joined, border = {goal}, [goal]
    while border:
        row, column = border.pop()
        beside = {(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)} & free - joined
        joined |= beside
        border += beside
    tree = {
        "kind": "workload",
        "name": "pocket",
        "planner": "breadth_first",
        "problem": {
            "map": {
                "generate": "random", "rows": rows, "columns": columns, "density": density, "seed": seed, "crop": crop,
            },
            "goals": [list(goal)], "starts": [list(max(free - {goal}))], "reach": least,
        },
        "mapping": {"search": {"component": "host", "style": "software"}},
    }  # fmt: skip
    workload = codesign.load_workload(tree)
    problem, faults = plannable(workload, scenario_of(workload))
    pocket = [each for each in faults if "of the free cells" in each.what or "free cells (" in each.what]
    assert bool(pocket) == (len(joined) < least * len(free))
    if problem is not None:
        assert problem.reach == len(joined) / len(free)


def test_every_program_pays_for_reading_its_map(tmp_path: Path) -> None:
    """Each planner in software, in each of its designs: the goal stands in a pocket of 4 cells, and the hall grows by
    8,000 cells. Each of them takes as long as a cell that breadth-first search reads, or longer."""
    times: list[dict[tuple[str, ...], float]] = []
    for rows in (80, 180):
        path = tmp_path / f"hall-{rows}.txt"
        path.write_text(hall(rows, 80))
        needs = advice.parse_needs("10 Hz")
        section = advice.problem_section(path, ["1,1"], ["2,2"], needs, reach=0.0)
        question = advice.ask(needs, section, path)
        laboratory = Laboratory(question)
        (board,) = advice.boards_of(["pc-epyc"])
        times.append({})
        families = (
            (each, family)
            for each in arrangements_of(board, question.problem, needs)
            for family in each.families()
            if family.chain
        )
        for arrangement, family in families:
            candidate = arrangement.candidate(family.chain[0])
            key = (candidate.planner.name, candidate.style.style, str(candidate.mapping))
            time = laboratory.trial(candidate)[1].time_s
            # The Java program has no cost here, and its heap holds no such map.
            assert time is not None or candidate.style.style == "software_java", key
            times[-1] |= {} if time is None else {key: time}
    small, large = times
    both = small.keys() & large.keys()
    assert {name for name, *_ in both} >= {"breadth_first", "wavefront", "relaxation", "harmonic"}
    read = 160e-12 * 80 * 100
    for key in both:
        assert large[key] - small[key] >= 0.99 * read, key
    assert any("direct" in mapping for *_, mapping in both)


def test_a_fault_of_the_share_names_the_file() -> None:
    tree = {
        "kind": "workload", "name": "a", "planner": "breadth_first",
        "problem": {"map": {"generate": "empty", "rows": 2, "columns": 2}, "goals": [[0, 0]], "reach": 2},
        "mapping": {"search": {"component": "host", "style": "software"}},
    }  # fmt: skip
    with pytest.raises(SpecError, match="reach"):
        codesign.load_workload(tree)
