"""What flows between the tasks of a workload."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Flow:
    """``bits`` that task ``sender`` hands task ``receiver`` under ``name``; a message where they are placed apart."""

    sender: str
    receiver: str
    name: str
    bits: int
