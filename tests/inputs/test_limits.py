"""Limits as people write them: in a file, and as --need."""

from __future__ import annotations

from pathlib import Path

import pytest
from spec_texts import WORKLOAD, faults

from codesign.ground.errors import SpecError
from codesign.ground.figures import FIGURES, SHORT_NAMES
from codesign.inputs.constraint import BOUNDS, Constraint, constraint_of, limit_text, needs_of
from codesign.inputs.exploration import Exploration


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("text", "figure", "bounds", "of_part"),
    [
        ("time < 100 ms", "plan_time_worst_s", {"below": 0.1}, False),
        ("plan_time_mean_s<=5us", "plan_time_mean_s", {"at_most": 5e-6}, False),
        ("  energy > 1 mJ ", "energy_j", {"above": 1e-3}, False),
        ("power ≤ 2 W", "power", {"at_most": 2.0}, False),
        ("mission_clearance ≥ 20 cm", "clearance_least_m", {"at_least": 0.2}, False),
        ("slices < 80 %", "slices", {"below": 0.8}, True),
        ("block_rams <= 20", "block_rams", {"at_most": 20.0}, False),
        ("slices <= 1e4", "slices", {"at_most": 1e4}, False),
        ("arrive >= 0.99", "arrive", {"at_least": 0.99}, False),
        ("arrive >= 99 %", "arrive", {"at_least": 0.99}, False),
        ("clearance >= 2.5 cells", "clearance_mean", {"at_least": 2.5}, False),
        ("closest_approach >= -0.5", "closest_approach", {"at_least": -0.5}, False),
    ],
)
def test_a_limit_as_text(text: str, figure: str, bounds: dict[str, float], of_part: bool) -> None:
    constraint = constraint_of(text)
    assert (constraint.figure.name, constraint.bounds, constraint.of_part) == (figure, bounds, of_part)
    # It is kept as a mapping, and written as a text that says the same.
    assert Constraint.model_validate(constraint.model_dump(mode="json")) == constraint
    assert constraint_of(limit_text(constraint)) == constraint


@pytest.mark.parametrize("name", [*SHORT_NAMES, *FIGURES])
def test_every_figure_and_short_name_has_a_limit(name: str) -> None:
    figure = FIGURES[SHORT_NAMES.get(name, name)]
    unit = "" if figure.unit == "1" else figure.unit
    assert constraint_of(f"{name} <= 1 {unit}").figure == figure


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("tme < 100 ms", "'tme' is no figure\n  hint: did you mean time? accepted: arrive, block_rams"),
        ("time = 100 ms", "'=' compares nothing\n  hint: accepted: <, <=, >, >="),
        ("time < 100", "'100' has no unit\n  hint: write a number and a unit, such as 10 us"),
        ("time < 100 W", "'100 W' has no unit of time"),
        ("time < 5 %", "'5 %' has no unit of time"),
        ("time <", "'time <' has no value\n  hint: write NAME < VALUE"),
        ("time", "'time' is no limit\n  hint: write NAME < VALUE, as in"),
        ("< 5 ms", "'< 5 ms' is no limit"),
        ("", "'' is no limit"),
        ("time < 1 s" + " " * 500, "a limit of 510 characters is too long\n  hint: at most 500"),
        ("3 < slices", "'3' names no figure\n  hint: write the figure first"),
        ("slices < 0.8", "'0.8': a count is a whole number\n  hint: write 80 % for a share of the part's slices"),
        ("slices < 1.5", "'1.5': a count is a whole number\n  hint: write a whole number"),
        ("collisions < 0.5", "'0.5': a count is a whole number\n  hint: write a whole number"),
        ("collisions < 5 %", "'5 %' is a share, and collisions is none\n  hint: write a whole number"),
        ("slices < 120 %", "'120 %' is out of bounds\n  hint: a share is from 0 to 100 %"),
        ("slices < many", "'many' is not a number\n  hint: write a whole number, or 80 % for a share"),
        ("slices < 5 ms", "'5 ms' has no unit of slices"),
        ("arrive >= 99", "'99' is out of bounds\n  hint: write 99 %, or 0.99"),
        ("arrive >= -1", "'-1' is out of bounds\n  hint: a share is from 0 to 1"),
        ("__import__('os') < 1", "character 12: \"'\" is not accepted"),
    ],
)  # fmt: skip
def test_a_text_that_is_no_limit(text: str, told: str) -> None:
    with pytest.raises(SpecError) as caught:
        needs_of([text])
    message = str(caught.value)
    assert message.startswith(f"--need {text[:60]!r}"[:60])
    assert told in message


def test_all_faults_of_needs_stand_together() -> None:
    with pytest.raises(SpecError) as caught:
        needs_of(["tme < 1 s", "slices < 0.5", "time < 1 ms", "power < 1 W", "time > 2 ms"])
    assert [fault.file for fault in caught.value.faults] == [
        "--need 'slices < 0.5'",
        "--need 'time > 2 ms'",
        "--need 'tme < 1 s'",
    ]
    assert "nothing is within this and plan_time_worst_s < 1 ms\n  hint: keep one" in str(caught.value)


@pytest.mark.parametrize(
    ("needs", "agree"),
    [
        (("time < 2 ms", "time > 1 ms"), True),
        (("time <= 1 ms", "time >= 1 ms"), True),
        (("time < 1 ms", "time >= 1 ms"), False),
        (("slices > 50 %", "slices < 40 %"), False),
        (("slices > 50 %", "slices < 40"), True),
    ],
)
def test_needs_that_contradict_each_other(needs: tuple[str, ...], agree: bool) -> None:
    if agree:
        assert len(needs_of(needs)) == 2
    else:
        with pytest.raises(SpecError, match="nothing is within this and"):
            needs_of(needs)


@pytest.mark.parametrize(
    ("explore", "expected"),
    [
        (
            "constraints: [time < 1 s, slices < 0.8]",
            "w.yaml:18:29: explore.constraints[1]: '0.8': a count is a whole number\n"
            "  hint: write 80 % for a share of the part's slices",
        ),
        (
            "constraints: [{figure: slices, at_most: 0.8}]",
            "w.yaml:18:43: explore.constraints[0].at_most: 0.8: a count is a whole number\n"
            "  hint: write 80 % for a share of the part's slices",
        ),
        (
            "constraints: [{figure: slices, at_least: 5, below: 80 %}]",
            "w.yaml:18:44: explore.constraints[0].at_least: below is a share of the part,"
            " and at_least a number of slices\n"
            "  hint: write two constraints",
        ),
        (
            "constraints: [time < 1 ms, {figure: plan_time_worst_s, above: 2 ms}]",
            "w.yaml:18:30: explore.constraints[1]: nothing is within this and plan_time_worst_s < 1 ms",
        ),
        (
            "constraints: [{figure: power, above: 1 W, at_most: 1 W}]",
            "w.yaml:18:40: explore.constraints[0].above: nothing is within these bounds",
        ),
        (
            "constraints: [{figure: power, at_most: 1 W, of_part: true}]",
            "w.yaml:18:56: explore.constraints[0].of_part: is of no part\n  hint: leave it out: power is no resource",
        ),
    ],
)  # fmt: skip
def test_limits_in_a_file(explore: str, expected: str) -> None:
    assert faults(f"{WORKLOAD}  {explore}\n").startswith(expected)


def test_a_file_takes_texts_and_mappings() -> None:
    section = Exploration.model_validate(
        {
            "constraints": [
                "time < 100 ms",
                {"figure": "slices", "below": "80 %"},
                {"figure": "arrive", "at_least": "99 %"},
            ]
        },
        context={"document": object()},
    )
    limits = [(limit.bounds, limit.of_part) for limit in section.constraints]
    assert limits == [({"below": 0.1}, False), ({"below": 0.8}, True), ({"at_least": 0.99}, False)]
    assert set(BOUNDS) <= set(Constraint.model_fields)
