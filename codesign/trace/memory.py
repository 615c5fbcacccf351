"""A listener that keeps every record in memory, for tests and notebooks."""

from __future__ import annotations

from typing import TypeVar

from codesign.records import Record

R = TypeVar("R", bound=Record)


class MemoryListener:
    """Keeps the records of a run in the order of emission, in ``records``."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def __call__(self, record: Record) -> None:
        """Keep one record."""
        self.records.append(record)

    def of(self, record_type: type[R]) -> list[R]:
        """The records of one class, in the order of emission."""
        return [record for record in self.records if isinstance(record, record_type)]
