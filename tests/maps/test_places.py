"""Goals and starts as users write them: cells, metres, lines of .scen files; on whole and on cropped maps."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from click.testing import Result

import codesign
from codesign.ground.errors import SpecError
from codesign.ground.records import FieldRecord, MapRecord, TrajectoryRecord
from codesign.planners.interface import Problem, Quality
from codesign.system.scenarios import bind
from codesign.views.trace import McapListener, MemoryListener, open_trace

DRAWN = """\
????????????
????#####???
????#...#???
????#.#.####
????#.#....#
????########
"""
"""Free cells lie in rows 2 to 4 and columns 5 to 10; ? is unknown."""

CELLS = np.array([list(row) for row in DRAWN.split()])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A map of map_server, its lower left corner at (-1 m, 2 m), 0.5 m a cell; and the same as MovingAI has it."""
    pixels = np.select([CELLS == ".", CELLS == "?"], [254, 205], 0).astype(np.uint8)
    (tmp_path / "floor.pgm").write_bytes(b"P5\n%d %d\n255\n" % pixels.shape[::-1] + pixels.tobytes())
    (tmp_path / "floor.yaml").write_text(
        "image: floor.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    rows = DRAWN.replace("?", "@").replace("#", "@")
    (tmp_path / "floor.map").write_text(f"type octile\nheight 6\nwidth 12\nmap\n{rows}")
    return tmp_path


def workload(folder: Path, problem: dict[str, Any], planner: str = "breadth_first") -> Path:
    task = {"breadth_first": "search", "wavefront": "propagate"}[planner]
    problem = {"map": {"file": "floor.yaml"}, **problem}
    content = {"kind": "workload", "name": "w", "planner": planner, "problem": problem}
    (folder / "w.yaml").write_text(yaml.safe_dump({**content, "mapping": {task: {"component": "fpga"}}}))
    return folder / "w.yaml"


def bound(folder: Path, problem: dict[str, Any]) -> Problem:
    found = bind(codesign.load_platform("virtex2pro"), codesign.load_workload(workload(folder, problem))).problem
    assert isinstance(found, Problem)
    return found


def faults(folder: Path, problem: dict[str, Any]) -> list[str]:
    with pytest.raises(SpecError) as caught:
        bound(folder, problem)
    for fault in caught.value.faults:
        assert fault.file.endswith("w.yaml"), fault
        assert min(fault.line, fault.column) > 0, fault
        assert fault.hint, fault
    return [f"{fault.key}: {fault.what}; {fault.hint}" for fault in caught.value.faults]


def test_metres_and_cells_name_the_same_places(folder: Path) -> None:
    """Cell (4, 10) spans x from 4 to 4.5 m and y from 2.5 to 3 m."""
    cells = bound(folder, {"goals": [[4, 10]], "starts": [[2, 5]]})
    metres = {"goals": [{"x": 4.25, "y": "2.6 m"}], "starts": [{"x": "150 cm", "y": "3.75 m"}]}
    assert bound(folder, metres).digest == cells.digest
    left = {"goals": [[4, 10]], "starts": [{"x": "-1 m", "y": 2}]}
    assert faults(folder, left) == [
        "problem.starts[0]: {x: -1 m, y: 2 m}, cell (5, 0), is in unknown space;"
        " the nearest free cell is {x: 1.75 m, y: 2.75 m}, cell (4, 5)"
    ]


def test_every_place_that_cannot_be_is_named_at_once(folder: Path) -> None:
    problem = {
        "goals": [[5, 10], {"x": 40, "y": 3}, {"x": 4.3, "y": 2.7}, [4, 10], [99, 0]],
        "starts": [[0, 0], {"x": "2.1 m", "y": "2.9 m"}],
    }
    assert faults(folder, problem) == [
        "problem.goals[0]: cell (5, 10) is on an obstacle; the nearest free cell is (4, 10)",
        "problem.goals[1]: {x: 40 m, y: 3 m} is outside of the map of 6 × 3 m;"
        " middles of cells are from {x: -0.75 m, y: 2.25 m} to {x: 4.75 m, y: 4.75 m}",
        "problem.goals[3]: it lies in cell (4, 10), as goals[2] does; name it once",
        "problem.goals[4]: cell (99, 0) is outside of the map of 6 × 12 cells; (row, column) from (0, 0) to (5, 11)",
        "problem.starts[0]: cell (0, 0) is in unknown space; the nearest free cell is (2, 5)",
        "problem.starts[1]: {x: 2.1 m, y: 2.9 m}, cell (4, 6), is on an obstacle;"
        " the nearest free cell is {x: 1.75 m, y: 2.75 m}, cell (4, 5)",
    ]


def test_steps_that_block_a_place_are_named(folder: Path) -> None:
    (blocked,) = faults(
        folder, {"map": {"file": "floor.yaml", "unknown": "free", "inflate": "0.6 m"}, "goals": [[2, 5]]}
    )
    assert blocked.startswith("problem.goals[0]: cell (2, 5) is within 0.6 m of an obstacle (inflate); ")
    (empty,) = faults(folder, {"map": {"file": "floor.yaml", "inflate": "1 cell"}, "goals": [[2, 5]]})
    assert empty == "problem.map: no cell of the map is free; inflate by less than 1 cells"
    (coarse,) = faults(folder, {"map": {"file": "floor.yaml", "downsample": 4}, "goals": [[0, 0]]})
    assert coarse == "problem.map: no cell of the map is free; downsample by less than 4"


def test_a_map_without_a_free_cell_names_its_unknown_cells(folder: Path) -> None:
    (folder / "floor.pgm").write_bytes(b"P5\n2 1\n255\n" + bytes([205, 0]))
    (empty,) = faults(folder, {"goals": [[0, 0]]})
    assert empty == (
        "problem.map: no cell of the map is free;"
        " 1 of 2 cells unknown: set unknown: free, or check the thresholds of the map"
    )


def test_check_counts_the_unknown_cells(folder: Path, hwsw: Callable[..., Result]) -> None:
    path = workload(folder, {"map": {"file": "floor.pgm"}, "goals": [[4, 10]]})
    unknown = int((CELLS == "?").sum())
    for specs in ((path,), ("virtex2pro", path)):
        out = hwsw("check", *specs).stdout
        assert f"{unknown} pixels of grey 205 taken as unknown; name floor.yaml in its place" in out
        assert f"note: problem.map: {unknown} of 72 cells are unknown, and count as blocked" in out


def test_metres_need_a_resolution(folder: Path) -> None:
    problem = {"map": {"file": "floor.map"}, "goals": [{"x": 5.2, "y": 1.1}], "starts": [[2, 5]]}
    (fault,) = faults(folder, problem)
    assert fault == (
        "problem.goals[0]: {x: 5.2 m, y: 1.1 m} is in metres, and the map does not say how large a cell is;"
        " give the map its resolution, as resolution: 5 cm or --resolution 5cm, or write row and column"
    )
    problem["map"] = {"file": "floor.map", "resolution": "1 m"}
    assert bound(folder, problem).goals == ((4, 5),)
    inflated = {"map": {"file": "floor.map", "inflate": "0.3 m"}, "goals": [[2, 5]]}
    assert faults(folder, inflated)[0].startswith("problem.map.inflate: a radius of 0.3 m on a map that does not say")
    twice = {"map": {"file": "floor.yaml", "resolution": "5 cm"}, "goals": [[2, 5]]}
    assert faults(folder, twice) == ["problem.map.resolution: the map itself says 0.5 m a cell; remove resolution"]


@pytest.mark.parametrize("place", [{"x": "12"}, {"x": 1, "y": "3"}, {"x": math.inf, "y": 1}, {"x": 1, "y": 1, "z": 1}])
def test_a_point_that_is_none_is_a_fault(folder: Path, place: dict[str, Any]) -> None:
    assert all("problem.goals[0]" in text for text in faults_of_text(folder, place))


def faults_of_text(folder: Path, place: dict[str, Any]) -> list[str]:
    with pytest.raises(SpecError) as caught:
        codesign.load_workload(workload(folder, {"goals": [place]}))
    return [str(fault) for fault in caught.value.faults]


CROPS = {"free": ((2, 5), (3, 6)), "reachable": ((2, 5), (3, 6)), "none": ((0, 0), (6, 12))}


@pytest.mark.parametrize("crop", CROPS)
def test_cropping_keeps_the_frame(folder: Path, crop: str) -> None:
    """Users see the same cells and metres; the design is that of a map that was cut by hand."""
    problem = {"map": {"file": "floor.yaml", "crop": crop}, "goals": [{"x": 4.25, "y": 2.75}], "starts": [[2, 5]]}
    path = workload(folder, problem, "wavefront")
    memory, file = MemoryListener(), folder / "run.mcap"
    platform, loaded = codesign.load_platform("virtex2pro"), codesign.load_workload(path)
    with McapListener(file) as mcap:
        result = codesign.simulate(platform, loaded, listeners=(memory, mcap))
    (corner, shape) = CROPS[crop]
    for records in (memory.records, list(open_trace(file).records())):
        (seen,) = (record for record in records if isinstance(record, MapRecord))
        (way,) = (record for record in records if isinstance(record, TrajectoryRecord))
        (field,) = (record for record in records if isinstance(record, FieldRecord))
        assert (seen.corner, seen.free.shape, field.values.shape) == (corner, shape, shape)
        assert seen.goals.tolist() == [[4, 10]]
        assert (way.points[0].tolist(), way.points[-1].tolist()) == ([2.0, 5.0], [4.0, 10.0])
        assert seen.origin is not None
        lower = 2.0 + (6 - corner[0] - shape[0]) * 0.5
        assert seen.origin.tolist() == [-1.0 + corner[1] * 0.5, lower, 0.0]
    unknown = int((CELLS == "?").sum())
    note = f"problem.map: {unknown} of 72 cells are unknown, and count as blocked (unknown: blocked)"
    assert [each for each in result.notes if not each.startswith("fpga.clock: ")] == [note]
    if crop == "free":
        rows = ["".join(row[5:11]).replace("?", "#") for row in CELLS[2:5]]
        (folder / "cut.txt").write_text("\n".join(rows) + "\n")
        path = workload(folder, {"map": {"file": "cut.txt"}, "goals": [[2, 5]], "starts": [[0, 0]]}, "wavefront")
        cut = codesign.simulate(platform, codesign.load_workload(path))
        assert (result.time, result.resources, result.quality) == (cut.time, cut.resources, cut.quality)


def test_a_trace_puts_the_cropped_map_at_its_metres(folder: Path) -> None:
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
    from mcap.reader import make_reader

    problem = {"map": {"file": "floor.yaml", "crop": "free"}, "goals": [[4, 10]], "starts": [[2, 5]]}
    with McapListener(folder / "run.mcap") as mcap:
        loaded = codesign.load_workload(workload(folder, problem))
        codesign.simulate(codesign.load_platform("virtex2pro"), loaded, listeners=(mcap,))
    messages: dict[str, list[Any]] = {}
    with (folder / "run.mcap").open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            pool = descriptor_pool.DescriptorPool()
            for file in descriptor_pb2.FileDescriptorSet.FromString(schema.data).file:
                pool.Add(file)
            kind = message_factory.GetMessageClass(pool.FindMessageTypeByName(schema.name))
            messages.setdefault(channel.topic, []).append(kind.FromString(message.data))
    position = messages["/map/grid"][0].pose.position
    assert (position.x, position.y) == (1.5, 2.5)
    line = messages["/path"][-1].entities[0].lines[0]
    first, last = line.points[0], line.points[-1]
    assert ((first.x, first.y), (last.x, last.y)) == ((1.75, 3.75), (4.25, 2.75))


SCEN = """\
version 1
0	floor.map	12	6	5	2	7	2	2.00000000
3	maps/floor.map	12	6	5	2	10	4	7.00000000
3	floor.map	12	6	5	4	10	4	9.00000000
"""


def test_a_line_of_a_scen_file_gives_goal_and_start(folder: Path) -> None:
    (folder / "a.scen").write_text(SCEN)
    on_map = {"map": {"file": "floor.map", "crop": "free"}}
    first = bound(folder, {**on_map, "goals": {"scen": "a.scen", "line": 2}})
    assert (first.goals, first.starts, first.optimal_lengths) == (((0, 2),), ((0, 0),), (2.0,))
    shared = bound(folder, {**on_map, "goals": {"scen": "a.scen", "bucket": 3, "same_goal": True}})
    assert (shared.goals, shared.starts) == (((2, 5),), ((0, 0), (2, 0)))
    others = bound(folder, {**on_map, "goals": {"scen": "a.scen", "line": 2}, "starts": {"count": 3}})
    assert (len(others.starts), others.optimal_lengths) == (3, ())


def test_the_lengths_of_a_scen_file_are_compared(folder: Path) -> None:
    (folder / "a.scen").write_text(SCEN)
    problem = {"map": {"file": "floor.map"}, "goals": {"scen": "a.scen", "bucket": 3, "same_goal": True}}
    path = workload(folder, problem)
    result = codesign.simulate(codesign.load_platform("virtex2pro"), codesign.load_workload(path))
    assert isinstance(result.quality, Quality)
    assert (result.quality.optimal_length_mean, result.quality.optimal_length_error) == (8.0, 0.0)
    assert result.notes == ()
    (folder / "a.scen").write_text(SCEN.replace("9.00000000", "11"))
    result = codesign.simulate(codesign.load_platform("virtex2pro"), codesign.load_workload(path))
    assert isinstance(result.quality, Quality)
    assert (result.quality.optimal_length_mean, result.quality.optimal_length_error) == (9.0, 2.0)
    assert "differs from the length in the .scen file by up to 2.00 cells" in result.notes[0]


@pytest.mark.parametrize(
    ("change", "goals", "expected"),
    [
        ({}, {"line": 9}, "goals.line: the file has no problem in line 9; from 2 to 4"),
        ({}, {"bucket": 1}, "goals.bucket: the file has no problem in bucket 1; from 0 to 3"),
        ({"\t12\t6": "\t12\t7"}, {"line": 2}, "goals.scen: it is of a map of 7 × 12 cells, and the map has 6 × 12; "),
        ({"floor.map": "door.map"}, {"line": 2}, "goals.scen: it is of the map door.map, and the map is floor.map; "),
        ({"version 1": "version 2"}, {"line": 2}, "goals.scen: "),
        ({"\t5\t2\t7\t2": "\t5\t2\t6\t4"}, {"line": 2}, "goals.line: line 2: cell (4, 6) is on an obstacle; "),
        ({"\t5\t2\t7\t2": "\t0\t0\t7\t2"}, {"line": 2}, "goals.line: line 2: cell (0, 0) is on an obstacle; "),
    ],
)
def test_a_scen_file_that_does_not_fit(
    folder: Path, change: dict[str, str], goals: dict[str, Any], expected: str
) -> None:
    text = SCEN
    for old, new in change.items():
        text = text.replace(old, new)
    (folder / "a.scen").write_text(text)
    problem = {"map": {"file": "floor.map"}, "goals": {"scen": "a.scen", **goals}}
    (fault,) = faults(folder, problem)
    assert fault.startswith(f"problem.{expected}")


def test_a_scen_file_is_of_the_whole_map(folder: Path) -> None:
    (folder / "a.scen").write_text(SCEN)
    (folder / "floor.map").write_text("type octile\nheight 6\nwidth 12\nmap\n" + ("." * 12 + "\n") * 6)
    coarse = {"map": {"file": "floor.map", "downsample": 2}, "goals": {"scen": "a.scen", "line": 2}}
    (fault,) = faults(folder, coarse)
    assert fault == (
        "problem.goals.scen: its cells are those of the whole map, and downsample joins them; remove downsample"
    )


@pytest.mark.parametrize("keys", [{}, {"line": 2, "bucket": 3}, {"line": 1}, {"line": 2, "scen": "none.scen"}])
def test_a_line_of_a_scen_file_is_named_once(folder: Path, keys: dict[str, Any]) -> None:
    (folder / "a.scen").write_text(SCEN)
    problem = {"map": {"file": "floor.map"}, "goals": {"scen": "a.scen", **keys}}
    with pytest.raises(SpecError, match=r"problem\.goals"):
        codesign.load_workload(workload(folder, problem))
