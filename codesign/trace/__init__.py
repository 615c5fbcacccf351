"""Traces: listeners that keep the records of a run, and readers that give them back.

Imports records, errors and units alone; the simulation takes any callable as a listener and does not know
this package. MCAP was chosen because Foxglove and its kin open it as it is, it holds schemas, metadata and
attachments beside the messages, and a file that was cut short still gives what is complete. Messages are
JSON: readable in every viewer's raw panel and by any script. Rejected: protobuf, which Rerun decodes too, but
which needs generated code for every record, a plug-in's included.
"""

from codesign.trace.export import PERFETTO_KINDS, POSE_KINDS, perfetto, poses_csv
from codesign.trace.info import TraceInfo, trace_info
from codesign.trace.mcap import McapListener
from codesign.trace.memory import MemoryListener
from codesign.trace.moment import MOMENT_KINDS, Moment, moment, moment_lines
from codesign.trace.reader import Channel, Trace, open_trace
from codesign.trace.show import HEADER, TimelineRow, thumbnail, timeline, trace_thumbnail

__all__ = [
    "HEADER",
    "MOMENT_KINDS",
    "PERFETTO_KINDS",
    "POSE_KINDS",
    "Channel",
    "McapListener",
    "MemoryListener",
    "Moment",
    "TimelineRow",
    "Trace",
    "TraceInfo",
    "moment",
    "moment_lines",
    "open_trace",
    "perfetto",
    "poses_csv",
    "thumbnail",
    "timeline",
    "trace_info",
    "trace_thumbnail",
]
