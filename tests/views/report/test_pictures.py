from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from report_samples import a_hopeless_study, a_study

from codesign.ground.errors import InputError
from codesign.ground.figures import FIGURES, ResultFigure
from codesign.ground.records import MapRecord, MessageRecord, Record, StageRecord, TaskRecord, TrajectoryRecord
from codesign.views.report import front_picture, map_picture, run_pictures, schedule_picture
from codesign.views.report.front_picture import _staircase

FREE = np.ones((12, 30), dtype=bool)
FREE[5, :20] = False


def records() -> list[Record]:
    potential = np.where(FREE, np.float32(1e-30), np.float32(0))
    return [
        MapRecord(0, "map", FREE, np.array([[2, 3]], np.int32), None),
        MessageRecord(0, "pci", "host", "fpga", "map", 720, 10, 3_000_000),
        TaskRecord(3_000_000, "fpga", "relax", 90_000_000, 13_000),
        StageRecord(40_000_000, "fpga", 3_000_000, 0, 7, 3, 12, 60, 540, 4, potential),
        StageRecord(90_000_000, "fpga", 40_000_000, 1, 15, 3, 12, 60, 540, 0, potential),
        TrajectoryRecord(90_000_000, "robot", np.array([[10.0, 3.0], [8.5, 24.0], [2.0, 3.0]]), True),
        TrajectoryRecord(90_000_000, "robot", np.array([[11.0, 3.0]]), False),
    ]


def test_pictures_are_what_they_say_and_the_same_every_time() -> None:
    study = a_study()
    png, svg = front_picture(study), front_picture(study, format="svg")
    assert png.data.startswith(b"\x89PNG")
    assert ElementTree.fromstring(svg.data).tag.endswith("svg")
    assert svg.data == front_picture(study, format="svg").data
    assert png.data == front_picture(study).data
    assert png.alt == "Scatter plot of slices against first plan time, 18 feasible points, front outlined and joined"


def test_a_dollar_in_a_name_is_no_formula() -> None:
    study = replace(a_study(), platform="$\\frac{", workload="a$b")
    assert front_picture(study).data.startswith(b"\x89PNG")


def test_other_figures_and_markers_can_be_chosen() -> None:
    study = a_study()
    picture = front_picture(
        study, x=FIGURES["slices"], y=FIGURES["energy_j"], colour=None, marker="relax.block", format="svg"
    )
    assert picture.title == "energy against slices"
    first, second = study.objectives[:2]
    assert front_picture(study, y=first).title == f"{first.label} against {second.label}"
    assert front_picture(study, x=second).title == f"{first.label} against {second.label}"
    with pytest.raises(InputError, match="needs two figures"):
        front_picture(replace(study, objectives=(first,)), y=first)
    assert picture.data != front_picture(study, format="svg").data


def test_a_front_of_nothing_is_refused() -> None:
    study = a_study()
    with pytest.raises(InputError, match="no feasible point has both first plan time and slices"):
        front_picture(a_hopeless_study())
    with pytest.raises(InputError, match="needs two figures"):
        front_picture(replace(study, objectives=(FIGURES["first_plan_s"],)))


@pytest.mark.parametrize("second", [FIGURES["slices"], FIGURES["clearance_mean"]])
@pytest.mark.parametrize("first", [FIGURES["first_plan_s"], FIGURES["share_reaching_goal"]])
def test_the_joined_line_is_the_best_that_can_be_had(first: ResultFigure, second: ResultFigure) -> None:
    values = np.random.default_rng(7).integers(0, 40, (60, 2)).astype(float)
    x, y = _staircase(values, (first.maximise, second.maximise))
    assert (np.diff(x) >= 0).all()
    # Each step goes along one axis only.
    assert ((np.diff(x) == 0) | (np.diff(y) == 0)).all()
    for across in np.arange(x[0] + 0.5, x[-1], 1.0):
        reach = values[:, 0] >= across if first.maximise else values[:, 0] <= across
        best = values[reach, 1].max() if second.maximise else values[reach, 1].min()
        segment = np.flatnonzero((x[:-1] < across) & (across < x[1:]))
        assert y[segment].tolist() == [best]


def test_a_run_is_shown_as_its_map_and_its_time_line() -> None:
    pictures = run_pictures(records())
    assert [picture.title for picture in pictures] == [
        "Map, and the field after the stage of 15 bits; 2 paths drawn, 1 of them to the goal",
        "When each component and link was busy",
    ]
    assert pictures[0].alt == "Map of 12 by 30 cells, 1 goal, the potential as colour, 2 paths drawn"
    assert pictures[1].alt.startswith("Time line of pci, fpga over 90 us")
    assert all(picture.data.startswith(b"\x89PNG") for picture in pictures)


def test_a_run_that_never_began_has_no_pictures() -> None:
    assert run_pictures([]) == ()


def test_a_map_without_a_field_and_a_large_map_are_drawn() -> None:
    assert map_picture(FREE, [(2, 3)]).data.startswith(b"\x89PNG")
    nothing = np.zeros((2, 2))
    assert map_picture(np.zeros((2, 2), bool), [], potential=nothing).data.startswith(b"\x89PNG")
    large = np.ones((3000, 40), dtype=bool)
    assert len(map_picture(large, [(5, 5)]).data) < 200_000


def test_stages_are_bars_of_their_precision() -> None:
    picture = schedule_picture(records())
    assert picture is not None
    assert picture.alt == "2 stages of at most 15 bits over 90 us, 0 local maxima after the last"
    bars, line = picture.figure.axes
    assert [bar.get_height() for bar in bars.patches] == [7, 15]
    assert [bar.get_x() for bar in bars.patches] == pytest.approx([3, 40])
    assert list(line.lines[0].get_ydata()) == [4, 0]
    assert schedule_picture([]) is None
    many = schedule_picture(records()[3:5] * 1500)
    assert many is not None
    assert "1,000 later stages are not drawn" in many.caption
