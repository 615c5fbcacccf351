"""Whatever lies in a file, nothing but a SpecError comes out, and soon."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from input_fuzz import assert_faults_are_told, paths, quietly, replaced, trees
from spec_texts import PLATFORM, TASKS, WORKLOAD

from codesign.ground.errors import CodesignError, SpecError
from codesign.inputs import cross_check, design_point, load_platform, load_workload
from codesign.inputs.yaml_tree import parse_document

SYNTAX = st.text(alphabet="ab01.: -[]{}&*!|>%@`\"'#,?\n\t\\<~é\ud7ff\u2028\x00", max_size=60)


def load(file: Path) -> object:
    """The spec in a file, a platform or a workload by what the file says it is."""
    is_platform = b"platform" in file.read_bytes()[:30]
    return load_platform(file) if is_platform else load_workload(file, TASKS)


PLATFORM_TREE = parse_document(PLATFORM.encode(), "p.yaml", Path()).tree
WORKLOAD_TREE = parse_document(
    (
        WORKLOAD + "  objectives: [first_plan_s, slices]\n  constraints: [{figure: first_plan_s, at_most: 1 s}]\n"
    ).encode(),
    "w",
    Path(),
).tree


@quietly
@given(SYNTAX)
def test_any_text(text: str) -> None:
    try:
        document = parse_document(text.encode("utf-8"), "f.yaml", Path())
    except SpecError:
        return
    for path in paths(document.tree):
        line, column = document.values[path]
        assert 1 <= line <= text.count("\n") + text.count("\r") + 2
        assert column >= 1


@quietly
@given(st.binary(max_size=80))
def test_any_bytes(content: bytes) -> None:
    assert_faults_are_told(lambda: parse_document(content, "f.yaml", Path()))


@quietly
@given(st.data())
def test_one_wrong_value_anywhere(tmp_path: Path, data: st.DataObject) -> None:
    file = tmp_path / "spec.yaml"
    which = data.draw(st.sampled_from([PLATFORM_TREE, WORKLOAD_TREE]))
    path = data.draw(st.sampled_from(paths(which)))
    # JSON is YAML, so any tree can be written without a YAML writer's own ideas.
    text = json.dumps(replaced(which, path, data.draw(trees)))
    file.write_text(text, encoding="utf-8")
    for fault in assert_faults_are_told(lambda: load(file)):
        assert fault.line == 1


@quietly
@given(st.data())
def test_bytes_of_a_spec_damaged(tmp_path: Path, data: st.DataObject) -> None:
    file = tmp_path / "spec.yaml"
    text = data.draw(st.sampled_from([PLATFORM, WORKLOAD])).encode()
    at = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 12))
    file.write_bytes(text[:at] + data.draw(st.binary(max_size=6)) + text[at + length :])
    assert_faults_are_told(lambda: load(file))


@quietly
@given(
    st.sampled_from(
        [
            "relax.block",
            "relax.schedule",
            "relax.schedule.last",
            "relax.component",
            "relax.style",
            "relax.block.x",
            "fpga.part",
            "fpga.clock",
            "fpga.type",
            "host.costs",
            "host.power.busy",
            "fpga",
            ".",
            "",
        ]
    ),
    trees,
)
def test_any_value_of_an_axis(tmp_path: Path, axis: str, value: Any) -> None:
    (tmp_path / "p.yaml").write_text(PLATFORM)
    (tmp_path / "w.yaml").write_text(WORKLOAD)
    platform = load_platform(tmp_path / "p.yaml")
    workload = load_workload(tmp_path / "w.yaml", TASKS)
    assert_faults_are_told(lambda: design_point(platform, workload, {axis: value}))
    axes = {"explore": {"axes": {axis: [value]}}}
    (tmp_path / "w.yaml").write_text(json.dumps({**WORKLOAD_TREE, **axes}), encoding="utf-8")
    assert_faults_are_told(lambda: cross_check(platform, load_workload(tmp_path / "w.yaml", TASKS)))


@pytest.mark.parametrize("name", ["", ".", "..", "x" * 10_000, "a\0b", "\ud800", "~", "C:", "virtex4-pci\n", "💥"])
def test_any_name(name: str) -> None:
    for load_named in (load_platform, load_workload):
        with pytest.raises(CodesignError) as caught:
            load_named(name)
        assert len(caught.value.what) < 200


@pytest.mark.parametrize(
    "text",
    [
        PLATFORM + "".join(f"componentsx{index}: 1\n" for index in range(10_000)),
        WORKLOAD + "".join(f"    relax.x{index}: [1]\n" for index in range(10_000)),
        WORKLOAD.replace("[63, 127]", str(list(range(1, 20_000)))),
        PLATFORM.replace("[host, fpga]", str([f"host{index}" for index in range(20_000)])),
        PLATFORM.replace("links:", "".join(f"  c{index}: {{type: fpgx}}\n" for index in range(5_000)) + "links:"),
    ],
    ids=["keys", "axes", "values", "ends", "components"],
)
def test_many_faults_take_no_time_that_grows_with_their_square(tmp_path: Path, text: str) -> None:
    (tmp_path / "spec.yaml").write_text(text)
    assert 1 <= len(assert_faults_are_told(lambda: load(tmp_path / "spec.yaml"))) <= 101
