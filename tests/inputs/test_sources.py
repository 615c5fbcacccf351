"""A spec from a name, a path, YAML text or a dict: the same spec, and the same faults."""

import datetime
from pathlib import Path
from typing import Any

import pytest
import yaml
from places import ROOT

import codesign
from codesign.ground.errors import InputError, SpecError
from codesign.inputs.files import document_from

LABYRINTH = (ROOT / "workloads" / "labyrinth.yaml").read_text(encoding="utf-8")
BOARD = (ROOT / "platforms" / "virtex4-pci.yaml").read_text(encoding="utf-8")


def tree() -> dict[str, Any]:
    loaded: dict[str, Any] = yaml.safe_load(LABYRINTH)
    return loaded


def test_name_path_text_and_dict_are_the_same_workload() -> None:
    by_name = codesign.load_workload("labyrinth")
    others = [ROOT / "workloads" / "labyrinth.yaml", LABYRINTH, tree()]
    assert {codesign.load_workload(each).digest() for each in others} == {by_name.digest()}


def test_text_and_dict_are_the_same_platform() -> None:
    text, plain = codesign.load_platform(BOARD), codesign.load_platform(yaml.safe_load(BOARD))
    assert text.digest() == plain.digest() == codesign.load_platform("virtex4-pci").digest()


def test_simulate_takes_names_and_dicts() -> None:
    workload = tree()
    workload["problem"]["starts"] = [[68, 2]]
    loaded = codesign.load_platform("virtex4-pci"), codesign.load_workload(workload)
    assert codesign.simulate("virtex4-pci", workload) == codesign.simulate(*loaded)


def test_explore_takes_names_and_dicts() -> None:
    workload = tree()
    workload["explore"] = {"axes": {"relax.iterations": [1, 6]}, "objectives": ["slices"]}
    study = codesign.explore("virtex4-pci", workload)
    assert [point.axes for point in study.points] == [{"relax.iterations": 1}, {"relax.iterations": 6}]


def test_every_fault_of_a_dict_comes_at_once_by_its_key() -> None:
    workload = tree()
    workload |= {"planner": "harmnic", "name": datetime.date(2020, 1, 1)}
    workload["problem"] |= {"goals": [[3, float("nan")]], 7: "seven"}
    with pytest.raises(SpecError) as caught:
        codesign.load_workload(workload)
    told = {(fault.file, fault.key): fault for fault in caught.value.faults}
    assert told["workload dict", "planner"].hint is not None
    assert "did you mean harmonic" in str(told["workload dict", "planner"].hint)
    assert "no plain value" in told["workload dict", "name"].what
    assert len(caught.value.faults) == 4
    assert "not finite" in told["workload dict", "problem.goals[0][1]"].what
    assert "key 7 is not text" in told["workload dict", "problem"].what


def test_a_fault_of_a_text_has_its_line() -> None:
    with pytest.raises(SpecError, match=r"workload text:5:10: planner: there is no planner 'harmnic'"):
        codesign.load_workload(LABYRINTH.replace("planner: harmonic", "planner: harmnic"))


def test_a_dict_that_contains_itself_or_is_too_large_is_refused() -> None:
    loop: dict[str, Any] = {}
    loop["loop"] = loop
    with pytest.raises(SpecError, match="nested more than"):
        document_from(loop, "a dict")
    with pytest.raises(SpecError, match=r"more than 100,000 values"):
        document_from({"list": [0] * 100_001}, "a dict")


def test_a_dict_is_copied() -> None:
    given = {"list": [1, {"a": (2, 3)}]}
    copied = document_from(given, "a dict").tree
    given["list"].append(4)
    assert copied == {"list": [1, {"a": [2, 3]}]}


def test_an_unknown_name_is_refused_with_the_nearest_one() -> None:
    with pytest.raises(InputError, match=r"there is no shipped workload 'labirinth'"):
        codesign.simulate("virtex4-pci", "labirinth")


def test_paths_in_a_text_start_at_the_current_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "room.txt").write_text("...\n...\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    workload = tree()
    workload["problem"] = {"map": {"file": "room.txt"}, "goals": [[0, 0]], "starts": [[1, 2]]}
    workload["mapping"]["relax"]["block"] = [2, 3]
    assert codesign.load_workload(workload).map_file == Path("room.txt")
