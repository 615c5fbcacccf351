"""What the user is told of a workload: the whole text for each typical mistake."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import WORKLOAD, faults

from codesign.ground.figures import SHORT_NAMES


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            ("    iterations: 6", "    iteratons: 6"),
            "w.yaml:9:5: mapping.relax.iterations: missing\n  hint: add this key\n"
            "w.yaml:11:5: mapping.relax.iteratons: unknown key\n"
            "  hint: did you mean iterations? "
            "accepted: block, blocks, component, exact, external_memory, iterations, schedule, share, style",
        ),
        (
            ("iterations: 6", 'iterations: "6"'),
            "w.yaml:11:17: mapping.relax.iterations: '6' is not a whole number\n  hint: write 6",
        ),
        (
            ("iterations: 6", "iterations: 6.0"),
            "w.yaml:11:17: mapping.relax.iterations: 6.0 is not a whole number\n  hint: write 6",
        ),
        (
            ("iterations: 6", "iterations: 1e6"),
            "w.yaml:11:17: mapping.relax.iterations: 1e6 is not a whole number\n  hint: write 1000000",
        ),
        (
            ("iterations: 6", "iterations: "),
            "w.yaml:11:16: mapping.relax.iterations: an empty value is not a whole number\n"
            "  hint: write a whole number",
        ),
        (
            ("{generate: rooms, rows: 40, columns: 60, room: [8, 8]}", "{file: }"),
            "w.yaml:5:14: problem.map.file: names no file\n"
            "  hint: write the path of a map; the path is relative to the file that names it",
        ),
        (
            ("{generate: rooms, rows: 40, columns: 60, room: [8, 8]}", "{file: 3}"),
            "w.yaml:5:15: problem.map.file: 3 is not text\n  hint: quote it",
        ),
        (
            ("[[4, 10]]", "[[.nan, 10]]"),
            "w.yaml:6:12: problem.goals[0][0]: .nan is not a finite number\n  hint: write a finite number",
        ),
        (
            ("iterations: 6", "iterations: true"),
            "w.yaml:11:17: mapping.relax.iterations: true is not a whole number\n  hint: write a whole number",
        ),
        (
            ("iterations: 6", "iterations: 1_000"),
            "w.yaml:11:17: mapping.relax.iterations: '1_000' is not a whole number\n  hint: write 1000",
        ),
        (
            ("iterations: 6", "iterations: 0"),
            "w.yaml:11:17: mapping.relax.iterations: 0 is out of bounds\n  hint: it must be at least 1",
        ),
        (
            ("iterations: 6", "iterations: 6\n    exact: 'False'"),
            "w.yaml:12:12: mapping.relax.exact: 'False' is not true or false\n"
            "  hint: write true or false, in lower case, without quotes",
        ),
        (
            ("iterations: 6", "iterations: 6\n    share: yes"),
            "w.yaml:12:12: mapping.relax.share: 'yes' is not a number\n  hint: write a number",
        ),
        (("block: [20, 30]", "block: [20, 30]\n    blocks: [2, 2]"), "w.yaml:9:5: mapping.relax: give block or blocks"),
        (
            ("step: 8", "stp: 8"),
            "w.yaml:12:15: mapping.relax.schedule.step: missing\n  hint: add this key\n"
            "w.yaml:12:26: mapping.relax.schedule.stp: unknown key\n"
            "  hint: did you mean step? accepted: first, last, step",
        ),
        (
            ("schedule: {first: 7, step: 8, last: 63}", "schedule: all"),
            "w.yaml:12:15: mapping.relax.schedule: 'all' is not a mapping or a list\n  hint: write a mapping or a list",
        ),
        (
            ("last: 63}", "last: 6}"),
            "w.yaml:12:41: mapping.relax.schedule.last: last 6 is below first 7\n  hint: raise last",
        ),
        (
            ("  relax:\n", "  relx:\n"),
            "w.yaml:8:3: mapping.relx: harmonic has no task 'relx'\n"
            "  hint: did you mean relax? accepted: command, decide, load, relax",
        ),
        (
            ("planner: harmonic", "planner: harmonc"),
            "w.yaml:3:10: planner: there is no planner 'harmonc'\n  hint: did you mean harmonic? accepted: harmonic",
        ),
        (
            ("goals: [[4, 10]]", "goals: [[4, 10], [40, 0], [4, 10], [1]]"),
            "w.yaml:6:38: problem.goals[3]: a list of 1 entries is too short\n  hint: 2 needed",
        ),
        (
            ("goals: [[4, 10]]", "goals: [[4, 10], [40, 0], [4, 10]]"),
            "w.yaml:6:20: problem.goals[1]: cell (40, 0) is outside of the map of 40 × 60 cells\n"
            "  hint: (row, column) from (0, 0) to (39, 59)\n"
            "w.yaml:6:29: problem.goals[2]: [4, 10] is named twice\n  hint: name it once",
        ),
        (
            ("goals: [[4, 10]]", "goals: []"),
            "w.yaml:6:10: problem.goals: a list of 0 entries is too short\n  hint: at least 1 needed",
        ),
        (
            ("goals: [[4, 10]]", "goals: [[4, 10]]\n  starts: all"),
            "w.yaml:7:11: problem.starts: 'all' names no starts\n"
            "  hint: write a list of [row, column] or {x: METRES, y: METRES}, {count: 64, seed: 0},"
            " or {scen: FILE, line: 2}",
        ),
        (
            ("generate: rooms", "generate: room"),
            "w.yaml:5:19: problem.map.generate: there is no generate 'room'\n"
            "  hint: did you mean rooms? accepted: corridor, empty, maze, random, rooms, spiral",
        ),
        (
            ("generate: rooms, ", ""),
            "w.yaml:5:8: problem.map: neither file nor generate is given\n"
            "  hint: write file: PATH of a map, or generate: and its parameters; "
            "generators: corridor, empty, maze, random, rooms, spiral",
        ),
        (
            ("rows: 40, columns: 60", "rows: 40000, columns: 60000"),
            "w.yaml:5:8: problem.map: a map of 40000 × 60000 cells is too large\n  hint: at most 16,777,216 cells",
        ),
        (
            ("relax.block: [[20, 30], [10, 15]]", "relax.block: [[20, 30], [10, a], [20, 30]]"),
            "w.yaml:15:34: explore.axes.relax.block[1][1]: 'a' is not a whole number\n"
            "  hint: write a whole number\n"
            "w.yaml:15:38: explore.axes.relax.block[2]: [20, 30] is listed twice\n  hint: list it once",
        ),
        (
            ("relax.block:", "relax.blok:"),
            "w.yaml:15:5: explore.axes.relax.blok: unknown key\n"
            "  hint: did you mean block? "
            "accepted: block, blocks, component, exact, external_memory, iterations, schedule, share, style",
        ),
        (
            ("    fpga.clock:", "    relax.blocks: [[2, 2]]\n    fpga.clock:"),
            "w.yaml:17:5: explore.axes.relax.blocks: sets the same thing as axis relax.block\n  hint: keep one of them",
        ),
        (
            ("    fpga.clock:", "    relax.schedule: [[7, 9]]\n    fpga.clock:"),
            "w.yaml:17:5: explore.axes.relax.schedule: sets the same thing as axis relax.schedule.last\n"
            "  hint: keep one of them",
        ),
        (
            ("relax.schedule.last: [63, 127]", "relax.iterations.last: [63, 127]"),
            "w.yaml:16:5: explore.axes.relax.iterations.last: "
            "mapping.relax.iterations is not a mapping\n"
            "  hint: set the whole of it",
        ),
        (
            ("fpga.clock: [", "clock: ["),
            "w.yaml:17:12: explore.axes.clock: 'clock' is no axis\n"
            "  hint: write TASK.PARAMETER, COMPONENT.FIELD, LINK.FIELD or platform, such as relax.iterations",
        ),
    ],
)
def test_workload_mistakes(change: tuple[str, str], expected: str) -> None:
    assert faults(WORKLOAD, change) == expected


@pytest.mark.parametrize(
    ("explore", "expected"),
    [
        (
            "objectives: [first_plan_s, slice, first_plan_s]",
            "w.yaml:18:30: explore.objectives[1]: 'slice' is not accepted\n  hint: did you mean slices? accepted: ",
        ),
        (
            "objectives: [first_plan_s, first_plan_s]",
            "w.yaml:18:30: explore.objectives[1]: first_plan_s is listed twice\n  hint: list it once",
        ),
        (
            "constraints: [{figure: first_plan_s, at_most: 5}]",
            "w.yaml:18:49: explore.constraints[0].at_most: 5 has no unit\n"
            "  hint: write a number and a unit, such as 10 us",
        ),
        (
            "objectives: [time, slices]",
            "w.yaml:18:16: explore.objectives[0]: 'time' is not accepted\n"
            "  hint: write plan_time_worst_s: time is its short name in limits as text",
        ),
        (
            "constraints: [{figure: mission_clearance, at_least: 20 cm}]",
            "w.yaml:18:26: explore.constraints[0].figure: 'mission_clearance' is not accepted\n"
            "  hint: write clearance_least_m: mission_clearance is its short name in limits as text",
        ),
        (
            "constraints: [{figure: slices, at_most: many}]",
            "w.yaml:18:43: explore.constraints[0].at_most: 'many' is not a number",
        ),
        (
            "constraints: [{figure: first_plan_s}]",
            "w.yaml:18:17: explore.constraints[0]: bounds nothing\n  hint: give at_least, at_most, or both",
        ),
        (
            "constraints: [{figure: slices, at_least: 2, at_most: 1}]",
            "w.yaml:18:44: explore.constraints[0].at_least: nothing is within these bounds",
        ),
    ],
)
def test_explore_mistakes(explore: str, expected: str) -> None:
    assert faults(f"{WORKLOAD}  {explore}\n").startswith(expected)


@pytest.mark.parametrize(("earlier", "name"), SHORT_NAMES.items())
def test_a_short_name_of_a_figure_has_its_name_as_the_remedy(earlier: str, name: str) -> None:
    refusal = f"{earlier!r} is not accepted\n  hint: write {name}: {earlier} is its short name in limits as text"
    for explore, key in (
        (f"objectives: [slices, {earlier}]", "objectives[1]"),
        (f"constraints: [{{figure: {earlier}, at_most: 5}}]", "constraints[0].figure"),
    ):
        assert f": explore.{key}: {refusal}" in faults(f"{WORKLOAD}  {explore}\n")


def test_no_cell_has_a_row_or_column_below_zero() -> None:
    text = faults(WORKLOAD.replace("goals: [[4, 10]]", "goals: [[-1, 10]]\n  starts: [[3, -2]]"))
    for key, value in (("goals[0][0]", -1), ("starts[0][1]", -2)):
        what = f"problem.{key}: {value} is not a row or column of a map"
        assert f"{what}\n  hint: rows and columns are counted from 0 at the top left" in text


def test_too_many_points_are_refused_with_the_product() -> None:
    many = str(list(range(1, 1001)))
    axes = f"    relax.iterations: {many}\n" + "".join(f"    fpga.{name}: {many}\n" for name in "abcde")
    text = f"{WORKLOAD[: WORKLOAD.index('    relax.block')]}{axes}"
    assert (
        "w.yaml:15:5: explore.axes: 1000 x 1000 x 1000 x 1000 x 1000 x 1000 = 1,000,000,000,000,000,000 points are too"
        " many\n  hint: at most 1,000,000,000,000,000" in faults(text)
    )
    longer = text.replace(f"fpga.b: {many}", f"fpga.b: {list(range(1001))}")
    assert "explore.axes.fpga.b: a list of 1001 entries is too long\n  hint: at most 1000 accepted" in faults(longer)
