"""Traces: listeners that keep the records of a run, and readers that return them.

This package imports records, errors and units alone. The simulation takes any callable as a listener and does not know
this package. MCAP was chosen for three reasons: Foxglove and similar viewers open it directly, it contains schemas,
metadata and attachments beside the messages, and a file that was cut short still gives its complete part. Messages are
protobuf, which Foxglove and Rerun both decode. Their schemas are made from the record classes when a run is traced,
plug-ins included, so no code is generated. Rejected: JSON. Rerun shows none of it, and it takes more time and
space.
"""

from codesign.ground.records import Level, MemoryListener
from codesign.views.trace.listeners import McapListener
from codesign.views.trace.moment import (
    HEADER,
    MOMENT_KINDS,
    Moment,
    TimelineRow,
    moment,
    moment_lines,
    thumbnail,
    timeline,
    trace_thumbnail,
)
from codesign.views.trace.reader import Channel, Trace, open_trace

__all__ = [
    "HEADER",
    "MOMENT_KINDS",
    "Channel",
    "Level",
    "McapListener",
    "MemoryListener",
    "Moment",
    "TimelineRow",
    "Trace",
    "moment",
    "moment_lines",
    "open_trace",
    "thumbnail",
    "timeline",
    "trace_thumbnail",
]
