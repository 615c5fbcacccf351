"""Axes: what a message names where a near word is no help, and values that say the same."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import ON_A_MAP

from codesign import load_platform, load_workload
from codesign.ground.errors import SpecError
from codesign.inputs import cross_check, design_point, starting_files


@pytest.mark.parametrize(("axis", "told"), [("relax", "relax.iterations"), ("fpga", "fpga.clock")])
def test_a_setting_of_a_whole_task_or_component_is_told_what_can_be_set(tmp_path: Path, axis: str, told: str) -> None:
    for name, text in starting_files().items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    point = load_platform(tmp_path / "my-platform.yaml"), load_workload(tmp_path / "my-workload.yaml")
    with pytest.raises(SpecError, match="no axis") as caught:
        design_point(*point, {axis: 1}, "--set ")
    assert told in str(caught.value)
    assert "did you mean" not in str(caught.value)


def test_one_value_written_in_two_ways_is_no_two_points(tmp_path: Path) -> None:
    texts = starting_files()
    platform, workload = (tmp_path / name for name in texts)
    platform.write_text(texts[platform.name], encoding="utf-8")
    workload.write_text(
        ON_A_MAP.format(file="map.txt") + "explore:\n  axes:\n    fpga.clock: [100 MHz, 50 MHz, 100000 kHz]\n"
    )
    (tmp_path / "map.txt").write_text("..\n")
    with pytest.raises(SpecError, match="'100000 kHz' says the same as a value before it") as caught:
        cross_check(load_platform(platform), load_workload(workload))
    assert [(fault.line, fault.column) for fault in caught.value.faults] == [(11, 35)]
