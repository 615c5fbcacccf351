"""A design point is what validating the edited files from the beginning gives, whatever is taken over from before."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from input_fuzz import quietly

from codesign.ground.errors import SpecError
from codesign.inputs import Platform, Workload, base, design_point, edit, load_platform
from codesign.inputs.faults import context_of
from codesign.system import catalog

PROBLEM = {
    "map": {"generate": "rooms", "rows": 32, "columns": 48, "room": [15, 15], "door": 4, "seed": 1},
    "goals": [[26, 42]],
    "starts": [[5, 5]],
}
AXES: dict[tuple[str, str], dict[str, list[Any]]] = {
    ("virtex4-pci", "labyrinth"): {
        "relax.block": [[72, 66], [48, 66], [0, 1], "72x66"],
        "relax.iterations": [1, 32, 0, 6.5],
        "relax.schedule": [{"first": 7, "step": 8, "last": 63}, [7, 15], {"first": 7, "stepp": 8}],
        "relax.schedule.last": [63, 255, -1],
        "relax.component": ["host", "fpga", 7],
        "relax.itterations": [3],
        "fpga.part": ["XC2V6000-4", "XC4VLX160-12", "XC2V60-4"],
        "fpga.clock": ["100 MHz", "150 MHz", "900 MHz", 100, {"value": "90 MHz", "status": "measured"}],
        "fpga.type": ["processor"],
        "pci.clock": ["33 MHz", "66 MHz"],
        "pci.errors.bit_error_rate": [1e-6, 2],
        "workload.problem.map.file": [""],
    },
    ("zynq", "office-partition"): {
        "workload.problem": [PROBLEM, {**PROBLEM, "goals": [[90, 1]]}, 3],
        "workload.problem.map.seed": [2, "two"],
        "workload.variant": ["base", "decide-on-host", "warm-start", "host-wave", "wave-track-on-host", "none"],
        "workload.scenario.replan.policy": ["restart", "restrat"],
        "workload.scenario.type": ["plan_once"],
        "workload.scenario": [{"type": "plan_once"}],
        "axi.clock": ["100 MHz", "50 kHz", "1"],
        "relax.block": [[32, 48], [16, 16]],
        "relax.iterations": [8, 12],
        "decide.component": ["arm", "fpga"],
        "decide.colour": ["red"],
        "arm.cores": [1, 2, 0],
    },
}
POINTS = [
    st.tuples(st.just(names), st.fixed_dictionaries({}, optional={k: st.sampled_from(v) for k, v in axes.items()}))
    for names, axes in AXES.items()
]


@cache
def loaded(names: tuple[str, str]) -> tuple[Platform, Workload]:
    return load_platform(names[0]), catalog.load_workload(names[1])


def outcome(names: tuple[str, str], values: dict[str, Any]) -> Any:
    try:
        return design_point(*loaded(names), values)
    except SpecError as error:
        return error.faults


def from_the_beginning(spec: Any) -> Any:
    document = spec.document
    left_out = {"explore": None, "variants": {}} if isinstance(spec, Workload) else {}
    tree = {key: raw for key, raw in document.tree.items() if key not in left_out}
    return type(spec).model_validate(tree, context=context_of(document)).with_document(document)


@settings(quietly, max_examples=examples(150))
@given(st.one_of(*POINTS))
def test_a_point_is_what_its_edited_files_are(point: tuple[tuple[str, str], dict[str, Any]]) -> None:
    names, values = point
    specs = outcome(names, values)
    with pytest.MonkeyPatch.context() as slow:
        slow.setattr(base, "_by_entries", lambda *_: None)
        slow.setattr(edit, "_kept_platform", edit._kept_platform.__wrapped__)
        slow.setattr(edit, "_kept_variant", lambda key, name: (edit.with_variant(key.it.document, name), None))
        slow_specs = outcome(names, values)
    if isinstance(specs[0], Platform):
        for spec, slow_spec in zip(specs, slow_specs, strict=True):
            assert spec.document.tree == slow_spec.document.tree
            assert spec.document.origins.keys() == slow_spec.document.origins.keys()
            for other in (slow_spec, from_the_beginning(spec)):
                dropped = {"explore", "variants"}
                assert spec.model_dump(exclude=dropped) == other.model_dump(exclude=dropped)
                assert spec.digest() == other.digest()
    else:
        assert specs == slow_specs


def test_most_of_these_values_make_a_point() -> None:
    """The property above speaks of sound points as well as of faults."""
    sound = [
        isinstance(outcome(names, {axis: values[0]})[0], Platform)
        for names, axes in AXES.items()
        for axis, values in axes.items()
    ]
    assert sum(sound) >= len(sound) * 2 // 3
