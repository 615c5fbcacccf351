"""A trace for Perfetto, in its own protobuf: ``hwsw trace export FILE --perfetto OUT``, open OUT at ui.perfetto.dev.

- Each component has a track of tasks, one of stages and one of visits; each direction of a link has one of messages,
  and each link one of messages that wait. Spans that overlap have tracks beside each other. So no span is dropped.
- Flows lead from a message to the first task that its receiver begins after it, and from the last task that a sender
  ended to its message. So from a scan one follows the chain to the command.
- Counters: the messages that wait for each link, the share of the time in which each component and link was busy, and
  the speed of each robot.
- Events of a mission are marks over all tracks.

Times are whole nanoseconds, rounded down: Perfetto has no finer unit. The exact picoseconds of a span stand in its
arguments, as ``begin_ps`` and ``end_ps``.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from operator import itemgetter
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from more_itertools import map_reduce
from perfetto.trace_builder.proto_builder import StreamingTraceProtoBuilder

from codesign.ground.activity import (
    WORKS,
    Activity,
    Lanes,
    Mark,
    Span,
    Value,
    activities,
    depth_over_time,
    share_over_time,
    spans_by_place,
    union,
)
from codesign.ground.records import Record

if TYPE_CHECKING:
    from perfetto.protos.perfetto.trace.perfetto_trace_pb2 import TracePacket

_SEQUENCE = 1
_PROCESS = 1
_PICOSECONDS = 1000
_BINS = 500
"""The parts of a run of which the busy share is told."""


def write_perfetto(records: Iterable[Record], file: IO[bytes]) -> int:
    """Write the records as a trace of Perfetto; returns the number of spans."""
    writer = _Writer(StreamingTraceProtoBuilder(file))
    spans: list[Span] = []
    for activity in activities(records):
        if isinstance(activity, Span):
            spans.append(activity)
        else:
            writer.put(activity)
    flows = _flows(spans)
    lanes = Lanes()
    for number, span in enumerate(spans):
        writer.span(span, lanes.lane(span), flows.get(number, ()))
    for value in _values(spans):
        writer.put(value)
    return len(spans)


def _flows(spans: list[Span]) -> dict[int, list[tuple[int, bool]]]:
    """The flows of each span: the number of the flow, and whether it ends there.

    A message flows from the last task of its sender that had ended when it was asked for, to the first task that its
    receiver begins when it has arrived or later.
    """
    tasks = map_reduce(
        ((number, span) for number, span in enumerate(spans) if span.kind == "task"), lambda each: each[1].where
    )
    waits = {
        (span.where, span.sender, span.receiver, span.name, span.end): span.begin
        for span in spans
        if span.kind == "wait"
    }
    by_begin = {where: sorted((*span.times, number) for number, span in each) for where, each in tasks.items()}
    by_end = {where: sorted((span.end, number) for number, span in each) for where, each in tasks.items()}
    ends: list[tuple[int, tuple[int, bool]]] = []
    for number, span in enumerate(spans):
        if span.kind != "message":
            continue
        asked = waits.get((span.where, span.sender, span.receiver, span.name, span.begin), span.begin)
        ended = by_end.get(span.sender, [])
        before = bisect_right(ended, (asked, len(spans))) - 1
        begun = by_begin.get(span.receiver, [])
        after = bisect_left(begun, (span.end, 0, 0))
        if before >= 0:
            ends += [(ended[before][1], (2 * number + 1, False)), (number, (2 * number + 1, True))]
        if after < len(begun) and span.details.get("outcome") == "delivered":
            ends += [(number, (2 * number + 2, False)), (begun[after][2], (2 * number + 2, True))]
    return map_reduce(ends, itemgetter(0), itemgetter(1))


def _values(spans: list[Span]) -> Iterable[Value]:
    """The number of messages that wait for each link, and the share of busy time of components and links, over time."""
    for link, waiting in spans_by_place(spans, "wait").items():
        for time, depth in zip(*(each.tolist() for each in depth_over_time(waiting)), strict=True):
            yield Value(time, f"{link}: messages waiting", depth, "messages")
    last = max((span.end for span in spans), default=0)
    if not last:
        return
    begins = (last * np.arange(_BINS + 1) // _BINS).tolist()
    for where, work in spans_by_place(spans, *WORKS).items():
        shares = share_over_time(union(span.times for span in work), 0, last, _BINS)
        for begin, share in zip(begins, [*shares.tolist(), 0.0], strict=True):
            yield Value(begin, f"{where}: busy", round(100 * share, 6), "%")


class _Writer:
    """Writes packets. Tracks are described when they are met first."""

    def __init__(self, builder: Any) -> None:
        self._builder = builder
        self._tracks: dict[str, int] = {}
        self._units: dict[str, str] = {}
        process = builder.create_packet()
        process.track_descriptor.uuid = _PROCESS
        process.track_descriptor.name = "platform"
        process.track_descriptor.child_ordering = process.track_descriptor.LEXICOGRAPHIC
        process.trusted_packet_sequence_id = _SEQUENCE
        process.sequence_flags = process.SEQ_INCREMENTAL_STATE_CLEARED
        builder.write_packet(process)

    def span(self, span: Span, track: str, flows: Iterable[tuple[int, bool]]) -> None:
        """A begin and an end: on its track the ones before have ended."""
        packet = self._event(span.begin, track)
        event = packet.track_event
        event.type, event.name = event.TYPE_SLICE_BEGIN, span.name
        event.categories.append(span.kind)
        _annotate(event, {**span.details, "begin_ps": span.begin, "end_ps": span.end})
        for flow, ends in flows:
            (event.terminating_flow_ids if ends else event.flow_ids).append(flow)
        self._builder.write_packet(packet)
        packet = self._event(span.end, track)
        packet.track_event.type = event.TYPE_SLICE_END
        self._builder.write_packet(packet)

    def put(self, activity: Activity) -> None:
        """A mark or a value."""
        if isinstance(activity, Mark):
            packet = self._event(activity.time, activity.track)
            event = packet.track_event
            event.type, event.name = event.TYPE_INSTANT, activity.name
            _annotate(event, activity.details)
        else:
            assert isinstance(activity, Value)
            packet = self._event(activity.time, activity.track, activity.unit)
            packet.track_event.type = packet.track_event.TYPE_COUNTER
            packet.track_event.double_counter_value = activity.value
        self._builder.write_packet(packet)

    def _event(self, time: int, track: str, unit: str | None = None) -> TracePacket:
        uuid = self._track(track, unit)
        packet: TracePacket = self._builder.create_packet()
        packet.timestamp = time // _PICOSECONDS
        packet.trusted_packet_sequence_id = _SEQUENCE
        packet.track_event.track_uuid = uuid
        return packet

    def _track(self, name: str, unit: str | None) -> int:
        """The number of a track. ``unit``: of a counter. The empty name is the process."""
        if not name:
            return _PROCESS
        if name not in self._tracks:
            self._tracks[name] = len(self._tracks) + _PROCESS + 1
            packet = self._builder.create_packet()
            packet.trusted_packet_sequence_id = _SEQUENCE
            descriptor = packet.track_descriptor
            descriptor.uuid, descriptor.parent_uuid, descriptor.name = self._tracks[name], _PROCESS, name
            if unit is not None:
                descriptor.counter.unit_name = unit
            self._builder.write_packet(packet)
        return self._tracks[name]


def _annotate(event: Any, details: Any) -> None:
    for name, value in details.items():
        annotation = event.debug_annotations.add()
        annotation.name = name
        if isinstance(value, str):
            annotation.string_value = value
        elif isinstance(value, int):
            annotation.int_value = value
        else:
            annotation.double_value = value
