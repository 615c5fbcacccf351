"""Values of axes on a command line: lists, ranges, and how they stand in the workload."""

from __future__ import annotations

from typing import Any

import pytest

import codesign
from codesign.ground.errors import InputError, SpecError
from codesign.inputs.axes import MAX_VALUES, axis_form, axis_values
from codesign.inputs.exploring import exploring


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a, b,c", ["a", "b", "c"]),
        ("6", [6]),
        ("[36,66],[24,44]", [[36, 66], [24, 44]]),
        ("{file: a.pgm, crop: free},'a,b'", [{"file": "a.pgm", "crop": "free"}, "a,b"]),
        ("../a.pgm,../b.pgm", ["../a.pgm", "../b.pgm"]),
        ("1..4", [1, 2, 3, 4]),
        ("-1..1", [-1, 0, 1]),
        ("1..10:4", [1, 5, 9]),
        ("0.1..0.3:0.1", [0.1, 0.2, 0.3]),
        ("10MHz..40MHz:10MHz", ["10 MHz", "20 MHz", "30 MHz", "40 MHz"]),
        ("500 kHz..2 MHz:500kHz", ["500 kHz", "1 MHz", "1.5 MHz", "2 MHz"]),
        ("1..1024*4", [1, 4, 16, 64, 256, 1024]),
        ("1 ms..1 s*10,5 s", ["1 ms", "10 ms", "100 ms", "1 s", "5 s"]),
        ("2..8*1.5", [2.0, 3.0, 4.5, 6.75]),
        ("1..10 in 4", [1, 4, 7, 10]),
        ("1..64 in 7 log", [1, 2, 4, 8, 16, 32, 64]),
        ("1..2 in 9", [1, 2]),
        ("0.0..1.0 in 3", [0.0, 0.5, 1.0]),
        ("10MHz..1GHz in 4 log", ["10 MHz", "46.4159 MHz", "215.443 MHz", "1 GHz"]),
        ("3 ps..6 ps in 9", ["3 ps", "4 ps", "5 ps", "6 ps"]),
    ],
)
def test_lists_and_ranges(text: str, values: list[Any]) -> None:
    assert axis_values(text, "--axis a.b") == values
    assert [type(value) for value in axis_values(text, "")] == [type(value) for value in values]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "a value is missing"),
        ("1,,2", "a value is missing"),
        ("8..1", "'8..1' has no value: the first is above the last"),
        ("1ms..2ms", "'1ms..2ms' has no step\n  hint: write 1ms..2ms:STEP"),
        ("0.5..2", "'0.5..2' has no step"),
        ("1..8:0", "does not end: a step is above 0"),
        ("1..8*1", "does not end: a factor is above 1, of values above 0"),
        ("0..8*2", "does not end: a factor is above 1, of values above 0"),
        ("1..8 in 1", "'1..8 in 1' is no range: a count of at least 2 needs two different ends"),
        ("8..8 in 3", "a count of at least 2 needs two different ends"),
        ("0..8 in 3 log", "a count of at least 2 needs two different ends above 0"),
        ("1..8 in x", "'x' is no number of values"),
        ("1..8 in 1001", "has 1,001 values\n  hint: at most 1,000"),
        ("1..8:x", "is no range: 'x' is not a number"),
        ("10MHz..5 s:1MHz", "is no range: '5 s' has no unit of frequency"),
        ("1 furlong..2 furlong:1", "is no range: '1 furlong' has no unit"),
        ("1..1e9", f"has 1,000,000,000 values\n  hint: at most {MAX_VALUES:,}"),
        ("1..1e90*1.0001", "too many values"),
        (",".join(["1"] * (MAX_VALUES + 1)), "too many values"),
        ("9" * 30_000, "is too long"),
        ("[1, 2", "--axis a.b"),
    ],
)
def test_what_is_no_list(text: str, told: str) -> None:
    with pytest.raises(InputError) as caught:
        axis_values(text, "--axis a.b")
    assert str(caught.value).startswith("--axis a.b: ")
    assert told in str(caught.value)


def test_axes_replace_those_of_the_file_or_are_added() -> None:
    workload = codesign.load_workload("labyrinth")
    before = workload.explore
    assert before is not None
    changed = exploring(
        workload, {"relax.iterations": [2, 4], "pci.clock": ["33 MHz"]}, {"relax.block": [[36, 66]]}
    ).explore
    assert changed is not None
    kept = [axis for axis in before.axes if axis != "relax.block"]
    assert list(changed.axes) == [*kept, "pci.clock"]
    assert changed.axes["relax.iterations"] == (2, 4)
    assert changed.conditions == {"relax.block": ([36, 66],)}
    assert changed.objectives == before.objectives
    assert exploring(workload, {}, {}) is workload


def test_needs_stand_behind_the_constraints_of_the_file() -> None:
    workload = codesign.load_workload("labyrinth")
    changed = exploring(workload, {}, {}, ["time < 1 s"])
    assert workload.explore is not None
    assert changed.explore is not None
    assert changed.explore.constraints[:-1] == workload.explore.constraints
    assert changed.explore.constraints[-1].bounds == {"below": 1.0}


def test_values_are_checked_as_in_a_file() -> None:
    workload = codesign.load_workload("labyrinth")
    with pytest.raises(SpecError) as caught:
        exploring(
            workload,
            {"relax.iterations": [2, "two"], "relax.blok": [1]},
            {"relax.schedule": []},
            ["slices < 0.5", "tme < 1 s"],
        )
    message = str(caught.value)
    assert "--axis relax.iterations[1]: 'two' is not a whole number" in message
    assert "--axis relax.blok: unknown key\n  hint: did you mean block?" in message
    assert "--need 'slices < 0.5': '0.5': a count is a whole number" in message
    assert "--need 'tme < 1 s': 'tme' is no figure" in message
    with pytest.raises(SpecError, match=r"--axis relax.iterations\[1\]: 2 is listed twice"):
        exploring(workload, {"relax.iterations": [2, 2]}, {})
    with pytest.raises(SpecError, match="--need 'time > 2 s': nothing is within this and"):
        exploring(workload, {}, {}, ["time < 1 s", "time > 2 s"])


def test_an_axis_of_the_command_line_may_depend_on_others() -> None:
    form = axis_form("1..3 when workload.variant=base,deep and relax.block=[8,12]", "--axis a.b")
    assert form == {"values": [1, 2, 3], "when": {"workload.variant": ["base", "deep"], "relax.block": [[8, 12]]}}
    assert axis_form("a when b", "") == {"values": ["a when b"]}
    with pytest.raises(InputError, match=r"--axis a\.b when c\.d: a value is missing"):
        axis_form("1 when c.d=", "--axis a.b")
    workload = codesign.load_workload("labyrinth")
    blocks = {"values": [[36, 66], [24, 44]]}
    axes = {"relax.block": blocks, "pci.clock": {"values": ["33 MHz", "66 MHz"], "when": {"relax.block": [[24, 44]]}}}
    before, changed = workload.explore, exploring(workload, axes, {}).explore
    assert before is not None
    assert changed is not None
    assert changed.points * 2 * len(before.axes["relax.block"]) == before.points * 2 * 3
    axes["pci.clock"]["when"] = {"relax.blok": [[24, 44]]}
    with pytest.raises(SpecError, match=r"--axis pci\.clock.* there is no such axis"):
        exploring(workload, axes, {})
    with pytest.raises(InputError, match="a condition is met by every design"):
        exploring(workload, {}, {"pci.clock": axes["pci.clock"]})
