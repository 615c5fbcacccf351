"""Any value in the place of any other in a workload with variants: faults, and no other exception."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from input_fuzz import assert_faults_are_told, paths, quietly, replaced, trees
from spec_texts import assert_axes_are_sound
from variant_texts import TREE, load

from codesign.inputs import Workload, cross_check, design_point, load_platform


def test_the_tree_of_the_fuzz_is_sound(tmp_path: Path) -> None:
    assert_axes_are_sound(*load(tmp_path, text=json.dumps(TREE)))


@settings(quietly, max_examples=60)
@given(st.data())
def test_one_wrong_value_anywhere(tmp_path: Path, data: st.DataObject) -> None:
    path = data.draw(st.sampled_from([each for each in paths(TREE) if each]))
    text = json.dumps(replaced(TREE, path, data.draw(trees)))
    made: list[Workload] = []

    def loaded() -> None:
        platform, workload = load(tmp_path, text=text)
        made.append(workload)
        cross_check(platform, workload)

    assert_faults_are_told(loaded)
    for workload in made:
        # What was accepted on loading is there to be chosen.
        for name in workload.variants:
            assert design_point(load_platform(tmp_path / "p.yaml"), workload, {"workload.variant": name})


@settings(quietly, max_examples=60)
@given(
    st.sampled_from(
        [
            "workload.variant", "workload.variant.x", "workload.scenario", "workload.scenario.replan",
            "workload.scenario.replan.policy", "workload.scenario.obstacles.random.count", "workload.scenario.type",
            "workload.x", "workload", "pci", "pci.clock", "pci.errors", "pci.errors.late.share", "pci.between",
        ]
    ),
    trees,
)  # fmt: skip
def test_any_value_of_an_axis(tmp_path: Path, axis: str, value: Any) -> None:
    specs = load(tmp_path)
    assert_faults_are_told(lambda: design_point(*specs, {axis: value}))
    assert_faults_are_told(lambda: design_point(*specs, {axis: value, "workload.variant": "patient"}))
    text = json.dumps({**TREE, "explore": {"axes": {axis: [value], "relax.iterations": [1]}}})
    assert_faults_are_told(lambda: cross_check(*load(tmp_path, text=text)))
