"""What the user is told: the whole text for each typical mistake, and all mistakes of a file at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, ClassVar

import pytest
from pydantic import BaseModel, ConfigDict, Field, model_validator

from codesign.errors import InputError, SpecError
from codesign.spec import RefusalError, SpecModel, list_parts, load_platform, load_workload

PLATFORM = """\
kind: platform
name: mine
components:
  fpga: {type: fpga, part: XC4VLX160-12, clock: 150 MHz}
  host:
    type: processor
    clock: 2 GHz
    costs:
      harmonic_node_update: {value: 40 ns, status: measured, source: own run, low: 35 ns, high: 50 ns}
    power: {busy: 75 W, idle: 25 W}
links:
  pci: {type: bus, between: [host, fpga], width: 32, clock: 33 MHz, setup_cycles: 8, burst_words: 16}
"""

WORKLOAD = """\
kind: workload
name: mine
planner: harmonic
problem:
  map: {generate: rooms, rows: 40, columns: 60, room: [8, 8]}
  goals: [[4, 10]]
mapping:
  relax:
    component: fpga
    block: [20, 30]
    iterations: 6
    schedule: {first: 7, step: 8, last: 63}
explore:
  axes:
    relax.block: [[20, 30], [10, 15]]
    relax.schedule.last: [63, 127]
    fpga.clock: [100 MHz, 150 MHz]
"""


class Range(SpecModel):
    first: Annotated[int, Field(ge=1)]
    step: Annotated[int, Field(ge=1)]
    last: Annotated[int, Field(ge=1, le=1023)]

    @model_validator(mode="after")
    def _rises(self) -> Range:
        if self.last < self.first:
            raise RefusalError(f"last {self.last} is below first {self.first}", "raise last", ("last",))
        return self


class Relax(SpecModel):
    alternatives: ClassVar[dict[str, tuple[str, ...]]] = {"block": ("blocks",), "blocks": ("block",)}

    block: tuple[int, int] | None = None
    blocks: tuple[int, int] | None = None
    iterations: Annotated[int, Field(ge=1)]
    schedule: Range | tuple[int, ...]
    exact: bool = True
    share: float = 1.0

    @model_validator(mode="after")
    def _one_partition(self) -> Relax:
        if (self.block is None) == (self.blocks is None):
            raise ValueError("give block or blocks")
        return self


class Decide(BaseModel):
    """A plain pydantic model, as a user's own planner may bring it."""

    model_config = ConfigDict(extra="forbid", frozen=True)


TASKS = {"harmonic": {"relax": Relax, "decide": Decide}}

PARTS = sorted({name.rpartition("-")[0] for name in list_parts()})


@pytest.fixture
def faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., str]:
    """What loading says of one of the texts above with some of it replaced."""
    monkeypatch.chdir(tmp_path)

    def of(text: str, *changes: tuple[str, str]) -> str:
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        file = Path("w.yaml" if text.startswith("kind: workload") else "p.yaml")
        file.write_text(text, encoding="utf-8")
        try:
            load_workload(file, TASKS) if file.stem == "w" else load_platform(file)
        except SpecError as error:
            return str(error)
        return ""

    return of


def test_both_texts_are_right(faults: Callable[..., str]) -> None:
    assert faults(PLATFORM) == ""
    assert faults(WORKLOAD) == ""


PLATFORM_MISTAKES = [
    (
        ("clock: 150 MHz", "clock: 650 MHz"),
        "p.yaml:4:49: components.fpga.clock: 650 MHz is above the 500 MHz limit of part XC4VLX160-12\n"
        "  hint: lower the clock, or choose a faster part",
    ),
    (
        ("clock: 150 MHz", "clock: 150 mhz"),
        "p.yaml:4:49: components.fpga.clock: '150 mhz' has no unit of frequency\n"
        "  hint: did you mean MHz? accepted units: Hz, kHz, MHz, GHz",
    ),
    (
        ("clock: 2 GHz", "clock: 2e9"),
        "p.yaml:7:12: components.host.clock: 2e9 has no unit\n"
        "  hint: write a number and a unit, such as 150 MHz",
    ),
    (
        ("XC4VLX160-12", "XC4VLX16-12"),
        "p.yaml:4:28: components.fpga.part: there is no part 'XC4VLX16'\n"
        f"  hint: did you mean XC4VLX160? accepted: {', '.join(PARTS)}",
    ),
    (
        ("XC4VLX160-12", "XC4VLX160"),
        "p.yaml:4:28: components.fpga.part: part XC4VLX160 has several speed grades; one has to be named\n"
        "  hint: did you mean XC4VLX160-12? accepted: XC4VLX160-10, XC4VLX160-11, XC4VLX160-12",
    ),
    (
        ("type: fpga,", "type: fgpa,"),
        "p.yaml:4:16: components.fpga.type: there is no type 'fgpa'\n"
        "  hint: did you mean fpga? accepted: fpga, processor",
    ),
    (
        ("type: fpga, ", ""),
        "p.yaml:4:9: components.fpga: type is missing\n  hint: accepted: fpga, processor",
    ),
    (
        ("between: [host, fpga]", "between: [host, fgpa]"),
        "p.yaml:12:36: links.pci.between[1]: there is no component 'fgpa'\n"
        "  hint: did you mean fpga? accepted: fpga, host",
    ),
    (
        ("between: [host, fpga]", "between: [host, host]"),
        "p.yaml:12:36: links.pci.between[1]: host is named twice\n  hint: name it once",
    ),
    (
        ("  pci:", "  host:"),
        "p.yaml:12:3: links.host: host names a component too\n  hint: give the link a name of its own",
    ),
    (
        ("width: 32,", "width: 32 b,"),
        "p.yaml:12:50: links.pci.width: '32 b' is not a whole number\n"
        "  hint: write it without a unit, such as 32",
    ),
    (
        ("burst_words: 16", "burst_words: 0"),
        "p.yaml:12:99: links.pci.burst_words: 0 is out of bounds\n  hint: from 1 to 1,000,000,000,000,000",
    ),
    (
        ("low: 35 ns", "low: 45 ns"),
        "p.yaml:9:84: components.host.costs.harmonic_node_update.low: 45 ns is above the value 40 ns\n"
        "  hint: correct low",
    ),
    (
        ("status: measured", "status: guessed"),
        "p.yaml:9:52: components.host.costs.harmonic_node_update.status: 'guessed' is not accepted\n"
        "  hint: accepted: assumed, calibrated, measured, published",
    ),
    (
        ("  fpga: {", "  1st: {"),
        "p.yaml:4:3: components.1st: '1st' is not a name\n  hint: letters, digits, _ and -, a letter first\n"
        "p.yaml:12:36: links.pci.between[1]: there is no component 'fpga'\n  hint: accepted: 1st, host",
    ),
    (
        ("power: {busy: 75 W, idle: 25 W}", "power: {busy: 75 W}"),
        "p.yaml:10:12: components.host.power.idle: missing\n  hint: add this key",
    ),
    (("kind: platform", "kind: workload "), None),
]


@pytest.mark.parametrize(("change", "expected"), PLATFORM_MISTAKES[:-1])
def test_platform_mistakes(faults: Callable[..., str], change: tuple[str, str], expected: str) -> None:
    assert faults(PLATFORM, change) == expected


def test_the_wrong_kind_of_file(tmp_path: Path) -> None:
    file = tmp_path / "w.yaml"
    file.write_text(WORKLOAD)
    with pytest.raises(SpecError) as caught:
        load_platform(file)
    assert f"{file}:1:7: kind: 'workload' is not accepted\n  hint: accepted: platform" in str(caught.value)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            ("    iterations: 6", "    iteratons: 6"),
            "w.yaml:9:5: mapping.relax.iterations: missing\n  hint: add this key\n"
            "w.yaml:11:5: mapping.relax.iteratons: unknown key\n"
            "  hint: did you mean iterations? "
            "accepted: block, blocks, component, exact, iterations, schedule, share, style",
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
            "  hint: write the path of a map; the path is relative to this workload file",
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
            "w.yaml:11:17: mapping.relax.iterations: true is not a whole number",
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
            "w.yaml:12:12: mapping.relax.share: 'yes' is not a number",
        ),
        (
            ("block: [20, 30]", "block: [20, 30]\n    blocks: [2, 2]"),
            "w.yaml:9:5: mapping.relax: give block or blocks",
        ),
        (
            ("step: 8", "stp: 8"),
            "w.yaml:12:15: mapping.relax.schedule.step: missing\n  hint: add this key\n"
            "w.yaml:12:26: mapping.relax.schedule.stp: unknown key\n"
            "  hint: did you mean step? accepted: first, last, step",
        ),
        (
            ("schedule: {first: 7, step: 8, last: 63}", "schedule: all"),
            "w.yaml:12:15: mapping.relax.schedule: 'all' is not a mapping or a list",
        ),
        (
            ("last: 63}", "last: 6}"),
            "w.yaml:12:41: mapping.relax.schedule.last: last 6 is below first 7\n  hint: raise last",
        ),
        (
            ("  relax:\n", "  relx:\n"),
            "w.yaml:8:3: mapping.relx: harmonic has no task 'relx'\n"
            "  hint: did you mean relax? accepted: decide, relax",
        ),
        (
            ("planner: harmonic", "planner: harmonc"),
            "w.yaml:3:10: planner: there is no planner 'harmonc'\n"
            "  hint: did you mean harmonic? accepted: harmonic",
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
            "  hint: write a list of [row, column], or {count: 64, seed: 0}",
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
            "w.yaml:15:38: explore.axes.relax.block[2]: [20, 30] is listed twice\n  hint: list it once",
        ),
        (
            ("relax.block:", "relax.blok:"),
            "w.yaml:15:5: explore.axes.relax.blok: task relax has no parameter 'blok'\n"
            "  hint: did you mean block? "
            "accepted: block, blocks, component, exact, iterations, schedule, share, style",
        ),
        (
            ("    fpga.clock:", "    relax.blocks: [[2, 2]]\n    fpga.clock:"),
            "w.yaml:17:5: explore.axes.relax.blocks: sets the same thing as axis relax.block\n"
            "  hint: keep one of them",
        ),
        (
            ("    fpga.clock:", "    relax.schedule: [[7, 9]]\n    fpga.clock:"),
            "w.yaml:17:5: explore.axes.relax.schedule: sets the same thing as axis relax.schedule.last\n"
            "  hint: keep one of them",
        ),
        (
            ("relax.schedule.last: [63, 127]", "relax.iterations.last: [63, 127]"),
            "w.yaml:16:5: explore.axes.relax.iterations.last: "
            "iterations is not a mapping in the mapping of the task\n"
            "  hint: write it out there as a mapping first",
        ),
        (
            ("fpga.clock: [", "clock: ["),
            "w.yaml:17:12: explore.axes.clock: 'clock' is no axis\n"
            "  hint: write TASK.PARAMETER or COMPONENT.FIELD, such as relax.iterations",
        ),
    ],
)
def test_workload_mistakes(faults: Callable[..., str], change: tuple[str, str], expected: str) -> None:
    assert faults(WORKLOAD, change) == expected


@pytest.mark.parametrize(
    ("explore", "expected"),
    [
        (
            "objectives: [time, slice, time]",
            "w.yaml:18:22: explore.objectives[1]: 'slice' is not accepted\n  hint: did you mean slices? accepted: ",
        ),
        (
            "objectives: [time, time]",
            "w.yaml:18:22: explore.objectives[1]: time is listed twice\n  hint: list it once",
        ),
        (
            "constraints: [{figure: time, at_most: 5}]",
            "w.yaml:18:41: explore.constraints[0].at_most: 5 has no unit\n"
            "  hint: write a number and a unit, such as 10 us",
        ),
        (
            "constraints: [{figure: slices, at_most: many}]",
            "w.yaml:18:43: explore.constraints[0].at_most: 'many' is not a number",
        ),
        (
            "constraints: [{figure: time}]",
            "w.yaml:18:17: explore.constraints[0]: bounds nothing\n  hint: give at_least, at_most, or both",
        ),
        (
            "constraints: [{figure: slices, at_least: 2, at_most: 1}]",
            "w.yaml:18:44: explore.constraints[0].at_least: nothing is within these bounds",
        ),
    ],
)
def test_explore_mistakes(faults: Callable[..., str], explore: str, expected: str) -> None:
    assert faults(f"{WORKLOAD}  {explore}\n").startswith(expected)


def test_too_many_points_are_refused_with_the_product(faults: Callable[..., str]) -> None:
    many = str(list(range(1, 1001)))
    axes = f"    relax.iterations: {many}\n    fpga.a: {many}\n    fpga.b: [1, 2]\n"
    text = f"{WORKLOAD[: WORKLOAD.index('    relax.block')]}{axes}"
    assert (
        "w.yaml:15:5: explore.axes: 1000 x 1000 x 2 = 2,000,000 points are too many\n  hint: at most 1,000,000"
        in (faults(text))
    )
    longer = text.replace("[1, 2]", str(list(range(1001))))
    assert "explore.axes.fpga.b: a list of 1001 entries is too long\n  hint: at most 1000 accepted" in faults(
        longer
    )


def test_all_faults_come_at_once_in_file_order(faults: Callable[..., str]) -> None:
    text = faults(
        WORKLOAD,
        ("name: mine", "nmae: mine"),
        ("rows: 40", "rows: 040"),
        ("iterations: 6", "iterations: six"),
        ("[100 MHz, 150 MHz]", "[.inf]"),
    )
    assert [line.split(": ")[0] for line in text.splitlines() if line.startswith("w.yaml")] == [
        "w.yaml:1:1",
        "w.yaml:2:1",
        "w.yaml:5:32",
        "w.yaml:11:17",
        "w.yaml:17:18",
    ]


def test_faults_of_yaml_and_of_the_schema_come_together(faults: Callable[..., str]) -> None:
    text = faults(
        WORKLOAD,
        ("name: mine", "name: mine\nname: mine\non: yes"),
        ("planner:", "planer:"),
        ("map: {", "map: &map {"),
        ("room: [8, 8]", "room: [8, 8], door: 0"),
        ("goals: [[4, 10]]", "gaols: &goals 3\n  starts: *goals"),
        ("step: 8", "step: !!int 8"),
    )
    assert [line.split(": ")[:3:2] for line in text.splitlines() if line.startswith("w.yaml")] == [
        ["w.yaml:1:1", "missing"],
        ["w.yaml:3:1", "key given twice, first at 2:1"],
        ["w.yaml:4:1", "unknown key"],
        ["w.yaml:5:1", "unknown key"],
        ["w.yaml:7:3", "missing"],
        ["w.yaml:7:8", "anchor &map"],
        ["w.yaml:7:74", "0 is out of bounds"],
        ["w.yaml:8:3", "unknown key"],
        ["w.yaml:8:10", "anchor &goals"],
        ["w.yaml:9:11", "alias *goals"],
        ["w.yaml:15:32", "tag tag:yaml.org,2002:int"],
    ]


def test_no_more_than_a_hundred_faults_are_told(faults: Callable[..., str]) -> None:
    text = faults("kind: platform\n" + "".join(f"key{index}: 1\n" for index in range(500)))
    lines = [line for line in text.splitlines() if line.startswith("p.yaml")]
    assert len(lines) == 101
    assert lines[-1].endswith("and 402 more faults")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "virtx4-pci",
            "there is no shipped platform 'virtx4-pci'\n  hint: did you mean virtex4-pci? accepted: ",
        ),
        ("mine.yaml", "mine.yaml: does not exist"),
        ("./virtex4-pci", "./virtex4-pci: does not exist"),
    ],
)
def test_names_and_paths(name: str, expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((InputError, SpecError)) as caught:
        load_platform(name)
    assert str(caught.value).startswith(expected)


def test_map_files_are_looked_for_beside_the_workload(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "office.yaml").write_text("image: office.png")
    monkeypatch.chdir("/")

    def load(file: str) -> Path | None:
        text = WORKLOAD.replace("{generate: rooms, rows: 40, columns: 60, room: [8, 8]}", f"{{file: {file}}}")
        (tmp_path / "w.yaml").write_text(text)
        return load_workload(tmp_path / "w.yaml", TASKS).map_file

    assert load("maps/office.yaml") == tmp_path / "maps" / "office.yaml"
    assert load("maps/../maps/office.yaml") is not None
    with pytest.raises(SpecError) as caught:
        load("maps/ofice.yaml")
    assert str(caught.value) == (
        f"{tmp_path}/w.yaml:5:15: problem.map.file: maps/ofice.yaml does not exist\n"
        "  hint: did you mean maps/office.yaml? the path is relative to this workload file"
    )
    with pytest.raises(SpecError, match="maps is not a file"):
        load("maps")
    with pytest.raises(SpecError, match="does not exist"):
        load("x" * 3000)
