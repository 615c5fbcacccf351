"""What a trace holds, at a glance: the answer of ``hwsw trace info FILE``."""

from __future__ import annotations

from dataclasses import dataclass

from codesign.errors import printable
from codesign.trace.reader import Channel, Trace
from codesign.units import format_count, format_time


@dataclass(frozen=True)
class TraceInfo:
    """The facts about a trace; times in ps, sizes in bytes, as in ``Trace``."""

    path: str
    size: int
    complete: bool
    fault: str | None
    library: str
    messages: int
    begin: int | None
    end: int | None
    channels: tuple[Channel, ...]
    metadata: dict[str, dict[str, str]]
    attachments: dict[str, int]

    def rows(self) -> list[tuple[str, str]]:
        """Name and value of each fact, for print; text from the file is made harmless."""
        span = (
            "no messages"
            if self.begin is None or self.end is None
            else (f"{format_time(self.begin)} to {format_time(self.end)}")
        )
        rows = [
            ("file", printable(self.path, None)),
            ("size", f"{format_count(self.size)} bytes"),
            ("whole", "yes" if self.fault is None else f"no, only what came before: {printable(self.fault)}"),
            ("written by", printable(self.library)),
            ("messages", format_count(self.messages)),
            ("simulated time", span),
        ]
        for name, texts in self.metadata.items():
            rows += [(f"{printable(name)}.{printable(key)}", printable(text)) for key, text in texts.items()]
        rows += [
            (f"attachment {printable(name)}", f"{format_count(size)} bytes")
            for name, size in self.attachments.items()
        ]
        return rows

    def channel_rows(self) -> list[tuple[str, str, str]]:
        """Topic, schema and number of messages of each channel, for print."""
        return [
            (printable(channel.topic), printable(channel.schema), format_count(channel.messages))
            for channel in self.channels
        ]


def trace_info(trace: Trace) -> TraceInfo:
    """The facts about an opened trace."""
    return TraceInfo(
        path=str(trace.path),
        size=trace.size,
        complete=trace.complete,
        fault=trace.fault,
        library=trace.library,
        messages=trace.messages,
        begin=trace.begin,
        end=trace.end,
        channels=tuple(trace.channels),
        metadata=trace.metadata,
        attachments={name: len(attachment.data) for name, attachment in trace.attachments.items()},
    )
