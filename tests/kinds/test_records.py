"""Every registered class of record: its role is declared, and trace, timeline, exports, pages and viewers follow it.

A record is drawn from the fields of its class, so one that is added is held to all of this without a word here.
"""

from __future__ import annotations

import io
import string
import typing
from pathlib import Path
from types import UnionType
from typing import Any

import numpy as np
import pytest
from trace_samples import same

from codesign.ground.activity import Mark, Span, Value, activities
from codesign.ground.records import (
    ACTIVITY_KINDS,
    RECORD_TYPES,
    ArrayOf,
    GoalRecord,
    Level,
    MapRecord,
    PoseRecord,
    Record,
    Subject,
)
from codesign.views.exports.difference import difference
from codesign.views.exports.perfetto import write_perfetto
from codesign.views.exports.statistics import gantt, statistics
from codesign.views.exports.waveform import waveform_of
from codesign.views.report.pictures import run_map_picture, run_timeline_picture
from codesign.views.report.result_page import scrub_data
from codesign.views.report.scenario_tables import board_latencies
from codesign.views.report.scrub import SCRUB_KINDS, scrub_of
from codesign.views.trace import McapListener, MemoryListener, moment, open_trace, timeline
from codesign.views.trace.reader import scan

SHAPE = (4, 6)
BEGIN, TIME, END = 1_000_000, 2_000_000, 3_000_000
PLAIN: dict[Any, Any] = {int: 3, float: 0.5, str: "ending", bool: True}

pytestmark = pytest.mark.parametrize("kind", RECORD_TYPES.values(), ids=RECORD_TYPES)


def sample(kind: type[Record]) -> Record:
    """A record on a map of 4 by 6 cells. Fields with a default have it."""
    hints = typing.get_type_hints(kind, include_extras=True)
    values = {
        name: value_of(kind, name, hint)
        for name, hint in hints.items()
        if typing.get_origin(hint) is not typing.ClassVar and not hasattr(kind, name)
    }
    return kind(**values)


def value_of(kind: type[Record], name: str, hint: Any) -> Any:
    if name in ("time", *kind.TIMES):
        late = {kind.ROLE.end: END, kind.ROLE.begin: END - 1 if kind.ROLE.end != "time" else BEGIN}
        return {**late, "time": TIME}.get(name, BEGIN)
    if name == "source":
        return "robot"
    if typing.get_origin(hint) in (typing.Union, UnionType):
        hint = typing.get_args(hint)[0]
    form = next((each for each in getattr(hint, "__metadata__", ()) if isinstance(each, ArrayOf)), None)
    if form is not None:
        sides = SHAPE if form.shape == (None, None) else tuple(side or 2 for side in form.shape)
        return (np.arange(np.prod(sides)).reshape(sides) % 4).astype(form.dtype)
    return PLAIN.get(hint, {"time_ps": END})


def written(path: Path, records: list[Record], level: Level = Level.BLOCKS) -> Path:
    with McapListener(path, {}, level) as listener:
        for record in records:
            listener(record)
    return path


def scene() -> list[Record]:
    """A robot that drives over a map."""
    goal = np.array([[3, 5]], np.int32)
    poses = [PoseRecord(time, "robot", 1.0, column, 0.0, 0.5) for time, column in ((10, 0.0), (2 * END, 4.0))]
    return [MapRecord(0, "map", np.ones(SHAPE, bool), goal, 0.5), GoalRecord(1, "robot", goal), *poses]


def test_it_declares_its_role(kind: type[Record]) -> None:
    role, record = kind.ROLE, sample(kind)
    assert "ROLE" in vars(kind), "a class says itself what its records are"
    braces = [name for text in (role.lane, role.label) for _, name, _, _ in string.Formatter().parse(text) if name]
    read = [*role.about.value, role.begin, role.end, *role.counts, *role.alike, *braces]
    assert [name for name in read if not hasattr(record, name)] == []
    assert {role.begin, role.end} <= {"time", *kind.TIMES}
    grids = [name for name, value in vars(record).items() if getattr(value, "shape", None) == SHAPE]
    assert [role.grid] * bool(role.grid) == grids[:1]


def test_a_trace_holds_it_from_its_level_on(kind: type[Record], tmp_path: Path) -> None:
    record, levels = sample(kind), list(Level)
    for level in levels:
        read = list(open_trace(written(tmp_path / f"{level}.mcap", [record], level)).records())
        if levels.index(level) < levels.index(kind.ROLE.level):
            assert read == []
        elif level is not Level.ITERATIONS:
            assert [same(record, each) for each in read] == [True]
        else:
            assert [type(each) for each in read] == [kind] * len(list(record.singles()))


def test_a_line_of_the_timeline_says_what_it_is(kind: type[Record], tmp_path: Path) -> None:
    record = sample(kind)
    (row,) = timeline(open_trace(written(tmp_path / "run.mcap", [record])))
    assert (row.begin, row.end) == record.between()
    assert row.what
    assert row.details
    assert (row.begin == row.end) == (kind.ROLE.begin == kind.ROLE.end)


def test_a_difference_finds_it(kind: type[Record]) -> None:
    (channel,) = difference(lambda: [sample(kind)], list).channels
    assert (channel.record, channel.counts) == (kind.__name__, (1, 0))


def test_the_exports_show_what_it_says_is_done(kind: type[Record]) -> None:
    records = [sample(kind)]
    said = list(activities(records))
    spans = [each for each in said if isinstance(each, Span)]
    assert bool(said) == (kind in ACTIVITY_KINDS)
    file = io.BytesIO()
    assert write_perfetto(records, file) == len(spans)
    shown = file.getvalue()
    for each in said:
        assert str(getattr(each, "name", "")).encode() in shown
        assert each.track.encode() in shown
    rows = {row.name for row in gantt(records, 200).rows}
    assert rows == {span.track for span in spans} | {"events" for each in said if is_event(each)}
    found, wave = statistics(records), waveform_of(records)
    assert len(found.latencies) == len([span for span in spans if span.kind != "visits"]) + len(record_times(kind))
    assert {scope for scope, _ in wave.signals} == {
        *(span.where for span in spans),
        *("mission" for each in said if is_event(each)),
        *(each.track.partition(":")[0] for each in said if isinstance(each, Value)),
    }
    assert all(signal.changes for signal in wave.signals.values())
    drawn = any(span.kind in ("task", "message", "stage") for span in spans)
    assert (run_timeline_picture(records) is not None) == drawn


def is_event(each: Any) -> bool:
    return isinstance(each, Mark) and not each.track


def record_times(kind: type[Record]) -> list[Any]:
    return list(sample(kind).lasted())


def seen(records: list[Record], path: Path) -> tuple[Any, ...]:
    """All that pages, pictures, viewers and tables show of a run."""
    messages = [item.data for item in scan(written(path, records)) if hasattr(item, "channel_id")]
    run, picture = (scrub_of(each for each in records if isinstance(each, SCRUB_KINDS)), run_map_picture(records))
    state = moment(records)
    page = None if run is None else scrub_data(run)
    facts = [state.goals.tolist(), state.path, state.belief is None, len(state.events), state.free.sum()]
    return (messages, page, picture and picture.data, str(facts), board_latencies(records), open_trace(path).result)


@pytest.fixture(scope="module")
def empty_scene(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, ...]:
    return seen(scene(), tmp_path_factory.mktemp("scene") / "run.mcap")


def test_it_is_drawn_as_what_it_is_about(kind: type[Record], empty_scene: tuple[Any, ...], tmp_path: Path) -> None:
    """By pages, pictures, viewers or tables. The messages of the trace are those of viewers alone."""
    before = scene()
    one, other = empty_scene, seen([*before[:-1], sample(kind), before[-1]], tmp_path / "run.mcap")
    views = len(other[0]) - len(one[0]) > 1
    assert (views or other[1:] != one[1:]) == (kind.ROLE.about is not Subject.OTHER or kind in SCRUB_KINDS)


def test_a_run_in_memory_is_seen_as_its_trace(kind: type[Record], tmp_path: Path) -> None:
    memory, records = MemoryListener(), [*scene()[:-1], sample(kind), scene()[-1]]
    for each in records:
        memory(each)
    trace = open_trace(written(tmp_path / "run.mcap", records))
    read, kept = (scrub_of(each) for each in (trace.records(kinds=SCRUB_KINDS), memory.records))
    assert read is not None
    assert kept is not None
    assert scrub_data(read) == scrub_data(kept)
