"""The list of what ships is read from heads of files, and says what the whole files say."""

from __future__ import annotations

from pathlib import Path

import pytest

from codesign.ground.errors import SpecError
from codesign.inputs import files as input_files
from codesign.inputs import list_platforms, list_workloads, load_platform
from codesign.inputs.components import FpgaComponent
from codesign.planners.registered import HEADLINES
from codesign.system import at_hand, catalog
from docs.make_reference.headlines import headlines_text


@pytest.mark.parametrize("name", list_platforms())
def test_the_headline_of_a_platform_is_that_of_the_whole_file(name: str) -> None:
    platform, line = load_platform(name), at_hand()["platforms"][name]
    price = platform.board.price if platform.board is not None else None
    parts = [fpga.part for fpga in platform.of(FpgaComponent).values()] if platform.board is not None else []
    facts = [*parts, *([f"{price.value:,g} USD of {price.date}, {price.status}"] if price is not None else [])]
    assert line == platform.description + (f" [{'; '.join(facts)}]" if facts else "")


def test_the_headline_of_a_workload_is_that_of_the_whole_file() -> None:
    assert at_hand()["workloads"] == {name: catalog.load_workload(name).description for name in list_workloads()}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("description: 6", r"p\.yaml:3:14: description: 6 is not text"),
        ("description: one\ndescription: two", r"p\.yaml:4:1: description: key given twice"),
        ("description: [", r"p\.yaml:\d+:\d+: not YAML"),
    ],
)
def test_a_file_with_a_faulty_head_is_told_as_when_it_is_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, fault: str
) -> None:
    for folder in ("platforms", "workloads"):
        (tmp_path / folder).mkdir()
    (tmp_path / "platforms" / "p.yaml").write_text(f"kind: platform\nname: p\n{text}\n")
    monkeypatch.setattr(input_files, "_data_folder", lambda name, _module: tmp_path / name)
    with pytest.raises(SpecError, match=fault) as listed:
        at_hand()
    with pytest.raises(SpecError) as read:
        load_platform("p")
    assert listed.value.faults == read.value.faults


def test_the_headlines_of_our_planners_are_those_of_the_planners() -> None:
    assert HEADLINES.read_text(encoding="utf-8") == headlines_text(), "out of date: run `make docs`"
    assert at_hand()["planners"].keys() >= catalog.planners().keys()
    assert at_hand()["styles"].keys() == {f"{planner}.{style}" for planner, style in catalog.architectures()}
