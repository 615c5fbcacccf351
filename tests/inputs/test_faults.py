"""What the user is told: the whole text for each typical mistake, and all mistakes of a file at once."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import PARTS, PLATFORM, TASKS, WORKLOAD, faults

from codesign.ground.errors import InputError, SpecError
from codesign.inputs import load_platform, load_workload


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_both_texts_are_right() -> None:
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
        "p.yaml:7:12: components.host.clock: 2e9 has no unit\n  hint: write a number and a unit, such as 150 MHz",
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
        "  hint: did you mean fpga? accepted: display, fpga, memory, processor, robot",
    ),
    (
        ("type: fpga, ", ""),
        "p.yaml:4:9: components.fpga: type is missing\n  hint: accepted: display, fpga, memory, processor, robot",
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
        "p.yaml:12:50: links.pci.width: '32 b' is not a whole number\n  hint: write it without a unit, such as 32",
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
def test_platform_mistakes(change: tuple[str, str], expected: str) -> None:
    assert faults(PLATFORM, change) == expected


def test_the_wrong_kind_of_file(tmp_path: Path) -> None:
    file = tmp_path / "w.yaml"
    file.write_text(WORKLOAD)
    with pytest.raises(SpecError) as caught:
        load_platform(file)
    what = "this is a workload, and a platform is asked for"
    hint = "are the two files swapped? the platform comes first"
    assert str(caught.value) == f"{file}:1:7: kind: {what}\n  hint: {hint}"


def test_all_faults_come_at_once_in_file_order() -> None:
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


def test_faults_of_yaml_and_of_the_schema_come_together() -> None:
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


def test_no_more_than_a_hundred_faults_are_told() -> None:
    text = faults("kind: platform\n" + "".join(f"key{index}: 1\n" for index in range(500)))
    lines = [line for line in text.splitlines() if line.startswith("p.yaml")]
    assert len(lines) == 101
    assert lines[-1].endswith("and at least 402 more faults")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("virtx4-pci", "there is no shipped platform 'virtx4-pci'\n  hint: did you mean virtex4-pci? accepted: "),
        ("mine.yaml", "mine.yaml: does not exist"),
        ("./virtex4-pci", "./virtex4-pci: does not exist"),
    ],
)
def test_names_and_paths(name: str, expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises((InputError, SpecError)) as caught:
        load_platform(name)
    assert str(caught.value).startswith(expected)


def test_map_files_are_looked_for_beside_the_workload(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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
        "  hint: did you mean maps/office.yaml? the path is relative to the file that names it"
    )
    with pytest.raises(SpecError, match="maps is not a file"):
        load("maps")
    with pytest.raises(SpecError, match="does not exist"):
        load("x" * 3000)
