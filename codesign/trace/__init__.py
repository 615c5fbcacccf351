"""Traces: listeners that keep the records of a run, and readers that return them.

This package imports records, errors and units alone. The simulation takes any callable as a listener and does not know
this package. MCAP was chosen for three reasons: Foxglove and similar viewers open it directly, it contains schemas,
metadata and attachments beside the messages, and a file that was cut short still gives its complete part. Messages are
JSON, which every viewer's raw panel shows and any script reads. Rejected: protobuf. Rerun decodes it too, but it needs
generated code for every record, including those of plug-ins.
"""

from codesign.trace.listeners import McapListener, MemoryListener
from codesign.trace.moment import MOMENT_KINDS, Moment, moment, moment_lines
from codesign.trace.reader import Channel, Trace, open_trace
from codesign.trace.show import HEADER, TimelineRow, thumbnail, timeline, trace_thumbnail

__all__ = [
    "HEADER",
    "MOMENT_KINDS",
    "Channel",
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
